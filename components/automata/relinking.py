"""Cold welding: a contact under high pressure that hardly slides becomes a link again.

    N / S' >= pressure        and        |sliding speed| <= slip_speed        (N: contact force, S': face of a whole cell)

This is the switching unlinked -> linked of movable cellular automata: Psakhie et al. (2003), section 2.2. Pairs that were
linked in the packing are linked again if their line of centres lies within 45 degrees of the axis of their link. The new link
carries the force of the contact; its strains count from there. Such specimens have one material, see `parameters`.

The kicks before and after a drift each do the work force x length / 2; for springs the sum is the change of energy. This fails
if the strains of a link change between the kicks, so the work of the forces before and after is computed (`_drift_work`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import SerializeAsAny

from ..support.float_arrays import FloatArray
from ..support.jit import internal, internal_inlined, jit
from ..support.parameter_fields import Magnitude, field
from ..support.tagged_union import ByName, Named
from .contacts import (
    FIRST,
    SECOND,
    SLOT,
    START,
    contact_link,
    contact_stiffnesses,
    link_weight,
    relative_motion,
    separation,
    sliding_speed,
    write_link_value,
)
from .energies import condensation_factor, dilation, pair_energy
from .lattice import (
    EPS,
    EX,
    EY,
    FACE,
    FIRST_SHARE,
    GAMMA,
    LAME,
    SECOND_SHARE,
    SHEAR,
    VX,
)
from .link_release import LINKING, scheduled_weight
from .pair_strains import write_link_strains

# Relative rounding error of an energy.
_ROUNDING = 1e-9


class Relinking(Named):
    """A condition under which a broken pair is linked again."""

    kinds: ClassVar[Mapping[str, str]] = {}
    """The kinds of events of this law: name -> description."""

    def constants(self) -> tuple[float, float]:
        """Return the smallest pressure [Pa] and the largest sliding speed [m/s]."""
        return 0.0, 0.0


class NoRelinking(Relinking):
    """No relinking: pairs stay broken."""

    name: Literal["none"] = field("none", "which law", "1")


class ColdWelding(Relinking):
    """Contact pressure >= `pressure` and sliding speed <= `slip_speed`, checked every `release_ticks` steps."""

    name: Literal["cold_welding"] = field("cold_welding", "which law", "1")
    pressure: Magnitude = field(..., "smallest pressure at which a contact is linked again", "Pa")
    slip_speed: Magnitude = field(..., "largest sliding speed at which a contact is linked again", "m/s")
    kinds = {"linked": "the contact pressure of a broken pair reached its limit, and the pair was linked again"}

    def constants(self) -> tuple[float, float]:
        """Return the smallest pressure [Pa] and the largest sliding speed [m/s] at which a pair is linked again."""
        return self.pressure, self.slip_speed


RELINKINGS: dict[str, type[Relinking]] = {"none": NoRelinking, "cold_welding": ColdWelding}

ChosenRelinking = Annotated[SerializeAsAny[Relinking], ByName(RELINKINGS)]


class _RelinkedPair(NamedTuple):
    """A pair whose link is being formed, and its state before the step.

    Attributes:
        row: row of its contact in `contacts.Contacts`.
        before: weight of the link before the step.
        after: weight of the link after the step; the kick uses the mean of both.
        origin: `origin_eps` and `origin_gamma` of the link before the step.
        places: displacements and angles of all automata, shape (3, m).
        time: length of the drift before the step [s].
        energy: `energies.pair_energy` before the step [J].
        work: `_drift_work` before the step [J].
    """

    row: int
    before: float
    after: float
    origin: tuple[float, float]
    places: FloatArray
    time: float
    energy: float
    work: float


@jit
def write_linking_pressures(medium, motion, links, contacts, pressure_out):
    """Write the pressures of contacts that may become links, or -1 for others, shape (used,) [Pa].

    Such a pair was once linked and is fully released, its sliding is slow enough, and its line of centres lies within 45
    degrees of the axis of its link. `links` has the strains of the present positions.
    """
    body, constants, pairs, place = medium.body, medium.contact_constants, contacts.pairs, medium.body.layout.place
    for row in range(contacts.used):
        pressure_out[row] = -1.0
        i, j = pairs[row, FIRST], pairs[row, SECOND]
        if pairs[row, SLOT] < 0 or link_weight(body.layout, medium.histories.weight, pairs, row) > 0.0:
            continue
        x, y, r = separation(constants, place, motion, i, j)
        overlap = contacts.rest[row] - r
        if not overlap > 0.0 or r == 0.0:
            continue
        q, p = contact_link(body.layout, pairs, row)
        slides = abs(sliding_speed(relative_motion(place, motion, i, j), x / r, y / r, r)) > medium.law.linking[1]
        if not slides and abs(links[GAMMA, q, p]) <= 1.0 + links[EPS, q, p]:
            # The pressure is that between whole automata: it does not depend on the part of their cells inside the shape.
            stiffness = constants.normal[i] * overlap * (2.0 * body.cells[SHEAR, p])
            pressure_out[row] = stiffness / (constants.tangential[i] * body.diameter)


@jit
def raise_link_weights(specimen, contacts, tick, time, places):
    """Raise the weights of links that are being formed again, and tally the energy dissipated in this.

    In each step such a link gets the strains at which it carries the force of its contact, with slightly more or less pressure
    so that no energy is needed: forming a link stiffens the volumes of both automata. If no such strain is near, energy may be
    dissipated. Energy is never created; the link waits for the next step instead. `time` is the time since the last force
    evaluation [s]; `places` is scratch, shape (3, m).

    Returns:
        Whether any weight was raised.
    """
    medium, motion, scratch, layout = specimen.medium, specimen.motion, specimen.scratch, specimen.medium.body.layout
    raised = False
    for row in range(contacts.used):
        weight = link_weight(layout, medium.histories.weight, contacts.pairs, row)
        if contacts.pairs[row, SLOT] < 0 or contacts.pairs[row, START] >= 0 or weight == 1.0:
            continue
        raised = True
        after = scheduled_weight(contacts.pairs, row, tick, medium.law.release)
        q, p = contact_link(layout, contacts.pairs, row)
        origin = medium.histories.origin_eps[q, p], medium.histories.origin_gamma[q, p]
        energy = pair_energy(medium, motion, scratch.links, contacts, row)
        for k in range(VX):
            places[k, :] = motion[k]
        work = _drift_work(medium, motion, scratch, contacts, row, places, time)
        pair = _RelinkedPair(row, weight, after, origin, places, time, energy, work)
        taken = _raise_link_weight(medium, motion, scratch, contacts, pair, 1.0, 0.0)
        if abs(taken) > _ROUNDING * energy:
            _restore_link(medium, contacts, pair)
            taken = _raise_without_dissipation(medium, motion, scratch, contacts, pair, taken)
        specimen.losses[LINKING] += taken
    return raised


@internal
def _raise_link_weight(medium, motion, scratch, contacts, pair, fraction, extra_strain):
    """Raise the weight of a link, strain it as `_strain_link` does, and return the dissipated energy [J].

    The strains of the previous drift are released, so that the kick does not include them. The work that forces would have
    done in that drift in addition to their actual work is no loss. `motion` has the velocities of the previous drift.
    """
    _strain_link(medium, motion, scratch, contacts, pair, fraction, extra_strain)
    taken = pair.energy - pair_energy(medium, motion, scratch.links, contacts, pair.row)
    taken += 0.5 * (pair.work + _drift_work(medium, motion, scratch, contacts, pair.row, pair.places, pair.time))
    write_link_value(medium.histories.weight, medium.body.layout, contacts.pairs, pair.row, 0.5 * (pair.before + pair.after))
    return taken - _drift_work(medium, motion, scratch, contacts, pair.row, pair.places, pair.time)


@internal
def _restore_link(medium, contacts, pair):
    """Restore the weight and strains that the link of a pair had before the step."""
    _write_origin_strains(medium, contacts, pair.row, pair.origin[0], pair.origin[1])
    write_link_value(medium.histories.weight, medium.body.layout, contacts.pairs, pair.row, pair.before)


@internal
def _write_origin_strains(medium, contacts, row, eps, gamma):
    write_link_value(medium.histories.origin_eps, medium.body.layout, contacts.pairs, row, eps)
    write_link_value(medium.histories.origin_gamma, medium.body.layout, contacts.pairs, row, gamma)


@internal
def _raise_without_dissipation(medium, motion, scratch, contacts, pair, dissipated):
    """Raise the weight of a link without dissipation, or with as little as possible; return the dissipated energy [J].

    Arguments as in `_raise_link_weight`; `dissipated` is the energy dissipated if the link takes the force of its contact [J].
    """
    _, _, r = separation(
        medium.contact_constants,
        medium.body.layout.place,
        motion,
        contacts.pairs[pair.row, FIRST],
        contacts.pairs[pair.row, SECOND],
    )
    unit, more = max(contacts.rest[pair.row] - r, 0.0) / medium.body.diameter, np.nan
    if unit > 0.0:
        # Trials with less and with more strain show for which strain the dissipation is zero.
        pressed_more = _raise_link_weight(medium, motion, scratch, contacts, pair, 1.0, -unit)
        _restore_link(medium, contacts, pair)
        pressed_less = _raise_link_weight(medium, motion, scratch, contacts, pair, 1.0, unit)
        _restore_link(medium, contacts, pair)
        more = _nearest_root(pressed_more, dissipated, pressed_less, unit)
    if more == more:
        return _raise_link_weight(medium, motion, scratch, contacts, pair, 1.0, more)
    if dissipated < 0.0 < pair.before:
        contacts.pairs[pair.row, START] -= 1
        return 0.0
    # A link of weight 0 cannot wait for the next step: if it would create energy, it begins without strains.
    return _raise_link_weight(medium, motion, scratch, contacts, pair, 0.0 if dissipated < 0.0 else 1.0, 0.0)


@internal_inlined
def _nearest_root(left, middle, right, unit):
    """Return the root nearest to 0 of a parabola with these values at -unit, 0, unit; NaN if there is none in this interval."""
    slope, curvature = 0.5 * (right - left) / unit, (0.5 * (right + left) - middle) / (unit * unit)
    under = slope * slope - 4.0 * curvature * middle
    if not (under >= 0.0 and slope != 0.0):
        return np.nan
    root = np.sqrt(under)
    strain = -2.0 * middle / (slope + (root if slope > 0.0 else -root))
    return strain if abs(strain) <= unit else np.nan


@internal
def _strain_link(medium, motion, scratch, contacts, pair, fraction, extra_strain):
    """Give a link its weight after the step, and strains at which it carries the force of its contact alone.

    The link keeps its history: the remaining stiffness, and the plastic strains, which its free faces have kept. The strains
    are multiplied by `fraction`, and `extra_strain` is added along the link.
    """
    body, h, links, row = medium.body, medium.histories, scratch.links, pair.row
    i, j, slot = contacts.pairs[row, FIRST], contacts.pairs[row, SECOND], contacts.pairs[row, SLOT]
    q, p = contact_link(body.layout, contacts.pairs, row)
    # The link may begin at the second automaton, whose force is the opposite one.
    sign = 1.0 if slot < body.layout.offset.size else -1.0
    twice = 2.0 * body.cells[SHEAR, p] * (1.0 + h.stiffness[q, p])
    x, y, r = separation(medium.contact_constants, body.layout.place, motion, i, j)
    normal, tangential = contact_stiffnesses(medium.contact_constants, i, j)
    overlap = max(contacts.rest[row] - r, 0.0)
    push, drag = normal * overlap, tangential * (contacts.slid[row] if overlap > 0.0 else 0.0)
    fx, fy = sign * (-push * x - drag * y) / r, sign * (-push * y + drag * x) / r
    nx, ny = links[EX, q, p], links[EY, q, p]
    along, across = fx * nx + fy * ny, fy * nx - fx * ny
    # The traction due to volume strains if the link has its new weight and no elastic strain, and its change with the strain.
    eps, gamma = links[EPS, q, p] - h.plastic_eps[q, p], links[GAMMA, q, p] - h.plastic_gamma[q, p]
    _write_origin_strains(medium, contacts, row, eps, gamma)
    write_link_value(medium.histories.weight, medium.body.layout, contacts.pairs, row, pair.after)
    begin, end = (i, j) if slot < body.layout.offset.size else (j, i)
    first, second = body.layout.place[begin], body.layout.place[end]
    others = 0.5 * body.cells[LAME, p] * (dilation(body, h, links, first) + dilation(body, h, links, second))
    slope = body.links[FIRST_SHARE, q, p] / condensation_factor(body, h, first) + body.links[
        SECOND_SHARE, q, p
    ] / condensation_factor(body, h, second)
    slope *= 0.5 * body.cells[LAME, p] * pair.after
    eps -= fraction * (along / body.links[FACE, q, p] - others) / (twice + slope) + extra_strain
    gamma -= fraction * across / (body.links[FACE, q, p] * twice)
    _write_origin_strains(medium, contacts, row, eps, gamma)


@internal
def _drift_work(medium, motion, scratch, contacts, row, places, time):
    """Return the work of the present forces of a pair (contact, link, volumes) over the way of a drift [J].

    `places` are the displacements and angles of all automata, `time` is the duration of the drift [s].
    """
    # Energies are quadratic in the displacements, so the difference over equal ways forwards and backwards is the exact work.
    _drift_and_strain(medium.body, motion, scratch, places, -0.5 * time)
    work = pair_energy(medium, motion, scratch.links, contacts, row)
    _drift_and_strain(medium.body, motion, scratch, places, 0.5 * time)
    work -= pair_energy(medium, motion, scratch.links, contacts, row)
    _drift_and_strain(medium.body, motion, scratch, places, 0.0)
    return work


@internal
def _drift_and_strain(body, motion, scratch, places, time):
    """Move all automata from `places` for a time [s] at their velocities, and write the strains of links."""
    for k in range(VX):
        for p in range(motion.shape[1]):
            motion[k, p] = places[k, p] + time * motion[VX + k, p]
    write_link_strains(body, motion, scratch)
