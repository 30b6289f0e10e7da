"""Regions of the plane, chosen by name (box, disc), for holes in a body or for the extent of a material or a strength."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import SerializeAsAny, model_validator

from .errors import ParameterError
from .support.float_arrays import FloatArray
from .support.parameter_fields import Pair, field
from .support.tagged_union import ByName, Named


class Area(Named):
    """A region of the plane."""

    @property
    @abstractmethod
    def bounds(self) -> tuple[float, float, float, float]:
        """Smallest and largest x, then smallest and largest y [m]."""

    @abstractmethod
    def contains(self, points: FloatArray, margin: float = 0.0) -> np.ndarray:
        """Return which points, shape (k, 2) [m], lie inside and farther than a margin [m] from the outline."""


class Box(Area):
    """A rectangle between two abscissas and two ordinates."""

    name: Literal["box"] = field("box", "a rectangle along the axes", "1")
    x: Pair = field(..., "smallest and largest x", "m")
    y: Pair = field(..., "smallest and largest y", "m")

    @model_validator(mode="after")
    def _validate_order(self) -> Box:
        for axis in ("x", "y"):
            low, high = getattr(self, axis)
            if not low < high:
                raise ParameterError(f"got [{low:g}, {high:g}]", expected="the smaller number first", at=(axis,))
        return self

    @property
    def bounds(self) -> tuple[float, float, float, float]:  # noqa: D102
        return self.x[0], self.x[1], self.y[0], self.y[1]

    def contains(self, points: FloatArray, margin: float = 0.0) -> np.ndarray:  # noqa: D102
        x, y = points[:, 0], points[:, 1]
        beside = (self.x[0] + margin < x) & (x < self.x[1] - margin)
        return beside & (self.y[0] + margin < y) & (y < self.y[1] - margin)


class Disc(Area):
    """All points within a distance from a centre."""

    name: Literal["disc"] = field("disc", "a disc", "1")
    centre: Pair = field(..., "centre of the disc", "m")
    radius: float = field(..., "radius of the disc", "m", gt=0.0)

    @property
    def bounds(self) -> tuple[float, float, float, float]:  # noqa: D102
        (x, y), r = self.centre, self.radius
        return x - r, x + r, y - r, y + r

    def contains(self, points: FloatArray, margin: float = 0.0) -> np.ndarray:  # noqa: D102
        x, y = points[:, 0] - self.centre[0], points[:, 1] - self.centre[1]
        radius = max(self.radius - margin, 0.0)
        return x * x + y * y < radius * radius


AREAS: dict[str, type[Area]] = {"box": Box, "disc": Disc}

ChosenArea = Annotated[SerializeAsAny[Any], ByName(AREAS)]
