"""Automata as fields on a lattice: each neighbour lies at a constant offset in memory.

The rows of the packing follow each other in memory. A link belongs to the automaton where it begins and has one of two
directions (square: along x and y) or three (hexagonal: along x, to the upper right, to the upper left). A place is an index
of a field; a link ends `offset` places after its beginning. Without a link the face has area 0, without an automaton the mass
is infinite. Loops over links and automata are therefore plain slices, without tables of neighbours.

A periodic specimen has ghosts, copies of the automata on the opposite side, at the places next to its ends.
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
    """Places (indices) of automata and links in the fields.

    Attributes:
        place: of each automaton, shape (n,).
        offset: from the place where a link begins to that where it ends, shape (directions,).
        ghosts: place of each ghost, and place of the automaton that it copies, shape (g, 2).
        begin: first place that may have an automaton.
        end: one past the last such place; a field has `end + begin` places.
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


# Rows of `Motion`: displacement along x and y [m], angle (counter-clockwise) [rad], and their time derivatives.
X, Y, ANGLE, VX, VY, SPIN = range(6)
# Rows of `Body.cells`: initial centres [m], X and Y; mass (infinite without an automaton) [kg], moment of inertia about the
# centre, m D^2 / 8 [kg m^2], volume [m^3], G and lambda = K - 2 G / 3 [Pa], and the share c* of free faces (`Packing.missing`).
MASS, INERTIA, VOLUME, SHEAR, LAME, MISSING = range(2, 8)
# Fields of `Body.links`: face area, 0 without a link [m^2]; contribution of the link's strain to the volume strain of the
# automaton where it begins, and to that of the automaton where it ends.
FACE, FIRST_SHARE, SECOND_SHARE = range(3)
# Fields of `Scratch.links`: strains along and across a link, its present direction; terms that are then summed over links, e.g.
# the force on the automaton where the link begins [N], and the torque on both automata divided by the radius [N].
EPS, GAMMA, EX, EY, FIRST_TERM, SECOND_TERM, TURNING = range(7)
# Further fields of links with histories: strain that counts in the volume strain, tractions along and across [Pa], terms of the
# stresses xx, yy and xy [Pa], and d: the strains of the two halves (materials) of the link are eps + d and eps - d.
COUNTED, NORMAL, TANGENTIAL, VIRIAL_XX, VIRIAL_YY, VIRIAL_XY, DIVISION = range(7, 14)
# Rows of `Scratch.cells`: force [N] and torque [N m], cos - 1 and sin of half the rotation angle, the volume strain theta, and
# its factor 1 / (1 + a), which accounts for free faces.
FORCE_X, FORCE_Y, TORQUE, COSINE, SINE, DILATION, STIFFENING = range(7)
# Further rows of automata with histories: lambda theta, G theta, and the stresses xx, yy and xy, tension positive [Pa].
PRESSURE, DEVIATOR, STRESS_XX, STRESS_YY, STRESS_XY = range(7, 12)

Motion = FloatArray


class Body(NamedTuple):
    """The constants of the automata: geometry, masses and moduli.

    Attributes:
        layout: a `Layout`.
        normal: unit vector of each link direction at the start, shape (directions, 2).
        diameter: distance of neighbours [m].
        cells: rows with one value per automaton, see MASS, shape (8, m).
        links: fields with one value per link, see FACE, shape (3, directions, m).
    """

    layout: Layout
    normal: FloatArray
    diameter: float
    cells: FloatArray
    links: FloatArray


class Scratch(NamedTuple):
    """Results of a force evaluation.

    Attributes:
        links: see EPS and COUNTED, shape (7 or 14, directions, m).
        cells: see FORCE_X and PRESSURE, shape (7 or 12, m).
    """

    links: FloatArray
    cells: FloatArray


def make_layout(packing: Packing) -> Layout:
    """Return the places of the automata of a packing, with rows as close in memory as possible."""
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
    # Column of each automaton along x, or along the oblique axis of a hexagonal packing, half a diameter further left per row.
    along = (where[:, 0] - where[:, 1]) // 2 if hexagonal else where[:, 0]
    stride = _smallest_row_stride(row, along)
    place = row * stride + along
    offset = np.array([1, stride, stride - 1] if hexagonal else [1, stride], np.int64)
    place += stride - place.min()
    copies = np.stack([place[len(at) :], place[np.array(list(ghosts.values()), np.int64)]], axis=1)
    return Layout(place[: len(at)], offset, copies, stride, int(place.max()) + 1)


def _smallest_row_stride(row: IntArray, along: IntArray) -> int:
    """Return the smallest distance between rows in memory at which no row begins before the row below has ended."""
    stride, rows = 2, np.unique(row)
    ends = np.array([[along[row == one].min(), along[row == one].max()] for one in rows.tolist()])
    for number in range(1, len(rows)):
        gap = int(rows[number] - rows[number - 1])
        stride = max(stride, math.floor((ends[number - 1, 1] - ends[number, 0]) / gap) + 1)
    return stride


def make_body(packing: Packing, density: FloatArray, moduli: FloatArray, thickness: float) -> Body:
    """Return the `Body` of a packing whose automata have these materials.

    Args:
        packing: the automata.
        density: of each automaton, shape (n,) [kg/m^3].
        moduli: G and lambda of each automaton, shape (n, 2) [Pa].
        thickness: extent along z [m].
    """
    layout, volume = make_layout(packing), packing.volume * thickness
    mass = density * volume
    half = packing.lattice.slots // 2
    links = np.zeros((3, half, layout.size))
    for direction in range(half):
        at, ends = packing.neighbours[:, direction], np.arange(len(volume))
        there = at != ends
        one, other = ends[there], at[there]
        for places in (layout.place[one], layout.place[other] - layout.offset[direction]):
            links[FACE, direction, places] = packing.face[one, direction] * thickness
            links[FIRST_SHARE, direction, places] = packing.share[one, direction]
            links[SECOND_SHARE, direction, places] = packing.share[other, direction + half]
    own = (
        *packing.reference.T,
        mass,
        mass * packing.diameter * packing.diameter / 8.0,
        volume,
        *moduli.T,
        packing.missing,
    )
    elsewhere = (0.0, 0.0, np.inf, np.inf, 1.0, *moduli[0], 0.0)
    cells = np.tile(np.array(elsewhere)[:, np.newaxis], layout.size)
    cells[:, layout.place] = own
    for row in (X, Y, VOLUME, SHEAR, LAME, MISSING):
        copy_to_ghosts(layout, cells[row])
    return Body(layout, packing.lattice.directions[:half].copy(), packing.diameter, cells, links)


def copy_to_ghosts(layout: Layout, field: FloatArray) -> None:
    """Copy values from automata to their ghosts, along the last axis of a field."""
    field[..., layout.ghosts[:, 0]] = field[..., layout.ghosts[:, 1]]


def make_motion(size: int) -> Motion:
    """Return fields at rest."""
    return np.zeros((6, size))


def make_scratch(body: Body, *, histories: bool) -> Scratch:
    """Return a `Scratch` for the automata of a body; `histories` says whether their links have histories."""
    directions, size = body.links.shape[1:]
    links, cells = np.zeros((14 if histories else 7, directions, size)), np.zeros((12 if histories else 7, size))
    cells[STIFFENING] = 1.0 / (1.0 + body.cells[MISSING] * body.cells[LAME] / (2.0 * body.cells[SHEAR]))
    return Scratch(links, cells)


@jit
def load_motion(layout, displacement, velocity, rotation, spin, motion):
    """Copy the state of the automata, arrays of shapes (n, 2), (n, 2), (n,) and (n,), to the fields of a `Motion`."""
    for i in range(layout.place.size):
        p = layout.place[i]
        motion[X, p], motion[Y, p], motion[ANGLE, p] = displacement[i, 0], displacement[i, 1], rotation[i]
        motion[VX, p], motion[VY, p], motion[SPIN, p] = velocity[i, 0], velocity[i, 1], spin[i]
    for row in range(6):
        update_ghosts(layout.ghosts, motion[row])


@jit
def store_motion(layout, displacement, velocity, rotation, spin, motion):
    """Copy the fields of a `Motion` to the state of the automata; arguments as in `load_motion`."""
    for i in range(layout.place.size):
        p = layout.place[i]
        displacement[i, 0], displacement[i, 1], rotation[i] = motion[X, p], motion[Y, p], motion[ANGLE, p]
        velocity[i, 0], velocity[i, 1], spin[i] = motion[VX, p], motion[VY, p], motion[SPIN, p]


@internal
def update_ghosts(ghosts, field):
    """Copy the values of automata to their ghosts."""
    for row in range(ghosts.shape[0]):
        field[ghosts[row, 0]] = field[ghosts[row, 1]]


@internal
def update_ghost_velocities(ghosts, motion):
    """Copy the velocities of automata to their ghosts."""
    for row in range(VX, SPIN + 1):
        update_ghosts(ghosts, motion[row])
