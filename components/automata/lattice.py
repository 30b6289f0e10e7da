"""Automata as fields on a lattice: every neighbour lies a constant number of places away.

Rows of the packing follow each other in memory. A link belongs to the automaton where it begins and to one of two directions
(square: along x and y) or three (hexagonal: along x, to the upper right, to the upper left). It ends `offset` places further
on. A place without a link has a face of area 0, a place without an automaton has infinite mass. Loops over links and automata
are therefore plain slices, without tables of neighbours.

A specimen that is closed on itself has ghosts, copies of the automata on the opposite side, at the places next to its ends.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray
from ..support.jit import internal, jit
from .packing import Packing

IntArray = npt.NDArray[np.int64]


class Layout(NamedTuple):
    """Where automata and links lie in the fields.

    Attributes:
        place: of each automaton, shape (n,).
        offset: from the beginning to the end of a link, shape (directions,).
        ghosts: places of ghosts and of the automata that they copy, shape (g, 2).
        begin: the first place that may have an automaton.
        end: after the last one. Fields have `begin` more places.
    """

    place: IntArray
    offset: IntArray
    ghosts: IntArray
    begin: int
    end: int

    @property
    def size(self) -> int:
        """Return the number of places of a field."""
        return self.end + self.begin


class Body(NamedTuple):
    """Constants: geometry, masses and moduli. Fields of automata have shape (m,), of links (directions, m). SI units.

    Attributes:
        layout: a `Layout`.
        normal: directions of links before anything moves, shape (directions, 2).
        diameter: distance of neighbours [m].
        x: of the centres before anything moves [m].
        y: likewise [m].
        mass: infinite without an automaton [kg].
        inertia: moment of inertia about the centre, m D^2 / 8 [kg m^2].
        volume: [m^3].
        shear: G [Pa].
        lame: lambda = K - 2 G / 3 [Pa].
        missing: share of the free faces of a whole cell.
        face: area of a link, 0 without one [m^2].
        first_share: what the strain of a link adds to the volumetric strain of the automaton where it begins.
        second_share: of the automaton where it ends.
    """

    layout: Layout
    normal: FloatArray
    diameter: float
    x: FloatArray
    y: FloatArray
    mass: FloatArray
    inertia: FloatArray
    volume: FloatArray
    shear: FloatArray
    lame: FloatArray
    missing: FloatArray
    face: FloatArray
    first_share: FloatArray
    second_share: FloatArray


class Motion(NamedTuple):
    """Displacements, velocities, angles (counter-clockwise) and angular velocities, each of shape (m,)."""

    x: FloatArray
    y: FloatArray
    vx: FloatArray
    vy: FloatArray
    angle: FloatArray
    spin: FloatArray


class Links(NamedTuple):
    """Strains and forces of links in the present positions, each of shape (directions, m).

    Attributes:
        eps: strain along the link.
        gamma: strain across the link.
        ex: present direction, x.
        ey: present direction, y.
        first: force along x on the automaton where the link begins [N]; or a term of a sum there.
        second: force along y there [N]; or a term of a sum at its other end.
        torque: on both automata, over the radius [N].
    """

    eps: FloatArray
    gamma: FloatArray
    ex: FloatArray
    ey: FloatArray
    first: FloatArray
    second: FloatArray
    torque: FloatArray


class Forces(NamedTuple):
    """Forces on automata, and the fields from which they follow; each of shape (m,).

    Attributes:
        x: force [N].
        y: force [N].
        torque: [N m].
        cosine: cos - 1 of half the rotation.
        sine: sin of half the rotation.
        dilation: volumetric strain theta.
        stiffening: 1 / (1 + a): factor of free faces in the volumetric strain.
    """

    x: FloatArray
    y: FloatArray
    torque: FloatArray
    cosine: FloatArray
    sine: FloatArray
    dilation: FloatArray
    stiffening: FloatArray


class Scratch(NamedTuple):
    """Fields that a force evaluation writes."""

    links: Links
    forces: Forces


def lay_out(packing: Packing) -> Layout:
    """Return the places of the automata of a packing, as close to each other in memory as rows allow."""
    hexagonal = packing.lattice.name == "hexagonal"
    steps = packing.lattice.steps
    at = packing.places.astype(np.int64)
    own = np.arange(len(at))
    ghosts = dict[tuple[int, int], int]()
    for slot, step in enumerate(steps):
        other = packing.neighbours[:, slot]
        wraps = (other != own) & (at[other] != at + step).any(axis=1)
        ghosts |= {tuple(where): one for where, one in zip((at + step)[wraps].tolist(), other[wraps].tolist(), strict=True)}
    where = np.concatenate([at, np.array(list(ghosts), np.int64).reshape(-1, 2)])
    row = where[:, 1] - where[:, 1].min()
    # Along x; of a hexagonal packing along its oblique axis, which begins half a diameter further left in each row.
    along = (where[:, 0] - where[:, 1]) // 2 if hexagonal else where[:, 0]
    stride = _least_stride(row, along)
    place = row * stride + along
    offset = np.array([1, stride, stride - 1] if hexagonal else [1, stride], np.int64)
    place += stride - place.min()
    copies = np.stack([place[len(at) :], place[np.array(list(ghosts.values()), np.int64)]], axis=1)
    return Layout(place[: len(at)], offset, copies, stride, int(place.max()) + 1)


def _least_stride(row: IntArray, along: IntArray) -> int:
    """Return the smallest distance of rows in memory with which none begins before the one below has ended."""
    stride, rows = 2, np.unique(row)
    ends = np.array([[along[row == one].min(), along[row == one].max()] for one in rows.tolist()])
    for number in range(1, len(rows)):
        gap = int(rows[number] - rows[number - 1])
        stride = max(stride, math.floor((ends[number - 1, 1] - ends[number, 0]) / gap) + 1)
    return stride


def make_body(packing: Packing, density: FloatArray, moduli: FloatArray, thickness: float) -> Body:
    """Return a packing made of materials.

    Args:
        packing: the automata.
        density: of each automaton, shape (n,) [kg/m^3].
        moduli: G and lambda of each automaton, shape (n, 2) [Pa].
        thickness: extent along z [m].
    """
    layout, classes, kind = lay_out(packing), packing.classes, packing.kind
    volume = classes.volume[kind] * thickness
    mass = density * volume
    face, first, second = (link_field(packing, layout) for _ in range(3))
    half = packing.lattice.slots // 2
    for direction in range(half):
        at, ends = packing.neighbours[:, direction], np.arange(len(kind))
        there = at != ends
        one, other = ends[there], at[there]
        for places in (layout.place[one], layout.place[other] - layout.offset[direction]):
            face[direction, places] = classes.face[kind[one], direction] * thickness
            first[direction, places] = classes.share[kind[one], direction]
            second[direction, places] = classes.share[kind[other], direction + half]

    def spread(values: FloatArray, elsewhere: float) -> FloatArray:
        field = np.full(layout.size, elsewhere)
        field[layout.place] = values
        return copy_to_ghosts(layout, field) if elsewhere != np.inf else field

    return Body(
        layout=layout,
        normal=packing.lattice.directions[:half].copy(),
        diameter=packing.diameter,
        x=spread(packing.reference[:, 0], 0.0),
        y=spread(packing.reference[:, 1], 0.0),
        mass=spread(mass, np.inf),
        inertia=spread(mass * packing.diameter * packing.diameter / 8.0, np.inf),
        volume=spread(volume, 1.0),
        shear=spread(moduli[:, 0], moduli[0, 0]),
        lame=spread(moduli[:, 1], moduli[0, 1]),
        missing=spread(classes.missing[kind], 0.0),
        face=face,
        first_share=first,
        second_share=second,
    )


def link_field(packing: Packing, layout: Layout) -> FloatArray:
    """Return a field of links with zeros, shape (directions, m)."""
    return np.zeros((packing.lattice.slots // 2, layout.size))


def copy_to_ghosts(layout: Layout, field: FloatArray) -> FloatArray:
    """Give ghosts the values of the automata that they copy; return the field."""
    field[layout.ghosts[:, 0]] = field[layout.ghosts[:, 1]]
    return field


def make_motion(size: int) -> Motion:
    """Return fields in which nothing moves."""
    return Motion(*np.zeros((6, size)).copy())


def make_scratch(body: Body) -> Scratch:
    """Return scratch for the automata of a body."""
    directions, size = body.face.shape
    links = Links(*(np.zeros((directions, size)) for _ in Links._fields))
    forces = Forces(*(np.zeros(size) for _ in Forces._fields))
    forces.stiffening[:] = 1.0 / (1.0 + body.missing * body.lame / (2.0 * body.shear))
    return Scratch(links, forces)


@jit
def load(layout, displacement, velocity, rotation, spin, motion):
    """Write the state of automata, arrays of shapes (n, 2), (n, 2), (n,) and (n,), to the fields of a `Motion`."""
    for i in range(layout.place.size):
        p = layout.place[i]
        motion.x[p], motion.y[p] = displacement[i, 0], displacement[i, 1]
        motion.vx[p], motion.vy[p] = velocity[i, 0], velocity[i, 1]
        motion.angle[p], motion.spin[p] = rotation[i], spin[i]
    update_ghosts(layout, motion.x)
    update_ghosts(layout, motion.y)
    update_ghosts(layout, motion.angle)
    update_ghost_velocities(layout, motion)


@jit
def store(layout, displacement, velocity, rotation, spin, motion):
    """Write the fields of a `Motion` to the state of automata; arguments as for `load`."""
    for i in range(layout.place.size):
        p = layout.place[i]
        displacement[i, 0], displacement[i, 1] = motion.x[p], motion.y[p]
        velocity[i, 0], velocity[i, 1] = motion.vx[p], motion.vy[p]
        rotation[i], spin[i] = motion.angle[p], motion.spin[p]


@internal
def update_ghosts(layout, field):
    """Give ghosts the values of the automata that they copy."""
    for row in range(layout.ghosts.shape[0]):
        field[layout.ghosts[row, 0]] = field[layout.ghosts[row, 1]]


@internal
def update_ghost_velocities(layout, motion):
    """Let ghosts move like the automata that they copy."""
    update_ghosts(layout, motion.vx)
    update_ghosts(layout, motion.vy)
    update_ghosts(layout, motion.spin)
