"""The preview of a log for stock viewers: messages made from some of its frames, for display only.

A wave lasts microseconds and moves particles by microns. Therefore:

- `log_time`, which viewers play, is a **slow clock**: the whole run lasts about 10 s. `publish_time` and the time stamps inside
  the messages are the simulated time.
- Each drawable is a ``foxglove.PointCloud`` in ``/points/NAME``, ``/cells/NAME``, ``/curves/NAME`` or ``/links/NAME``.
- Each number that changes is a ROS 2 ``Float64MultiArray`` in ``/QUANTITY/NAME``, with its unit in the channel's metadata.
- ``/about`` describes clock, factor and colours, and lists units and constants.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...components.drawables import Drawable, drawn_outputs
from ...components.variables import Variable
from . import encoding
from .clouds import Clouds, Picture, shown_drawables

# Approximate length of the whole run on the slow clock [s].
_SHOWN_SECONDS = 10.0
_SINGLE_DIGITS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
# Limits on the numbers of frames with numbers, of drawn frames, and of their bytes.
MOST_FRAMES, MOST_PICTURES, _MOST_BYTES = 400, 100, 8 << 20
# Limits on the numbers of plotted balances (energy and momentum are the first) and of elements of a plotted array, because
# rerun 0.41 gives each number a view, and at most eight views at first.
_MOST_BALANCES, _MOST_ELEMENTS = 2, 4
# A number that changes by less than this part of its magnitude is constant; see `_group_numbers` for small numbers.
_CONSTANT, _SMALL = 1e-9, 0.05
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
        unit = _clock_unit(max(self._rows[-1][0], self._pictures[-1][0]) - start)
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
        """Yield topic, time and content of the numbers that change; add units and constants to the text of ``/about``."""
        columns = np.array([row for _, row in self._rows]).T
        groups = {topic: self._quantities.get(one.name, one.name) for topic, (one, _) in self._topics.items()}
        plotted, constant, omits = _group_numbers(dict(zip(self._topics, columns, strict=True)), groups)
        units = {topic: "" if one.unit == "1" else one.unit for topic, (one, _) in self._topics.items()}
        named = dict.fromkeys(f"{topic_quantity(topic)} {units[topic]}" for topic in plotted if units[topic])
        text += [f"Units: {', '.join(named)}."] if named else []
        kept = [f"{topic.rpartition('/')[2]} {value:.4g} {units[topic]}".strip() for topic, value in constant.items()]
        text += [f"Constant: {', '.join(kept)}."] if kept else []
        text += [f"Not plotted: numbers below {_SMALL:.0%} of the largest in their balance or array."] if omits else []
        for name, column in plotted.items():
            one, _ = self._topics[name]
            texts = {"unit": one.unit, "description": one.description}
            topic = Topic(name, encoding.NUMBERS_NAME, "ros2msg", encoding.NUMBERS.encode(), texts)
            for (time, _), data in zip(self._rows, encoding.encode_numbers(column), strict=True):
                yield topic, time, data


def number_topics(
    variables: Mapping[str, Variable], quantities: Mapping[str, str]
) -> dict[str, tuple[Variable, tuple[int, ...]]]:
    """Return topic -> variable and index of each number that viewers can plot: scalars, and the elements of short arrays.

    Vectors of a balance are omitted, and so are all but the first balances.
    """
    found, balances = dict[str, tuple[Variable, tuple[int, ...]]](), list(dict.fromkeys(quantities.values()))[:_MOST_BALANCES]
    for name, one in variables.items():
        quantity = quantities.get(name)
        if math.prod(one.shape) > _MOST_ELEMENTS or (quantity is not None and (one.shape or quantity not in balances)):
            continue
        for place in np.ndindex(one.shape):
            axes = zip(place, [*one.axes, *[""] * len(place)], strict=False)
            ends = ["xyz"[number] if axis == "direction" and number < 3 else str(number) for number, axis in axes]
            found[f"/{quantity or _QUANTITIES.get(one.unit, 'other')}/{'_'.join([name, *ends])}"] = (one, place)
    return found


def topic_quantity(topic: str) -> str:
    """Return the quantity of a topic with numbers."""
    return topic.split("/")[1]


def _group_numbers(
    numbers: Mapping[str, np.ndarray], groups: Mapping[str, str]
) -> tuple[dict[str, np.ndarray], dict[str, float], bool]:
    """Return topic -> values of the numbers to plot, topic -> value of the constants, and whether small numbers are omitted.

    Small numbers of a group (a balance or an array) are omitted: they are below `_SMALL` times the largest of the group. So is
    a balance whose residual is as large as its entries, which are rounding errors then.
    """
    plotted, constant, omits = dict[str, np.ndarray](), dict[str, float](), False
    finite = {name: values[np.isfinite(values)] for name, values in numbers.items()}
    sizes = {name: float(np.abs(values).max(initial=0.0)) for name, values in finite.items()}
    for name, values in numbers.items():
        own = {one: sizes[one] for one in numbers if groups[one] == groups[name]}
        residual = max((size for one, size in own.items() if one.endswith("_residual")), default=0.0)
        largest = max((size for one, size in own.items() if not one.endswith("_residual")), default=0.0)
        if not sizes[name] or 2.0 * residual > largest:
            continue
        if sizes[name] < _SMALL * largest:
            omits = True
        elif np.ptp(finite[name]) > _CONSTANT * sizes[name]:
            plotted[name] = values
        else:
            constant[name] = float(finite[name][0])
    return plotted, constant, omits


def _clock_unit(nanoseconds: int) -> float:
    """Return the simulated time per second of the slow clock [ns], rounded to one digit (or 1.5, 2.5) for readability."""
    if nanoseconds <= 0:
        return 1e9
    value = nanoseconds / _SHOWN_SECONDS
    decade = float(f"1e{f'{value:e}'.partition('e')[2]}")
    return min((digit * decade for digit in _SINGLE_DIGITS), key=lambda unit: max(unit / value, value / unit))


def _time_text(nanoseconds: float) -> str:
    """Return a time in s, ms, us or ns."""
    sizes = {"s": 1e9, "ms": 1e6, "us": 1e3, "ns": 1.0}
    name = next((name for name, size in sizes.items() if nanoseconds >= size), "ns")
    return f"{nanoseconds / sizes[name]:g} {name}"
