"""The viewing direction for a body in space: a fixed oblique view, or its mirror image on the side of the events."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from granular_env.components.drawables import Cells, Drawable
from granular_env.components.support.float_arrays import FloatArray
from granular_env.recording.event_places import event_place
from granular_env.recording.preview.visible_drawables import area_vectors, is_solid, visible_cells

# Usual direction towards the eye: in front (y < 0), above, and slightly to the left.
USUAL = np.array([-0.25, -0.6, 0.76]) / np.sqrt(0.25**2 + 0.6**2 + 0.76**2)
# Least cosine of a side's normal and the eye's direction at which a side is seen well; components below the second count as 0.
_SEEN_WELL, _SMALL = 0.5, 0.2
_MOST_EVENTS = 100


def viewpoint(focus: FloatArray | None) -> FloatArray:
    """Return the direction towards the eye, shape (3,), of length 1.

    The usual direction is kept if it shows the side of the events. Otherwise it is mirrored in the coordinates in which the
    events are on the hidden side, and x and y are swapped if the normal is closer to x than to y.

    Args:
        focus: normal from `focus_normal`; None for the usual direction.
    """
    if focus is None or focus @ USUAL >= _SEEN_WELL:
        return USUAL
    eye = USUAL[[1, 0, 2]] if abs(focus[0]) > abs(focus[1]) else USUAL
    return np.where((eye * focus < 0.0) & (np.abs(focus) > _SMALL), -eye, eye)


def viewpoint_text(towards_eye: FloatArray) -> str:
    """Return a phrase that describes from where a body is seen, and how one axis runs in the picture."""
    x, y, z = towards_eye.tolist()
    axis, is_right = ("x", y < 0.0) if abs(y) > abs(x) else ("y", x > 0.0)
    return f"obliquely from {'above' if z > 0.0 else 'below'}, {axis} to the {'right' if is_right else 'left'}"


def focus_normal(log: Any, drawables: Sequence[Drawable]) -> FloatArray | None:
    """Return the outward unit normal of the side to show, shape (3,); None if no side has more events.

    Its direction is the mean normal of the cells nearest to the events plus the mean normal of the surface. The latter is
    zero for a closed body and points outwards from an open body, such as half a tube.
    """
    surfaces = [one for one in visible_cells(drawables) if is_solid(one.nodes)]
    if not surfaces:
        return None
    areas = np.concatenate([area_vectors(one.nodes[one.connectivity]) for one in surfaces])
    middles = np.concatenate([one.nodes[one.connectivity].mean(axis=1) for one in surfaces])
    nearest = [int(((middles - place) ** 2).sum(axis=1).argmin()) for place in _event_places(log)]
    normals = areas[nearest] / np.maximum(np.sqrt((areas[nearest] ** 2).sum(axis=1, keepdims=True)), 1e-300)
    focus = areas.sum(axis=0) / np.sqrt((areas**2).sum(axis=1)).sum() + normals.sum(axis=0) / max(len(normals), 1)
    length = float(np.sqrt(focus @ focus))
    return focus / length if length > _SMALL else None


def _event_places(log: Any) -> list[tuple[float, ...]]:
    """Return the positions, shape (n, 3) [m], of at most a hundred events, picked evenly among those with a position."""
    details, drawn = log.event_details, {one.name for one in log.drawables if not isinstance(one, Cells) or is_solid(one.nodes)}
    events = [event for event in log.events() if event.kind in details and details[event.kind].counts in drawn]
    picked = np.unique(np.linspace(0, len(events) - 1, min(len(events), _MOST_EVENTS)).astype(np.int64))
    places = (event_place(events[one].index, details[events[one].kind], log.drawables) for one in picked)
    return [place.position for place in places if place is not None and len(place.position) == 3]
