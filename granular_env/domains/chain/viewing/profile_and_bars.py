"""The profile above a row of grains and the bars below its contacts, with zero lines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.colours import sequential_colours, symmetric_limit
from granular_env.optional_packages import import_optional
from granular_env.viewing.scene_data import Motion
from granular_env.viewing.scene_scales import REST_COLOUR, Scales

# Distance of the zero line's label from this line, over the length of the longest bar.
WORDS = 1.25
# Length of the longest bar, as a fraction of the scene's length.
_BAR_LENGTH = 0.05


@dataclass(frozen=True)
class Row:
    """The layout of the profile and the bars.

    Attributes:
        height: length of the longest bar and half the span of the profile [m].
        profile_level: height of the profile's zero line [m].
        contact_level: height of the upper ends of the contacts' bars [m].
        contact_limit: contact force [N] or overlap [um] that is shown by a bar of length `height`.
    """

    height: float
    profile_level: float
    contact_level: float
    contact_limit: float


def row_layout(motion: Motion, scales: Scales) -> Row:
    """Return the layout that fits a motion."""
    length = scales.high[0] - scales.low[0]
    height, margin = _BAR_LENGTH * length, 0.015 * length + float(motion.radius.max())
    lowest = 0.0 if motion.colour is None else max(0.0, -float(motion.colour.min())) / scales.colour_limit
    # Room for negative values below the profile's zero line; for a running simulation they are unknown, so reserve full height.
    below = height * (lowest if scales.settled else 1.0)
    return Row(
        height,
        float(motion.reference[:, 2].max()) + margin + below,
        float(motion.reference[:, 2].min()) - margin,
        symmetric_limit([0.0] if motion.contact is None else motion.contact),
    )


def send_guides(recording: Any, motion: Motion, scales: Scales, row: Row) -> None:
    """Send the zero lines of the profile and of the bars, with labels."""
    rr = import_optional("rerun", "the viewer")
    variable = motion.colour_variable
    guides = []
    if motion.colour is not None:
        words = f"{variable.name} of each grain; full height {scales.colour_limit:g} {variable.unit}"
        guides.append((row.profile_level, 1.0, words))
    if motion.contact is not None:
        words = f"{motion.contact_name} of each contact; full length {row.contact_limit:g} {motion.contact_unit}"
        guides.append((row.contact_level, -1.0, words))
    low, high = scales.low[0], scales.high[0]
    for index, (level, direction, text) in enumerate(guides):
        ends = [[low, 0.0, level], [high, 0.0, level]]
        line = rr.LineStrips3D([ends], colors=[REST_COLOUR], radii=rr.Radius.ui_points(0.7))
        recording.log(f"scene/zero_lines/{index}", line, static=True)
        # Place the label at the right end, beyond the longest bar and the highest point of the curve.
        place = [high - 0.12 * (high - low), 0.0, level + direction * WORDS * row.height]
        shown = rr.Points3D([place], labels=[text], show_labels=True, radii=0.0, colors=[REST_COLOUR])
        recording.log(f"scene/words/{index}", shown, static=True)


def send_profile(
    recording: Any, motion: Motion, scales: Scales, row: Row, positions: npt.NDArray[Any], when: list[Any]
) -> None:
    """Send the quantity by which the grains are coloured as a curve above the grains."""
    if motion.colour is None or positions.shape[1] < 2:
        return
    radius = import_optional("rerun", "the viewer").Radius.ui_points(1.5)
    curve = positions.copy()
    curve[..., 2] = row.profile_level + row.height * motion.colour / scales.colour_limit
    _send_strips(recording, "scene/profile", when, curve, 1, np.full((len(positions), 3), 235, np.uint8), radius)


def send_bars(recording: Any, motion: Motion, scales: Scales, row: Row, positions: npt.NDArray[Any], when: list[Any]) -> None:
    """Send contact forces or overlaps as bars below the contacts."""
    if motion.contact is None:
        return
    rr = import_optional("rerun", "the viewer")
    frames, contacts = motion.contact.shape
    top = 0.5 * (positions[:, 1:] + positions[:, :-1])
    top[..., 2] = row.contact_level
    bottom = top.copy()
    bottom[..., 2] -= row.height * motion.contact / row.contact_limit
    bars = np.stack([top, bottom], axis=2).reshape(frames * contacts, 2, 3)
    colours = sequential_colours(motion.contact, row.contact_limit).reshape(-1, 3)
    # Bars are half a grain wide if this width is visible.
    thin = motion.radius.min() < 1e-3 * (scales.high[0] - scales.low[0])
    radius = rr.Radius.ui_points(1.0) if thin else 0.25 * motion.radius.min()
    _send_strips(recording, "scene/contacts", when, bars, contacts, colours, radius)


def _send_strips(
    recording: Any,
    path: str,
    when: list[Any],
    strips: npt.NDArray[Any],
    per_frame: int,
    colours: npt.NDArray[np.uint8],
    radius: float,
) -> None:
    rr = import_optional("rerun", "the viewer")
    frames = len(strips) // per_frame
    lines = rr.LineStrips3D.columns(strips=strips, colors=colours, radii=np.full(len(strips), radius, np.float32))
    recording.send_columns(path, when, lines.partition(np.full(frames, per_frame)))
