"""Rerun panes for a field along a line: a curve of its values over the coordinate; the title states the ranges of both."""

from __future__ import annotations

from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from granular_env.colours import PALETTE, parse_rgb

from ..scene_data import ProfileFrames
from ..unit_labels import label_with_unit
from .shapes import entity_path

# Width and height of the plot frame, and the margin around it, in pixels of the pane.
_WIDTH, _HEIGHT, _ROOM = 1000.0, 120.0, 8.0
_FRAME = (90, 95, 98)


def profile_path(profile: ProfileFrames) -> str:
    """Return rerun's entity path of a profile (the values of a field along a line)."""
    return entity_path("profiles/", profile.name)


def profile_pane(profile: ProfileFrames) -> Any:
    """Return the pane of a profile."""
    bounds = rrb.VisualBounds2D(x_range=[-_ROOM, _WIDTH + _ROOM], y_range=[-_ROOM, _HEIGHT + _ROOM])
    quantity, values, x = label_with_unit(profile.variable.name, profile.variable.unit), profile.values, profile.coordinate
    name = f"{quantity}, {values.min():.3g} to {values.max():.3g}, along x from {x[0]:.3g} to {x[-1]:.3g} m"
    return rrb.Spatial2DView(origin=profile_path(profile), name=name, background=[13, 16, 17], visual_bounds=bounds)


def send_profile(recording: Any, profile: ProfileFrames, when: list[Any]) -> None:
    """Send the frame around the plot, which does not change, and the curve of the values at each time."""
    low, high = profile.limits
    path = profile_path(profile)
    corners = np.array([[0.0, 0.0], [_WIDTH, 0.0], [_WIDTH, _HEIGHT], [0.0, _HEIGHT], [0.0, 0.0]])
    zero, heights = (_HEIGHT * (high - values) / (high - low) for values in (0.0, profile.values))  # from the top
    lines = [corners, np.array([[0.0, zero], [_WIDTH, zero]])]
    recording.log(f"{path}/frame", rr.LineStrips2D(lines, colors=_FRAME, radii=rr.Radius.ui_points(0.5)), static=True)
    x = profile.coordinate
    across = _WIDTH * (x - x[0]) / (x[-1] - x[0])
    curves = np.stack([np.broadcast_to(across, profile.values.shape), heights], axis=2)
    shown = rr.LineStrips2D.columns(
        strips=curves.astype(np.float32),
        colors=np.broadcast_to(np.array(parse_rgb(PALETTE[0]), np.uint8), (len(curves), 3)),
        radii=np.full(len(curves), rr.Radius.ui_points(1.2), np.float32),
    )
    recording.send_columns(f"{path}/curve", when, shown.partition(np.ones(len(curves), np.int64)))
