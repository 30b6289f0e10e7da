"""The preview of a log for stock viewers: messages made from some of its frames, for display only.

A wave lasts microseconds and moves particles by microns. Therefore:

- `log_time`, which viewers play, is a **slow clock**: the whole run lasts about 10 s. `publish_time` and the time stamps inside
  the messages are the simulated time.
- Each drawable is a ``foxglove.PointCloud`` in ``/points/NAME``, ``/cells/NAME``, ``/curves/NAME`` or ``/links/NAME``.
- Each number that changes is a ROS 2 ``Float64MultiArray`` in ``/QUANTITY/NAME``, with its unit in the channel's metadata.
- ``/about`` describes clock, factor and colours, and lists units.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...components.drawables import Drawable, drawn_outputs
from ...components.variables import Variable, entry_names
from . import encoding
from .clouds import Clouds, Picture, shown_drawables

# Approximate length of the whole run on the slow clock [s].
_SHOWN_SECONDS = 10.0
# Limits on the numbers of frames with numbers, of drawn frames, and of their bytes.
MOST_FRAMES, MOST_PICTURES, _MOST_BYTES = 400, 100, 8 << 20
# Largest number of elements of a plotted array, because rerun 0.41 gives each number a view, and at most eight views at first.
_MOST_ELEMENTS = 4
# A number is plotted if it changes by more than this part of the largest number in its balance or array.
_SMALL = 0.02
ABOUT_TOPIC = "/about"
# Quantities of numbers that belong to no balance, by unit.
_QUANTITIES = {
    "J": "energy", "W": "power", "kg m/s": "momentum", "N": "force", "Pa": "pressure", "m": "length", "m2": "area",
    "m/s": "velocity", "m/s^2": "acceleration", "kg": "mass", "K": "temperature", "s": "time", "rad": "angle", "1": "number",
}  # fmt: skip


class Topic(NamedTuple):
    """A channel of the log: its name, schema, encoding and definition of its messages, and its metadata."""

    name: str
    schema: str
    encoding: str
    definition: bytes
    metadata: Mapping[str, str] = {}

    @property
    def message_encoding(self) -> str:
        """Return MCAP's name for the encoding of the messages."""
        return "cdr" if self.encoding == "ros2msg" else self.encoding


class PreviewMessage(NamedTuple):
    """A message of the preview: its `log_time` is on the slow clock, its `publish_time` is the simulated time [ns]."""

    topic: Topic
    log_time: int
    publish_time: int
    data: bytes


class Preview:
    """The frames kept for the preview of a log: every n-th frame, so that memory and file size are bounded for any run.

    Args:
        title: title of the log.
        drawables: drawables of the component; those without recorded outputs are omitted.
        variables: recorded variables by name.
        quantities: name of a balance's variable -> quantity of the balance.
    """

    def __init__(
        self, title: str, drawables: Sequence[Drawable], variables: Mapping[str, Variable], quantities: Mapping[str, str]
    ) -> None:
        self._title, self._variables, self._quantities = title, variables, quantities
        self._drawables = shown_drawables(drawables, variables)
        self._topics = number_topics(variables, quantities)
        self._drawn = drawn_outputs(self._drawables)
        size = sum(4 * math.prod(variables[name].shape) for name in self._drawn)
        self._most_pictures = max(8, min(MOST_PICTURES, _MOST_BYTES // max(size, 1)))
        self._count, self._row_stride, self._picture_stride = 0, 1, 1
        self._rows: list[tuple[int, list[float]]] = []
        self._pictures: list[Picture] = []

    def add_frame(self, nanoseconds: int, values: Mapping[str, Any]) -> None:
        """Add the next frame: its time since the start of the log, and the recorded values by name."""
        if self._count % self._row_stride == 0:
            self._rows.append(
                (nanoseconds, [float(np.asarray(values[one.name])[place]) for one, place in self._topics.values()])
            )
        if self._count % self._picture_stride == 0:
            drawn = {name: np.array(values[name], dtype=np.float32) for name in self._drawn}
            self._pictures.append((nanoseconds, drawn))
        if len(self._rows) > MOST_FRAMES:
            self._rows, self._row_stride = self._rows[::2], 2 * self._row_stride
        if len(self._pictures) > self._most_pictures:
            self._pictures, self._picture_stride = self._pictures[::2], 2 * self._picture_stride
        self._count += 1

    def messages(self) -> list[PreviewMessage]:
        """Return all messages of the preview in the order of time."""
        if not self._rows:
            return []
        start = self._rows[0][0]
        # Simulated time per second of the slow clock [ns], rounded to two digits.
        unit = float(f"{(max(self._rows[-1][0], self._pictures[-1][0]) - start) / _SHOWN_SECONDS:.1e}") or 1e9
        text = [self._title, f"1 s of playback is {_time_text(unit)} of simulated time."]
        found = [*self._draw(text), *self._plot(text)]
        about = Topic(ABOUT_TOPIC, encoding.TEXT_NAME, "ros2msg", encoding.TEXT.encode())
        shown = [PreviewMessage(topic, round((time - start) / unit * 1e9), time, data) for topic, time, data in found]
        shown.sort(key=lambda message: message.log_time)
        return [PreviewMessage(about, 0, start, encoding.encode_text("\n".join(text))), *shown]

    def _draw(self, text: list[str]) -> Iterator[tuple[Topic, int, bytes]]:
        """Yield topic, time and content of the point clouds; add the sentences on them to the text of ``/about``."""
        if not self._drawables:
            return
        clouds = Clouds(self._drawables, self._variables, self._pictures)
        text += clouds.sentences
        for time, drawn in self._pictures:
            for name, places, colours in clouds.messages(drawn):
                topic = Topic(name, "foxglove.PointCloud", "protobuf", encoding.point_cloud_schema())
                yield topic, time, encoding.encode_point_cloud(time, places, colours)

    def _plot(self, text: list[str]) -> Iterator[tuple[Topic, int, bytes]]:
        """Yield topic, time and content of the numbers that change; add their units to the text of ``/about``."""
        columns = np.array([row for _, row in self._rows]).T
        finite = np.nan_to_num(columns, posinf=0.0, neginf=0.0)
        groups = [self._quantities.get(one.name, one.name) for one, _ in self._topics.values()]
        largest = {name: np.abs(finite[[own == name for own in groups]]).max() for name in groups}
        changes = np.ptp(finite, axis=1) > [_SMALL * largest[name] for name in groups]
        plotted = [(topic, one, columns[row]) for row, (topic, (one, _)) in enumerate(self._topics.items()) if changes[row]]
        units = dict.fromkeys(f"{topic_quantity(topic)} {one.unit}" for topic, one, _ in plotted if one.unit != "1")
        text += [f"Units: {', '.join(units)}."] if units else []
        text += [f"Not plotted: numbers that change by less than {_SMALL:.0%} of the largest in their balance or array."]
        for name, one, column in plotted:
            texts = {"unit": one.unit, "description": one.description}
            topic = Topic(name, encoding.NUMBERS_NAME, "ros2msg", encoding.NUMBERS.encode(), texts)
            for (time, _), data in zip(self._rows, encoding.encode_numbers(column), strict=True):
                yield topic, time, data


def number_topics(
    variables: Mapping[str, Variable], quantities: Mapping[str, str]
) -> dict[str, tuple[Variable, tuple[int, ...]]]:
    """Return topic -> variable and index of each number that viewers can plot: scalars, and the elements of short arrays.

    Only the first balance, the energy, is plotted.
    """
    found, first = dict[str, tuple[Variable, tuple[int, ...]]](), next(iter(quantities.values()), None)
    for name, one in variables.items():
        quantity = quantities.get(name)
        if math.prod(one.shape) > _MOST_ELEMENTS or quantity not in (None, first):
            continue
        for place in np.ndindex(one.shape):
            axes = zip(place, one.axes or [""] * len(place), one.shape, strict=True)
            ends = [(entry_names(axis, size) or range(size))[number] for number, axis, size in axes]
            found[f"/{quantity or _QUANTITIES.get(one.unit, 'other')}/{'_'.join(map(str, [name, *ends]))}"] = (one, place)
    return found


def topic_quantity(topic: str) -> str:
    """Return the quantity of a topic with numbers."""
    return topic.split("/")[1]


def _time_text(nanoseconds: float) -> str:
    """Return a time in s, ms, us or ns."""
    sizes = {"s": 1e9, "ms": 1e6, "us": 1e3, "ns": 1.0}
    name = next((name for name, size in sizes.items() if nanoseconds >= size), "ns")
    return f"{nanoseconds / sizes[name]:g} {name}"
