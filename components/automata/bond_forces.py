"""Pairs with a history: links that weaken, yield, break, and are released over several steps.

As in `sweep`, with the weight w of each link (1 while it holds, falling to 0 while it is released), what is left of its
stiffness g, and its plastic strains:

    theta_i = sum_j c (w eps + (1 - w) eps_p) / (1 + a),      a = (c* + sum_j (1 - w) c / g) lambda / 2 G
    f_n = w S (2 G g (eps - eps_p) + lambda (theta_i + theta_j) / 2),      f_t = w S 2 G g (gamma - gamma_p)
    U = sum over pairs w S r G g ((eps - eps_p)^2 + (gamma - gamma_p)^2) + sum over automata (1/2) V lambda (1 + a) theta^2

A released face carries no traction: its strain is that at which 2 G g (eps - eps_p) + lambda theta = 0. This condenses it as
the free faces of a whole cell are, but from the strain that has flowed and with the stiffness that is left. So what it takes to
release a link is never negative: dU/dw = V c G g (eps - eps_p + lambda theta / 2 G g)^2 for each of both automata. Sums run
over opposite slots together, from the last pair of slots to the first: the bits are those of the mirrored specimen.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..support.arrays import FloatArray
from ..support.jit import internal, internal_inlined, jit
from .breaking.functions import failure
from .pair import mirrored_slots, orient, strains, turned
from .responses.functions import respond
from .state import Body
from .stress import virial


class Bonds(NamedTuple):
    """The histories of links; each is kept at both of its ends.

    Attributes:
        weight: 1 for a link that holds, less while it is released, 0 afterwards; shape (n, slots).
        plastic: plastic strains along and across, shape (n, slots, 2).
        stiffness: part of the shear modulus that is left, less 1, shape (n, slots).
        inelastic: inelastic strain, shape (n, slots).
        origin: strains along and across from which those of a link count, shape (n, slots, 2); where no pair is linked again
            they are all 0, and this has shape (0, slots).
    """

    weight: FloatArray
    plastic: FloatArray
    stiffness: FloatArray
    inelastic: FloatArray
    origin: FloatArray


class Law(NamedTuple):
    """The response and the breaking criterion of links, as numbers for kernels.

    Attributes:
        elastic: whether they have no history.
        response: see `responses.Response.constants`, shape (3,).
        criterion: number of the criterion.
        strength: see `breaking.Criterion.constants`, shape (3,).
        factors: of the strength of each link, shape (n, slots / 2).
        release: over how many internal steps a broken link is released, and a new one made.
        linking: see `relinking.Relinking.constants`, shape (2,).
        linking_ticks: after how many internal steps it is looked which pairs are linked again; 0 for never.
    """

    elastic: bool
    response: FloatArray
    criterion: int
    strength: FloatArray
    factors: FloatArray
    release: int
    linking: FloatArray
    linking_ticks: int


@internal_inlined
def opposite_slot(slots, slot):
    """Return the slot of the same pair at its other end."""
    return slot + slots // 2 if slot < slots // 2 else slot - slots // 2


@internal_inlined
def pair_strains(body, displacement, half, i, slot):
    """Return the strains of a pair since anything moved, and cos - 1 and sin of its rotation."""
    nx, ny, j = body.directions[slot, 0], body.directions[slot, 1], body.neighbours[i, slot]
    return strains(displacement, half, i, j, nx, ny, body.diameter)


@internal_inlined
def _origin_of(origin, i, slot):
    """Return the strains from which those of a link count; which of the two is known when this is compiled.

    A question to be answered for each link would make everything around it ten times as slow.
    """
    if origin.ndim == 3:
        return origin[i, slot, 0], origin[i, slot, 1]
    return 0.0, 0.0


@internal_inlined
def bond_strains(body, bonds, displacement, half, i, slot):
    """Return the strains of a link, from those on that it was made with, and cos - 1 and sin of its rotation."""
    eps, gamma, less, sine = pair_strains(body, displacement, half, i, slot)
    along, across = _origin_of(bonds.origin, i, slot)
    return eps - along, gamma - across, less, sine


@internal_inlined
def bond_tractions(body, bonds, displacement, half, dilation, i, slot):
    """Return the tractions along and across a link, and cos - 1 and sin of its rotation."""
    eps, gamma, less, sine = bond_strains(body, bonds, displacement, half, i, slot)
    twice = 2.0 * body.shear * (1.0 + bonds.stiffness[i, slot])
    eps, gamma = eps - bonds.plastic[i, slot, 0], gamma - bonds.plastic[i, slot, 1]
    pressing = body.lame * (0.5 * (dilation[i] + dilation[body.neighbours[i, slot]]))
    return twice * eps + pressing, twice * gamma, less, sine


@internal_inlined
def _free_share(body, bonds, i, kind, slot):
    """Return what a released face adds to the shares of free faces; its stiffness is what is left of that of the link."""
    if bonds.weight[i, slot] == 1.0:
        return 0.0
    return (1.0 - bonds.weight[i, slot]) * body.share[kind, slot] / (1.0 + bonds.stiffness[i, slot])


@internal_inlined
def condensation(body, bonds, i):
    """Return 1 + a of an automaton: what its free and released faces make of the volumetric strain."""
    k, slots = body.kind[i], body.directions.shape[0]
    free = 0.0
    for group in range(slots // 2 - 1, -1, -1):
        a, b = mirrored_slots(slots, group)
        free += _free_share(body, bonds, i, k, a) + _free_share(body, bonds, i, k, b)
    return 1.0 + (body.missing[k] + free) * body.lame / (2.0 * body.shear)


@internal_inlined
def bond_dilation(body, bonds, displacement, half, i):
    """Return the volumetric strain of an automaton."""
    k, slots = body.kind[i], body.directions.shape[0]
    total = 0.0
    for group in range(slots // 2 - 1, -1, -1):
        pair = 0.0
        for slot in mirrored_slots(slots, group):
            eps, _, _, _ = bond_strains(body, bonds, displacement, half, i, slot)
            weight = bonds.weight[i, slot]
            # A released face keeps the strain that has flowed.
            strain = eps if weight == 1.0 else weight * eps + (1.0 - weight) * bonds.plastic[i, slot, 0]
            pair += body.share[k, slot] * strain
        total += pair
    return total / condensation(body, bonds, i)


@internal
def bond_dilations(body, bonds, displacement, half, dilation_out, begin, end):
    """Write the volumetric strains of automata from `begin` up to `end`; arguments as for `bond_forces`."""
    for i in range(begin, end):
        dilation_out[i] = bond_dilation(body, bonds, displacement, half, i)


@internal
def bond_stresses(body, bonds, displacement, half, dilation, stress_out, begin, end):
    """Write the stresses of automata from `begin` up to `end`; arguments as for `stress.stresses`."""
    slots = body.directions.shape[0]
    for i in range(begin, end):
        k, xx, yy, xy = body.kind[i], 0.0, 0.0, 0.0
        for group in range(slots // 2 - 1, -1, -1):
            px, py, pxy = 0.0, 0.0, 0.0
            for slot in mirrored_slots(slots, group):
                ax, ay, axy = _virial(body, bonds, displacement, half, dilation, i, k, slot)
                px, py, pxy = px + ax, py + ay, pxy + axy
            xx, yy, xy = xx + px, yy + py, xy + pxy
        stress_out[i, 0], stress_out[i, 1], stress_out[i, 2] = xx, yy, xy


@internal_inlined
def _virial(body, bonds, displacement, half, dilation, i, kind, slot):
    normal, tangential, less, sine = bond_tractions(body, bonds, displacement, half, dilation, i, slot)
    share = body.share[kind, slot] * bonds.weight[i, slot]
    return virial(share * normal, share * tangential, body.directions[slot, 0], body.directions[slot, 1], less, sine)


@internal
def bond_forces(body, bonds, displacement, half, dilation, force_out, torque_out, begin, end):
    """Write the forces and torques of the links on automata from `begin` up to `end`.

    Args:
        body: a `Body`.
        bonds: `Bonds`.
        displacement: shape (n, 2) [m].
        half: see `pair.orient`, shape (n, 2).
        dilation: see `bond_dilations`, of all automata from `begin` to `end` and their neighbours, shape (n,).
        force_out: shape (n, 2) [N].
        torque_out: shape (n,) [N m].
        begin: first automaton.
        end: after the last one.
    """
    slots = body.directions.shape[0]
    for i in range(begin, end):
        k, fx, fy, torque = body.kind[i], 0.0, 0.0, 0.0
        for group in range(slots // 2 - 1, -1, -1):
            px, py, turning = 0.0, 0.0, 0.0
            for slot in mirrored_slots(slots, group):
                ax, ay, at = _pull(body, bonds, displacement, half, dilation, i, k, slot)
                px, py, turning = px + ax, py + ay, turning + at
            fx, fy, torque = fx + px, fy + py, torque + turning
        force_out[i, 0], force_out[i, 1], torque_out[i] = fx, fy, torque


@internal_inlined
def _pull(body, bonds, displacement, half, dilation, i, kind, slot):
    """Return the force of a link on an automaton, x and y, and its torque."""
    normal, tangential, less, sine = bond_tractions(body, bonds, displacement, half, dilation, i, slot)
    eps, gamma, _, _ = pair_strains(body, displacement, half, i, slot)
    area = body.face[kind, slot] * bonds.weight[i, slot]
    fn, ft = area * normal, area * tangential
    fx, fy = turned(fn, ft, body.directions[slot, 0], body.directions[slot, 1], less, sine)
    return fx, fy, (0.5 * body.diameter) * ((1.0 + eps) * ft - gamma * fn)


def intact_bonds(body: Body) -> Bonds:
    """Return links that all hold."""
    shape = body.neighbours.shape
    return Bonds(np.ones(shape), np.zeros((*shape, 2)), np.zeros(shape), np.zeros(shape), np.zeros((0, shape[1])))


@jit
def update_bond_forces(body, bonds, motion, scratch):
    """Write the volumetric strains of the positions as they are, and the forces and torques of the links."""
    u, half, count = motion.displacement, scratch.half, body.kind.size
    orient(motion.rotation, half, 0, count)
    bond_dilations(body, bonds, u, half, scratch.dilation, 0, count)
    bond_forces(body, bonds, u, half, scratch.dilation, scratch.force, scratch.torque, 0, count)


@jit
def measure_bonds(body, bonds, motion, scratch, stress_out):
    """Write the volumetric strains and the stresses, shape (n, 3) [Pa], of the positions as they are."""
    u, half, count = motion.displacement, scratch.half, body.kind.size
    orient(motion.rotation, half, 0, count)
    bond_dilations(body, bonds, u, half, scratch.dilation, 0, count)
    bond_stresses(body, bonds, u, half, scratch.dilation, stress_out, 0, count)


@internal
def pair_energy(body, bonds, displacement, half, i, slot):
    """Return the energy of a link itself, for a weight of 1 [J]."""
    eps, gamma, _, _ = bond_strains(body, bonds, displacement, half, i, slot)
    modulus = body.shear * (1.0 + bonds.stiffness[i, slot])
    eps, gamma = eps - bonds.plastic[i, slot, 0], gamma - bonds.plastic[i, slot, 1]
    return body.face[body.kind[i], slot] * body.diameter * modulus * (eps * eps + gamma * gamma)


@internal
def volume_energy(body, bonds, displacement, half, i):
    """Return the energy of the volumetric strain of an automaton [J]."""
    theta = bond_dilation(body, bonds, displacement, half, i)
    return 0.5 * body.volume[body.kind[i]] * body.lame * condensation(body, bonds, i) * theta * theta


@jit
def bond_energy(body, bonds, displacement, half):
    """Return the energy that is stored in all links and volumes [J]."""
    total, slots = 0.0, body.directions.shape[0]
    for i in range(body.kind.size):
        total += volume_energy(body, bonds, displacement, half, i)
        for slot in range(slots // 2):
            if bonds.weight[i, slot] > 0.0:
                total += bonds.weight[i, slot] * pair_energy(body, bonds, displacement, half, i, slot)
    return total


@internal
def update_bonds(body, bonds, law, displacement, half, dilation, stress, mark_out):
    """Let links that hold yield, and mark those that have to break.

    Args:
        body: a `Body`.
        bonds: `Bonds`, updated in place.
        law: a `Law`.
        displacement: shape (n, 2) [m].
        half: see `pair.orient`, shape (n, 2).
        dilation: see `bond_dilations`, shape (n,).
        stress: see `bond_stresses`, shape (n, 3) [Pa].
        mark_out: the value that decided of each link that has to break, 0 of the others, shape (n, slots / 2).

    Returns:
        How many have to break, and the energy that flow and degradation took [J].
    """
    slots, marked, lost = body.directions.shape[0], 0, 0.0
    for i in range(body.kind.size):
        for slot in range(slots // 2):
            mark_out[i, slot] = 0.0
            j = body.neighbours[i, slot]
            if j == i or bonds.weight[i, slot] != 1.0:
                continue
            if not law.elastic:
                equivalent = mean_equivalent_stress(body, bonds, dilation, stress, i, slot)
                if equivalent > law.response[0]:
                    before = pair_energy(body, bonds, displacement, half, i, slot)
                    flow = _respond(body, bonds, law, displacement, half, dilation, i, slot, equivalent)
                    # Flow takes place under the stress after it: the kicks before and after see that, not the one tried.
                    lost += before - pair_energy(body, bonds, displacement, half, i, slot) - flow
            if law.criterion:
                eps, gamma, _, _ = bond_strains(body, bonds, displacement, half, i, slot)
                normal, tangential, equivalent, mean = pair_stress(body, bonds, displacement, half, dilation, stress, i, slot)
                value, limit, _ = failure(
                    law.criterion, law.strength, eps, gamma, normal, tangential, equivalent, mean, law.factors[i, slot]
                )
                if value >= limit:
                    mark_out[i, slot] = value
                    marked += 1
    return marked, lost


@internal_inlined
def _respond(body, bonds, law, displacement, half, dilation, i, slot, equivalent):
    """Write the history of a link that yields, at both of its ends; return the energy of its plastic strains alone [J]."""
    eps, gamma, _, _ = bond_strains(body, bonds, displacement, half, i, slot)
    j, back = body.neighbours[i, slot], opposite_slot(body.directions.shape[0], slot)
    theta = 0.5 * (dilation[i] + dilation[j])
    eps_p, gamma_p, stiffness, inelastic = respond(
        equivalent, eps, gamma, theta, bonds.plastic[i, slot, 0], bonds.plastic[i, slot, 1], 1.0 + bonds.stiffness[i, slot],
        bonds.inelastic[i, slot], body.shear, law.response[0], law.response[1], law.response[2],
    )  # fmt: skip
    more, across = eps_p - bonds.plastic[i, slot, 0], gamma_p - bonds.plastic[i, slot, 1]
    bonds.plastic[i, slot, 0], bonds.plastic[i, slot, 1] = eps_p, gamma_p
    bonds.plastic[j, back, 0], bonds.plastic[j, back, 1] = eps_p, gamma_p
    bonds.stiffness[i, slot], bonds.stiffness[j, back] = stiffness - 1.0, stiffness - 1.0
    bonds.inelastic[i, slot], bonds.inelastic[j, back] = inelastic, inelastic
    return body.face[body.kind[i], slot] * body.diameter * body.shear * stiffness * (more * more + across * across)


@internal_inlined
def pair_stress(body, bonds, displacement, half, dilation, stress, i, slot):
    """Return the stress of a link: tractions along and across, equivalent and mean stress [Pa].

    The tractions are the link's own; along its face the mean stress of both automata acts.
    """
    normal, tangential, less, sine = bond_tractions(body, bonds, displacement, half, dilation, i, slot)
    j = body.neighbours[i, slot]
    ex, ey = turned(0.0, 1.0, body.directions[slot, 0], body.directions[slot, 1], less, sine)
    xx, yy, xy = 0.5 * (stress[i, 0] + stress[j, 0]), 0.5 * (stress[i, 1] + stress[j, 1]), 0.5 * (stress[i, 2] + stress[j, 2])
    side = (ex * ex * xx + ey * ey * yy) + 2.0 * (ex * ey) * xy
    mean = _mean_stress(body, bonds, dilation, i, slot)
    return normal, tangential, equivalent_stress(normal, side, 3.0 * mean - normal - side, tangential), mean


@internal_inlined
def _mean_stress(body, bonds, dilation, i, slot):
    """Return the mean stress of a link, K theta, with what is left of its shear modulus [Pa]."""
    left = 1.0 + bonds.stiffness[i, slot]
    return (body.lame + 2.0 * body.shear * left / 3.0) * (0.5 * (dilation[i] + dilation[body.neighbours[i, slot]]))


@internal_inlined
def equivalent_stress(xx, yy, zz, xy):
    """Return von Mises' equivalent stress [Pa]."""
    squares = (xx - yy) * (xx - yy) + (yy - zz) * (yy - zz) + (zz - xx) * (zz - xx)
    return np.sqrt(0.5 * squares + 3.0 * xy * xy)


@internal_inlined
def mean_equivalent_stress(body, bonds, dilation, stress, i, slot):
    """Return the equivalent stress of the mean of both automata [Pa].

    All pairs of an automaton then yield together. With their own tractions they would not: what one pair takes off its deviator
    the others' stress along z would have to carry.
    """
    j = body.neighbours[i, slot]
    xx, yy, xy = 0.5 * (stress[i, 0] + stress[j, 0]), 0.5 * (stress[i, 1] + stress[j, 1]), 0.5 * (stress[i, 2] + stress[j, 2])
    return equivalent_stress(xx, yy, 3.0 * _mean_stress(body, bonds, dilation, i, slot) - xx - yy, xy)


@internal
def bond_failure(body, bonds, law, displacement, half, dilation, stress, i, slot):
    """Return what decides whether a link breaks, its limit, and the number of the cause; slot in the first half."""
    eps, gamma, _, _ = bond_strains(body, bonds, displacement, half, i, slot)
    normal, tangential, equivalent, mean = pair_stress(body, bonds, displacement, half, dilation, stress, i, slot)
    factor = law.factors[i, slot]
    return failure(law.criterion, law.strength, eps, gamma, normal, tangential, equivalent, mean, factor)


@jit
def criterion_ratios(body, bonds, law, displacement, half, dilation, stress, pairs, ratio_out):
    """Write how near links are to breaking: what decides over its limit, 0 of those that are broken or far from it.

    Args:
        body: a `Body`.
        bonds: `Bonds`.
        law: a `Law` with a criterion.
        displacement: shape (n, 2) [m].
        half: see `pair.orient`, shape (n, 2).
        dilation: see `bond_dilations`, shape (n,).
        stress: see `bond_stresses`, shape (n, 3) [Pa].
        pairs: see `packing.Packing.pairs`, shape (m, 3).
        ratio_out: shape (m,).
    """
    for row in range(pairs.shape[0]):
        i, slot, ratio_out[row] = pairs[row, 0], pairs[row, 2], 0.0
        if bonds.weight[i, slot] == 1.0:
            value, limit, _ = bond_failure(body, bonds, law, displacement, half, dilation, stress, i, slot)
            ratio_out[row] = max(value / limit, 0.0)
