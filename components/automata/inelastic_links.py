"""Links that weaken, yield and break: their forces, stresses and energies, and how near they are to breaking.

As in `linked_sweep`, with the weight w of each link (1 while it holds, falling to 0 while it is released), what is left of its
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
import numpy.typing as npt

from ..support.float_arrays import FloatArray
from ..support.jit import internal, internal_inlined, jit
from .breaking.dispatch import failure
from .link_histories import bond_strains, opposite_slot, pair_strains, strain_rates
from .material_mixture import both_shear, lame_of, mean_shear, shear_of, volumetric_stress
from .pair import mirrored_slots, orient, turned
from .responses.return_mapping import respond
from .strain_division import bond_dilations, division_energy
from .stress import equivalent_stress, virial
from .volumetric_strain import bond_dilation, condensation


class Law(NamedTuple):
    """The response and the breaking criterion of links, as numbers for kernels.

    Attributes:
        elastic: whether they have no history.
        response: see `responses.Response.constants`, shape (3,); of several materials a row for each law, shape (laws, 3).
        criterion: number of the criterion.
        strength: see `breaking.Criterion.constants`, shape (3,), or (laws, 3).
        rows: the two laws of each link of several materials, the weaker of which breaks it, and the first of which it follows
            when it yields, shape (n, slots / 2, 2); else (0,).
        factors: of the strength of each link, shape (n, slots / 2).
        release: over how many internal steps a broken link is released, and a new one made.
        linking: see `relinking.Relinking.constants`, shape (2,).
        linking_ticks: after how many internal steps it is looked which pairs are linked again; 0 for never.
    """

    elastic: bool
    response: FloatArray
    criterion: int
    strength: FloatArray
    rows: npt.NDArray[np.int64]
    factors: FloatArray
    release: int
    linking: FloatArray
    linking_ticks: int


@internal_inlined
def bond_tractions(body, bonds, displacement, half, dilation, i, slot):
    """Return the tractions along and across a link, and cos - 1 and sin of its rotation."""
    eps, gamma, less, sine = bond_strains(body, bonds, displacement, half, i, slot)
    moduli, j, left = bonds.mixture.moduli, body.neighbours[i, slot], 1.0 + bonds.stiffness[i, slot]
    along, across = 2.0 * mean_shear(moduli, i, j, body.shear) * left, 2.0 * both_shear(moduli, i, j, body.shear) * left
    eps, gamma = eps - bonds.plastic[i, slot, 0], gamma - bonds.plastic[i, slot, 1]
    pressing = volumetric_stress(moduli, bonds.mixture.division, i, j, slot, body.lame, dilation[i], dilation[j])
    return along * eps + pressing, across * gamma, less, sine


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
    eps, gamma = eps - bonds.plastic[i, slot, 0], gamma - bonds.plastic[i, slot, 1]
    volume = body.face[body.kind[i], slot] * body.diameter
    return _elastic_energy(
        bonds.mixture.moduli, body, volume, i, body.neighbours[i, slot], 1.0 + bonds.stiffness[i, slot], eps, gamma
    )


@internal_inlined
def _elastic_energy(moduli, body, volume, i, j, left, eps, gamma):
    if moduli.ndim == 2:
        along, across = mean_shear(moduli, i, j, 0.0), both_shear(moduli, i, j, 0.0)
        return volume * left * (along * (eps * eps) + across * (gamma * gamma))
    return volume * (body.shear * left) * (eps * eps + gamma * gamma)


@internal
def volume_energy(body, bonds, displacement, half, i):
    """Return the energy of the volumetric strain of an automaton [J]."""
    theta = bond_dilation(body, bonds, displacement, half, i)
    lame = lame_of(bonds.mixture.moduli, i, body.lame)
    return 0.5 * body.volume[body.kind[i]] * lame * condensation(body, bonds, i) * theta * theta


@jit
def bond_energy(body, bonds, displacement, half):
    """Return the energy that is stored in all links and volumes [J]."""
    slots, moduli = body.directions.shape[0], bonds.mixture.moduli
    total = 0.0
    for i in range(body.kind.size):
        total += volume_energy(body, bonds, displacement, half, i)
        for slot in range(slots // 2):
            if bonds.weight[i, slot] > 0.0:
                total += bonds.weight[i, slot] * pair_energy(body, bonds, displacement, half, i, slot)
                total -= bonds.weight[i, slot] * division_energy(moduli, body, bonds, displacement, half, i, slot)
    return total


@internal
def update_bonds(body, bonds, law, motion, half, dilation, stress, time, mark_out):
    """Let links that hold yield, and mark those that have to break.

    Args:
        body: a `Body`.
        bonds: `Bonds`, updated in place.
        law: a `Law`.
        motion: a `Motion`; its velocities are those since the forces were computed last.
        half: see `pair.orient`, shape (n, 2).
        dilation: see `bond_dilations`, shape (n,).
        stress: see `bond_stresses`, shape (n, 3) [Pa].
        time: since the forces were computed last [s].
        mark_out: the value that decided of each link that has to break, 0 of the others, shape (n, slots / 2).

    Returns:
        How many have to break, and the energy that flow and degradation took [J].
    """
    slots, marked, lost, displacement = body.directions.shape[0], 0, 0.0, motion.displacement
    for i in range(body.kind.size):
        for slot in range(slots // 2):
            mark_out[i, slot] = 0.0
            j = body.neighbours[i, slot]
            if j == i or bonds.weight[i, slot] != 1.0:
                continue
            if not law.elastic:
                equivalent = mean_equivalent_stress(body, bonds, dilation, stress, i, slot)
                onset, _, _ = _response_of(law.response, law.rows, i, slot)
                if equivalent > onset:
                    lost += _respond(body, bonds, law, motion, half, dilation, i, slot, equivalent, time)
            if law.criterion:
                eps, gamma, _, _ = bond_strains(body, bonds, displacement, half, i, slot)
                normal, tangential, equivalent, mean = pair_stress(body, bonds, displacement, half, dilation, stress, i, slot)
                value, limit, _ = _failure_of(law.strength, law, eps, gamma, normal, tangential, equivalent, mean, i, slot)
                if value >= limit:
                    mark_out[i, slot] = value
                    marked += 1
    return marked, lost


@internal_inlined
def _response_of(response, rows, i, slot):
    """Return onset, slope and part of the response of a link; links between two materials have no onset."""
    if response.ndim == 2:
        row = rows[i, slot, 0]
        onset = response[row, 0] if row == rows[i, slot, 1] else np.inf
        return onset, response[row, 1], response[row, 2]
    return response[0], response[1], response[2]


@internal_inlined
def _failure_of(strength, law, eps, gamma, normal, tangential, equivalent, mean, i, slot):
    """Return what decides whether a link breaks, its limit, and the number of the cause; see `breaking.dispatch.failure`."""
    code, factor = law.criterion, law.factors[i, slot]
    if strength.ndim == 2:
        one, other = strength[law.rows[i, slot, 0]], strength[law.rows[i, slot, 1]]
        value, limit, cause = failure(code, one, eps, gamma, normal, tangential, equivalent, mean, factor)
        value_2, limit_2, cause_2 = failure(code, other, eps, gamma, normal, tangential, equivalent, mean, factor)
        if value_2 / limit_2 > value / limit:
            return value_2, limit_2, cause_2
        return value, limit, cause
    return failure(code, strength, eps, gamma, normal, tangential, equivalent, mean, factor)


@internal_inlined
def _respond(body, bonds, law, motion, half, dilation, i, slot, equivalent, time):
    """Write the history of a link that yields, at both of its ends; return the energy that this takes [J].

    It is the work of the kicks before and after the drift less the change of the energy of the link, so that the balance of a
    step closes: with its elastic strains u before the drift and w after it, and stiffnesses g and h,

        S r G ((g - h) u.w + (g u + h w).de_p),

    the area between the lines of loading and unloading, and the mean stress times the strain that has flowed.
    """
    displacement = motion.displacement
    eps, gamma, _, _ = bond_strains(body, bonds, displacement, half, i, slot)
    j, back = body.neighbours[i, slot], opposite_slot(body.directions.shape[0], slot)
    theta, shear = 0.5 * (dilation[i] + dilation[j]), shear_of(bonds.mixture.moduli, i, body.shear)
    onset, hardening, degradation = _response_of(law.response, law.rows, i, slot)
    tried, sheared, before = eps - bonds.plastic[i, slot, 0], gamma - bonds.plastic[i, slot, 1], 1.0 + bonds.stiffness[i, slot]
    eps_p, gamma_p, stiffness, inelastic = respond(
        equivalent, eps, gamma, theta, bonds.plastic[i, slot, 0], bonds.plastic[i, slot, 1], before,
        bonds.inelastic[i, slot], shear, onset, hardening, degradation,
    )  # fmt: skip
    more, across = eps_p - bonds.plastic[i, slot, 0], gamma_p - bonds.plastic[i, slot, 1]
    stretching, shearing = strain_rates(body, motion, half, i, slot)
    ux, uy, wx, wy = tried - time * stretching, sheared - time * shearing, eps - eps_p, gamma - gamma_p
    bonds.plastic[i, slot, 0], bonds.plastic[i, slot, 1] = eps_p, gamma_p
    bonds.plastic[j, back, 0], bonds.plastic[j, back, 1] = eps_p, gamma_p
    bonds.stiffness[i, slot], bonds.stiffness[j, back] = stiffness - 1.0, stiffness - 1.0
    bonds.inelastic[i, slot], bonds.inelastic[j, back] = inelastic, inelastic
    flow = (before * ux + stiffness * wx) * more + (before * uy + stiffness * wy) * across
    return body.face[body.kind[i], slot] * body.diameter * shear * ((before - stiffness) * (ux * wx + uy * wy) + flow)


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
    left, j = 1.0 + bonds.stiffness[i, slot], body.neighbours[i, slot]
    return _mean_pressure(bonds.mixture.moduli, body, i, j, left, dilation[i], dilation[j])


@internal_inlined
def _mean_pressure(moduli, body, i, j, left, theta_i, theta_j):
    if moduli.ndim == 2:
        one, other = moduli[i, 1] + 2.0 * moduli[i, 0] * left / 3.0, moduli[j, 1] + 2.0 * moduli[j, 0] * left / 3.0
        return 0.5 * (one * theta_i + other * theta_j)
    return (body.lame + 2.0 * body.shear * left / 3.0) * (0.5 * (theta_i + theta_j))


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
    return _failure_of(law.strength, law, eps, gamma, normal, tangential, equivalent, mean, i, slot)


@jit
def criterion_ratios(body, bonds, law, displacement, half, dilation, stress, pairs, ratio_out, cause_out):
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
        cause_out: the numbers of what decides, shape (m,).
    """
    for row in range(pairs.shape[0]):
        i, slot, ratio_out[row], cause_out[row] = pairs[row, 0], pairs[row, 2], 0.0, 0
        if bonds.weight[i, slot] == 1.0:
            value, limit, cause_out[row] = bond_failure(body, bonds, law, displacement, half, dilation, stress, i, slot)
            ratio_out[row] = max(value / limit, 0.0)
