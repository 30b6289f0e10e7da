"""Points and cells as viewers see them: which are drawn, which of them lie in a plane, how far displacements are stretched."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from granular_env.components.contract import Variable
from granular_env.components.drawables import Cells, Drawable, Links, Points, drawn_outputs
from granular_env.components.support.arrays import FloatArray
from granular_env.components.support.roots import round_down_to_125
from granular_env.recording.preview.displacement_scale import choose_exaggeration

# Nodes of cells are drawn so far from where they began, at most, in lengths of the picture.
_DRAWN_TRAVEL = 0.1


def is_hidden(drawable: Drawable, others: Sequence[Drawable]) -> bool:
    """Return whether a drawable would hide others: points that are the nodes of cells, which are drawn themselves."""
    return isinstance(drawable, Points) and any(
        isinstance(one, Cells) and one.displacement == drawable.displacement and np.array_equal(one.nodes, drawable.reference)
        for one in others
    )


def visible_points(drawables: Sequence[Drawable]) -> list[Points]:
    """Return the points that are drawn."""
    return [one for one in drawables if isinstance(one, Points) and not is_hidden(one, drawables)]


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
    """The things that an output that is drawn belongs to.

    Attributes:
        name: of points and links, a plural such as "discs"; empty for cells, whose name is that of all of them together.
        fills_plane: whether the things lie side by side in a plane, so that their numbers say little about where they are.
    """

    name: str
    fills_plane: bool


def places_of_outputs(drawables: Sequence[Drawable]) -> dict[str, Place]:
    """Return what each output that is drawn belongs to, by the output's name."""
    points = {one.name: one for one in drawables if isinstance(one, Points)}
    found: dict[str, Place] = {}
    for one in drawables:
        if isinstance(one, Cells):
            found |= dict.fromkeys(drawn_outputs([one]), Place("", fills_plane(one.nodes[one.connectivity].mean(axis=1))))
        elif isinstance(one, Points | Links) and not is_hidden(one, drawables):
            reference = (one if isinstance(one, Points) else points[one.points]).reference
            found |= dict.fromkeys(drawn_outputs([one]), Place(one.name, fills_plane(reference)))
    return found


def fills_plane(places: FloatArray) -> bool:
    """Return whether places, shape (n, d), lie side by side and not in one row along x; rounding apart."""
    across = np.ptp(places[:, 1:], axis=0)
    return bool((across > 1e-9 * np.ptp(places[:, 0])).any())


def common_exaggeration(
    points: Iterable[tuple[FloatArray, FloatArray, FloatArray]], cells: Iterable[tuple[FloatArray, FloatArray]]
) -> float:
    """Return one factor for all displacements: no particles pass one another, and nodes stay near.

    Args:
        points: reference (n, 3), radius (n,) and displacement (frames, n, 3) of points [m].
        cells: reference (n, d) and displacement (frames, n, d) of the nodes of cells [m].
    """
    factors = [choose_exaggeration(*one) for one in points]
    for nodes, displacement in cells:
        if (travel := float(np.abs(displacement).max(initial=0.0))) > 0.0:
            factors.append(max(1.0, round_down_to_125(_DRAWN_TRAVEL * float(np.ptp(nodes, axis=0).max()) / travel)))
    return min(factors, default=1.0)
