"""Links that weaken, yield and break: strains, tractions, forces, and the ratio to their breaking limit.

Symbols as in `linked_specimen`. Each link has a weight w (1 if intact, decreasing to 0 during its release), a remaining
fraction g of its stiffness, and plastic strains eps_p and gamma_p; a accounts for free and released faces:

    theta_i = sum_j c (w eps + (1 - w) eps_p) / (1 + a),      a = (c* + sum_j (1 - w) c / g) lambda / 2 G
    f_n = w S (2 G g (eps - eps_p) + (lambda_i theta_i + lambda_j theta_j) / 2),      f_t = w S 2 G g (gamma - gamma_p)
    U = sum over pairs w S r G g ((eps - eps_p)^2 + (gamma - gamma_p)^2) + sum over automata (1/2) V lambda (1 + a) theta^2

A released link is a free face without traction: its strain solves 2 G g (eps - eps_p) + lambda theta = 0. It is eliminated as
at other free faces, but relative to the plastic strain and with the remaining stiffness. The energy freed by a release is
therefore never negative: dU/dw = V c G g (eps - eps_p + lambda theta / 2 G g)^2 for each of the two automata.

The strain of a link between two materials is divided between its halves. The half of i is strained by eps + d, the half of j by
eps - d, and d approximately minimises the energy:

    d = -q / D,        q = (G_i - G_j) eps + (lambda_i theta_i - lambda_j theta_j) / 2
    D = G_i + G_j + (1/2) sum over both of |lambda| C / (1 + a),      C = sum of the shares c of its links to other materials
    U = sum over pairs w S r ((G_i + G_j) eps^2 / 2 + G_ij gamma^2 - q^2 / 2 D) + sum over automata V lambda (1 + a) theta^2 / 2
    theta'_i = theta_i + sum_j c w d / (1 + a),      f_t = w S 2 G_ij gamma,      G_ij = 2 G_i G_j / (G_i + G_j)
    f_n = w S ((G_i + G_j) eps + (G_i - G_j) d + (lambda_i theta'_i + lambda_j theta'_j) / 2)

This d is exact if the links of an automaton to other materials have equal strains, as in layers along the rows of a square
packing. Otherwise D is an upper bound of the value for the whole system, and U lies above its minimum: never negative, a little
too stiff. D assumes that all links are intact. Solving the whole system would need all links of an interface in every step.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..support.dispatch import dispatch_by_class
from ..support.float_arrays import FloatArray
from ..support.jit import internal, internal_inlined, jit
from .lattice import (
    COUNTED,
    DEVIATOR,
    DILATION,
    DIVISION,
    EPS,
    EX,
    EY,
    FACE,
    FIRST_SHARE,
    FIRST_TERM,
    GAMMA,
    LAME,
    MISSING,
    NORMAL,
    PRESSURE,
    SECOND_SHARE,
    SECOND_TERM,
    SHEAR,
    SPIN,
    STIFFENING,
    STRESS_XX,
    STRESS_XY,
    STRESS_YY,
    TANGENTIAL,
    TURNING,
    VIRIAL_XX,
    VIRIAL_XY,
    VIRIAL_YY,
    VX,
    VY,
    Body,
    copy_to_ghosts,
    update_ghosts,
)
from .laws.criterion import LinkStress, failure_measure
from .laws.responses import ElasticResponses, History, LinkResponses, link_response_constants, updated_history
from .pair_strains import equivalent_stress, sum_by_shares, sum_link_forces, sum_over_links, virial_stress, write_link_strains

# Rows of the moduli of links: G_i + G_j, and 2 G_ij.
ALONG, ACROSS = 0, 1


class Histories(NamedTuple):
    """Histories of links, each of shape (directions, m).

    Attributes:
        weight: 1 for an intact link, less during its release, 0 afterwards and without a link.
        plastic_eps: plastic strain along the link.
        plastic_gamma: plastic shear strain of the link.
        stiffness: remaining fraction of the shear modulus, minus 1.
        inelastic: accumulated inelastic strain q, see `laws.responses`.
        origin_eps: strain along the link from which its strain counts; nonzero only for a pair that was linked again.
        origin_gamma: the same for the shear strain.
    """

    weight: FloatArray
    plastic_eps: FloatArray
    plastic_gamma: FloatArray
    stiffness: FloatArray
    inelastic: FloatArray
    origin_eps: FloatArray
    origin_gamma: FloatArray


class UniformModuli(NamedTuple):
    """Moduli of links if there is one material: G_i + G_j and 2 G_ij, shape (2, directions, m) [Pa]."""

    moduli: FloatArray


class MixedModuli(NamedTuple):
    """Moduli of links within and between several materials.

    Attributes:
        moduli: G_i + G_j and 2 G_ij, shape (2, directions, m) [Pa].
        compliance: 1 / D for links between two materials, see above; 0 for the others, shape (directions, m) [1/Pa].
    """

    moduli: FloatArray
    compliance: FloatArray


class LinkLaws(NamedTuple):
    """The laws of links.

    Attributes:
        response: `LinkResponses`, or `ElasticResponses`.
        criterion: constants of a criterion, or `laws.criterion.WeakerLaw`.
        factors: factor of the strength of each link, shape (directions, m).
        release: number of internal steps in which a broken link is released, or a new one formed.
        linking: constants of the condition under which pairs are linked again, see `relinking.Relinking.constants`.
        linking_ticks: number of internal steps between searches for pairs to link again; 0 for never.
    """

    response: Any
    criterion: Any
    factors: FloatArray
    release: int
    linking: tuple[float, float]
    linking_ticks: int


class Medium(NamedTuple):
    """A specimen with histories, for kernels.

    Attributes:
        body: a `lattice.Body`.
        histories: `Histories`.
        link_moduli: `UniformModuli`, or a `MixedModuli`.
        law: a `LinkLaws`.
        contact_constants: a `contacts.ContactConstants`.
    """

    body: Body
    histories: Histories
    link_moduli: Any
    law: LinkLaws
    contact_constants: Any


def make_link_moduli(body: Body, has_several_materials: bool) -> UniformModuli | MixedModuli:
    """Return the moduli of the links of a body: `UniformModuli`, or `MixedModuli` if it has several materials."""
    moduli, compliance = np.ones((2, *body.links.shape[1:])), np.zeros(body.links.shape[1:])
    shear, lame, (face, *shares) = body.cells[SHEAR], body.cells[LAME], body.links
    stiffening = 1.0 + body.cells[MISSING] * lame / (2.0 * shear)
    coupling = np.zeros(len(shear))
    differing = []
    for q, o in enumerate(body.layout.offset.tolist()):
        i, j = slice(0, len(coupling) - o), slice(o, None)
        one, other = shear[i], shear[j]
        moduli[ALONG, q, i] = one + other
        moduli[ACROSS, q, i] = np.where(one == other, 2.0 * one, 4.0 * (one * other) / (one + other))
        differs = ((one != other) | (lame[i] != lame[j])) & (face[q, i] > 0.0)
        differing.append(differs)
        for end, share in zip((i, j), shares, strict=True):
            coupling[end] += 0.5 * np.abs(lame[end]) * share[q, i] * differs / stiffening[end]
    # A ghost has the links of the automaton that it copies.
    copy_to_ghosts(body.layout, coupling)
    for q, o in enumerate(body.layout.offset.tolist()):
        i, j = slice(0, len(coupling) - o), slice(o, None)
        stiffness = moduli[ALONG, q, i] + (coupling[i] + coupling[j])
        compliance[q, i] = np.where(differing[q], 1.0 / stiffness, 0.0)
    return MixedModuli(moduli, compliance) if has_several_materials else UniformModuli(moduli)


# -- strains and tractions --------------------------------------------------------------------------------------------------


@internal
def write_medium_strains(medium, motion, scratch):
    """Write the strains of all links and the volumetric strains, for the present histories."""
    body, h, links, cells = medium.body, medium.histories, scratch.links, scratch.cells
    write_link_strains(body, motion, scratch)
    # 1 / (1 + a) is the factor by which free and released faces reduce the volume strains.
    for q in range(links.shape[1]):
        for p in range(links.shape[2]):
            links[COUNTED, q, p] = (1.0 - h.weight[q, p]) / (1.0 + h.stiffness[q, p])
    sum_by_shares(body, links[COUNTED], links, cells[STIFFENING])
    for p in range(cells.shape[1]):
        free = body.cells[MISSING, p] + cells[STIFFENING, p]
        cells[STIFFENING, p] = 1.0 / (1.0 + free * body.cells[LAME, p] / (2.0 * body.cells[SHEAR, p]))
    # A released link keeps its plastic strain.
    for q in range(links.shape[1]):
        for p in range(links.shape[2]):
            held = h.weight[q, p] * (links[EPS, q, p] - h.origin_eps[q, p])
            links[COUNTED, q, p] = held + (1.0 - h.weight[q, p]) * h.plastic_eps[q, p]
    sum_by_shares(body, links[COUNTED], links, cells[DILATION])
    for p in range(cells.shape[1]):
        cells[DILATION, p] *= cells[STIFFENING, p]
    update_ghosts(body.layout.ghosts, cells[DILATION])
    divide_strains(medium.link_moduli, medium, scratch)
    for p in range(cells.shape[1]):
        cells[PRESSURE, p] = cells[DILATION, p] * body.cells[LAME, p]
        cells[DEVIATOR, p] = cells[DILATION, p] * body.cells[SHEAR, p]


@dispatch_by_class
def divide_strains(link_moduli, medium, scratch):
    """Divide the strain of each link between two materials into those of its halves, and correct the volume strains."""


@divide_strains.register(UniformModuli)
def _divide_no_strains(link_moduli, medium, scratch):
    return None


@divide_strains.register(MixedModuli)
def _divide_strains(link_moduli, medium, scratch):
    body, links, theta, weight = medium.body, scratch.links, scratch.cells[DILATION], medium.histories.weight
    shear, lame, correction = body.cells[SHEAR], body.cells[LAME], scratch.cells[PRESSURE]
    for q in range(links.shape[1]):
        o = body.layout.offset[q]
        for p in range(theta.size - o):
            eps = links[EPS, q, p] - medium.histories.origin_eps[q, p]
            pressing = 0.5 * (lame[p] * theta[p] - lame[p + o] * theta[p + o])
            division = -link_moduli.compliance[q, p] * ((shear[p] - shear[p + o]) * eps + pressing)
            links[DIVISION, q, p] = division
            links[FIRST_TERM, q, p] = body.links[FIRST_SHARE, q, p] * division * weight[q, p]
            links[SECOND_TERM, q, p] = body.links[SECOND_SHARE, q, p] * division * weight[q, p]
    # The half at the beginning of a link is strained more, the half at its end less.
    sum_over_links(body.layout, links[FIRST_TERM], links[SECOND_TERM], -1.0, correction)
    for p in range(theta.size):
        theta[p] += correction[p] * scratch.cells[STIFFENING, p]
    update_ghosts(body.layout.ghosts, theta)


@internal
def write_medium_tractions(medium, scratch):
    """Write the tractions of all links for the present strains."""
    h, moduli, links, cells = medium.histories, medium.link_moduli.moduli, scratch.links, scratch.cells
    for q in range(links.shape[1]):
        pressure_j = cells[PRESSURE, medium.body.layout.offset[q] :]
        for p in range(pressure_j.size):
            left = 1.0 + h.stiffness[q, p]
            eps = (links[EPS, q, p] - h.origin_eps[q, p]) - h.plastic_eps[q, p]
            gamma = (links[GAMMA, q, p] - h.origin_gamma[q, p]) - h.plastic_gamma[q, p]
            links[NORMAL, q, p] = moduli[ALONG, q, p] * left * eps + 0.5 * (cells[PRESSURE, p] + pressure_j[p])
            links[TANGENTIAL, q, p] = moduli[ACROSS, q, p] * left * gamma
    add_division_tractions(medium.link_moduli, medium.body, links)


@dispatch_by_class
def add_division_tractions(link_moduli, body, links):
    """Add to the tractions of links between two materials the terms of d; the strains of their halves are eps + d, eps - d."""


@add_division_tractions.register(UniformModuli)
def _add_no_tractions(link_moduli, body, links):
    return None


@add_division_tractions.register(MixedModuli)
def _add_division_tractions(link_moduli, body, links):
    for q in range(links.shape[1]):
        o = body.layout.offset[q]
        for p in range(links.shape[2] - o):
            links[NORMAL, q, p] += (body.cells[SHEAR, p] - body.cells[SHEAR, p + o]) * links[DIVISION, q, p]


@internal
def write_medium_stresses(medium, scratch):
    """Write the stresses of the automata from the tractions of their links."""
    links, weight = scratch.links, medium.histories.weight
    for q in range(links.shape[1]):
        for p in range(links.shape[2]):
            xx, yy, xy = virial_stress(links[NORMAL, q, p], links[TANGENTIAL, q, p], links[EX, q, p], links[EY, q, p])
            links[VIRIAL_XX, q, p], links[VIRIAL_YY, q, p] = weight[q, p] * xx, weight[q, p] * yy
            links[VIRIAL_XY, q, p] = weight[q, p] * xy
    for component in range(3):
        sum_by_shares(medium.body, links[VIRIAL_XX + component], links, scratch.cells[STRESS_XX + component])
        update_ghosts(medium.body.layout.ghosts, scratch.cells[STRESS_XX + component])


@internal
def write_medium_forces(medium, scratch):
    """Write the forces and torques of the links on the automata, from their tractions."""
    links, weight = scratch.links, medium.histories.weight
    for q in range(links.shape[1]):
        for p in range(links.shape[2]):
            area, ex, ey = medium.body.links[FACE, q, p] * weight[q, p], links[EX, q, p], links[EY, q, p]
            fn, ft = area * links[NORMAL, q, p], area * links[TANGENTIAL, q, p]
            links[FIRST_TERM, q, p], links[SECOND_TERM, q, p] = fn * ex - ft * ey, fn * ey + ft * ex
            links[TURNING, q, p] = (1.0 + links[EPS, q, p]) * ft - links[GAMMA, q, p] * fn
    sum_link_forces(medium.body, links, scratch.cells)


# -- breaking ---------------------------------------------------------------------------------------------------------------


class _EndFields(NamedTuple):
    """Fields of the automata where the links of one direction begin and end: lambda theta, G theta, and the stresses."""

    pressure: FloatArray
    deviator: FloatArray
    xx: FloatArray
    yy: FloatArray
    xy: FloatArray


@internal_inlined
def _end_fields(layout, cells, q):
    o = layout.offset[q]
    return _EndFields(
        cells[PRESSURE, o:], cells[DEVIATOR, o:], cells[STRESS_XX, o:], cells[STRESS_YY, o:], cells[STRESS_XY, o:]
    )


@internal_inlined
def _mean_stresses(cells, ends, stiffness, p):
    """Return the means of xx, yy, xy over both automata of a link, and K theta with the remaining fraction of G [Pa]."""
    xx, yy = 0.5 * (cells[STRESS_XX, p] + ends.xx[p]), 0.5 * (cells[STRESS_YY, p] + ends.yy[p])
    left = 1.0 + stiffness
    mean = 0.5 * ((cells[PRESSURE, p] + ends.pressure[p]) + (2.0 * left / 3.0) * (cells[DEVIATOR, p] + ends.deviator[p]))
    return xx, yy, 0.5 * (cells[STRESS_XY, p] + ends.xy[p]), mean


@internal_inlined
def _criterion_value(law, histories, scratch, ends, q, p):
    """Return the quantity of a link that its criterion tests, the limit, and the number of the cause of breaking.

    The normal stress along the face of the link is that of the mean stress of both automata.
    """
    links = scratch.links
    xx, yy, xy, mean = _mean_stresses(scratch.cells, ends, histories.stiffness[q, p], p)
    sx, sy = -links[EY, q, p], links[EX, q, p]
    side = (sx * sx * xx + sy * sy * yy) + 2.0 * (sx * sy) * xy
    normal, tangential = links[NORMAL, q, p], links[TANGENTIAL, q, p]
    equivalent = equivalent_stress(normal, side, 3.0 * mean - normal - side, tangential)
    eps, gamma = links[EPS, q, p] - histories.origin_eps[q, p], links[GAMMA, q, p] - histories.origin_gamma[q, p]
    number = q * links.shape[2] + p
    return failure_measure(
        law.criterion, LinkStress(eps, gamma, normal, tangential, equivalent, mean, law.factors[q, p], number)
    )


@internal
def count_failing_links(medium, scratch):
    """Return the number of links that meet their breaking criterion."""
    failing = 0
    for q in range(scratch.links.shape[1]):
        ends = _end_fields(medium.body.layout, scratch.cells, q)
        for p in range(ends.xx.size):
            value, limit, _ = _criterion_value(medium.law, medium.histories, scratch, ends, q, p)
            failing += 1 if (medium.histories.weight[q, p] == 1.0) & (value >= limit) else 0
    return failing


@jit
def write_criterion_values(medium, scratch, out):
    """Write for each link the quantity that its criterion tests, the limit, and the number of the cause, (3, directions, m)."""
    for q in range(scratch.links.shape[1]):
        ends = _end_fields(medium.body.layout, scratch.cells, q)
        for p in range(ends.xx.size):
            out[0, q, p], out[1, q, p], out[2, q, p] = _criterion_value(medium.law, medium.histories, scratch, ends, q, p)


# -- flow -------------------------------------------------------------------------------------------------------------------


@dispatch_by_class
def yield_links(response, medium, motion, scratch, time):
    """Let links yield at the present strains, and return the energy dissipated by flow and degradation [J].

    `time` is the time since the last force evaluation [s]; `motion` has the velocities since then. Histories of `medium` are
    updated.
    """


@yield_links.register(ElasticResponses)
def _yield_no_links(response, medium, motion, scratch, time):
    return 0.0


@yield_links.register(LinkResponses)
def _yield_links(response, medium, motion, scratch, time):
    lost, layout, histories, size = 0.0, medium.body.layout, medium.histories, scratch.links.shape[2]
    for q in range(layout.offset.size):
        ends = _end_fields(layout, scratch.cells, q)
        for p in range(ends.xx.size):
            law = link_response_constants(response, q * size + p)
            equivalent = _mean_equivalent_stress(scratch.cells, ends, histories.stiffness[q, p], p)
            if histories.weight[q, p] == 1.0 and equivalent > law.onset:
                taken = _yield_link(law, medium, motion, scratch, (q, p), equivalent, time)
                # A link that ends at an automaton with a ghost is stored twice.
                lost += taken if _is_automaton(layout.ghosts, p) else 0.0
    return lost


@internal
def _is_automaton(ghosts, p):
    """Return whether there is an automaton, not a ghost, at place p."""
    for row in range(ghosts.shape[0]):
        if ghosts[row, 0] == p:
            return False
    return True


@internal_inlined
def _mean_equivalent_stress(cells, ends, stiffness, p):
    """Return the von Mises stress of the mean of the stresses of both automata of a link [Pa].

    All pairs of an automaton then yield together. With their own tractions they would not: the decrease of the deviator by one
    pair would have to be balanced by the stress along z of the others.
    """
    xx, yy, xy, mean = _mean_stresses(cells, ends, stiffness, p)
    return equivalent_stress(xx, yy, 3.0 * mean - xx - yy, xy)


@internal
def _yield_link(law, medium, motion, scratch, link, equivalent, time):
    """Write the new history of a link that yields, and return the energy dissipated in it [J].

    It is the work of the kicks before and after the drift minus the change of the link's energy, so that the balance of a step
    closes. With the elastic strains u before and w after the drift, and the stiffnesses g and h, it is

        S r G ((g - h) u.w + (g u + h w).de_p),

    i.e. the area between the loading and unloading lines, and the mean stress times the plastic strain increment.
    """
    (q, p), body, h = link, medium.body, medium.histories
    j = p + body.layout.offset[q]
    eps, gamma = scratch.links[EPS, q, p] - h.origin_eps[q, p], scratch.links[GAMMA, q, p] - h.origin_gamma[q, p]
    theta, shear = 0.5 * (scratch.cells[DILATION, p] + scratch.cells[DILATION, j]), body.cells[SHEAR, p]
    before = History(h.plastic_eps[q, p], h.plastic_gamma[q, p], 1.0 + h.stiffness[q, p], h.inelastic[q, p])
    after = updated_history(law, before, equivalent, eps, gamma, theta, shear)
    along, across = strain_rates(body, motion, scratch, q, p)
    ux, uy = eps - before.eps - time * along, gamma - before.gamma - time * across
    wx, wy, g, k = eps - after.eps, gamma - after.gamma, before.stiffness, after.stiffness
    h.plastic_eps[q, p], h.plastic_gamma[q, p] = after.eps, after.gamma
    h.stiffness[q, p], h.inelastic[q, p] = k - 1.0, after.inelastic
    flow = (g * ux + k * wx) * (after.eps - before.eps) + (g * uy + k * wy) * (after.gamma - before.gamma)
    return body.links[FACE, q, p] * body.diameter * shear * ((g - k) * (ux * wx + uy * wy) + flow)


@internal_inlined
def strain_rates(body, motion, scratch, q, p):
    """Return the strain rates of a link, along and across it [1/s]."""
    j, inverse, links = p + body.layout.offset[q], 1.0 / body.diameter, scratch.links
    vx, vy = motion[VX, j] - motion[VX, p], motion[VY, j] - motion[VY, p]
    turning, nx, ny = 0.5 * (motion[SPIN, p] + motion[SPIN, j]), links[EX, q, p], links[EY, q, p]
    return (
        (vx * nx + vy * ny) * inverse + turning * links[GAMMA, q, p],
        (vy * nx - vx * ny) * inverse - turning * (1.0 + links[EPS, q, p]),
    )
