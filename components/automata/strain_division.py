"""Division of the strain of a link between automata of two materials between its halves.

A link of one material strains both its halves alike. Between i and j of two materials the half of i is strained by eps + d,
that of j by eps - d, and d makes the energy small; with a of free and released faces, see `inelastic_links`,

    d = -q / D,        q = (G_i - G_j) eps + (lambda_i theta_i - lambda_j theta_j) / 2
    D = G_i + G_j + (1/2) sum over both of |lambda| C / (1 + a),      C = sum of the shares c of its links to other materials
    U = sum over pairs w S r ((G_i + G_j) eps^2 / 2 + G_ij gamma^2 - q^2 / 2 D) + sum over automata V lambda (1 + a) theta^2 / 2

theta without d, and G_ij = 2 G_i G_j / (G_i + G_j), two halves in series. The forces are the derivatives of this energy:

    theta'_i = theta_i + sum_j c w d / (1 + a),      f_t = w S 2 G_ij gamma
    f_n = w S ((G_i + G_j) eps + (G_i - G_j) d + (lambda_i theta'_i + lambda_j theta'_j) / 2)

With the d that makes U least the tractions of both halves are the same. Where the links of an automaton to other materials are
strained alike, as in layers along the rows of a square packing, this d is that one, and the moduli of the layers are exact for
every strain. Elsewhere D is at least what the whole system has (the sum of the moduli of a row of it), so U lies above its
least value: never negative, a little too stiff. D belongs to links that all hold. Solving the whole system would need all
links of an interface at once, in every step.
"""

from __future__ import annotations

from ..support.jit import internal
from .link_histories import bond_strains
from .pair import mirrored_slots
from .volumetric_strain import bond_dilation, condensation, uniform_dilations


@internal
def bond_dilations(body, bonds, displacement, half, dilation_out, begin, end):
    """Write the volumetric strains of automata from `begin` up to `end`, of several materials those of all.

    Args:
        body: a `Body`.
        bonds: `Bonds`; of several materials the division of strains is written.
        displacement: shape (n, 2) [m].
        half: see `pair.orient`, shape (n, 2).
        dilation_out: shape (n,).
        begin: first automaton.
        end: after the last one.
    """
    uniform_dilations(body, bonds, displacement, half, dilation_out, begin, end)
    _divide_strains(bonds.mixture.moduli, body, bonds, displacement, half, dilation_out)


@internal
def _divide_strains(moduli, body, bonds, displacement, half, dilation):
    """Divide the strains of links between two materials, and give the volumetric strains what that changes."""
    if moduli.ndim == 2:
        slots, compliance, division = body.directions.shape[0], bonds.mixture.compliance, bonds.mixture.division
        for i in range(body.kind.size):
            for slot in range(slots):
                division[i, slot] = 0.0
                if compliance[i, slot] > 0.0:
                    stress = _driving_stress(
                        moduli, body, bonds, displacement, half, i, slot, dilation[i], dilation[body.neighbours[i, slot]]
                    )
                    division[i, slot] = -compliance[i, slot] * stress
        for i in range(body.kind.size):
            k, more = body.kind[i], 0.0
            for group in range(slots // 2 - 1, -1, -1):
                pair = 0.0
                for slot in mirrored_slots(slots, group):
                    pair += body.share[k, slot] * bonds.weight[i, slot] * division[i, slot]
                more += pair
            if more != 0.0:
                dilation[i] += more / condensation(body, bonds, i)


@internal
def _driving_stress(moduli, body, bonds, displacement, half, i, slot, theta, other_theta):
    """Return q of a link: half of what the tractions of its halves differ where both are strained alike [Pa]."""
    j = body.neighbours[i, slot]
    eps, _, _, _ = bond_strains(body, bonds, displacement, half, i, slot)
    return (moduli[i, 0] - moduli[j, 0]) * eps + 0.5 * (moduli[i, 1] * theta - moduli[j, 1] * other_theta)


@internal
def division_energy(moduli, body, bonds, displacement, half, i, slot):
    """Return by how much the division of its strain lowers the energy of a link, for a weight of 1 [J]."""
    if moduli.ndim == 2:
        compliance = bonds.mixture.compliance[i, slot]
        if compliance == 0.0:
            return 0.0
        theta = bond_dilation(body, bonds, displacement, half, i)
        other = bond_dilation(body, bonds, displacement, half, body.neighbours[i, slot])
        stress = _driving_stress(moduli, body, bonds, displacement, half, i, slot, theta, other)
        return 0.5 * body.face[body.kind[i], slot] * body.diameter * compliance * stress * stress
    return 0.0


@internal
def divisions_around(moduli, body, bonds, displacement, half, i, j):
    """Return by how much the divisions of strains lower the energies of all links of two neighbours [J]."""
    total = 0.0
    if moduli.ndim == 2:
        for slot in range(body.directions.shape[0]):
            total += bonds.weight[i, slot] * division_energy(moduli, body, bonds, displacement, half, i, slot)
            if body.neighbours[j, slot] != i:
                total += bonds.weight[j, slot] * division_energy(moduli, body, bonds, displacement, half, j, slot)
    return total
