"""Points and cells as viewers show them: which are drawn, which lie in a plane, how far displacements are stretched."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from granular_env.components.drawables import Cells, Drawable, Links, Points, drawn_outputs
from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.variables import Variable


def is_hidden(drawable: Drawable, others: Sequence[Drawable]) -> bool:
    """Return whether a drawable is not drawn, because others show it, or it would hide them.

    These are points that are the nodes of cells, or lie below a surface in space, links between such points, and cells in a
    plane beside the surface of a body.
    """
    match drawable:
        case Points():
            return any(isinstance(one, Cells) and _covers(one, drawable) for one in others) or any(
                isinstance(one, Cells)
                and one.displacement == drawable.displacement
                and np.array_equal(one.nodes, drawable.reference)
                for one in others
            )
        case Links():
            return any(isinstance(one, Points) and one.name == drawable.points and is_hidden(one, others) for one in others)
        case Cells():
            return not is_solid(drawable.nodes) and any(isinstance(one, Cells) and is_solid(one.nodes) for one in others)
        case _:
            return False


def is_solid(places: FloatArray) -> bool:
    """Return whether places, shape (n, d), fill three dimensions."""
    return places.ndim == 2 and places.shape[1] == 3 and bool(np.ptp(places, axis=0).all())


def recolour(drawables: Sequence[Drawable], variables: Mapping[str, Variable], name: str) -> tuple[Drawable, ...]:
    """Return drawables of which those that an output can colour are coloured by it.

    Args:
        drawables: what a log or a component has.
        variables: those that can be had, by name.
        name: of the output.

    Raises:
        ParameterError: there is no such output, or nothing that is drawn has one value of it for each of its nodes, cells or
            points.
    """
    known = colouring_outputs([one for one in drawables if not is_hidden(one, drawables)], variables)
    if name not in known:
        raise ParameterError(
            f"{name!r} was not recorded, or it is not one value for each node, cell or point of a drawable",
            hint=f"this log can be coloured by {', '.join(known) or 'nothing'}", at="colour",
        )  # fmt: skip
    return tuple(one if not _can_colour(one, variables, name) else with_colour(one, name) for one in drawables)


def with_colour(drawable: Drawable, name: str) -> Drawable:
    """Return points or cells coloured by an output."""
    return dataclasses.replace(drawable, **{"field" if isinstance(drawable, Cells) else "colour": name})


def colouring_outputs(drawables: Sequence[Drawable], variables: Mapping[str, Variable]) -> list[str]:
    """Return the names of the outputs that can colour any of the drawables."""
    return [name for name in variables if any(_can_colour(one, variables, name) for one in drawables)]


def _can_colour(drawable: Drawable, variables: Mapping[str, Variable], name: str) -> bool:
    """Return whether an output has a value for each node or cell, or each point, in the same order as what colours them now."""
    if isinstance(drawable, Cells):
        counts = (len(drawable.nodes), len(drawable.connectivity))
    elif isinstance(drawable, Points):
        counts = (len(drawable.radius),)
    else:
        return False
    one = variables[name]
    if one.causality != "output" or len(one.shape) != 1 or one.shape[0] not in counts:
        return False
    known = (variables.get(colour_name(drawable)), variables.get(drawable.displacement))
    return all(one.axes == other.axes[:1] or one.shape != other.shape[:1] for other in known if other is not None)


def colour_name(drawable: Drawable) -> str:
    """Return the name of the output that colours points or cells; "" where there is none."""
    return drawable.field if isinstance(drawable, Cells) else drawable.colour if isinstance(drawable, Points) else ""


def _covers(surface: Cells, points: Points) -> bool:
    """Return whether points lie in the box around a surface in space, or below it."""
    places = points.reference
    if surface.nodes.shape[1] != 3 or places.ndim != 2 or places.shape[1] != 3:
        return False
    low, high = surface.nodes.min(axis=0), surface.nodes.max(axis=0)
    slack = 1e-9 * float((high - low).max())
    low[2] = -np.inf
    return bool(((places >= low - slack) & (places <= high + slack)).all())


def visible_points(drawables: Sequence[Drawable]) -> list[Points]:
    """Return the points that are drawn."""
    return [one for one in drawables if isinstance(one, Points) and not is_hidden(one, drawables)]


def visible_cells(drawables: Sequence[Drawable]) -> list[Cells]:
    """Return the cells that are drawn."""
    return [one for one in drawables if isinstance(one, Cells) and not is_hidden(one, drawables)]


def is_plane(reference: FloatArray, displacement: Variable | None) -> bool:
    """Return whether places lie in two dimensions or more, or can move in them; otherwise they are a row along x.

    Args:
        reference: before anything moves, shape (n, d) [m].
        displacement: the output that moves them; None where there is none.
    """
    moves = displacement is not None and len(displacement.shape) == 2 and displacement.shape[1] > 1
    return moves or bool(np.ptp(reference[:, 1:], axis=0).any())


@dataclass(frozen=True)
class Place:
    """The things that an output belongs to.

    Attributes:
        name: of points and links, a plural such as "discs"; empty for cells, whose name is that of all of them together.
        fills_plane: whether the things lie side by side in a plane, so that their numbers say little about where they are.
    """

    name: str
    fills_plane: bool


def place_of_output(drawables: Sequence[Drawable], name: str, count: int) -> Place | None:
    """Return what an output of `count` values belongs to; None where nothing is drawn by it or fills a plane with as many."""
    points = {one.name: one for one in drawables if isinstance(one, Points)}
    alike: Place | None = None
    for one in drawables:
        if isinstance(one, Cells):
            things, places, counts = "", one.nodes[one.connectivity].mean(axis=1), (len(one.nodes), len(one.connectivity))
        elif isinstance(one, Points):
            things, places, counts = one.name, one.reference, (len(one.reference),)
        elif isinstance(one, Links):
            things, places, counts = one.name, points[one.points].reference, (len(one.pairs),)
        else:
            continue
        if name in drawn_outputs([one]) and (isinstance(one, Cells) or not is_hidden(one, drawables)):
            return Place(things, fills_plane(places))
        if count in counts and fills_plane(places):
            alike = Place(things, fills_plane=True)
    return alike


def fills_plane(places: FloatArray) -> bool:
    """Return whether places, shape (n, d), lie side by side and not in one row along x; rounding apart."""
    across = np.ptp(places[:, 1:], axis=0)
    return bool((across > 1e-9 * np.ptp(places[:, 0])).any())
