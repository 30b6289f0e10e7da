"""How viewers show points and cells: whether at all, in one, two or three dimensions, and coloured by which output."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from ...components.drawables import Cells, Drawable, Links, Points, element_count, element_positions
from ...components.support.float_arrays import FloatArray
from ...components.variables import Variable


def is_hidden(drawable: Drawable, others: Sequence[Drawable]) -> bool:
    """Return whether a drawable is omitted because others show it or it would hide them.

    Omitted are points that are nodes of cells or lie below a surface in space, links between these points, and plane cells
    next to the surface of a body.
    """
    cells = [one for one in others if isinstance(one, Cells)]
    match drawable:
        case Points():
            own = [one for one in cells if one.displacement == drawable.displacement]
            are_nodes = any(np.array_equal(one.nodes, drawable.reference) for one in own)
            return are_nodes or any(_covers(one, drawable) for one in cells)
        case Links():
            return any(isinstance(one, Points) and one.name == drawable.points and is_hidden(one, others) for one in others)
        case Cells():
            return not is_solid(drawable.nodes) and any(is_solid(one.nodes) for one in cells)
        case _:
            return False


def _covers(surface: Cells, points: Points) -> bool:
    """Return whether all points lie inside or below the bounding box of a surface in space, so that the surface hides them."""
    places = points.reference
    if surface.nodes.shape[1] != 3 or places.ndim != 2 or places.shape[1] != 3:
        return False
    low, high = surface.nodes.min(axis=0), surface.nodes.max(axis=0)
    slack = 1e-9 * float((high - low).max())
    low[2] = -np.inf
    return bool(((places >= low - slack) & (places <= high + slack)).all())


def is_solid(places: FloatArray) -> bool:
    """Return whether positions, shape (n, d), span three dimensions."""
    return places.ndim == 2 and places.shape[1] == 3 and bool(np.ptp(places, axis=0).all())


def area_vectors(corners: FloatArray) -> FloatArray:
    """Return outward vectors of length twice the area of each cell, shape (m, 3), from its corners, shape (m, k, 3)."""
    return np.cross(corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1])


def colour_name(drawable: Drawable) -> str:
    """Return the name of the output that colours points or cells; "" if there is none."""
    return drawable.field if isinstance(drawable, Cells) else drawable.colour if isinstance(drawable, Points) else ""


def with_colour(drawable: Drawable, name: str) -> Drawable:
    """Return the drawable (points or cells) with the output `name` as its colour."""
    return dataclasses.replace(drawable, **{"field" if isinstance(drawable, Cells) else "colour": name})


def with_recorded_colour(drawable: Drawable, recorded: Mapping[str, Variable]) -> Drawable:
    """Return the drawable with the first recorded output that can colour it if the output that colours it was not recorded."""
    own = colour_name(drawable)
    others = [name for name in colouring_outputs([drawable], recorded) if name != getattr(drawable, "state", "")]
    return with_colour(drawable, others[0]) if own and own not in recorded and others else drawable


def colouring_outputs(drawables: Sequence[Drawable], variables: Mapping[str, Variable]) -> list[str]:
    """Return the names of the outputs that can colour any of the drawables."""
    return [name for name in variables if any(_can_colour(one, variables, name) for one in drawables)]


def _can_colour(drawable: Drawable, variables: Mapping[str, Variable], name: str) -> bool:
    """Return whether an output can colour a drawable: it has one value per node, cell or point, in the drawable's order."""
    return len(variables[name].shape) == 1 and has_elements(drawable, variables, name)


def has_elements(drawable: Drawable, variables: Mapping[str, Variable], name: str) -> bool:
    """Return whether an output has one row per node, cell or point of a drawable, in the drawable's order."""
    one = variables[name]
    if not isinstance(drawable, Points | Cells) or one.causality != "output" or not one.shape:
        return False
    counts = {element_count(drawable), len(drawable.nodes) if isinstance(drawable, Cells) else 0}
    known = (variables.get(colour_name(drawable)), variables.get(drawable.displacement))
    return one.shape[0] in counts and all(
        one.axes[:1] == other.axes[:1] or one.shape[:1] != other.shape[:1] for other in known if other is not None
    )


def visible_points(drawables: Sequence[Drawable]) -> list[Points]:
    """Return the points that are drawn."""
    return [one for one in drawables if isinstance(one, Points) and not is_hidden(one, drawables)]


def visible_cells(drawables: Sequence[Drawable]) -> list[Cells]:
    """Return the cells that are drawn."""
    return [one for one in drawables if isinstance(one, Cells) and not is_hidden(one, drawables)]


def is_plane(reference: FloatArray, displacement: Variable | None) -> bool:
    """Return whether positions lie, or can move, in two or more dimensions; otherwise they are a row along x.

    Args:
        reference: initial positions, shape (n, d) [m].
        displacement: output with the displacements; None if there is none.
    """
    moves = displacement is not None and len(displacement.shape) == 2 and displacement.shape[1] > 1
    return moves or bool(np.ptp(reference[:, 1:], axis=0).any())


def is_plane_filling(drawables: Sequence[Drawable], count: int) -> bool:
    """Return whether a drawable with `count` points, links, nodes or cells fills a plane instead of a row along x.

    In a plane, the number of a place does not determine its position.
    """
    # The tolerance allows for rounding errors in the positions.
    return any(
        len(places) == count > 0 and bool((np.ptp(places[:, 1:], axis=0) > 1e-9 * np.ptp(places[:, 0])).any())
        for one in drawables
        for places in (element_positions(one, drawables), *([one.nodes] if isinstance(one, Cells) else []))
    )
