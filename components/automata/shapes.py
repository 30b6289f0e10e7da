"""Shapes of specimens in the plane, chosen by name; a packing fills their interior."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import SerializeAsAny, model_validator

from ..errors import ParameterError, one_line
from ..regions import ChosenArea
from ..support.float_arrays import FloatArray, norms
from ..support.parameter_fields import SignedPair, field
from ..support.tagged_union import ByName, Named

# Points this close to the outline are on it, in diameters of an automaton.
ON_THE_OUTLINE = 1e-6
# Distance at which sides of a polygon count as touching, as a fraction of its extent.
_TOUCHING = 1e-9


class StraightSide(NamedTuple):
    """A side along x or y: its name in messages, axis normal to it (0 or 1), position [m], whole multiple of `rows` rows."""

    name: str
    axis: int
    place: float
    rows: int = 1


class Shape(Named):
    """The outline of a specimen, and its holes."""

    holes: list[ChosenArea] = field([], "areas without automata: boxes or discs; an area at the outline makes a notch", "1")

    @property
    @abstractmethod
    def anchor(self) -> tuple[float, float]:
        """A point at which the packing must have the centre of an automaton [m]."""

    @property
    @abstractmethod
    def bounds(self) -> tuple[float, float, float, float]:
        """The smallest and largest x, then the smallest and largest y [m]."""

    @abstractmethod
    def surrounds(self, points: FloatArray, margin: float) -> np.ndarray:
        """Return which points, shape (n, 2) [m], lie inside the outline or within a margin [m] of it; holes are ignored."""

    def contains(self, points: FloatArray, margin: float) -> np.ndarray:
        """Return which points, shape (n, 2) [m], lie inside, or within `margin` [m] of the outline or of a hole's outline."""
        inside = self.surrounds(points, margin)
        for hole in self.holes:
            inside &= ~hole.contains(points, margin)
        return inside

    def straight_sides(self) -> list[StraightSide]:
        """Return the sides along x or y that must lie on rows of centres."""
        return []


class Rectangle(Shape):
    """A rectangle with a corner at the origin."""

    name: Literal["rectangle"] = field("rectangle", "which shape", "1")
    width: float = field(..., "extent along x", "m", gt=0.0)
    height: float = field(..., "extent along y", "m", gt=0.0)

    @property
    def anchor(self) -> tuple[float, float]:
        """The lower left corner; see `Shape.anchor`."""
        return 0.0, 0.0

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """The positions of the four sides."""
        return 0.0, self.width, 0.0, self.height

    def surrounds(self, points: FloatArray, margin: float) -> np.ndarray:
        """Return which points lie inside the outline."""
        inside = (points >= -margin) & (points <= np.array([self.width, self.height]) + margin)
        return inside[:, 0] & inside[:, 1]

    def straight_sides(self) -> list[StraightSide]:
        """Return the two sides that do not pass through the corner at the origin."""
        return [StraightSide("width", 0, self.width), StraightSide("height", 1, self.height)]


class Disc(Shape):
    """A disc about the origin, optionally cut flat above and below; the round part of its outline is a staircase."""

    name: Literal["disc"] = field("disc", "which shape", "1")
    radius: float = field(..., "radius", "m", gt=0.0)
    height: float | None = field(
        None, "extent along y between flats that cut it at top and bottom; default: not cut", "m", absent="not cut", gt=0.0
    )

    @model_validator(mode="after")
    def _validate_height(self) -> Disc:
        if self.height is not None and self.height >= 2.0 * self.radius:
            raise ParameterError(
                f"got {self.height:g} m", expected=f"less than the diameter, {2.0 * self.radius:g} m", at="height"
            )
        return self

    @property
    def anchor(self) -> tuple[float, float]:
        """The centre; see `Shape.anchor`."""
        return 0.0, 0.0

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """The sides of the rectangle around the disc."""
        half = self._half_height
        return -self.radius, self.radius, -half, half

    @property
    def _half_height(self) -> float:
        return self.radius if self.height is None else 0.5 * self.height

    def surrounds(self, points: FloatArray, margin: float) -> np.ndarray:
        """Return which points lie inside the outline."""
        round_part = points[:, 0] ** 2 + points[:, 1] ** 2 <= (self.radius + margin) ** 2
        return round_part & (np.abs(points[:, 1]) <= self._half_height + margin)

    def straight_sides(self) -> list[StraightSide]:
        """Return both flats; they are described by the distance between them."""
        return [] if self.height is None else [StraightSide("height", 1, self.height, rows=2)]


class Polygon(Shape):
    """A polygon without self-intersections; the first corner is the centre of an automaton, oblique sides are staircases."""

    name: Literal["polygon"] = field("polygon", "which shape", "1")
    corners: list[SignedPair] = field(
        ..., "corners in order around the outline, x and y of each", "m", min_length=3, max_length=10_000
    )

    @model_validator(mode="after")
    def _validate_area(self) -> Polygon:
        corners = np.array(self.corners)
        if not abs(_polygon_area(corners)) > 1e-12 * float(np.ptp(corners, axis=0).max()) ** 2:
            raise ParameterError(f"got {one_line(self.corners)}", expected="a polygon of nonzero area", at="corners")
        twice = np.flatnonzero((corners == np.roll(corners, -1, axis=0)).all(axis=1))
        if len(twice):
            raise ParameterError(f"corner {twice[0]} equals the next one", hint="give each corner once", at="corners")
        meeting = _first_crossing_sides(corners)
        if meeting is not None:
            raise ParameterError(
                f"side {meeting[0]} meets side {meeting[1]}",
                expected="a polygon that does not touch itself",
                hint="give slits and notches as boxes in `holes`, and leave a gap between parts that would meet at a point",
                at="corners",
            )
        return self

    @property
    def anchor(self) -> tuple[float, float]:
        """The first corner; see `Shape.anchor`."""
        return self.corners[0][0], self.corners[0][1]

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """The sides of the rectangle around the polygon."""
        x, y = zip(*self.corners, strict=True)
        return min(x), max(x), min(y), max(y)

    def surrounds(self, points: FloatArray, margin: float) -> np.ndarray:
        """Return which points lie inside the outline (an odd number of sides above them), or close to a side."""
        corners = np.array(self.corners)
        inside, near = np.zeros(len(points), bool), np.zeros(len(points), bool)
        x, y = points[:, 0], points[:, 1]
        for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            side = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
            inside ^= ((ax <= x) != (bx <= x)) & ((side < 0.0) == (bx > ax))
            length = math.hypot(bx - ax, by - ay)
            along = np.clip(((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length**2, 0.0, 1.0)
            near |= (x - ax - along * (bx - ax)) ** 2 + (y - ay - along * (by - ay)) ** 2 <= margin**2
        return inside | near if margin > 0.0 else inside

    def straight_sides(self) -> list[StraightSide]:
        """Return the sides along x or y."""
        sides = []
        for number, (start, end) in enumerate(zip(self.corners, self.corners[1:] + self.corners[:1], strict=True)):
            for axis in (0, 1):
                if start[axis] == end[axis]:
                    sides.append(StraightSide(f"corners[{number}]", axis, start[axis]))
        return sides


def _polygon_area(corners: FloatArray) -> float:
    x, y = corners.T
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def _first_crossing_sides(corners: FloatArray) -> tuple[int, int] | None:
    """Return the numbers of two non-adjacent sides that cross or touch, or None."""
    limit, ends, count = _TOUCHING * float(np.ptp(corners, axis=0).max()), np.roll(corners, -1, axis=0), len(corners)
    for first in range(count):
        a, b = corners[first], ends[first]
        others = np.array([other for other in range(first + 2, count) if (other + 1) % count != first], np.int64)
        c, d = corners[others], ends[others]
        crosses = (_double_area(a, b, c) * _double_area(a, b, d) < 0.0) & (_double_area(c, d, a) * _double_area(c, d, b) < 0.0)
        near = (
            np.minimum.reduce(
                [_segment_distance(a, c, d), _segment_distance(b, c, d), _segment_distance(c, a, b), _segment_distance(d, a, b)]
            )
            <= limit
        )
        if (crosses | near).any():
            return first, int(others[(crosses | near).argmax()])
    return None


def _segment_distance(point: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return the distance of each point from its side (start to end), shape (k,) [m]; arguments of shape (2,) or (k, 2)."""
    way, offset = end - start, point - start
    part = np.clip((way * offset).sum(axis=-1) / (way * way).sum(axis=-1), 0.0, 1.0)
    return norms(offset - part[..., np.newaxis] * way)


def _double_area(a: FloatArray, b: FloatArray, c: FloatArray) -> Any:
    """Return twice the signed area of each triangle with the corners a, b, c."""
    ab, ac = b - a, c - a
    return ab[..., 0] * ac[..., 1] - ab[..., 1] * ac[..., 0]


SHAPES: dict[str, type[Shape]] = {"rectangle": Rectangle, "disc": Disc, "polygon": Polygon}

ChosenShape = Annotated[SerializeAsAny[Shape], ByName(SHAPES)]
