"""Links that weaken, yield and break: their strains, tractions and forces, and how near they are to breaking.

As in `linked`, with the weight w of each link (1 while it holds, falling to 0 while it is released), what is left of its
stiffness g, and its plastic strains:

    theta_i = sum_j c (w eps + (1 - w) eps_p) / (1 + a),      a = (c* + sum_j (1 - w) c / g) lambda / 2 G
    f_n = w S (2 G g (eps - eps_p) + (lambda_i theta_i + lambda_j theta_j) / 2),      f_t = w S 2 G g (gamma - gamma_p)
    U = sum over pairs w S r G g ((eps - eps_p)^2 + (gamma - gamma_p)^2) + sum over automata (1/2) V lambda (1 + a) theta^2

A released face carries no traction: its strain is that at which 2 G g (eps - eps_p) + lambda theta = 0. This condenses it as
the free faces of a whole cell are, but from the strain that has flowed and with the stiffness that is left. So what it takes to
release a link is never negative: dU/dw = V c G g (eps - eps_p + lambda theta / 2 G g)^2 for each of both automata.

The strain of a link between two materials is divided between its halves. The half of i is strained by eps + d, that of j by
eps - d, and d makes the energy small:

    d = -q / D,        q = (G_i - G_j) eps + (lambda_i theta_i - lambda_j theta_j) / 2
    D = G_i + G_j + (1/2) sum over both of |lambda| C / (1 + a),      C = sum of the shares c of its links to other materials
    U = sum over pairs w S r ((G_i + G_j) eps^2 / 2 + G_ij gamma^2 - q^2 / 2 D) + sum over automata V lambda (1 + a) theta^2 / 2
    theta'_i = theta_i + sum_j c w d / (1 + a),      f_t = w S 2 G_ij gamma,      G_ij = 2 G_i G_j / (G_i + G_j)
    f_n = w S ((G_i + G_j) eps + (G_i - G_j) d + (lambda_i theta'_i + lambda_j theta'_j) / 2)

Where the links of an automaton to other materials are strained alike, as in layers along the rows of a square packing, this d
is the exact one. Elsewhere D is at least what the whole system has, so U lies above its least value: never negative, a little
too stiff. D belongs to links that all hold. Solving the whole system would need all links of an interface in every step.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..support.dispatch import dispatched
from ..support.float_arrays import FloatArray
from ..support.jit import internal, internal_inlined, jit
from .breaking.criterion import LinkStress, failure
from .lattice import Body, update_ghosts
from .pair import equivalent_stress, share_out, strain_links, sum_forces, sum_over_links, sum_shares, virial
from .responses import Flow, FlowOfEach, History, NoFlow, flow_of, respond


class Histories(NamedTuple):
    """Histories of links, each of shape (directions, m).

    Attributes:
        weight: 1 for a link that holds, less while it is released, 0 afterwards and without a link.
        plastic_eps: plastic strain along the link.
        plastic_gamma: plastic strain across the link.
        stiffness: part of the shear modulus that is left, less 1.
        inelastic: inelastic strain.
        origin_eps: strain along the link from which that of the link counts; not 0 where a pair was linked again.
        origin_gamma: the same across.
    """

    weight: FloatArray
    plastic_eps: FloatArray
    plastic_gamma: FloatArray
    stiffness: FloatArray
    inelastic: FloatArray
    origin_eps: FloatArray
    origin_gamma: FloatArray


class Uniform(NamedTuple):
    """Moduli of links, each of shape (directions, m): G_i + G_j, and 2 G_ij [Pa]."""

    along: FloatArray
    across: FloatArray


class Mixture(NamedTuple):
    """Moduli of links within and between several materials, and the division of their strains, each of shape (directions, m).

    Attributes:
        along: G_i + G_j [Pa].
        across: 2 G_ij [Pa].
        compliance: 1 / D of links between two materials, 0 of the others [1/Pa].
        division: scratch: d.
    """

    along: FloatArray
    across: FloatArray
    compliance: FloatArray
    division: FloatArray


class Tractions(NamedTuple):
    """Results of a force evaluation.

    Attributes:
        counted: strain of each link that counts in the volumetric strain, shape (directions, m).
        normal: traction along each link, shape (directions, m) [Pa].
        tangential: traction across each link, likewise [Pa].
        virial: terms of links in the stress for a share of 1, shape (3, directions, m) [Pa].
        stress: xx, yy and xy of the automata, tension positive, shape (3, m) [Pa].
        pressure: lambda theta of the automata, shape (m,) [Pa].
        deviator: G theta of the automata, shape (m,) [Pa].
    """

    counted: FloatArray
    normal: FloatArray
    tangential: FloatArray
    virial: FloatArray
    stress: FloatArray
    pressure: FloatArray
    deviator: FloatArray


class Law(NamedTuple):
    """The laws of links.

    Attributes:
        response: a `Flow`, `FlowOfEach`, or `NoFlow`.
        criterion: constants of a criterion, or `breaking.criterion.Weaker`.
        factors: of the strength of each link, shape (directions, m).
        release: over how many internal steps a broken link is released, and a new one made.
        linking: see `welding.Relinking.constants`, shape (2,).
        linking_ticks: after how many internal steps it is looked which pairs are linked again; 0 for never.
    """

    response: Any
    criterion: Any
    factors: FloatArray
    release: int
    linking: FloatArray
    linking_ticks: int


class Medium(NamedTuple):
    """A specimen with histories, as kernels take it.

    Attributes:
        body: a `lattice.Body`.
        histories: `Histories`.
        mixture: `Uniform`, or a `Mixture`.
        tractions: `Tractions`.
        law: a `Law`.
        ground: a `contacts.Ground`.
    """

    body: Body
    histories: Histories
    mixture: Any
    tractions: Tractions
    law: Law
    ground: Any


def make_mixture(body: Body, several: bool) -> Uniform | Mixture:
    """Return the moduli of the links of automata."""
    along, across, compliance = (np.ones(body.face.shape) for _ in range(3))
    compliance[:] = 0.0
    stiffening = 1.0 + body.missing * body.lame / (2.0 * body.shear)
    coupling = np.zeros(len(body.mass))
    differing = []
    for q, o in enumerate(body.layout.offset.tolist()):
        i, j = slice(0, len(coupling) - o), slice(o, None)
        one, other = body.shear[i], body.shear[j]
        along[q, i], across[q, i] = one + other, np.where(one == other, 2.0 * one, 4.0 * (one * other) / (one + other))
        differs = ((one != other) | (body.lame[i] != body.lame[j])) & (body.face[q, i] > 0.0)
        differing.append(differs)
        coupling[i] += 0.5 * np.abs(body.lame[i]) * body.first_share[q, i] * differs / stiffening[i]
        coupling[j] += 0.5 * np.abs(body.lame[j]) * body.second_share[q, i] * differs / stiffening[j]
    # A ghost has the links of the automaton that it copies.
    coupling[body.layout.ghosts[:, 0]] = coupling[body.layout.ghosts[:, 1]]
    for q, o in enumerate(body.layout.offset.tolist()):
        i, j = slice(0, len(coupling) - o), slice(o, None)
        stiffness = along[q, i] + (coupling[i] + coupling[j])
        compliance[q, i] = np.where(differing[q], 1.0 / stiffness, 0.0)
    return Mixture(along, across, compliance, np.zeros(body.face.shape)) if several else Uniform(along, across)


def make_tractions(body: Body) -> Tractions:
    """Return room for the results of a force evaluation."""
    counted, normal, tangential = (np.zeros(body.face.shape) for _ in range(3))
    fields = np.zeros((3, *body.face.shape)), np.zeros((3, len(body.mass))), np.zeros(len(body.mass)), np.zeros(len(body.mass))
    return Tractions(counted, normal, tangential, *fields)


# -- strains and tractions --------------------------------------------------------------------------------------------------


@internal
def strain_medium(medium, motion, scratch):
    """Write the strains of all links and the volumetric strains, with the histories as they are."""
    body, theta = medium.body, scratch.forces.dilation
    strain_links(body, motion, scratch)
    _soften(medium, scratch)
    for q in range(body.layout.offset.size):
        _count_strains(_row_of(medium, scratch, q), medium.tractions.counted[q, : theta.size - body.layout.offset[q]])
    sum_shares(body, medium.tractions.counted, scratch.links, theta)
    _multiply(theta, scratch.forces.stiffening)
    update_ghosts(body.layout, theta)
    divide_strains(medium.mixture, medium, scratch)
    _multiply_into(theta, body.lame, medium.tractions.pressure)
    _multiply_into(theta, body.shear, medium.tractions.deviator)


@internal
def _multiply(values, factors):
    for p in range(values.size):
        values[p] *= factors[p]


@internal
def _multiply_into(values, factors, out):
    for p in range(values.size):
        out[p] = values[p] * factors[p]


@internal
def _soften(medium, scratch):
    """Write 1 / (1 + a): the factor of free and released faces in the volumetric strains."""
    body, histories, free, stiffening = medium.body, medium.histories, medium.tractions.counted, scratch.forces.stiffening
    for q in range(body.layout.offset.size):
        _free_faces(histories.weight[q], histories.stiffness[q], free[q])
    sum_shares(body, free, scratch.links, stiffening)
    _stiffen(body.missing, body.lame, body.shear, stiffening)


@internal
def _free_faces(weight, stiffness, out):
    for p in range(out.size):
        out[p] = (1.0 - weight[p]) / (1.0 + stiffness[p])


@internal
def _stiffen(missing, lame, shear, stiffening):
    for p in range(stiffening.size):
        stiffening[p] = 1.0 / (1.0 + (missing[p] + stiffening[p]) * lame[p] / (2.0 * shear[p]))


@internal
def _count_strains(row, out):
    """Write the strains that count in the volumetric strain: a released face keeps the strain that has flowed."""
    for p in range(out.size):
        out[p] = row.weight[p] * (row.eps[p] - row.origin_eps[p]) + (1.0 - row.weight[p]) * row.plastic_eps[p]


@dispatched
def divide_strains(mixture, medium, scratch):
    """Divide the strains of links between two materials, and correct the volumetric strains."""


@divide_strains.register(Uniform)
def _divide_nothing(mixture, medium, scratch):
    return None


@divide_strains.register(Mixture)
def _divide_strains(mixture, medium, scratch):
    body, links, theta = medium.body, scratch.links, scratch.forces.dilation
    for q in range(body.layout.offset.size):
        o = body.layout.offset[q]
        for p in range(theta.size - o):
            eps = links.eps[q, p] - medium.histories.origin_eps[q, p]
            pressing = 0.5 * (body.lame[p] * theta[p] - body.lame[p + o] * theta[p + o])
            mixture.division[q, p] = -mixture.compliance[q, p] * ((body.shear[p] - body.shear[p + o]) * eps + pressing)
    for q in range(body.layout.offset.size):
        share_out(body.first_share[q], body.second_share[q], mixture.division[q], links.first[q], links.second[q])
        _multiply(links.first[q], medium.histories.weight[q])
        _multiply(links.second[q], medium.histories.weight[q])
    # The half of the automaton where a link begins is strained more, that of the other one less.
    sum_over_links(body, links.first, links.second, -1.0, medium.tractions.pressure)
    for p in range(theta.size):
        theta[p] += medium.tractions.pressure[p] * scratch.forces.stiffening[p]
    update_ghosts(body.layout, theta)


class _Row(NamedTuple):
    """The fields of the links of one direction, and of their two automata; see `_row_of`."""

    eps: FloatArray
    gamma: FloatArray
    ex: FloatArray
    ey: FloatArray
    weight: FloatArray
    plastic_eps: FloatArray
    plastic_gamma: FloatArray
    stiffness: FloatArray
    origin_eps: FloatArray
    origin_gamma: FloatArray
    normal: FloatArray
    tangential: FloatArray
    pressure: tuple[FloatArray, FloatArray]
    deviator: tuple[FloatArray, FloatArray]


@internal
def _row_of(medium, scratch, q):
    links, h, tractions, o = scratch.links, medium.histories, medium.tractions, medium.body.layout.offset[q]
    end = medium.body.mass.size - o
    return _Row(
        links.eps[q, :end], links.gamma[q, :end], links.ex[q, :end], links.ey[q, :end], h.weight[q, :end],
        h.plastic_eps[q, :end], h.plastic_gamma[q, :end], h.stiffness[q, :end], h.origin_eps[q, :end], h.origin_gamma[q, :end],
        tractions.normal[q, :end], tractions.tangential[q, :end], (tractions.pressure[:end], tractions.pressure[o:]),
        (tractions.deviator[:end], tractions.deviator[o:]),
    )  # fmt: skip


@internal
def pull_medium(medium, scratch):
    """Write the tractions of all links in the strains as they are, and the stresses of the automata."""
    body, mixture = medium.body, medium.mixture
    for q in range(body.layout.offset.size):
        end = body.mass.size - body.layout.offset[q]
        row = _row_of(medium, scratch, q)
        _write_tractions(row, mixture.along[q, :end], mixture.across[q, :end], row.normal, row.tangential)
        add_division(mixture, body, q, row.normal)


@dispatched
def add_division(mixture, body, q, normal):
    """Add what the division of strains gives the tractions of the links of one direction."""


@add_division.register(Uniform)
def _add_nothing(mixture, body, q, normal):
    return None


@add_division.register(Mixture)
def _add_division(mixture, body, q, normal):
    for p in range(normal.size):
        normal[p] += (body.shear[p] - body.shear[p + body.layout.offset[q]]) * mixture.division[q, p]


@internal
def _write_tractions(row, along, across, normal, tangential):
    pressure_i, pressure_j = row.pressure
    for p in range(normal.size):
        left = 1.0 + row.stiffness[p]
        eps = (row.eps[p] - row.origin_eps[p]) - row.plastic_eps[p]
        gamma = (row.gamma[p] - row.origin_gamma[p]) - row.plastic_gamma[p]
        normal[p] = along[p] * left * eps + 0.5 * (pressure_i[p] + pressure_j[p])
        tangential[p] = across[p] * left * gamma


@internal
def stress_medium(medium, scratch):
    """Write the stresses of the automata, from the tractions of their links."""
    body, tractions = medium.body, medium.tractions
    for q in range(body.layout.offset.size):
        end = body.mass.size - body.layout.offset[q]
        out = (tractions.virial[0, q, :end], tractions.virial[1, q, :end], tractions.virial[2, q, :end])
        _write_virial(_row_of(medium, scratch, q), out)
    for component in range(3):
        sum_shares(body, tractions.virial[component], scratch.links, tractions.stress[component])
        update_ghosts(body.layout, tractions.stress[component])


@internal
def _write_virial(row, out):
    xx, yy, xy = out
    for p in range(xx.size):
        a, b, c = virial(row.normal[p], row.tangential[p], row.ex[p], row.ey[p])
        xx[p], yy[p], xy[p] = row.weight[p] * a, row.weight[p] * b, row.weight[p] * c


@internal
def force_medium(medium, scratch):
    """Write the forces and torques of the links on the automata, from their tractions."""
    body, links = medium.body, scratch.links
    for q in range(body.layout.offset.size):
        end = body.mass.size - body.layout.offset[q]
        pulls = (links.first[q, :end], links.second[q, :end], links.torque[q, :end])
        _write_pulls(_row_of(medium, scratch, q), body.face[q, :end], pulls)
    sum_forces(body, links, scratch.forces)


@internal
def _write_pulls(row, face, pulls):
    fx, fy, torque = pulls
    for p in range(fx.size):
        area = face[p] * row.weight[p]
        fn, ft = area * row.normal[p], area * row.tangential[p]
        fx[p], fy[p] = fn * row.ex[p] - ft * row.ey[p], fn * row.ey[p] + ft * row.ex[p]
        torque[p] = (1.0 + row.eps[p]) * ft - row.gamma[p] * fn


@jit
def measure_medium(medium, motion, scratch):
    """Write strains, stresses and the forces of links in the present positions, for readings."""
    strain_medium(medium, motion, scratch)
    pull_medium(medium, scratch)
    stress_medium(medium, scratch)
    force_medium(medium, scratch)


# -- breaking ---------------------------------------------------------------------------------------------------------------


class _Stress(NamedTuple):
    """The stresses xx, yy and xy of the two automata of the links of one direction."""

    first: tuple[FloatArray, FloatArray, FloatArray]
    second: tuple[FloatArray, FloatArray, FloatArray]


@internal
def _stress_of(medium, q):
    o, stress = medium.body.layout.offset[q], medium.tractions.stress
    end = medium.body.mass.size - o
    return _Stress((stress[0, :end], stress[1, :end], stress[2, :end]), (stress[0, o:], stress[1, o:], stress[2, o:]))


@internal_inlined
def _mean_stress(row, p):
    """Return the mean stress of a link, K theta, with what is left of its shear modulus [Pa]."""
    (pressure_i, pressure_j), (deviator_i, deviator_j) = row.pressure, row.deviator
    left = 1.0 + row.stiffness[p]
    return 0.5 * ((pressure_i[p] + pressure_j[p]) + (2.0 * left / 3.0) * (deviator_i[p] + deviator_j[p]))


@internal_inlined
def _link_stress(row, stress, factor, number, p):
    """Return what a criterion judges. Along the face of a link the mean stress of both automata acts."""
    (xx_i, yy_i, xy_i), (xx_j, yy_j, xy_j) = stress.first, stress.second
    xx, yy, xy = 0.5 * (xx_i[p] + xx_j[p]), 0.5 * (yy_i[p] + yy_j[p]), 0.5 * (xy_i[p] + xy_j[p])
    sx, sy = -row.ey[p], row.ex[p]
    side = (sx * sx * xx + sy * sy * yy) + 2.0 * (sx * sy) * xy
    mean, normal, tangential = _mean_stress(row, p), row.normal[p], row.tangential[p]
    equivalent = equivalent_stress(normal, side, 3.0 * mean - normal - side, tangential)
    eps, gamma = row.eps[p] - row.origin_eps[p], row.gamma[p] - row.origin_gamma[p]
    return LinkStress(eps, gamma, normal, tangential, equivalent, mean, factor[p], number + p)


@internal
def count_failing(medium, scratch):
    """Return how many links have to break."""
    failing = 0
    for q in range(medium.body.layout.offset.size):
        row, stress = _row_of(medium, scratch, q), _stress_of(medium, q)
        failing += _count_failing(medium.law.criterion, row, stress, medium.law.factors[q], q * medium.body.mass.size)
    return failing


@internal
def _count_failing(law, row, stress, factor, number):
    failing = 0
    for p in range(row.eps.size):
        value, limit, _ = failure(law, _link_stress(row, stress, factor, number, p))
        failing += 1 if (row.weight[p] == 1.0) & (value >= limit) else 0
    return failing


@internal
def failure_of(medium, scratch, q, p):
    """Return what decides whether a link breaks, its limit, and the number of the cause."""
    row, stress, number = _row_of(medium, scratch, q), _stress_of(medium, q), q * medium.body.mass.size
    return failure(medium.law.criterion, _link_stress(row, stress, medium.law.factors[q], number, p))


@jit
def find_failing(medium, scratch):
    """Call `count_failing` from Python."""
    return count_failing(medium, scratch)


@jit
def criterion_ratios(medium, scratch, direction, place, ratio_out, cause_out):
    """Write how near links are to breaking: what decides over its limit, 0 of those that are broken or far from it.

    Args:
        medium: a `Medium`.
        scratch: a `lattice.Scratch`, as `measure_medium` leaves it.
        direction: of the links, shape (k,).
        place: where they begin, shape (k,).
        ratio_out: shape (k,).
        cause_out: the numbers of what decides, shape (k,).
    """
    for row in range(place.size):
        q, p = direction[row], place[row]
        ratio_out[row], cause_out[row] = 0.0, 0
        if medium.histories.weight[q, p] == 1.0:
            value, limit, cause_out[row] = failure_of(medium, scratch, q, p)
            ratio_out[row] = max(value / limit, 0.0)


# -- flow -------------------------------------------------------------------------------------------------------------------


@dispatched
def let_flow(response, medium, motion, scratch, time):
    """Let links yield in the strains as they are, and return the energy that flow and degradation take [J].

    Args:
        response: of the law of the medium.
        medium: a `Medium`; its histories are updated.
        motion: a `lattice.Motion`; its velocities are those since the forces were computed last.
        scratch: a `lattice.Scratch`.
        time: since the forces were computed last [s].
    """


@let_flow.register(NoFlow)
def _let_nothing_flow(response, medium, motion, scratch, time):
    return 0.0


@let_flow.register(Flow)
@let_flow.register(FlowOfEach)
def _let_flow(response, medium, motion, scratch, time):
    lost, layout = 0.0, medium.body.layout
    for q in range(layout.offset.size):
        row, stress, number = _row_of(medium, scratch, q), _stress_of(medium, q), q * medium.body.mass.size
        if not _count_flowing(response, row, stress, number):
            continue
        for p in range(row.eps.size):
            equivalent = _mean_equivalent(row, stress, p)
            law = flow_of(response, number + p)
            if row.weight[p] == 1.0 and equivalent > law.onset:
                taken = _flow(law, medium, motion, scratch, (q, p), equivalent, time)
                # A link that ends at an automaton of which there is a ghost is there twice.
                lost += taken if _is_real(layout, p) else 0.0
    return lost


@internal
def _is_real(layout, p):
    """Return whether a place is not that of a ghost."""
    for row in range(layout.ghosts.shape[0]):
        if layout.ghosts[row, 0] == p:
            return False
    return True


@internal
def _count_flowing(response, row, stress, number):
    flowing = 0
    for p in range(row.eps.size):
        flowing += 1 if (row.weight[p] == 1.0) & (_mean_equivalent(row, stress, p) > flow_of(response, number + p).onset) else 0
    return flowing


@internal_inlined
def _mean_equivalent(row, stress, p):
    """Return the equivalent stress of the mean of both automata [Pa].

    All pairs of an automaton then yield together. With their own tractions they would not: what one pair takes off its deviator
    the others' stress along z would have to carry.
    """
    (xx_i, yy_i, xy_i), (xx_j, yy_j, xy_j) = stress.first, stress.second
    xx, yy, xy = 0.5 * (xx_i[p] + xx_j[p]), 0.5 * (yy_i[p] + yy_j[p]), 0.5 * (xy_i[p] + xy_j[p])
    return equivalent_stress(xx, yy, 3.0 * _mean_stress(row, p) - xx - yy, xy)


@internal
def _flow(law, medium, motion, scratch, link, equivalent, time):
    """Write the history of a link that yields, and return the energy that this takes [J].

    It is the work of the kicks before and after the drift less the change of the energy of the link, so that the balance of a
    step closes: with its elastic strains u before the drift and w after it, and stiffnesses g and h,

        S r G ((g - h) u.w + (g u + h w).de_p),

    the area between the lines of loading and unloading, and the mean stress times the strain that has flowed.
    """
    (q, p), body, h = link, medium.body, medium.histories
    j = p + body.layout.offset[q]
    eps, gamma = scratch.links.eps[q, p] - h.origin_eps[q, p], scratch.links.gamma[q, p] - h.origin_gamma[q, p]
    theta, shear = 0.5 * (scratch.forces.dilation[p] + scratch.forces.dilation[j]), body.shear[p]
    before = History(h.plastic_eps[q, p], h.plastic_gamma[q, p], 1.0 + h.stiffness[q, p], h.inelastic[q, p])
    after = respond(law, before, equivalent, eps, gamma, theta, shear)
    along, across = strain_rates(body, motion, scratch, q, p)
    ux, uy = eps - before.eps - time * along, gamma - before.gamma - time * across
    wx, wy, g, k = eps - after.eps, gamma - after.gamma, before.stiffness, after.stiffness
    h.plastic_eps[q, p], h.plastic_gamma[q, p] = after.eps, after.gamma
    h.stiffness[q, p], h.inelastic[q, p] = k - 1.0, after.inelastic
    flow = (g * ux + k * wx) * (after.eps - before.eps) + (g * uy + k * wy) * (after.gamma - before.gamma)
    return body.face[q, p] * body.diameter * shear * ((g - k) * (ux * wx + uy * wy) + flow)


@internal_inlined
def strain_rates(body, motion, scratch, q, p):
    """Return the rates of the strains of a link, along and across [1/s]."""
    j, inverse, links = p + body.layout.offset[q], 1.0 / body.diameter, scratch.links
    vx, vy = motion.vx[j] - motion.vx[p], motion.vy[j] - motion.vy[p]
    turning, nx, ny = 0.5 * (motion.spin[p] + motion.spin[j]), links.ex[q, p], links.ey[q, p]
    return (
        (vx * nx + vy * ny) * inverse + turning * links.gamma[q, p],
        (vy * nx - vx * ny) * inverse - turning * (1.0 + links.eps[q, p]),
    )
