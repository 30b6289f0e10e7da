"""A film for an HTML page: pictures of the plane at several instants, and a time axis with what happened when.

The page runs no script: the instants are radio buttons, which a mouse and the arrow keys choose from, and the style sheet shows
the picture of the one that is chosen; "play" lets it show them in turn.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import Image

from granular_env.components.support.float_arrays import FloatArray

from ..recorded_fields import evenly_picked
from ..scene_data import SceneData
from .colour_bar import draw_bars
from .drawing import canvas, new_figure, svg, time_unit, with_style
from .plane import Plane, draw_instant, events_in_sight, instant_words, load_plane, stretch_words

# Frames, and shapes in all of them together: fewer frames of many shapes, and no film where few would be left.
_MOST_FRAMES, _FEWEST_FRAMES, _MOST_DRAWN = 25, 5, 200_000
# The largest picture [inch] and its fineness.
_LARGEST, _DOTS_PER_INCH = (7.2, 6.4), 110
# Larger pictures get a palette, which makes them a third of the size; its steps are not visible in them.
_MOST_BYTES, _COLOURS = 40_000, 64


@dataclass(frozen=True)
class Film:
    """A film.

    Attributes:
        instants: time in words and picture as an address (data:) of each, in the order of time.
        ratio: width over height of each.
        events: height of a bar for each picture but the first, 0 to 1: what happened since the one before; empty where nothing
            happened.
        words: what happened when.
        bars: what the colours mean, as SVG; empty where there are none.
        stretch: how displacements are drawn, in words; empty where they are true to scale.
    """

    instants: tuple[tuple[str, str], ...]
    ratio: float
    events: tuple[float, ...]
    words: str
    bars: str
    stretch: str = ""


def film_of(log: Any, scene_data: SceneData) -> Film | None:
    """Draw the film of a log; None where nothing lies or moves in a plane, nothing moves at all, or too much would be drawn."""
    clocks = [shape.times for shape in scene_data.shapes if len(shape.times) > 1]
    if not scene_data.is_plane or not clocks:
        return None
    count = sum(len(one.radius) for one in scene_data.motions) + sum(len(one.connectivity) for one in scene_data.meshes)
    frames = min(_MOST_FRAMES, _MOST_DRAWN // count)
    plane = None if frames < _FEWEST_FRAMES else load_plane(log, scene_data, _instants(log, clocks[0], frames))
    if plane is None:
        return None
    instants = []
    for frame in range(len(plane.times)):
        picture = base64.b64encode(_picture(plane, frame)).decode()
        instants.append((instant_words(plane, frame), f"data:image/png;base64,{picture}"))
    events, words = _events(log, plane.times)
    width, height = _size(plane)
    bars = _bars(plane) if plane.scales.colours else ""
    return Film(tuple(instants), width / height, events, words, bars, stretch_words(plane))


def _instants(log: Any, clock: FloatArray, frames: int) -> list[float]:
    """Return as many instants [s]: half of them evenly spaced, the others closer where more happens; all where nothing does."""
    events = events_in_sight(log)
    if not events or len(clock) <= frames:
        return clock[evenly_picked(len(clock), frames)].tolist()
    even = clock[evenly_picked(len(clock), frames - frames // 2)]
    times = np.clip(_times(log, events), clock[0], clock[-1])
    return np.concatenate([even, np.quantile(times, np.linspace(0.0, 1.0, frames // 2))]).tolist()


def _size(plane: Plane) -> tuple[float, float]:
    """Return width and height of the pictures [inch]."""
    low, high = plane.box
    width, height = (high - low).tolist()
    inches = min(_LARGEST[0] / width, _LARGEST[1] / height)
    return inches * width, inches * height


@with_style
def _picture(plane: Plane, frame: int) -> bytes:
    """Return the picture of one frame, on no ground, as the bytes of a PNG file."""
    figure = new_figure(*_size(plane))
    figure.set_layout_engine("none")
    figure.patch.set_alpha(0.0)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.patch.set_alpha(0.0)
    draw_instant(axes, plane, frame)
    picture = Image.fromarray(np.asarray(canvas(figure, _DOTS_PER_INCH).buffer_rgba()))
    data = _png(picture)
    if len(data) > _MOST_BYTES:
        data = _png(picture.quantize(_COLOURS, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE))
    return data


def _png(picture: Image.Image) -> bytes:
    buffer = io.BytesIO()
    picture.save(buffer, "PNG")
    return buffer.getvalue()


@with_style
def _bars(plane: Plane) -> str:
    return svg(draw_bars(plane.scales.colours, _LARGEST[0], 0.7), "film-bars")


def _events(log: Any, instants: FloatArray) -> tuple[tuple[float, ...], str]:
    """Return the heights of the bars of events, and in words how many there are, when the first was, and what was before."""
    found, earlier = log.events(), log.earlier_events()
    if not found:
        return (), ""
    times = _times(log, found)
    counts = np.bincount(np.searchsorted(instants[1:-1], times), minlength=len(instants) - 1)
    # A single event next to thousands is still visible.
    heights = np.where(counts > 0, np.maximum(counts / counts.max(), 0.08), 0.0)
    scale, unit = time_unit(float(instants[-1]))
    before = f"; before this log begins {_count_words(earlier)}" if earlier else ""
    return tuple(heights.tolist()), f"{_count_words(found)}, the first at {times[0] * scale:.4g} {unit}{before}"


def _times(log: Any, events: Sequence[Any]) -> FloatArray:
    return log.step_size * np.array([event.tick for event in events], dtype=np.float64)


def _count_words(events: Sequence[Any]) -> str:
    kinds = [event.kind for event in events]
    return ", ".join(f"{kinds.count(kind)} x {kind.replace('_', ' ')}" for kind in dict.fromkeys(kinds))
