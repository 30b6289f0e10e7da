"""A film for an HTML page: pictures of the plane at several times, and a time axis with the events.

The page runs no script. The times are radio buttons, selected with the mouse or the arrow keys, and the style sheet shows the
picture of the selected time; "play" shows all pictures in sequence.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from granular_env.components.support.float_arrays import FloatArray
from granular_env.recording.event_places import event_summary

from ..recorded_fields import pick_evenly
from ..scene_data import SceneData
from .colour_bar import draw_colour_bars
from .drawing import to_svg, use_style
from .film_figure import FilmFigure
from .plane import instant_text, load_plane, visible_events

# Most and fewest frames of a film, and most shapes drawn in all frames together; if that allows too few, there is no film.
_MOST_FRAMES, _FEWEST_FRAMES, _MOST_DRAWN = 25, 5, 200_000
# Resolution of a picture, and size of a colour bar [inch].
_DOTS_PER_INCH, _BAR_SIZE = 110.0, (7.2, 0.7)
# Size of the palette of a picture, without visible steps.
_COLOURS = 64


@dataclass(frozen=True)
class Film:
    """A film: its pictures, and the parts of the page that explain them.

    Attributes:
        instants: time label and picture (as a data: URL) of each frame, in the order of time.
        ratio: width over height of each picture.
        events: height, 0 to 1, of a bar for each picture but the first: events since the previous picture; empty without
            events.
        words: description of the events.
        bars: colour bars as SVG; empty if there are none.
    """

    instants: tuple[tuple[str, str], ...]
    ratio: float
    events: tuple[float, ...]
    words: str
    bars: str


@use_style
def make_film(log: Any, scene_data: SceneData) -> Film | None:
    """Draw the film of a log; None if it shows no plane or body in space, nothing moves, or there are too many shapes."""
    clocks = [shape.times for shape in scene_data.shapes if len(shape.times) > 1]
    if not scene_data.is_plane or not clocks:
        return None
    count = sum(len(one.radius) for one in scene_data.motions) + sum(len(one.connectivity) for one in scene_data.meshes)
    frames = min(_MOST_FRAMES, _MOST_DRAWN // count)
    plane = None if frames < _FEWEST_FRAMES else load_plane(log, scene_data, _choose_instants(log, clocks[0], frames))
    if plane is None:
        return None
    instants, figure, ratio = [], FilmFigure(plane, _DOTS_PER_INCH, is_page=True), 1.0
    for frame in range(len(plane.times)):
        pixels = figure.draw_frame(frame)
        ratio = pixels.shape[1] / pixels.shape[0]
        picture = base64.b64encode(_encode_picture(pixels)).decode()
        instants.append((instant_text(plane, frame), f"data:image/png;base64,{picture}"))
    events, words = _event_bars(log, plane.times)
    bars = draw_colour_bars(plane.colour_scales, *_BAR_SIZE) if plane.colour_scales else None
    return Film(tuple(instants), ratio, events, words, to_svg(bars, "film-bars") if bars else "")


def _choose_instants(log: Any, clock: FloatArray, frames: int) -> list[float]:
    """Return `frames` times [s]: half evenly spaced, the others concentrated at events; all evenly spaced without events."""
    events = visible_events(log)
    if not events or len(clock) <= frames:
        return clock[pick_evenly(len(clock), frames)].tolist()
    even = clock[pick_evenly(len(clock), frames - frames // 2)]
    times = np.clip(_event_times(log, events), clock[0], clock[-1])
    return np.concatenate([even, np.quantile(times, np.linspace(0.0, 1.0, frames // 2))]).tolist()


def _encode_picture(pixels: npt.NDArray[np.uint8]) -> bytes:
    """Return a picture with a transparent background as the bytes of a PNG file with a palette."""
    buffer = io.BytesIO()
    picture = Image.fromarray(pixels).quantize(_COLOURS, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    picture.save(buffer, "PNG")
    return buffer.getvalue()


def _event_bars(log: Any, instants: FloatArray) -> tuple[tuple[float, ...], str]:
    """Return the heights of the event bars, and a text on the numbers of events."""
    found = log.events()
    if not found:
        return (), ""
    times = _event_times(log, found)
    counts = np.bincount(np.searchsorted(instants[1:-1], times), minlength=len(instants) - 1)
    # Give the bars a least height, so that a single event stays visible next to thousands.
    heights = np.where(counts > 0, np.maximum(counts / counts.max(), 0.08), 0.0)
    words = event_summary(found, log.earlier_events() or [], log.start_tick * log.step_size)
    return tuple(heights.tolist()), words.replace("_", " ")


def _event_times(log: Any, events: Sequence[Any]) -> FloatArray:
    return log.step_size * np.array([event.tick for event in events], dtype=np.float64)
