"""Forces, energies and flow of tied faces and of rows beside a zigzag whose links may yield and break; see `zigzag_strains`.

    f_n = w S (2 G g (eps - eps_p) + lambda theta_i),      f_t = w S 2 G g (gamma - gamma_p)
    U = w S (D / 2) G g ((eps - eps_p)^2 + (gamma - gamma_p)^2)

of a face, and w s (D / 4) (lambda_j theta_j - lambda_i theta_i) across a pair of a row, per thickness: the derivatives of the
energies of links and volumes. `ties` is None without any, which is known when these are compiled.
"""

from __future__ import annotations

from ..support.jit import internal, internal_inlined
from .material_mixture import lame_of, shear_of
from .pair import turned
from .responses.return_mapping import respond
from .stress import equivalent_stress, virial
from .zigzag_faces import face_strain_rates, face_strains, push, row_moment, row_strains, whole_face
from .zigzag_strains import face_weight, tied_strains


@internal_inlined
def _face_tractions(body, bonds, ties, displacement, half, dilation, row):
    """Return the tractions along and across a tied face of weight 1, its strains, and cos - 1 and sin of its rotation."""
    i, slot = ties.automata[row], ties.slots[row]
    eps, gamma, less, sine = face_strains(body, ties, displacement, half, row)
    strain, shear_strain = tied_strains(body, bonds, ties, displacement, half, row)
    moduli = bonds.mixture.moduli
    twice = 2.0 * shear_of(moduli, i, body.shear) * (1.0 + bonds.stiffness[i, slot])
    along, across = twice * (strain - bonds.plastic[i, slot, 0]), twice * (shear_strain - bonds.plastic[i, slot, 1])
    return along + lame_of(moduli, i, body.lame) * dilation[i], across, eps, gamma, less, sine


@internal
def add_tied_forces(ties, body, bonds, displacement, half, dilation, force, torque):
    """Add the forces and torques of tied faces and of rows.

    Args:
        ties: `Ties`, or None.
        body: a `Body`.
        bonds: `Bonds`.
        displacement: shape (n, 2) [m].
        half: see `pair.orient`, shape (n, 2).
        dilation: see `bond_dilations`, shape (n,).
        force: shape (n, 2), updated in place [N].
        torque: shape (n,), updated in place [N m].
    """
    if ties is not None:
        for row in range(ties.automata.size):
            i, slot = ties.automata[row], ties.slots[row]
            normal, tangential, eps, gamma, less, sine = _face_tractions(body, bonds, ties, displacement, half, dilation, row)
            area, _ = whole_face(body, body.kind[i])
            area *= face_weight(bonds, ties, row)
            fn, ft = area * normal, area * tangential
            fx, fy = turned(fn, ft, body.directions[slot, 0], body.directions[slot, 1], less, sine)
            push(force, i, ties.ends[row, 0], 0.5 * fx, 0.5 * fy)
            push(force, i, ties.ends[row, 1], 0.5 * fx, 0.5 * fy)
            torque[i] += (0.5 * body.diameter) * ((1.0 + eps) * ft - gamma * fn)
        _add_row_forces(body, bonds, ties, displacement, half, dilation, force, torque)


@internal
def _add_row_forces(body, bonds, ties, displacement, half, dilation, force, torque):
    """Add the forces and torques of rows, of both sides of an automaton together; arguments as for `add_tied_forces`."""
    for place in range(ties.touched.size):
        i, right, left = ties.touched[place], ties.pairs[place, 0], ties.pairs[place, 1]
        fx, fy, turning, bx, by, back = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if right >= 0:
            fx, fy, turning = _row_force(body, bonds, ties, displacement, half, dilation, right)
        if left >= 0:
            bx, by, back = _row_force(body, bonds, ties, displacement, half, dilation, left)
        force[i, 0] += fx - bx
        force[i, 1] += fy - by
        torque[i] += turning + back


@internal
def _row_force(body, bonds, ties, displacement, half, dilation, row):
    """Return the force of a pair of a row on its left automaton, x and y, and its torque on both."""
    i, j, moduli = ties.rows[row, 0], ties.rows[row, 1], bonds.mixture.moduli
    eps, _, less, sine = row_strains(body, ties, displacement, half, row)
    pressing = lame_of(moduli, j, body.lame) * dilation[j] - lame_of(moduli, i, body.lame) * dilation[i]
    across = bonds.weight[i, 0] * (row_moment(body, ties, row) / body.diameter) * pressing
    fx, fy = turned(0.0, across, 1.0, 0.0, less, sine)
    return fx, fy, (0.5 * body.diameter) * (1.0 + eps) * across


@internal
def add_face_stresses(ties, body, bonds, displacement, half, dilation, stress):
    """Add what the tractions on tied faces are of the stresses of their automata, shape (n, 3) [Pa]; as above."""
    if ties is not None:
        for row in range(ties.automata.size):
            i, slot = ties.automata[row], ties.slots[row]
            normal, tangential, _, _, less, sine = _face_tractions(body, bonds, ties, displacement, half, dilation, row)
            _, share = whole_face(body, body.kind[i])
            nx, ny, part = body.directions[slot, 0], body.directions[slot, 1], share * face_weight(bonds, ties, row)
            xx, yy, xy = virial(normal, tangential, nx, ny, less, sine)
            stress[i, 0] += part * xx
            stress[i, 1] += part * yy
            stress[i, 2] += part * xy


@internal_inlined
def _face_energy(body, bonds, ties, displacement, half, row):
    """Return the energy of a tied face for a weight of 1, without that of the volumetric strain [J]."""
    i, slot = ties.automata[row], ties.slots[row]
    eps, gamma = tied_strains(body, bonds, ties, displacement, half, row)
    eps, gamma = eps - bonds.plastic[i, slot, 0], gamma - bonds.plastic[i, slot, 1]
    area, _ = whole_face(body, body.kind[i])
    shear = shear_of(bonds.mixture.moduli, i, body.shear) * (1.0 + bonds.stiffness[i, slot])
    return 0.5 * body.diameter * area * shear * (eps * eps + gamma * gamma)


@internal
def faces_energy(ties, body, bonds, displacement, half):
    """Return the energy of all tied faces, without that of the volumetric strains [J]."""
    total = 0.0
    if ties is not None:
        for row in range(ties.automata.size):
            total += face_weight(bonds, ties, row) * _face_energy(body, bonds, ties, displacement, half, row)
    return total


@internal
def faces_energy_of(ties, body, bonds, displacement, half, i):
    """Return the energy of the tied faces of an automaton, without that of its volumetric strain [J]."""
    total = 0.0
    if ties is not None:
        if ties.place[i] >= 0:
            for side in range(2):
                row = ties.faces[ties.place[i], side]
                if row >= 0:
                    total += face_weight(bonds, ties, row) * _face_energy(body, bonds, ties, displacement, half, row)
    return total


@internal
def update_faces(ties, body, bonds, law, motion, half, dilation, stress, time):
    """Let tied faces that hold yield, by the stress of their automata; return the energy that this takes [J].

    Args:
        ties: `Ties`, or None.
        body: a `Body`.
        bonds: `Bonds`, updated in place.
        law: a `Law` that is not elastic.
        motion: a `Motion`; its velocities are those since the forces were computed last.
        half: see `pair.orient`, shape (n, 2).
        dilation: see `bond_dilations`, shape (n,).
        stress: see `bond_stresses`, shape (n, 3) [Pa].
        time: since the forces were computed last [s].
    """
    lost = 0.0
    if ties is not None:
        for row in range(ties.automata.size):
            if face_weight(bonds, ties, row) == 1.0:
                lost += _update_face(body, bonds, ties, law, motion, half, dilation, stress, row, time)
    return lost


@internal
def _update_face(body, bonds, ties, law, motion, half, dilation, stress, row, time):
    """Let a tied face yield; return the energy that this takes [J], as `inelastic_links` counts that of a link."""
    i, slot, moduli = ties.automata[row], ties.slots[row], bonds.mixture.moduli
    left, shear = 1.0 + bonds.stiffness[i, slot], shear_of(moduli, i, body.shear)
    mean = (lame_of(moduli, i, body.lame) + 2.0 * shear * left / 3.0) * dilation[i]
    xx, yy, xy = stress[i, 0], stress[i, 1], stress[i, 2]
    equivalent = equivalent_stress(xx, yy, 3.0 * mean - xx - yy, xy)
    onset, hardening, degradation = _response_of(law.response, ties.materials[row])
    if not equivalent > onset:
        return 0.0
    eps, gamma = tied_strains(body, bonds, ties, motion.displacement, half, row)
    old_eps, old_gamma = bonds.plastic[i, slot, 0], bonds.plastic[i, slot, 1]
    eps_p, gamma_p, stiffness, inelastic = respond(
        equivalent, eps, gamma, dilation[i], old_eps, old_gamma, left, bonds.inelastic[i, slot], shear, onset, hardening,
        degradation,
    )  # fmt: skip
    bonds.plastic[i, slot, 0], bonds.plastic[i, slot, 1] = eps_p, gamma_p
    bonds.stiffness[i, slot], bonds.inelastic[i, slot] = stiffness - 1.0, inelastic
    stretching, shearing = face_strain_rates(body, ties, motion, half, row)
    ux, uy = eps - old_eps - time * stretching, gamma - old_gamma - time * shearing
    wx, wy, more, across = eps - eps_p, gamma - gamma_p, eps_p - old_eps, gamma_p - old_gamma
    area, _ = whole_face(body, body.kind[i])
    flow = (left * ux + stiffness * wx) * more + (left * uy + stiffness * wy) * across
    return 0.5 * body.diameter * area * shear * ((left - stiffness) * (ux * wx + uy * wy) + flow)


@internal_inlined
def _response_of(response, material):
    """Return onset, slope and part of the response of a material."""
    if response.ndim == 2:
        return response[material, 0], response[material, 1], response[material, 2]
    return response[0], response[1], response[2]
