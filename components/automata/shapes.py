"""Shapes of specimens in the plane, chosen by name; a packing fills what lies inside."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import SerializeAsAny, model_validator

from ..errors import one_line
from ..regions import Box, ChosenArea
from ..support.float_arrays import FloatArray
from ..support.parameter_fields import SignedPair, field
from ..support.tagged_union import ByName, Named
from ..support.validation import refusal

# Points this close to the outline are on it, in diameters of an automaton.
ON_THE_OUTLINE = 1e-6
# A corner of a polygon this close to another of its sides lies on it, in parts of the polygon's extent.
_TOUCHING = 1e-9


class StraightSide(NamedTuple):
    """A side along x or y: its name in messages, the axis across (0 or 1), its place there [m], by how many rows it goes."""

    name: str
    axis: int
    place: float
    rows: int = 1


class Shape(Named):
    """The outline of a specimen, and holes in it."""

    holes: list[ChosenArea] = field([], "areas without automata: a box or a disc; at the outline it makes a notch", "1")

    @property
    @abstractmethod
    def anchor(self) -> tuple[float, float]:
        """A point where an automaton has its centre [m]."""

    @property
    @abstractmethod
    def bounds(self) -> tuple[float, float, float, float]:
        """The least and the largest x, the least and the largest y [m]."""

    @abstractmethod
    def surrounds(self, points: FloatArray, margin: float) -> np.ndarray:
        """Return which points, shape (n, 2) [m], lie inside the outline or within a margin [m] of it, in holes too."""

    def contains(self, points: FloatArray, margin: float) -> np.ndarray:
        """Return which points, shape (n, 2) [m], lie inside or within a margin [m] of the outline or of a hole's."""
        inside = self.surrounds(points, margin)
        for hole in self.holes:
            inside &= ~hole.contains(points, margin)
        return inside

    def straight_sides(self) -> list[StraightSide]:
        """Return the sides along x or y that have to lie on rows of centres."""
        return []

    def hole_sides(self, x: float, y: float, margin: float) -> list[StraightSide]:
        """Return those edges of box-shaped holes that lie inside the shape, of the holes within a margin of a point [m]."""
        left, right, low, high = self.bounds
        sides = []
        for number, hole in enumerate(self.holes):
            west, east, south, north = hole.bounds
            beside = west - margin <= x <= east + margin and south - margin <= y <= north + margin
            if not (isinstance(hole, Box) and beside):
                continue
            for axis, (name, ends, limits) in enumerate((("x", hole.x, (left, right)), ("y", hole.y, (low, high)))):
                for end, place in enumerate(ends):
                    if limits[0] < place < limits[1]:
                        sides.append(StraightSide(f"holes[{number}].{name}[{end}]", axis, place))
        return sides


class Rectangle(Shape):
    """A rectangle with a corner at the origin."""

    name: Literal["rectangle"] = field("rectangle", "which shape", "1")
    width: float = field(..., "extent along x", "m", gt=0.0)
    height: float = field(..., "extent along y", "m", gt=0.0)

    @property
    def anchor(self) -> tuple[float, float]:
        """The lower left corner."""
        return 0.0, 0.0

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """The sides."""
        return 0.0, self.width, 0.0, self.height

    def surrounds(self, points: FloatArray, margin: float) -> np.ndarray:
        """Return which points lie inside the outline."""
        inside = (points >= -margin) & (points <= np.array([self.width, self.height]) + margin)
        return inside[:, 0] & inside[:, 1]

    def straight_sides(self) -> list[StraightSide]:
        """Return the two sides that do not pass through the corner at the origin."""
        return [StraightSide("width", 0, self.width), StraightSide("height", 1, self.height)]


class Disc(Shape):
    """A disc about the origin, which may be cut flat above and below; the round of its outline is a staircase."""

    name: Literal["disc"] = field("disc", "which shape", "1")
    radius: float = field(..., "radius", "m", gt=0.0)
    height: float | None = field(
        None, "extent along y to which it is cut flat above and below; default: not cut", "m", without="not cut", gt=0.0
    )

    @model_validator(mode="after")
    def _validate_height(self) -> Disc:
        if self.height is not None and self.height >= 2.0 * self.radius:
            raise refusal(f"got {self.height:g} m", f"less than the diameter, {2.0 * self.radius:g} m", at=("height",))
        return self

    @property
    def anchor(self) -> tuple[float, float]:
        """The centre."""
        return 0.0, 0.0

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """The rectangle around it."""
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
        """Return both flats, as one length between them."""
        return [] if self.height is None else [StraightSide("height", 1, self.height, rows=2)]


class Polygon(Shape):
    """A polygon that nowhere meets itself; the first corner is the centre of an automaton, oblique sides are staircases."""

    name: Literal["polygon"] = field("polygon", "which shape", "1")
    corners: list[SignedPair] = field(..., "corners in order around it, each x and y", "m", min_length=3, max_length=10_000)

    @model_validator(mode="after")
    def _validate_area(self) -> Polygon:
        corners = np.array(self.corners)
        if not abs(_area(corners)) > 1e-12 * float(np.ptp(corners, axis=0).max()) ** 2:
            raise refusal(f"got {one_line(self.corners)}", "a polygon with an area", at=("corners",))
        twice = np.flatnonzero((corners == np.roll(corners, -1, axis=0)).all(axis=1))
        if len(twice):
            raise refusal(f"corner {twice[0]} is followed by itself", hint="give each corner once", at=("corners",))
        crossing = _first_crossing(corners)
        if crossing is not None:
            raise refusal(f"side {crossing[0]} crosses side {crossing[1]}", "a polygon that does not", at=("corners",))
        touching = _first_touch(corners)
        if touching is not None:
            raise refusal(
                touching,
                "a polygon that touches itself nowhere",
                hint="give slits and notches as boxes in `holes`, and leave a gap between parts that would meet in a point",
                at=("corners",),
            )
        return self

    @property
    def anchor(self) -> tuple[float, float]:
        """The first corner."""
        return self.corners[0][0], self.corners[0][1]

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """The rectangle around it."""
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


def _area(corners: FloatArray) -> float:
    x, y = corners.T
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def _first_crossing(corners: FloatArray) -> tuple[int, int] | None:
    """Return the numbers of two sides that cross, or None."""
    ends = np.roll(corners, -1, axis=0)
    for first in range(len(corners)):
        a, b = corners[first], ends[first]
        c, d = corners[first + 1 :], ends[first + 1 :]
        across = _turn(a, b, c) * _turn(a, b, d)
        along = _turn(c, d, a) * _turn(c, d, b)
        found = np.flatnonzero((across < 0.0) & (along < 0.0))
        if len(found):
            return first, first + 1 + int(found[0])
    return None


def _first_touch(corners: FloatArray) -> str | None:
    """Return which corner lies on which other corner, or on which side that does not end there; None where none does."""
    limit = _TOUCHING * float(np.ptp(corners, axis=0).max())
    ends = np.roll(corners, -1, axis=0)
    (left, low), (right, high) = (np.minimum(corners, ends) - limit).T, (np.maximum(corners, ends) + limit).T
    for number, (x, y) in enumerate(corners.tolist()):
        for side in np.flatnonzero((left <= x) & (x <= right) & (low <= y) & (y <= high)).tolist():
            both = (side, (side + 1) % len(corners))
            if number in both or _distance((x, y), *corners[list(both)].tolist()) > limit:
                continue
            met = [f"corner {other}" for other in both if math.dist(corners[other], (x, y)) <= limit] or [f"side {side}"]
            return f"corner {number} at ({x:.9g}, {y:.9g}) m lies on {met[0]}"
    return None


def _distance(point: tuple[float, float], start: list[float], end: list[float]) -> float:
    """Return how far a point lies off a side [m]."""
    (x, y), (ax, ay), (bx, by) = point, start, end
    along = ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2)
    part = min(max(along, 0.0), 1.0)
    return math.hypot(x - ax - part * (bx - ax), y - ay - part * (by - ay))


def _turn(a: FloatArray, b: FloatArray, c: FloatArray) -> Any:
    """Return twice the signed area of the triangles a, b, c."""
    ab, ac = b - a, c - a
    return ab[..., 0] * ac[..., 1] - ab[..., 1] * ac[..., 0]


SHAPES: dict[str, type[Shape]] = {"rectangle": Rectangle, "disc": Disc, "polygon": Polygon}

ChosenShape = Annotated[SerializeAsAny[Shape], ByName(SHAPES)]
