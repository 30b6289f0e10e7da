"""Packings of equal automata: which automata fill a shape, their neighbours, and the fraction of each cell inside it.

The centres lie on a lattice, inside the outline or on it. An automaton on the outline is a part of a cell: a half on a side, a
quarter at a corner; its volume, mass and faces are smaller accordingly. A free face of a whole cell (at the zigzag of
the hexagonal packing, or the staircase of an oblique side) carries no traction, see `Packing.missing`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..errors import Fault, ParameterError
from ..support.float_arrays import FloatArray
from .shapes import ON_THE_OUTLINE, Shape

# cos and sin of 60 degrees, each a single constant, so that mirrored directions are exact mirror images.
_HALF, _SINE = 0.5, 0.5 * math.sqrt(3.0)
# A sector of a cell lies inside the shape if its point at this distance from the centre does [diameters].
_PROBE = 0.01


@dataclass(frozen=True)
class Lattice:
    """A regular packing, in units of the diameter.

    Attributes:
        name: "square" or "hexagonal". A slot is the number of a direction to a neighbour, counter-clockwise from +x.
        steps: vectors from a centre to its neighbours, in multiples of `unit` along x and y, shape (slots, 2).
        unit: spacing of the lattice coordinates along x and y.
        directions: unit vectors to the neighbours, shape (slots, 2).
        face: length S / D of the face towards a neighbour.
        volume: area V / D^2 of the cell.
    """

    name: str
    steps: npt.NDArray[np.int64]
    unit: FloatArray
    directions: FloatArray
    face: float
    volume: float

    @property
    def slots(self) -> int:
        """Number of neighbours of an interior automaton."""
        return len(self.steps)

    @property
    def sectors(self) -> FloatArray:
        """Triangles into which a cell is divided, in diameters from its centre, counter-clockwise, shape (2 slots, 3, 2)."""
        onward = np.roll(self.directions, -1, axis=0)
        # A corner of the cell projects to half a diameter along both adjacent directions.
        corners = 0.5 * (self.directions + onward) / (1.0 + (self.directions * onward).sum(axis=1, keepdims=True))
        centre = np.zeros_like(corners)
        left, right = [centre, 0.5 * self.directions, corners], [centre, corners, 0.5 * onward]
        return np.stack([np.stack(left, axis=1), np.stack(right, axis=1)], axis=1).reshape(-1, 3, 2)


LATTICES = {
    "square": Lattice(
        "square",
        np.array([(1, 0), (0, 1), (-1, 0), (0, -1)]),
        np.array([1.0, 1.0]),
        np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)]),
        face=1.0,
        volume=1.0,
    ),
    "hexagonal": Lattice(
        "hexagonal",
        np.array([(2, 0), (1, 1), (-1, 1), (-2, 0), (-1, -1), (1, -1)]),
        np.array([_HALF, _SINE]),
        np.array([(1.0, 0.0), (_HALF, _SINE), (-_HALF, _SINE), (-1.0, 0.0), (-_HALF, -_SINE), (_HALF, -_SINE)]),
        face=1.0 / math.sqrt(3.0),
        volume=_SINE,
    ),
}


@dataclass(frozen=True)
class Packing:
    """Automata that fill a shape, in rows from below, each from left to right.

    Attributes:
        lattice: the regular packing on which the centres lie.
        diameter: of an automaton [m].
        places: lattice coordinates of the centres from `Shape.anchor`, in multiples of `lattice.unit`, shape (n, 2).
        reference: centres, shape (n, 2) [m].
        neighbours: of each automaton in each slot; the automaton itself if missing, shape (n, slots), int32.
        volume: area of each cell inside the shape, shape (n,) [m^2].
        face: length of the face in each slot, 0 without a neighbour, shape (n, slots) [m].
        share: contribution of the strain of each pair to the volumetric strain, S r / 2 V, shape (n, slots).
        missing: 2 minus the sum of the shares, i.e. the share of the free faces of a whole cell, shape (n,).
        sectors: which `lattice.sectors` of each cell lie inside the shape, shape (n, 2 slots).
    """

    lattice: Lattice
    diameter: float
    places: npt.NDArray[np.int32]
    reference: FloatArray
    neighbours: npt.NDArray[np.int32]
    volume: FloatArray
    face: FloatArray
    share: FloatArray
    missing: FloatArray
    sectors: npt.NDArray[np.bool_]

    def pairs(self) -> npt.NDArray[np.int64]:
        """Return the pairs of neighbours, sorted by slot and automaton, shape (m, 3): automaton, neighbour, slot."""
        found = []
        for slot in range(self.lattice.slots // 2):
            first = np.flatnonzero(self.neighbours[:, slot] != np.arange(len(self.places)))
            found.append(np.stack([first, self.neighbours[first, slot], np.full(len(first), slot)], axis=1))
        return np.concatenate(found).astype(np.int64)

    def nearest_automaton(self, x: float, y: float) -> int:
        """Return the automaton nearest to a point [m]; the first one if several are equally near."""
        return int(np.argmin((self.reference[:, 0] - x) ** 2 + (self.reference[:, 1] - y) ** 2))


def pack_shape(name: str, shape: Shape, diameter: float, periodic: tuple[bool, bool] = (False, False)) -> Packing:
    """Return the automata that fill a shape.

    Args:
        name: name of the lattice, "square" or "hexagonal".
        shape: the shape that the automata fill.
        diameter: of the automata [m].
        periodic: whether the left and right sides of a rectangle are joined, and the lower and upper ones.

    Raises:
        ParameterError: a straight side does not lie on the lattice, or the shape contains no pair of automata.
    """
    lattice = LATTICES[name]
    _refuse_misfit_sides(lattice, shape, diameter, periodic)
    _refuse_idle_holes(lattice, shape, diameter)
    places = _places_inside(lattice, shape, diameter, periodic)
    if not len(places) and shape.holes:
        raise ParameterError("the holes remove the whole shape", at=("shape", "holes"))
    turns = _lattice_periods(lattice, shape, diameter, periodic)
    _refuse_own_neighbours(lattice, turns)
    neighbours = _neighbours(lattice, places, turns)
    linked = neighbours != np.arange(len(places))[:, np.newaxis]
    sectors = _sectors_inside(lattice, shape, diameter, places, periodic)
    # A face counts only where sectors of both cells lie inside. Sector 2 k is left of the direction of slot k, 2 k - 1 right.
    own = 0.5 * (sectors[:, 0::2].astype(float) + np.roll(sectors, 1, axis=1)[:, 0::2])
    opposite = np.roll(np.arange(lattice.slots), -(lattice.slots // 2))
    face = np.where(linked, np.minimum(own, own[neighbours, opposite]), 0.0)
    kept: npt.NDArray[np.bool_] = np.any(face > 0.0, axis=1)
    if not kept.any():
        raise ParameterError(
            f"got a {shape.name} that is too small for two automata of diameter {diameter:g} m",
            expected="a larger shape, or a smaller diameter",
            at="shape",
        )
    if not kept.all():
        number = np.cumsum(kept) - 1
        dropped = ~kept[neighbours]
        face, neighbours = np.where(dropped, 0.0, face)[kept], neighbours[kept]
        places, sectors = places[kept], sectors[kept]
        neighbours = number[neighbours]
    neighbours = np.where(face > 0.0, neighbours, np.arange(len(places))[:, np.newaxis])
    volume, length = sectors.mean(axis=1) * lattice.volume * diameter**2, face * lattice.face * diameter
    share = length * diameter / (2.0 * volume[:, np.newaxis])
    missing = np.maximum(2.0 - share.sum(axis=1), 0.0)
    missing[missing < 1e-12] = 0.0
    reference = np.array(shape.anchor) + diameter * lattice.unit * places
    return Packing(
        lattice,
        diameter,
        places.astype(np.int32),
        reference,
        neighbours.astype(np.int32),
        volume,
        length,
        share,
        missing,
        sectors,
    )


def _refuse_misfit_sides(lattice: Lattice, shape: Shape, diameter: float, periodic: tuple[bool, bool]) -> None:
    """Refuse straight sides between the rows of the lattice; name the two nearest positions that fit."""
    faults = []
    for name, axis, place, rows in shape.straight_sides():
        unit = diameter * lattice.unit[axis] * rows
        # Only a whole number of diameters along x and an even number of rows along y make a hexagonal packing periodic.
        step = unit * (2 if periodic[axis] and lattice.name == "hexagonal" else 1)
        count = (place - shape.anchor[axis]) / step
        if abs(count - round(count)) * step > ON_THE_OUTLINE * diameter:
            nearest = sorted({math.floor(count), math.ceil(count)} - {0})
            fitting = " or ".join(f"{shape.anchor[axis] + one * step:.12g} m" for one in nearest)
            came = f"{place:.12g} m is {count * rows:.9g} rows of {step / rows:.9g} m"
            faults.append(Fault(("shape", name), came, f"{'a whole' if rows == 1 else 'an even'} number; use {fitting}"))
    if faults:
        raise ParameterError(*faults)


def _refuse_idle_holes(lattice: Lattice, shape: Shape, diameter: float) -> None:
    """Refuse holes that remove no automaton."""
    points = _lattice_points(lattice, shape, diameter)[1]
    points = points[shape.surrounds(points, 0.0)]
    for number, hole in enumerate(shape.holes):
        if not hole.contains(points, ON_THE_OUTLINE * diameter).any():
            raise ParameterError(
                "contains no centre of an automaton", hint="make it larger, or leave it out", at=("shape", "holes", number)
            )


def _places_inside(lattice: Lattice, shape: Shape, diameter: float, periodic: tuple[bool, bool]) -> npt.NDArray[np.int64]:
    """Return the lattice points in a shape, row by row from below; of two sides joined by a period only the left or lower."""
    margin = ON_THE_OUTLINE * diameter
    places, points = _lattice_points(lattice, shape, diameter)
    inside = shape.contains(points, margin)
    _, right, _, high = shape.bounds
    for axis, limit in ((0, right), (1, high)):
        if periodic[axis]:
            inside &= points[:, axis] < limit - margin
    return places[inside]


def _lattice_points(lattice: Lattice, shape: Shape, diameter: float) -> tuple[npt.NDArray[np.int64], FloatArray]:
    """Return the lattice points around a shape: coordinates in lattice units, and positions [m], shape (k, 2)."""
    unit = diameter * lattice.unit
    left, right, low, high = shape.bounds
    x, y = shape.anchor
    columns = np.arange(math.floor((left - x) / unit[0]) - 1, math.ceil((right - x) / unit[0]) + 2)
    rows = np.arange(math.floor((low - y) / unit[1]) - 1, math.ceil((high - y) / unit[1]) + 2)
    places = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    if lattice.name == "hexagonal":
        places = places[places.sum(axis=1) % 2 == 0]
    return places, np.array(shape.anchor) + unit * places


def _lattice_periods(lattice: Lattice, shape: Shape, diameter: float, periodic: tuple[bool, bool]) -> tuple[int, int]:
    """Return the periods of a packing along x and y in lattice coordinates, 0 if not periodic."""
    left, right, low, high = shape.bounds
    extent = np.array([right - left, high - low]) / (diameter * lattice.unit)
    return int(round(extent[0])) * periodic[0], int(round(extent[1])) * periodic[1]


def _refuse_own_neighbours(lattice: Lattice, periods: tuple[int, int]) -> None:
    """Refuse a periodic packing so narrow that an automaton would be its own neighbour."""
    if any(
        all(step % turn == 0 if turn else step == 0 for step, turn in zip(one, periods, strict=True)) for one in lattice.steps
    ):
        raise ParameterError(
            "an automaton of this periodic body is its own neighbour", expected="a width of 2 diameters or more", at="shape"
        )


def _neighbours(lattice: Lattice, places: npt.NDArray[np.int64], periods: tuple[int, int]) -> npt.NDArray[np.int64]:
    """Return the neighbour of each automaton in each slot; the automaton itself if the neighbour is missing."""
    low = places.min(axis=0) - 2
    width = places.max(axis=0) - low + 3
    table = np.full(width[0] * width[1], -1, np.int64)
    table[(places[:, 1] - low[1]) * width[0] + places[:, 0] - low[0]] = np.arange(len(places))
    neighbours = np.empty((len(places), lattice.slots), np.int64)
    for slot, step in enumerate(lattice.steps):
        other = places + step
        for axis, turn in enumerate(periods):
            if turn:
                other[:, axis] %= turn
        neighbours[:, slot] = table[(other[:, 1] - low[1]) * width[0] + other[:, 0] - low[0]]
    return np.where(neighbours < 0, np.arange(len(places))[:, np.newaxis], neighbours)


def _sectors_inside(
    lattice: Lattice, shape: Shape, diameter: float, places: npt.NDArray[np.int64], periodic: tuple[bool, bool]
) -> npt.NDArray[np.bool_]:
    """Return which of the triangular sectors of each cell lie inside the shape, shape (n, 2 slots); see `Lattice.sectors`."""
    centres = np.array(shape.anchor) + diameter * lattice.unit * places
    inside = np.empty((len(places), 2 * lattice.slots), bool)
    left, right, low, high = shape.bounds
    for sector in range(2 * lattice.slots):
        angle = math.pi / lattice.slots * (sector + 0.5)
        probes = centres + _PROBE * diameter * np.array([math.cos(angle), math.sin(angle)])
        for axis, (start, end) in enumerate(((left, right), (low, high))):
            if periodic[axis]:
                probes[:, axis] = start + (probes[:, axis] - start) % (end - start)
        inside[:, sector] = shape.contains(probes, 0.0)
    return inside
