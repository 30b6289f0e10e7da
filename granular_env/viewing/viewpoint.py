"""The direction from which a body in space is seen: towards its outside, on the side where most happens."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from granular_env.components.drawables import Cells, Drawable, Links, Points
from granular_env.components.support.float_arrays import FloatArray
from granular_env.recording.event_places import place_of

from .visible_drawables import is_solid, visible_cells

# Directions towards the eye in the order of preference: z is up, and a body is seen from before (y < 0) and above, and a little
# from the left, unless its outside or what happens there is better seen from behind, from below, or from its ends.
_BEFORE, _BEHIND, _RIGHT, _LEFT = (-0.25, -0.6), (0.25, 0.6), (0.6, -0.25), (-0.6, 0.25)
_ABOVE, _BELOW = 0.76, -0.76
_TOWARDS_EYE = np.array([
    [*side, height] for pair in ((_BEFORE, _BEHIND), (_RIGHT, _LEFT)) for height in (_ABOVE, _BELOW) for side in pair
])  # fmt: skip
_TOWARDS_EYE /= np.sqrt(0.25 * 0.25 + 0.6 * 0.6 + 0.76 * 0.76)
# A place is seen well where its outside faces the eye by this cosine, that is up to 53 degrees from it.
_SEEN_WELL = 0.6
# A surface faces some way where the mean of its normals is so long: of a whole tube it is 0, of half a tube 2 / pi.
_FACING = 0.2
# An eye sees the inside of an open body where the mean of the normals has so much of the direction away from it.
_FACING_AWAY = 0.1
# So many events say where they are: more, evenly picked from all, would say the same.
_MOST_EVENTS = 100
# A coloured quantity is large where it is above this part of its largest value.
_LARGE_PART = 0.5


def viewpoint(surfaces: Iterable[Cells | Any], focus_normal: FloatArray | None = None) -> FloatArray:
    """Return the direction towards the eye, shape (3,), of length 1.

    Args:
        surfaces: of bodies in space: all that has nodes in three coordinates, and connectivity.
        focus_normal: as `focus_normal` returns it; None where nothing tells.
    """
    areas = np.concatenate([np.zeros((1, 3)), *(_area_vectors(one) for one in surfaces)])
    eyes = _TOWARDS_EYE[_TOWARDS_EYE @ _mean_normal(areas) > -_FACING_AWAY]
    if focus_normal is None:
        return eyes[0]
    # Rounded, so that of two eyes that see a place alike the first one is taken.
    cosine = np.round(eyes @ focus_normal, 6)
    is_well_seen = cosine >= _SEEN_WELL
    return eyes[is_well_seen.argmax() if is_well_seen.any() else cosine.argmax()]


def viewpoint_words(towards_eye: FloatArray) -> str:
    """Return from where a body is seen, and where an axis points in the picture."""
    x, y, z = towards_eye.tolist()
    axis, is_right = ("x", y < 0.0) if abs(y) > abs(x) else ("y", x > 0.0)
    return f"obliquely from {'above' if z > 0.0 else 'below'}, {axis} to the {'right' if is_right else 'left'}"


def focus_normal(log: Any, drawables: Sequence[Drawable]) -> FloatArray | None:
    """Return which way the surface of a body in space faces where most happens, shape (3,), of length 1.

    That is at the events that have a place on the body; without any, where the quantity that colours it is large at the end.

    Args:
        log: an open log; what it holds so far, where it is not complete.
        drawables: of it, with the output that colours each.

    Returns:
        None where there is no body in space, nothing happens to it, or as much on all sides.
    """
    surfaces = [one for one in visible_cells(drawables) if is_solid(one.nodes)]
    if not surfaces:
        return None
    places = _event_places(log)
    areas = _areas_near(surfaces, places) if len(places) else _areas_of_large_values(log, surfaces)
    mean = _mean_normal(areas)
    length = float(np.sqrt(mean @ mean))
    return mean / length if length > _FACING else None


def _event_places(log: Any) -> FloatArray:
    """Return where some events took place in three dimensions, evenly picked from all of them, shape (events, 3) [m]."""
    spatial = {one.name for one in log.drawables if _fills_space(one, log.drawables)}
    details = {kind: detail for kind, detail in log.event_details.items() if detail.counts in spatial}
    events = [event for event in log.events() if event.kind in details] if details else []
    picked = np.unique(np.linspace(0, len(events) - 1, min(len(events), _MOST_EVENTS)).astype(np.int64))
    found = (place_of(events[one].index, details[events[one].kind], log.drawables) for one in picked)
    return np.array([place.position for place in found if place is not None]).reshape(-1, 3)


def _fills_space(drawable: Drawable, others: Sequence[Drawable]) -> bool:
    match drawable:
        case Points():
            return is_solid(drawable.reference)
        case Cells():
            return is_solid(drawable.nodes)
        case Links():
            return any(isinstance(one, Points) and one.name == drawable.points and is_solid(one.reference) for one in others)
        case _:
            return False


def _areas_near(surfaces: Sequence[Cells], places: FloatArray) -> FloatArray:
    """Return the area vector of the cell that is nearest to each place, of length 1 each, shape (places, 3)."""
    areas = np.concatenate([_area_vectors(one) for one in surfaces])
    middles = np.concatenate([one.nodes[one.connectivity].mean(axis=1) for one in surfaces])
    nearest = areas[[int(((middles - place) ** 2).sum(axis=1).argmin()) for place in places]]
    return nearest / np.maximum(np.sqrt((nearest * nearest).sum(axis=1)), 1e-300)[:, None]


def _areas_of_large_values(log: Any, surfaces: Sequence[Cells]) -> FloatArray:
    """Return the area vectors of the cells where what colours them is large in its last frame, shape (m, 3) [m2]."""
    found = [np.zeros((0, 3))]
    for one in surfaces:
        if one.field not in log.variables or not len(times := log.times(one.field)):
            continue
        values = np.abs(log.get(one.field, float(times[-1])))
        values = np.where(np.isfinite(values), values, 0.0)
        cells = values if len(values) == len(one.connectivity) else values[one.connectivity].mean(axis=1)
        if largest := float(cells.max()):
            found.append(_area_vectors(one)[cells > _LARGE_PART * largest])
    return np.concatenate(found)


def _area_vectors(surface: Cells | Any) -> FloatArray:
    """Return outward vectors as long as twice the area of each cell, shape (m, 3) [m2]."""
    corners = surface.nodes[surface.connectivity]
    return np.cross(corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1])


def _mean_normal(areas: FloatArray) -> FloatArray:
    """Return the mean of the normals, weighted by area, of length 0 (they face all ways) to 1 (all one way), shape (3,)."""
    whole = float(np.sqrt((areas * areas).sum(axis=1)).sum())
    return areas.sum(axis=0) / max(whole, 1e-300)
