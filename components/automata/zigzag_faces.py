"""Faces of a hexagonal packing that another body or a held edge carries along: along a zigzag, and at the corners beside it.

A zigzag has half cells, whose centres move with that body or edge, and between two of these, a and b, a whole cell i, half a
diameter inside. Its outer face f moves with the middle of the two. It is tied like half of a pair, with the rotation of i:

    d = (x_a + x_b) / 2 - x_i,      eps = d . N(phi_i) / (D / 2) - 1,      gamma = d . T(phi_i) / (D / 2)
    f_n = S (2 G eps + lambda theta_i),      f_t = S 2 G gamma,      U = S (D / 2) G (eps^2 + gamma^2)

and adds its share to theta_i, as the face of a pair would; -F / 2 acts on a and on b.

The half of the cell between its centre and the face, m / 2, moves by half with each of them, as the half pair is strained:
m / 4 goes from i to a and b. With all of it in the centre it would lie a quarter of a diameter too far inside, and the
interface would send back six times as much of P waves.

At a corner with a row along x, the cells of the row are cut along their centres, and a pair of the row counts half a face at
the middle between the centres, not at the middle of that half. For two neighbours on opposite sides that cancels; at the corner
it does not, and the volumetric strain would feel a shear. With s = 1 for automata above the row, -1 below it,

    V_i theta_i  gets  -s (D^2 / 4) gamma,      V_j theta_j  gets  s (D^2 / 4) gamma

of each pair i, j of the row, i on the left: exact at the corner, a second difference along the row. Forces follow from the
energy, so that momentum, angular momentum and energy are conserved as without.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray
from ..support.jit import internal_inlined, jit
from .kernel_arrays import Body
from .pair import half_turn, strains, turned
from .stress import virial

_SINE = 0.5 * math.sqrt(3.0)


class Ties(NamedTuple):
    """Tied faces, and pairs of rows that end at a corner beside them.

    Attributes:
        automata: whose face is tied, shape (t,).
        slots: of that face, shape (t,).
        ends: the two automata that carry it, shape (t, 2).
        rows: pairs along x whose faces are halved, the left automaton first, shape (r, 2).
        sides: 1 for a row with automata above it, -1 below it, shape (r,).
        touched: all automata whose volumetric strain these change, shape (q,).
        change: scratch: of the volumetric strain of each automaton, zeros, shape (n,).
        place: row of each automaton in `touched`, -1 of the others, shape (n,).
        faces: of the automata in `touched`, the rows of their tied faces, or -1, shape (q, 2).
        pairs: of these, the rows of the pairs along x with their right and with their left neighbour, or -1, shape (q, 2).
        materials: of the automata with tied faces, numbers, shape (t,).
    """

    automata: npt.NDArray[np.int64]
    slots: npt.NDArray[np.int64]
    ends: npt.NDArray[np.int64]
    rows: npt.NDArray[np.int64]
    sides: FloatArray
    touched: npt.NDArray[np.int64]
    change: FloatArray
    place: npt.NDArray[np.int64]
    faces: npt.NDArray[np.int64]
    pairs: npt.NDArray[np.int64]
    materials: npt.NDArray[np.int64]


def tie_faces(body: Body, ties: Ties) -> Body:
    """Return a body with tied faces: kinds of their own, with fewer free faces, and with mass moved from centre to face."""
    tied, moved = np.zeros((2, len(body.kind)))
    whole = body.mass[body.kind[ties.automata]]
    np.add.at(tied, ties.automata, 1.0)
    np.add.at(moved, ties.automata, -0.25 * whole)
    for column in (0, 1):
        np.add.at(moved, ties.ends[:, column], 0.125 * whole)
    rows, kinds = np.unique(np.stack([body.kind, tied, moved], axis=1), axis=0, return_inverse=True)
    source, faces = rows[:, 0].astype(np.int64), rows[:, 1]
    missing = body.missing[source] - faces * body.share[source].max(axis=1)
    return body._replace(
        kind=kinds.reshape(-1).astype(np.int32), missing=np.where(missing > 1e-12, missing, 0.0),
        mass=body.mass[source] + rows[:, 2],
        **{name: getattr(body, name)[source] for name in ("face", "share", "volume", "inertia")},
    )  # fmt: skip


@internal_inlined
def face_strains(body, ties, displacement, half, row):
    """Return the strains along and across a tied face, and cos - 1 and sin of the rotation of its automaton."""
    i, a, b, slot = ties.automata[row], ties.ends[row, 0], ties.ends[row, 1], ties.slots[row]
    dx = 0.5 * (displacement[a, 0] + displacement[b, 0]) - displacement[i, 0]
    dy = 0.5 * (displacement[a, 1] + displacement[b, 1]) - displacement[i, 1]
    nx, ny, inverse, c, s = body.directions[slot, 0], body.directions[slot, 1], 2.0 / body.diameter, half[i, 0], half[i, 1]
    less, sine = (c + c) + (c * c - s * s), (s + s) + (c * s + s * c)
    x, y = dx + (less * dx + sine * dy), dy + (less * dy - sine * dx)
    return (x * nx + y * ny) * inverse + less, (y * nx - x * ny) * inverse - sine, less, sine


@internal_inlined
def face_strain_rates(body, ties, motion, half, row):
    """Return the rates of the strains of a tied face, along and across [1/s]."""
    eps, gamma, less, sine = face_strains(body, ties, motion.displacement, half, row)
    i, a, b, slot = ties.automata[row], ties.ends[row, 0], ties.ends[row, 1], ties.slots[row]
    v, inverse, turning = motion.velocity, 2.0 / body.diameter, motion.spin[i]
    nx, ny = turned(1.0, 0.0, body.directions[slot, 0], body.directions[slot, 1], less, sine)
    vx, vy = 0.5 * (v[a, 0] + v[b, 0]) - v[i, 0], 0.5 * (v[a, 1] + v[b, 1]) - v[i, 1]
    return (vx * nx + vy * ny) * inverse + turning * gamma, (vy * nx - vx * ny) * inverse - turning * (1.0 + eps)


@internal_inlined
def row_strains(body, ties, displacement, half, row):
    """Return the strains of a pair of a row, and cos - 1 and sin of its rotation."""
    return strains(displacement, half, ties.rows[row, 0], ties.rows[row, 1], 1.0, 0.0, body.diameter)


@internal_inlined
def row_moment(body, ties, row):
    """Return what of gamma the volume of the right automaton of a pair of a row gets, +-D^2 / 4 times the thickness."""
    return ties.sides[row] * (_SINE * body.face[body.kind[ties.rows[row, 0]], 0]) * body.diameter


@internal_inlined
def _stiffening(body, k):
    return 1.0 + body.missing[k] * body.lame / (2.0 * body.shear)


@internal_inlined
def whole_face(body, k):
    """Return the area of the face of a whole cell and its share in the volumetric strain."""
    area = 0.0
    for slot in range(body.face.shape[1]):
        area = max(area, body.face[k, slot])
    return area, 0.5 * area * body.diameter / body.volume[k]


@jit
def add_ties(body, ties, motion, scratch):
    """Add what ties do to the volumetric strains, forces and torques that pairs alone have.

    Args:
        body: as `tie_faces` gives it.
        ties: `Ties`.
        motion: a `Motion`.
        scratch: a `Scratch`, updated in place.
    """
    u, half, radius = motion.displacement, scratch.half, 0.5 * body.diameter
    slots = body.directions.shape[0]
    for place in range(ties.touched.size):
        i = ties.touched[place]
        half[i, 0], half[i, 1] = half_turn(motion.rotation[i])
        for slot in range(slots):
            j = body.neighbours[i, slot]
            half[j, 0], half[j, 1] = half_turn(motion.rotation[j])
    for row in range(ties.automata.size):
        i, k = ties.automata[row], body.kind[ties.automata[row]]
        eps, _, _, _ = face_strains(body, ties, u, half, row)
        _, share = whole_face(body, k)
        ties.change[i] += share * eps / _stiffening(body, k)
    for row in range(ties.sides.size):
        i, j, moment = ties.rows[row, 0], ties.rows[row, 1], row_moment(body, ties, row)
        _, gamma, _, _ = row_strains(body, ties, u, half, row)
        ties.change[i] -= moment * gamma / (body.volume[body.kind[i]] * _stiffening(body, body.kind[i]))
        ties.change[j] += moment * gamma / (body.volume[body.kind[j]] * _stiffening(body, body.kind[j]))
    for place in range(ties.touched.size):
        i = ties.touched[place]
        k, more = body.kind[i], ties.change[i]
        ties.change[i] = 0.0
        scratch.dilation[i] += more
        for slot in range(slots):
            j, nx, ny = body.neighbours[i, slot], body.directions[slot, 0], body.directions[slot, 1]
            if j != i:
                _, gamma, less, sine = strains(u, half, i, j, nx, ny, body.diameter)
                normal = body.face[k, slot] * (0.5 * body.lame) * more
                fx, fy = turned(normal, 0.0, nx, ny, less, sine)
                push(scratch.force, i, j, fx, fy)
                scratch.torque[i] -= radius * gamma * normal
                scratch.torque[j] -= radius * gamma * normal
    for row in range(ties.automata.size):
        i, a, b, slot = ties.automata[row], ties.ends[row, 0], ties.ends[row, 1], ties.slots[row]
        eps, gamma, less, sine = face_strains(body, ties, u, half, row)
        area, _ = whole_face(body, body.kind[i])
        pressing, across = area * body.lame * scratch.dilation[i], area * (2.0 * body.shear) * gamma
        nx, ny = body.directions[slot, 0], body.directions[slot, 1]
        fx, fy = turned(area * (2.0 * body.shear) * eps + pressing, across, nx, ny, less, sine)
        push(scratch.force, i, a, 0.5 * fx, 0.5 * fy)
        push(scratch.force, i, b, 0.5 * fx, 0.5 * fy)
        # (1 + eps) f_t - gamma f_n, without what cancels.
        scratch.torque[i] += radius * (across - gamma * pressing)
    for row in range(ties.sides.size):
        i, j = ties.rows[row, 0], ties.rows[row, 1]
        eps, _, less, sine = row_strains(body, ties, u, half, row)
        moment = row_moment(body, ties, row) / body.diameter
        across = moment * body.lame * (scratch.dilation[j] - scratch.dilation[i])
        fx, fy = turned(0.0, across, 1.0, 0.0, less, sine)
        push(scratch.force, i, j, fx, fy)
        scratch.torque[i] += radius * (1.0 + eps) * across
        scratch.torque[j] += radius * (1.0 + eps) * across


@internal_inlined
def push(force, i, j, fx, fy):
    """Add a force on one automaton, and the opposite one on another."""
    force[i, 0] += fx
    force[i, 1] += fy
    force[j, 0] -= fx
    force[j, 1] -= fy


@jit
def tie_energy(body, ties, displacement, half):
    """Return the energy of tied faces, without that of the volumetric strains [J]; `half` as for `elastic_energy`."""
    total = 0.0
    for row in range(ties.automata.size):
        eps, gamma, _, _ = face_strains(body, ties, displacement, half, row)
        area, _ = whole_face(body, body.kind[ties.automata[row]])
        total += 0.5 * body.diameter * area * body.shear * (eps * eps + gamma * gamma)
    return total


@jit
def add_tie_stresses(body, ties, displacement, half, dilation, stress):
    """Add what the tractions on tied faces are of the stresses of their automata; arguments as for `stress.stresses`."""
    for row in range(ties.automata.size):
        i, slot = ties.automata[row], ties.slots[row]
        eps, gamma, less, sine = face_strains(body, ties, displacement, half, row)
        _, share = whole_face(body, body.kind[i])
        normal = 2.0 * body.shear * eps + body.lame * dilation[i]
        nx, ny = body.directions[slot, 0], body.directions[slot, 1]
        xx, yy, xy = virial(normal, 2.0 * body.shear * gamma, nx, ny, less, sine)
        stress[i, 0] += share * xx
        stress[i, 1] += share * yy
        stress[i, 2] += share * xy


def make_ties(body: Body, faces: list[tuple[int, int]], corners: npt.NDArray[np.int64], reference: FloatArray) -> Ties | None:
    """Return ties of a hexagonal packing; None where there are no faces to tie.

    Args:
        body: the packing.
        faces: whole automata of a zigzag, and the slot of their tied face, 0 or 3.
        corners: automata at which a zigzag with tied faces ends, shape (k,).
        reference: centres, for their number, shape (n, 2).
    """
    if not faces:
        return None
    automata, slots = np.array(sorted(set(faces)), np.int64).T
    ends = np.stack([body.neighbours[automata, np.where(slots == 0, one, other)] for one, other in ((1, 2), (5, 4))], axis=1)
    rows, sides = _rows_at(body, corners)
    touched = np.unique(np.concatenate([automata, rows.reshape(-1)]))
    place = np.full(len(reference), -1)
    place[touched] = np.arange(len(touched))
    of_faces, of_pairs = np.full((2, len(touched), 2), -1)
    of_faces[place[automata], (slots > 0).astype(int)] = np.arange(len(automata))
    for column in (0, 1):
        of_pairs[place[rows[:, column]], column] = np.arange(len(rows))
    return Ties(
        np.ascontiguousarray(automata), np.ascontiguousarray(slots), ends.astype(np.int64), rows, sides, touched,
        np.zeros(len(reference)), place, of_faces, of_pairs, np.zeros(len(automata), np.int64),
    )  # fmt: skip


def _rows_at(body: Body, corners: npt.NDArray[np.int64]) -> tuple[npt.NDArray[np.int64], FloatArray]:
    """Return the pairs with half a face in the rows through the corners, from end to end, and on which side automata are."""
    whole = float(body.face.max())
    halved = np.abs(body.face[body.kind, 0] - 0.5 * whole) <= 1e-9 * whole
    found: dict[int, float] = {}
    waiting: list[int] = corners.tolist()
    while waiting:
        i = waiting.pop()
        left = int(body.neighbours[i, 3])
        for first in (i, left):
            if halved[first] and first not in found and (first != left or left != i):
                found[first] = 1.0 if body.face[body.kind[first], 1] > 0.0 else -1.0
                waiting += [first, int(body.neighbours[first, 0])]
    firsts = np.array(sorted(found), np.int64)
    pairs: Any = np.stack([firsts, body.neighbours[firsts, 0].astype(np.int64)], axis=1)
    return pairs, np.array([found[one] for one in firsts.tolist()], dtype=np.float64)
