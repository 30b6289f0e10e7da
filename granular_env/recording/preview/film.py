"""The preview of a log for stock viewers: messages made from some of its frames, for display only.

A wave lasts microseconds and moves particles by microns. Therefore:

- `log_time`, which viewers play, is a **slow clock**: the whole run lasts about 10 s. `publish_time` and the time stamps inside
  the messages are the simulated time.
  - Displacements are multiplied by a stated factor. Each drawable is a ``foxglove.PointCloud``: ``/points/NAME``, grey dots
    between the linked points of ``/links/NAME``, the nodes or centres of ``/cells/NAME``, the values of ``/curves/NAME`` as
    heights over the coordinate. The colouring output runs from blue through grey to red; for points in a row along x it is
    also drawn as a height.
  - One topic per unit, such as ``/energy[J]``, is a ROS 2 ``Float64MultiArray``, which viewers plot; its label has the names
    of the numbers. Scalars that stay zero are omitted.
  - ``/about`` describes factor, clock, colours and the order of the numbers.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ...colours import diverging_colours
from ...components.drawables import OUTPUT_FIELDS, Cells, Curve, Drawable, Links, Points, drawn_outputs, to_three_columns
from ...components.variables import Variable
from . import encoding
from .displacement_scale import common_exaggeration

# Approximate length of the whole run on the slow clock [s].
_SHOWN_SECONDS = 10.0
_SINGLE_DIGITS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
# Limits on the numbers of frames with scalars, of drawn frames, of their bytes, and of drawn elements of a drawable.
MOST_FRAMES, MOST_PICTURES, _MOST_BYTES, MOST_PLACES = 400, 100, 8 << 20, 5_000
# Dots per link; drawn height of a curve's largest value, relative to its length; number of colours on each side of grey.
_LINK_DOTS, _HEIGHT, _SHADES = 5, 0.22, 15
# Colour of the value 0: a grey that is visible on light and dark backgrounds.
_ZERO = "#bebebe"
ABOUT_TOPIC = "/about"
_FOLDERS = {Points: "points", Links: "links", Cells: "cells", Curve: "curves"}
COUNTED = {Points: "radius", Links: "pairs", Cells: "nodes", Curve: "coordinate"}
QUANTITIES = {
    "J": "energy", "kg m/s": "momentum", "N": "force", "m/s": "velocity", "m": "position", "m/s^2": "acceleration",
    "kg": "mass", "Pa": "pressure", "K": "temperature", "s": "time",
}  # fmt: skip
_SUPERSCRIPTS = str.maketrans("0123456789-", "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079\u207b")


class Topic(NamedTuple):
    """A channel of the log: its name, and schema, encoding and definition of its messages."""

    name: str
    schema: str
    encoding: str
    definition: bytes

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


# A picture (drawn frame): its time [ns], and the values of the drawn outputs by name.
_Picture = tuple[int, dict[str, np.ndarray]]


class Preview:
    """The frames kept for the preview of a log: every n-th frame, so that memory and file size are bounded for any run.

    Args:
        title: title of the log.
        drawables: drawables of the component; those without recorded outputs are omitted.
        variables: recorded variables by name.
    """

    def __init__(self, title: str, drawables: Sequence[Drawable], variables: Mapping[str, Variable]) -> None:
        self._title = title
        self._drawables = shown_drawables(drawables, variables)
        self._units = {name: one.unit for name, one in variables.items()}
        self._scalars = [name for name, one in variables.items() if one.shape == ()]
        self._drawn = drawn_outputs(self._drawables)
        size = sum(4 * math.prod(variables[name].shape) for name in self._drawn)
        self._most_pictures = max(8, min(MOST_PICTURES, _MOST_BYTES // max(size, 1)))
        self._count, self._row_stride, self._picture_stride = 0, 1, 1
        self._rows: list[tuple[int, list[float]]] = []
        self._pictures: list[_Picture] = []

    def add_frame(self, nanoseconds: int, values: Mapping[str, Any]) -> None:
        """Add the next frame: its time since the start of the log, and the recorded values by name."""
        if self._count % self._row_stride == 0:
            self._rows.append((nanoseconds, [float(values[name]) for name in self._scalars]))
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
        text = [
            self._title, "", f"Slow clock: 1 s here = {unit / 1e9:.3g} s simulated.",
            "Simulated time is on the timeline message_publish_time and in the time stamps of the messages.", "",
        ]  # fmt: skip
        clouds, found = _Clouds(self._drawables, self._pictures), []
        text += [*clouds.about_lines(self._units), ""]
        rows = np.array([row for _, row in self._rows], dtype=np.float64).reshape(len(self._rows), -1)
        groups: dict[str, list[int]] = {}
        for place in np.flatnonzero((rows != 0.0).any(axis=0)).tolist():
            groups.setdefault(topic_name(self._units[self._scalars[place]]), []).append(place)
        for name, places in groups.items():
            names = [self._scalars[place] for place in places]
            topic = Topic(name, encoding.NUMBERS_NAME, "ros2msg", encoding.NUMBERS.encode())
            contents = encoding.encode_numbers(names, rows[:, places])
            found += [(topic, time, data) for (time, _), data in zip(self._rows, contents, strict=True)]
            text.append(f"{name}: " + ", ".join(f"[{place}] {name}" for place, name in enumerate(names)))
        for time, drawn in self._pictures:
            found += [(topic, time, data) for topic, data in clouds.messages(time, drawn)]
        about = Topic(ABOUT_TOPIC, encoding.TEXT_NAME, "ros2msg", encoding.TEXT.encode())
        shown = [PreviewMessage(topic, round((time - start) / unit * 1e9), time, data) for topic, time, data in found]
        shown.sort(key=lambda message: message.log_time)
        return [PreviewMessage(about, 0, start, encoding.encode_text("\n".join(text))), *shown]


def _clock_unit(nanoseconds: int) -> float:
    """Return the simulated time per second of the slow clock [ns], rounded to one digit (or 1.5, 2.5) for readability."""
    if nanoseconds <= 0:
        return 1e9
    value = nanoseconds / _SHOWN_SECONDS
    decade = float(f"1e{f'{value:e}'.partition('e')[2]}")
    return min((digit * decade for digit in _SINGLE_DIGITS), key=lambda unit: max(unit / value, value / unit))


class _Clouds:
    """The drawables as point clouds, with one displacement factor and colours scaled to the largest value of all pictures."""

    def __init__(self, drawables: Sequence[Drawable], pictures: Sequence[_Picture]) -> None:
        self._drawables = drawables
        self._points = {one.name: one for one in drawables if isinstance(one, Points)}
        self._heights = {cloud_topic(one): _curve_height(one) for one in drawables}
        self._largest = {"": 1.0} | {name: _largest_magnitude(pictures, name) for name in drawn_outputs(drawables)}
        points, cells = [], []
        for one in drawables:
            if isinstance(one, Points) and one.displacement:
                some = _drawn_indices(one.radius)
                moved = _displacements(pictures, one.displacement, some)
                points.append((to_three_columns(one.reference)[some], one.radius[some], moved))
            elif isinstance(one, Cells) and one.displacement:
                some = _drawn_indices(one.nodes)
                cells.append((to_three_columns(one.nodes)[some], _displacements(pictures, one.displacement, some)))
        self._factor = common_exaggeration(points, cells)

    def messages(self, nanoseconds: int, picture: Mapping[str, np.ndarray]) -> Iterator[tuple[Topic, bytes]]:
        """Yield the point clouds of one picture; `nanoseconds` is their time on the slow clock."""
        for one in self._drawables:
            places, colours = self._make_cloud(one, picture)
            some = _drawn_indices(places)
            topic = Topic(cloud_topic(one), "foxglove.PointCloud", "protobuf", encoding.point_cloud_schema())
            yield topic, encoding.encode_point_cloud(nanoseconds, places[some], colours[some])

    def about_lines(self, units: Mapping[str, str]) -> list[str]:
        """Return the lines of the text in the topic ``/about``."""
        lines = [f"Displacements are multiplied by {self._factor:g}."] if self._drawables else []
        for one in self._drawables:
            name = "" if isinstance(one, Links) else one.colour if isinstance(one, Points) else one.field
            if name:
                full = f"{self._largest[name]:.4g} {units[name]}"
                lines.append(f"{cloud_topic(one)}: {name}, from -{full} (blue) through 0 (grey) to +{full} (red).")
        return lines

    def _make_cloud(self, drawable: Drawable, picture: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Return the positions and colours of the dots that show a drawable in a picture."""
        if isinstance(drawable, Points):
            some, moved = _drawn_indices(drawable.radius), picture.get(drawable.displacement)
            colour = picture[drawable.colour][some] if drawable.colour else np.zeros(len(drawable.radius[some]), np.float32)
            places = self._displaced_positions(drawable.reference[some], None if moved is None else moved[some])
            places[:, 2] += self._heights[cloud_topic(drawable)] * colour / self._largest[drawable.colour]
            return places, value_colours(colour, self._largest[drawable.colour])
        if isinstance(drawable, Links):
            points, state = self._points[drawable.points], picture[drawable.state]
            places = self._displaced_positions(points.reference, picture.get(points.displacement))
            whole = np.flatnonzero((state != 0.0) & points.is_unwrapped(drawable.pairs))
            first, second = places[drawable.pairs[whole, 0]], places[drawable.pairs[whole, 1]]
            parts = np.linspace(0.0, 1.0, _LINK_DOTS + 2)[1:-1]
            dots = np.concatenate([first + part * (second - first) for part in parts])
            return dots, value_colours(np.zeros(len(dots)), 1.0)
        field = picture[drawable.field]
        if isinstance(drawable, Curve):
            places = to_three_columns(drawable.coordinate)
            places[:, 2] = self._heights[cloud_topic(drawable)] * field / self._largest[drawable.field]
            return places, value_colours(field, self._largest[drawable.field])
        nodes = self._displaced_positions(drawable.nodes, picture.get(drawable.displacement))
        is_of_nodes = len(field) == len(nodes)
        places = nodes if is_of_nodes else nodes[drawable.connectivity].mean(axis=1)
        if drawable.state:
            whole = picture[drawable.state] != 0.0
            shown = np.unique(drawable.connectivity[whole]) if is_of_nodes else np.flatnonzero(whole)
            places, field = places[shown], field[shown]
        return places, value_colours(field, self._largest[drawable.field])

    def _displaced_positions(self, reference: np.ndarray, displacement: np.ndarray | None) -> np.ndarray:
        """Return the drawn positions, shape (n, 3): at rest if no displacement was recorded."""
        return to_three_columns(reference) + (
            0.0 if displacement is None else self._factor * to_three_columns(displacement.astype(np.float64))
        )


def shown_drawables(drawables: Sequence[Drawable], variables: Mapping[str, Variable]) -> tuple[Drawable, ...]:
    """Return the drawables with recorded outputs, without the names of unrecorded outputs.

    Points and cells without a recorded displacement are shown at rest; links only if their state and points are recorded.
    """
    found: list[Drawable] = []
    for one in drawables:
        if not len(getattr(one, COUNTED[type(one)])):
            continue
        roles = {role: name for role in OUTPUT_FIELDS if (name := getattr(one, role, ""))}
        recorded = {role: name if name in variables and role != "rotation" else "" for role, name in roles.items()}
        if isinstance(one, Links) and one.points not in {points.name for points in found}:
            continue
        if any(recorded.values()) if isinstance(one, Points) else recorded.get("field", recorded.get("state")):
            found.append(dataclasses.replace(one, **recorded))
    return tuple(found)


def cloud_topic(drawable: Drawable) -> str:
    """Return the topic of a drawable's point clouds."""
    return f"/{_FOLDERS[type(drawable)]}/{drawable.name}"


def bounding_box(drawables: Sequence[Drawable]) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and highest corner of all drawables in the initial state, shape (3,) each [m]."""
    lows, highs = [], []
    for one in drawables:
        if isinstance(one, Links):
            continue
        places = to_three_columns(
            one.reference if isinstance(one, Points) else one.nodes if isinstance(one, Cells) else one.coordinate
        )
        margin = one.radius[:, None] if isinstance(one, Points) else 0.0
        lows.append((places - margin).min(axis=0))
        highs.append((places + margin).max(axis=0))
        highs[-1][2] += _curve_height(one)
    return np.min(lows, axis=0), np.max(highs, axis=0)


def _curve_height(drawable: Drawable) -> float:
    """Return the drawn height of the largest value above points in a row along x, or of a curve [m]; 0 for others."""
    if isinstance(drawable, Points) and drawable.colour and not np.ptp(drawable.reference[:, 1:], axis=0).any():
        return _HEIGHT * float(np.ptp(drawable.reference[:, 0]))
    return _HEIGHT * float(np.ptp(drawable.coordinate)) if isinstance(drawable, Curve) else 0.0


def topic_name(unit: str) -> str:
    """Return the topic for the scalars that have this unit, such as ``/velocity[m\u00b7s\u207b\u00b9]``.

    The unit has no slash or space, because viewers would split the name there.
    """
    quantity = QUANTITIES.get(unit, "value")
    if unit in ("", "1"):
        return f"/{quantity}"
    factors = []
    for sign, part in zip(("", "-"), unit.partition("/")[::2], strict=True):
        for factor in part.split():
            symbol, _, exponent = factor.partition("^")
            power = sign + (exponent or "1")
            shown = f"^{power}" if "." in power else power.translate(_SUPERSCRIPTS)
            factors += [] if symbol == "1" else [symbol if power == "1" else symbol + shown]
    product = "\u00b7".join(factors)
    return f"/{quantity}[{product}]"


def value_colours(values: np.ndarray, largest: float) -> np.ndarray:
    """Return the colours of values: blue below 0, grey at 0 and for NaN, red above 0, full at `largest`; shape (n, 4) uint8."""
    with np.errstate(invalid="ignore"):
        shades = np.clip(values * np.float32(_SHADES / (largest or 1.0)), -_SHADES, _SHADES)
    return _palette()[np.rint(np.nan_to_num(shades)).astype(np.int16) + _SHADES]


@cache
def _palette() -> np.ndarray:
    shades = diverging_colours(np.linspace(-1.0, 1.0, 2 * _SHADES + 1), 1.0, _ZERO)
    return np.concatenate([shades, np.full((len(shades), 1), 255, dtype=np.uint8)], axis=1)


def _largest_magnitude(pictures: Sequence[_Picture], name: str) -> float:
    """Return the largest finite magnitude of an output in all pictures, or 1 if all values are 0."""
    values = [np.abs(drawn[name]) for _, drawn in pictures]
    return max((float(one.max(initial=0.0, where=np.isfinite(one))) for one in values), default=0.0) or 1.0


def _displacements(pictures: Sequence[_Picture], name: str, indices: slice) -> np.ndarray:
    """Return the displacements `name` of chosen elements as vectors, shape (pictures, n, 3), with 0 for non-finite values."""
    found = np.stack([to_three_columns(drawn[name][indices].astype(np.float64)) for _, drawn in pictures])
    return np.nan_to_num(found, posinf=0.0, neginf=0.0)


def _drawn_indices(places: np.ndarray) -> slice:
    """Return the indices of the elements to draw, evenly spaced if there are too many elements."""
    return slice(None, None, -(-len(places) // MOST_PLACES) or 1)
