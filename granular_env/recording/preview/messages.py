"""The preview of a log for stock viewers: derived data, a pure function from the frames of a run to messages.

    messages = list(preview_messages(facts, frames))

`facts` follow from the header (or from the component), `frames` are those that `frame_selection.PreviewFrames` has kept of the
recorded ones: a program that runs a log again, passes each recorded frame to such a selection, and calls this function, finds
the same bytes in the log.
Nothing else enters: no clock of the machine, no random number, no size of a batch.

A run of a wave lasts microseconds and moves particles by microns, so the messages have two clocks and show the particles twice:

- `log_time` is a **slow clock**: the whole run lasts about 10 s. Viewers play it by default. `publish_time` and the time stamps
  inside the messages are the simulated time.
- ``/particles``: every particle at its true place, a ``foxglove.PointCloud``.
- ``/preview``: beside it, displacements multiplied by a stated factor; over each particle a column as high as the colouring
  quantity. ``/preview/spheres``: the same particles as spheres of their sizes, a ``foxglove.SceneUpdate``.
- ``/links/NAME``, ``/cells/NAME``, ``/curves/NAME``: the other drawables as point clouds at their true places: dots between
  linked points, the nodes or centres of cells, a curve's values as heights over its coordinate.
- one topic for each unit, such as ``/energy[J]``: a ROS 2 ``Float64MultiArray``, which stock rerun plots; and ``/scalars``: the
  same numbers as named fields (``kinetic_energy_J``) for Foxglove and PlotJuggler. What is zero all the time is left out.
- ``/about``: factor, clocks, colours and the order of the numbers, in words.

Messages are single precision, thinned and rounded to what can be seen: never read back.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache

import numpy as np

from ...colours import diverging
from ...components.drawables import Cells, Curve, Drawable, Links, Points, main_points, spatial
from ..format import protobuf
from . import cdr
from .displacement_scale import choose_exaggeration

# About so long lasts the whole run on the slow clock [s].
_SHOWN_SECONDS = 10.0
_SINGLE_DIGITS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
# Bounds of what is drawn: moving pictures, particles of the preview, those drawn as spheres or with columns.
MOST_PICTURES = 100
_MOST_PARTICLES, _MOST_SPHERES = 500, 200
# Parts of the picture's length: how far the preview is lifted beside the true particles, the highest column. With less,
# the camera that rerun chooses stands so near that it sees half of a long row.
_LIFT, _HEIGHT = 0.55, 0.22
_COLUMN_POINTS = 8
# Dots that a link is drawn as; links, nodes or samples of a curve beyond which it is left out of the preview.
_LINK_DOTS, _MOST_OTHERS = 5, 20_000
# Steps to which heights, displacements (per radius) and shades are rounded: unchanged particles then cost next to no bytes.
_HEIGHT_STEPS, _PLACES_PER_RADIUS, _SHADES = 32, 16, 15
# Seen on light and on dark grounds.
_ZERO = "#bebebe"

PARTICLES_TOPIC, PREVIEW_TOPIC, SPHERES_TOPIC = "/particles", "/preview", "/preview/spheres"
SCALARS_TOPIC, ABOUT_TOPIC = "/scalars", "/about"

QUANTITIES = {
    "J": "energy", "kg m/s": "momentum", "N": "force", "m/s": "velocity", "m": "position", "m/s^2": "acceleration",
    "kg": "mass", "Pa": "pressure", "K": "temperature", "s": "time",
}  # fmt: skip
_SUPERSCRIPTS = str.maketrans("0123456789-", "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079\u207b")
_DIMENSIONLESS = ("", "1")


@dataclasses.dataclass(frozen=True, slots=True)
class PreviewFacts:
    """The facts that the preview needs beside the frames.

    Attributes:
        title: name of the experiment, else of the component.
        drawables: what the messages are made of.
        drawn_units: unit of each output that the component's drawables show, by name.
        sizes: how many numbers each of these outputs holds.
        units: unit of each scalar, by name, in the order of `PreviewFrame.scalars`.
    """

    title: str
    drawables: tuple[Drawable, ...]
    drawn_units: Mapping[str, str]
    sizes: Mapping[str, int]
    units: Mapping[str, str]


@dataclasses.dataclass(frozen=True, slots=True)
class PreviewFrame:
    """One instant.

    Attributes:
        number: how many frames were recorded before it.
        nanoseconds: simulated time since the log began [ns].
        scalars: one value for each of the facts' units.
        drawn: the outputs that the messages are made of, by name, single precision.
    """

    number: int
    nanoseconds: int
    scalars: Sequence[float]
    drawn: Mapping[str, np.ndarray]


@dataclasses.dataclass(frozen=True, slots=True)
class Topic:
    """A channel of the log: its name, and schema, encoding and definition of its messages."""

    name: str
    schema: str
    encoding: str
    definition: bytes

    @property
    def message_encoding(self) -> str:
        """Return what MCAP calls the encoding of the messages."""
        return "cdr" if self.encoding == "ros2msg" else self.encoding


@dataclasses.dataclass(frozen=True, slots=True)
class PreviewMessage:
    """One message, in parts: `log_time` on the slow clock, `publish_time` simulated [ns]."""

    topic: Topic
    log_time: int
    publish_time: int
    parts: Sequence[bytes | memoryview]


def preview_messages(facts: PreviewFacts, frames: Sequence[PreviewFrame]) -> Iterator[PreviewMessage]:
    """Yield the whole preview of a run, in the order of time.

    Args:
        facts: what is drawn, and the units.
        frames: in the order of time.
    """
    if not frames:
        return
    clock = SlowClock.of(frames)
    scalars = _Scalars.of(facts, frames)
    scene, others = Scene.of(facts, frames), Others.of(facts, frames)
    yield _about(facts, clock, scene, scalars)
    pictures = set(_evenly(len(frames), MOST_PICTURES))
    for place, frame in enumerate(frames):
        times = clock.at(frame.nanoseconds), frame.nanoseconds
        for topic, encoded in scalars.topics:
            yield PreviewMessage(topic, *times, [encoded[place]])
        if scene is not None and place in pictures:
            for topic, parts in scene.pictures(frame):
                yield PreviewMessage(topic, *times, parts)
        if place in pictures:
            for topic, parts in others.pictures(frame):
                yield PreviewMessage(topic, *times, parts)


def _evenly(available: int, wanted: int) -> list[int]:
    """Return places of evenly spaced items, the first and the last among them."""
    if available <= wanted:
        return list(range(available))
    return [round(place * (available - 1) / (wanted - 1)) for place in range(wanted)]


# -- time ------------------------------------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True, slots=True)
class SlowClock:
    """Simulated time as viewers play it: `unit` simulated nanoseconds take one second; it starts at `start` with 0."""

    start: int
    end: int
    unit: float

    @staticmethod
    def of(frames: Sequence[PreviewFrame]) -> SlowClock:
        """Return the clock for frames: the unit has a single digit (or 1.5, 2.5), so that the ticks of a plot can be read."""
        start, end = frames[0].nanoseconds, frames[-1].nanoseconds
        return SlowClock(start, end, _single_digit((end - start) / _SHOWN_SECONDS) if end > start else 1e9)

    def at(self, nanoseconds: int) -> int:
        """Return the time on this clock [ns]."""
        return round((nanoseconds - self.start) / self.unit * 1e9)


def _single_digit(value: float) -> float:
    decade = float(f"1e{f'{value:e}'.partition('e')[2]}")
    return min((digit * decade for digit in _SINGLE_DIGITS), key=lambda unit: max(unit / value, value / unit))


# -- scalars ---------------------------------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True, slots=True)
class _Scalars:
    """Topics with one encoded message for each frame, and the names behind the numbers of each topic."""

    topics: list[tuple[Topic, list[bytes]]]
    names: dict[str, list[str]]

    @staticmethod
    def of(facts: PreviewFacts, frames: Sequence[PreviewFrame]) -> _Scalars:
        rows = np.array([frame.scalars for frame in frames], dtype=np.float64).reshape(len(frames), -1)
        names = list(facts.units)
        acting = [place for place in range(len(names)) if np.any(rows[:, place] != 0.0)]
        groups: dict[str, list[int]] = {}
        for place in acting:
            groups.setdefault(topic_name(facts.units[names[place]]), []).append(place)
        topics, labels = [], {}
        for name, places in groups.items():
            labels[name] = [names[place] for place in places]
            topic = Topic(name, cdr.NUMBERS_NAME, "ros2msg", cdr.NUMBERS.encode())
            topics.append((topic, cdr.encode_numbers(", ".join(labels[name]), rows[:, places])))
        if not acting:
            return _Scalars([], {})
        fields = [field_name(names[place], facts.units[names[place]]) for place in acting]
        topic = Topic(SCALARS_TOPIC, "granular.Scalars", "protobuf", protobuf.scalars_schema(fields))
        topics.append((topic, protobuf.encode_scalars(rows[:, acting])))
        return _Scalars(topics, labels)


def topic_name(unit: str) -> str:
    """Return the topic of the scalars of a unit, such as ``/velocity[m\u00b7s\u207b\u00b9]``.

    There is no slash or space in the unit: viewers would split the name there.
    """
    quantity = QUANTITIES.get(unit, "value")
    return f"/{quantity}" if unit in _DIMENSIONLESS else f"/{quantity}[{_as_product(unit)}]"


def _as_product(unit: str) -> str:
    """Return ``kg m/s`` as a product of powers, with dots and superscripts."""
    above, _, below = unit.partition("/")
    factors = [_power(part, 1) for part in above.split()] + [_power(part, -1) for part in below.split()]
    return "\u00b7".join(factor for factor in factors if factor)


def _power(factor: str, sign: int) -> str:
    symbol, _, exponent = factor.partition("^")
    exponent = ("" if sign > 0 else "-") + (exponent or "1")
    if symbol == "1" or exponent == "1":
        return "" if symbol == "1" else symbol
    return symbol + (exponent.translate(_SUPERSCRIPTS) if "." not in exponent else f"^{exponent}")


def field_name(name: str, unit: str) -> str:
    """Return the field of ``/scalars`` for a scalar, such as ``left_velocity_m_per_s``."""
    if unit in _DIMENSIONLESS:
        return name
    words = unit.replace("/", " per ").replace("^", "").replace(".", "p").replace("%", "percent")
    return "_".join([name, *("".join(c if c.isalnum() and c.isascii() else "_" for c in words).split("_"))]).replace("__", "_")


# -- particles -------------------------------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True, slots=True)
class Scene:
    """The particles beside the true ones: which, where at rest, how much their displacements and heights are multiplied.

    Attributes:
        points: all of them, their reference with three columns.
        blocks: first particle of each block that one drawn stands for, shape (n,); each alone where there are few.
        reference, radius: of those drawn, lifted; shapes (n, 3), (n,) [m].
        exaggeration: factor of the displacements.
        lift: height above the true particles [m].
        largest: magnitude of the colouring quantity that gives the fullest colour and the highest column.
        height: of that column [m].
    """

    points: Points
    blocks: np.ndarray
    reference: np.ndarray
    radius: np.ndarray
    exaggeration: float
    lift: float
    largest: float
    height: float

    @staticmethod
    def of(facts: PreviewFacts, frames: Sequence[PreviewFrame]) -> Scene | None:
        """Return the scene of frames; None without particles."""
        points = main_points(facts.drawables)
        if points is None or not len(points.radius):
            return None
        blocks = np.arange(0, len(points.radius), -(-len(points.radius) // _MOST_PARTICLES))
        reference, radius = points.reference[blocks], points.radius[blocks]
        moved = np.stack([_vectors(frame.drawn[points.displacement], blocks) for frame in frames])
        lift, height = _lift_and_height(*_extent(points))
        largest = _largest(frames, points.colour)
        factor = choose_exaggeration(reference, radius, moved)
        return Scene(points, blocks, reference + [0.0, 0.0, lift], radius, factor, lift, largest, height)

    def pictures(self, frame: PreviewFrame) -> Iterator[tuple[Topic, list[bytes | memoryview]]]:
        """Yield the messages of one frame."""
        time, displacement = frame.nanoseconds, frame.drawn[self.points.displacement]
        colour = frame.drawn.get(self.points.colour, np.zeros(len(self.points.radius), np.float32))
        true = positions_of(self.points, displacement)
        yield _cloud_topic(PARTICLES_TOPIC), protobuf.encode_point_cloud(time, true, colours_of(colour, self.largest))
        part = self._part(colour)
        places, colours = self._places(displacement), colours_of(part, 1.0)
        yield _cloud_topic(PREVIEW_TOPIC), protobuf.encode_point_cloud(time, *self._with_columns(places, part, colours))
        if len(places) <= _MOST_SPHERES:
            yield _spheres_topic(), protobuf.encode_spheres(time, places, self.radius, colours)

    def _part(self, colour: np.ndarray) -> np.ndarray:
        """Return the extreme of each block as a part of the largest, -1 to 1, in steps."""
        high, low = np.maximum.reduceat(colour, self.blocks), np.minimum.reduceat(colour, self.blocks)
        extreme = np.nan_to_num(np.where(high >= -low, high, low) / self.largest, posinf=1.0, neginf=-1.0)
        return np.rint(extreme * _HEIGHT_STEPS) / _HEIGHT_STEPS

    def _places(self, displacement: np.ndarray) -> np.ndarray:
        return self._round_lengths(self.reference + self.exaggeration * _vectors(displacement, self.blocks))

    def _round_lengths(self, lengths: np.ndarray) -> np.ndarray:
        """Return lengths in steps of a power of two: numbers of few digits compress well."""
        step = 2.0 ** math.frexp(self.radius.min() / _PLACES_PER_RADIUS)[1]
        return np.rint(lengths / step) * step

    def _with_columns(self, places: np.ndarray, part: np.ndarray, colours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the particles drawn, and the points over (or under) them, one on top."""
        owners, heights = [np.arange(len(places))], [np.zeros(len(places))]
        if len(places) <= _MOST_SPHERES:
            rungs = np.arange(1, _COLUMN_POINTS)
            rung, owner = np.nonzero(np.abs(part) * _COLUMN_POINTS > rungs[:, None])
            owners.append(owner)
            heights.append(np.sign(part[owner]) * (rungs[rung] / _COLUMN_POINTS))
        tops = np.flatnonzero(part)
        owner = np.concatenate([*owners, tops])
        points = places[owner]
        points[:, 2] += self._round_lengths(np.concatenate([*heights, part[tops]]) * self.height)
        return points, colours[owner]


@cache
def _cloud_topic(name: str) -> Topic:
    return Topic(name, "foxglove.PointCloud", "protobuf", protobuf.point_cloud_schema())


@cache
def _spheres_topic() -> Topic:
    return Topic(SPHERES_TOPIC, "foxglove.SceneUpdate", "protobuf", protobuf.scene_update_schema())


def _largest(frames: Sequence[PreviewFrame], name: str) -> float:
    """Return the largest finite magnitude of an output in all frames; 1 where it stays 0, or there is none."""
    drawn = [np.abs(frame.drawn[name]) for frame in frames if name in frame.drawn]
    return max((float(values.max(initial=0.0, where=np.isfinite(values))) for values in drawn), default=0.0) or 1.0


# -- links, cells, curves --------------------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True, slots=True)
class Others:
    """The drawables that are no points, and what scales them.

    Attributes:
        points: the points that links join, by name, their reference with three columns.
        drawables: links, cells and curves.
        largest: magnitude of the output that gives the fullest colour, by name.
    """

    points: Mapping[str, Points]
    drawables: tuple[Drawable, ...]
    largest: Mapping[str, float]

    @staticmethod
    def of(facts: PreviewFacts, frames: Sequence[PreviewFrame]) -> Others:
        """Return what there is to draw beside the points."""
        points = {one.name: main_points([one]) for one in facts.drawables if isinstance(one, Points)}
        drawables = tuple(one for one, _ in topics_of_others(facts.drawables))
        largest = {name: _largest(frames, name) for name in facts.sizes} if drawables else {}
        return Others(points, drawables, largest)  # type: ignore[arg-type]

    def pictures(self, frame: PreviewFrame) -> Iterator[tuple[Topic, list[bytes | memoryview]]]:
        """Yield the messages of one frame."""
        for drawable, topic in topics_of_others(self.drawables):
            if isinstance(drawable, Links):
                drawn = self._dots(drawable, frame)
            elif isinstance(drawable, Cells):
                drawn = self._nodes(drawable, frame)
            elif isinstance(drawable, Curve):
                drawn = self._heights(drawable, frame)
            else:
                continue
            cloud = _cloud_topic(topic)
            yield cloud, protobuf.encode_point_cloud(frame.nanoseconds, np.asarray(drawn[0], np.float32), drawn[1])

    def _dots(self, links: Links, frame: PreviewFrame) -> tuple[np.ndarray, np.ndarray]:
        """Return dots on the line between linked points."""
        points, state = self.points[links.points], frame.drawn[links.state]
        places = positions_of(points, frame.drawn[points.displacement])
        whole = np.flatnonzero((state != 0.0) & points.stays_inside(links.pairs))
        first, second = places[links.pairs[whole, 0]], places[links.pairs[whole, 1]]
        parts = np.linspace(0.0, 1.0, _LINK_DOTS + 2)[1:-1]
        dots = np.concatenate([first + part * (second - first) for part in parts])
        return dots, np.tile(colours_of(state[whole], self.largest[links.state]), (_LINK_DOTS, 1))

    def _nodes(self, cells: Cells, frame: PreviewFrame) -> tuple[np.ndarray, np.ndarray]:
        """Return the nodes, or where the field belongs to the cells their centres; of cells that are not broken."""
        nodes, field = spatial(cells.nodes), frame.drawn[cells.field]
        if cells.displacement:
            nodes = nodes + spatial(frame.drawn[cells.displacement])
        is_of_nodes = len(field) == len(nodes)
        places = nodes if is_of_nodes else nodes[cells.connectivity].mean(axis=1)
        if cells.state:
            whole = frame.drawn[cells.state] != 0.0
            shown = np.unique(cells.connectivity[whole]) if is_of_nodes else np.flatnonzero(whole)
            places, field = places[shown], field[shown]
        return places, colours_of(field, self.largest[cells.field])

    def _heights(self, curve: Curve, frame: PreviewFrame) -> tuple[np.ndarray, np.ndarray]:
        """Return the values as heights over the coordinate, the largest a quarter of its length."""
        field, largest = frame.drawn[curve.field], self.largest[curve.field]
        places = spatial(curve.coordinate)
        places[:, 2] = field / largest * _HEIGHT * max(float(np.ptp(curve.coordinate)), 1e-300)
        return places, colours_of(field, largest)


def _is_small(drawable: Drawable) -> bool:
    counts = {Links: "pairs", Cells: "nodes", Curve: "coordinate"}
    return len(getattr(drawable, counts[type(drawable)])) <= _MOST_OTHERS  # type: ignore[index]


_FOLDERS = {Links: "links", Cells: "cells", Curve: "curves"}


def topics_of_others(drawables: Sequence[Drawable]) -> list[tuple[Drawable, str]]:
    """Return the drawables that are no points, but for those that are too large for a preview, each with its topic."""
    others = [one for one in drawables if not isinstance(one, Points)]
    return [(one, f"/{_FOLDERS[type(one)]}/{one.name}") for one in others if _is_small(one)]


def pictured(drawables: Sequence[Drawable]) -> tuple[Drawable, ...]:
    """Return the drawables that the messages are made of: not further points, unless links join them, nor what is too large."""
    others = [one for one, _ in topics_of_others(drawables)]
    points = [one for one in drawables if isinstance(one, Points)]
    joined = {one.points for one in others if isinstance(one, Links)}
    return (*points[:1], *(one for one in points[1:] if one.name in joined), *others)


def picture_box(drawables: Sequence[Drawable]) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and the highest corner of all that is drawn, before anything moves; shape (3,) each [m]."""
    points = main_points(drawables)
    boxes = [_rest_box(one) for one in drawables if not isinstance(one, Points | Links)]
    if points is not None:
        low, high = _extent(points)
        boxes.append((low, high + [0.0, 0.0, sum(_lift_and_height(low, high))]))
    return np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)


def _rest_box(drawable: Cells | Curve) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of cells before they move, of a curve with its highest value."""
    places = spatial(drawable.nodes if isinstance(drawable, Cells) else drawable.coordinate)
    low, high = places.min(axis=0), places.max(axis=0)
    return low, high + [0.0, 0.0, 0.0 if isinstance(drawable, Cells) else _HEIGHT * float(np.ptp(drawable.coordinate))]


def _extent(points: Points) -> tuple[np.ndarray, np.ndarray]:
    radius, reference = points.radius[:, None], spatial(points.reference)
    return (reference - radius).min(axis=0), (reference + radius).max(axis=0)


def _lift_and_height(low: np.ndarray, high: np.ndarray) -> tuple[float, float]:
    length = float((high - low).max())
    return float(high[2] - low[2]) + _LIFT * length, _HEIGHT * length


def _vectors(displacement: np.ndarray, blocks: np.ndarray) -> np.ndarray:
    """Return displacements of some particles as vectors, shape (n, 3), double precision."""
    return spatial(displacement[blocks].astype(np.float64))


def positions_of(points: Points, displacement: np.ndarray) -> np.ndarray:
    """Return reference plus displacement (along x where it is one number a point), shape (n, 3) [m], single precision."""
    return (spatial(points.reference) + spatial(displacement)).astype(np.float32)


def colours_of(values: np.ndarray, largest: float) -> np.ndarray:
    """Return blue below 0, grey at 0, red above, full at `largest`; shape (n, 4) uint8."""
    with np.errstate(invalid="ignore"):
        shades = np.clip(values * np.float32(_SHADES / (largest or 1.0)), -_SHADES, _SHADES)
    np.nan_to_num(shades, copy=False)  # grey is what has no number
    return np.take(_palette(), np.rint(shades).astype(np.int16) + _SHADES).view(np.uint8).reshape(-1, 4)


@cache
def _palette() -> np.ndarray:
    """Return the colours of all shades, each one number: four times as fast to look up as four."""
    shades = diverging(np.linspace(-1.0, 1.0, 2 * _SHADES + 1), 1.0, _ZERO)
    return np.concatenate([shades, np.full((len(shades), 1), 255, dtype=np.uint8)], axis=1).view(np.uint32).ravel()


# -- words -----------------------------------------------------------------------------------------------------------------


def _about(facts: PreviewFacts, clock: SlowClock, scene: Scene | None, scalars: _Scalars) -> PreviewMessage:
    lines = [facts.title, "", f"Slow clock: 1 s here = {clock.unit / 1e9:.3g} s simulated."]
    lines += ["Simulated time: the timeline message_publish_time, and the messages' time stamps.", ""]
    if scene is not None:
        lines.append(f"/preview: displacements {scene.exaggeration:g} x as large as they are.")
        if colour := scene.points.colour:
            full = f"{scene.largest:.4g} {facts.drawn_units[colour]}"
            lines.append(f"Columns and colours: {colour}, from -{full} (blue) through 0 (grey) to +{full} (red).")
        lines += [f"/particles, {scene.lift:.3g} m below: true places.", ""]
        if len(scene.blocks) < len(scene.points.radius):
            lines += [f"/preview has {len(scene.blocks)} points for {len(scene.points.radius)} particles.", ""]
    for topic, names in scalars.names.items():
        lines.append(f"{topic}: " + ", ".join(f"[{place}] {name}" for place, name in enumerate(names)))
    topic = Topic(ABOUT_TOPIC, cdr.TEXT_NAME, "ros2msg", cdr.TEXT.encode())
    return PreviewMessage(topic, 0, clock.start, [cdr.encode_text("\n".join(lines))])
