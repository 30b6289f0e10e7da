"""Views of a chain in addition to its grains: profile, contact bars, close-up and x-t diagram."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.colours import parse_rgb
from granular_env.optional_packages import import_optional
from granular_env.viewing.domain_views import Views
from granular_env.viewing.rerun.caption import escape_markdown
from granular_env.viewing.rerun.scene import time_columns
from granular_env.viewing.scene_data import Motion
from granular_env.viewing.scene_scales import Scales, enlarge_limit

from .closeup import WINDOW, closeup_camera, has_closeup, send_closeup
from .profile_and_bars import WORDS, row_layout, send_bars, send_guides, send_profile
from .space_time_diagram import GrowingPicture, Picture, space_time_picture


class ChainViews(Views):
    """The views of a chain as the viewer needs them; see `Views` for the meaning of the methods."""

    def __init__(self, motion: Motion, scales: Scales, begin: float = 0.0, end: float | None = None) -> None:
        """Compute the layout of the views; see `Views`."""
        self._row = row_layout(motion, scales)
        self._growing = None if scales.settled else GrowingPicture(begin, end)
        if self._growing is not None and motion.colour is not None:
            # Draw the axes in advance, so that the first frames do not wait for them.
            self._growing.prepare_axes(motion, scales.colour_limit)

    def vertical_extent(self, scales: Scales) -> tuple[float, float]:
        """Return the lower and upper ends of the zero lines' labels [m]."""
        beyond = (WORDS + 0.18) * self._row.height
        return self._row.contact_level - beyond, self._row.profile_level + beyond

    def add_frame(self, motion: Motion) -> bool:
        """Add a frame of a running simulation; return whether the force or overlap of the longest bar has increased."""
        if self._growing is not None and motion.colour is not None:
            self._growing.store_frame(motion)
        largest = 0.0 if motion.contact is None else float(motion.contact.max(initial=0.0))
        limit = enlarge_limit(self._row.contact_limit, largest)
        has_grown = limit != self._row.contact_limit
        self._row = dataclasses.replace(self._row, contact_limit=limit)
        return has_grown

    def send_static(self, recording: Any, motion: Motion, scales: Scales) -> None:
        """Send the close-up's camera and the zero lines."""
        if has_closeup(motion):
            closeup_camera(motion).send(recording)
        send_guides(recording, motion, scales, self._row)

    def send_frames(
        self,
        recording: Any,
        motion: Motion,
        scales: Scales,
        positions: npt.NDArray[Any],
        colours: npt.NDArray[np.uint8],
        when: list[Any],
    ) -> None:
        """Send profile, bars and close-up for the given frames."""
        send_profile(recording, motion, scales, self._row, positions, when)
        send_bars(recording, motion, scales, self._row, positions, when)
        if has_closeup(motion):
            send_closeup(recording, motion, scales, colours, when)

    def send_pictures(self, recording: Any, motion: Motion, scales: Scales) -> None:
        """Send the x-t diagram; for a whole run, also a line that marks the time shown."""
        if motion.colour is None:
            return
        if self._growing is not None:
            if self._growing.is_drawable:
                _send_picture(recording, self._growing.draw_picture(motion, scales.colour_limit))
        elif len(motion.times) > 1:
            picture = space_time_picture(motion, scales.colour_limit)
            _send_picture(recording, picture)
            _send_time_line(recording, picture, motion)

    def full_width_panes(self, motion: Motion, scales: Scales) -> list[tuple[Any, float]]:
        """Return the pane with the close-up."""
        if not has_closeup(motion):
            return []
        name = f"Close-up: the {WINDOW} grains around the largest {motion.colour_variable.name}"
        drawn = f"overlaps drawn {scales.stretch_text}" if motion.located else "positions at the start"
        return [(closeup_camera(motion).make_pane(f"{name}; {drawn}", ["closeup/**"]), 1.2)]

    def side_panes(self, motion: Motion, scales: Scales) -> list[Any]:
        """Return the pane with the x-t diagram."""
        if motion.colour is None or (scales.settled and len(motion.times) < 2):
            return []
        return [import_optional("rerun.blueprint", "the viewer").Spatial2DView(origin="space_time", name="x-t diagram")]

    def caption_paragraphs(self, motion: Motion, scales: Scales) -> list[str]:
        """Return captions for the curve, the bars, the close-up and the diagram."""
        name, unit = escape_markdown(motion.colour_variable.name), escape_markdown(motion.colour_variable.unit)
        words = []
        if motion.colour is not None:
            words.append(f"**White curve above:** {name} of each grain, full height {scales.colour_limit:g} {unit}.")
        if motion.contact is not None:
            limit = f"{self._row.contact_limit:g} {motion.contact_unit}"
            words.append(f"**Bars below:** {motion.contact_name} of each contact, full length {limit}.")
        if has_closeup(motion):
            words.append(f"**Close-up:** the {WINDOW} grains around the largest {name}, numbered from 0 at the left.")
        if len(motion.times) > 1 or not scales.settled:
            words.append(f"**x-t diagram:** {name} of every grain; grey: instants without a frame.")
        if len(motion.times) > 1:
            words.append("The orange line marks the present time.")
        return words


def _send_picture(recording: Any, picture: Picture) -> None:
    """Send the x-t diagram, replacing an earlier one."""
    recording.log("space_time/picture", import_optional("rerun", "the viewer").Image(picture.pixels), static=True)


def _send_time_line(recording: Any, picture: Picture, motion: Motion) -> None:
    rr = import_optional("rerun", "the viewer")
    rows = picture.pixel_rows(motion.times)
    lines = np.empty((len(rows), 2, 2), np.float32)
    lines[:, 0, 0], lines[:, 1, 0] = picture.left, picture.right
    lines[:, :, 1] = rows[:, None]
    now = rr.LineStrips2D.columns(strips=lines, colors=np.full((len(rows), 3), parse_rgb("#e69f00"), np.uint8))
    recording.send_columns("space_time/now", time_columns(motion.times, motion.ticks), now.partition(np.ones(len(rows), int)))
