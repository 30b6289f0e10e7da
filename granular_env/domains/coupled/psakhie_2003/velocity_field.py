"""The velocities of a half-space at an instant, read from a log; x along the surface, the interface at x = 0, y upwards."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline, RectBivariateSpline

from granular_env.components.drawables import Cells, Points
from granular_env.components.support.float_arrays import FloatArray
from granular_env.recording.log import Log


@dataclass(frozen=True)
class Part:
    """The grid or the automata.

    Attributes:
        x: of the columns, shape (columns,) [m].
        y: of the rows, shape (rows,) [m].
        velocity: shape (rows, columns, 2) [m/s].
    """

    x: FloatArray
    y: FloatArray
    velocity: FloatArray

    @cached_property
    def _splines(self) -> Sequence[RectBivariateSpline]:
        return [RectBivariateSpline(self.y, self.x, self.velocity[..., axis]) for axis in (0, 1)]

    def at(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return the velocity between the samples, by cubic splines; shape (*x.shape, 2) [m/s]."""
        return np.stack([spline.ev(y, x) for spline in self._splines], axis=-1)


@dataclass(frozen=True)
class Motion:
    """Velocities in a half-space.

    Attributes:
        parts: the grid alone, or the grid (x < 0) and the automata.
    """

    parts: Sequence[Part]

    def at(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return the velocity at points; shape (*x.shape, 2) [m/s]."""
        x, y = np.broadcast_arrays(x, y)
        if len(self.parts) == 1:
            return self.parts[0].at(x, y)
        return np.where((x < 0.0)[..., None], self.parts[0].at(x, y), self.parts[1].at(x, y))


def shift(alone: Motion, distance: float) -> Motion:
    """Return the motion of a grid alone, moved along the surface [m]."""
    [part] = alone.parts
    return Motion([Part(part.x + distance, part.y, part.velocity)])


def motion(log: Log, time: float) -> Motion:
    """Return the motion that a log of a Lamb experiment holds at an instant [s]."""
    cells, points = _places(log)
    if "velocity" in log.variables:
        return Motion([_regular(cells, log.get("velocity", time))])
    velocities = [log.get(f"{name}_velocity", time) for name in ("grid", "automata")]
    if float(points[:, 0].min()) >= -1e-9 and float(cells[:, 0].min()) >= -1e-9:
        # The half-space lies to the right of its surface: turned, so that it lies below.
        cells, points, *velocities = (_turn(one) for one in (cells, points, *velocities))
    return Motion([_regular(cells, velocities[0]), _even(points, velocities[1])])


def _places(log: Log) -> tuple[FloatArray, FloatArray]:
    """Return where nodes and automata are before anything moves."""
    [cells] = [one.nodes for one in log.drawables if isinstance(one, Cells)]
    points = [one.reference for one in log.drawables if isinstance(one, Points) and one.name == "automata"]
    return np.array(cells), np.array(points[0]) if points else np.zeros((0, 2))


def _turn(vectors: FloatArray) -> FloatArray:
    """Turn by a right angle, clockwise: what points to the right points down."""
    return np.stack([vectors[:, 1], -vectors[:, 0]], axis=1)


def _regular(points: FloatArray, velocity: FloatArray) -> Part:
    """Return points on lines along x and y, in whatever order they come, as columns and rows."""
    x, column = _lines(points[:, 0])
    y, row = _lines(points[:, 1])
    table = np.zeros((len(y), len(x), 2))
    table[row, column] = velocity
    return Part(x, y, table)


def _lines(places: FloatArray) -> tuple[FloatArray, npt.NDArray[np.int64]]:
    """Return the places of lines, and on which line each of the places is."""
    order = np.argsort(places, kind="stable")
    steps = np.diff(places[order], prepend=places[order[0]])
    line = np.cumsum(steps > 1e-6 * np.ptp(places))
    number = np.zeros(len(places), dtype=np.int64)
    number[order] = line
    first = np.searchsorted(line, np.arange(line[-1] + 1))
    return places[order][first], number


def _even(points: FloatArray, velocity: FloatArray) -> Part:
    """Return automata as columns and rows; every other column of a hexagonal packing is moved by half a diameter."""
    x, column = _lines(points[:, 0])
    y = np.unique(np.round(points[:, 1], 12))
    if len(points) == len(x) * len(y):
        return _regular(points, velocity)
    even = np.sort(points[column == 0, 1])
    table = np.zeros((len(even), len(x), 2))
    for number in range(len(x)):
        own = np.flatnonzero(column == number)
        own = own[np.argsort(points[own, 1])]
        for axis in (0, 1):
            table[:, number, axis] = _along(points[own, 1], velocity[own, axis], even)
    return Part(x, even, table)


def _along(places: FloatArray, values: FloatArray, wanted: FloatArray) -> FloatArray:
    """Interpolate by cubic splines; the ends, which lie half a diameter outside, are continued."""
    return CubicSpline(places, values)(wanted)
