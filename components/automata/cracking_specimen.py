"""Steps and outputs of a specimen whose links yield and break, and whose pieces touch."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError
from ..events import MOST_INDEX, EventDetail
from ..state_block import Block
from ..support.counter_random import uniform
from ..support.float_arrays import FloatArray, norms
from .contacts import (
    FIRST,
    SECOND,
    SKIN,
    SLOT,
    START,
    ContactConstants,
    Contacts,
    find_pairs,
    is_within_search_range,
    merge_contacts,
)
from .energies import stored_energies
from .kernels import BREAK, SEARCH, TOO_FAST, Specimen, StepLimits, advance, write_current_fields
from .lattice import EPS, FACE, FIRST_SHARE, GAMMA, LAME, SECOND_SHARE, SHEAR, STRESS_XX, TORQUE, VOLUME, VX, VY, Body, X, Y
from .laws.criterion import WeakerLaw
from .link_release import LOSSES, NEVER_FOUND, TRAVEL, write_rest_distances
from .linked_specimen import LinkedSpecimen
from .links import Histories, LinkLaws, Medium, make_link_moduli, write_criterion_values
from .materials import IntArray, chosen_materials, link_law_numbers, make_criterion, make_response
from .packing import Packing
from .parameters import AutomataParameters
from .relinking import raise_link_weights, write_linking_pressures
from .stability import ALLOWED_PART, damping_limit

# A result of `advance`, in addition to those of `linked_specimen`.
TOO_FAR = 2
# Distance that the fastest automaton may move before the next search for contacts, in diameters.
_MOST_TRAVEL = 0.5 * SKIN
# The search also includes inner automata with a link strained more than this. Below this strain, second neighbours are at least
# 2 (1 - 0.05) sin(45 degrees - 0.05) = 1.28 diameters apart, and the next search comes before they can touch.
_STRAINED = 0.05
# Names of the state variables per link: for links that yield, and for links that may be formed again.
_FLOWING = "plastic_eps", "plastic_gamma", "stiffness", "inelastic"
_WELDED = "origin_eps", "origin_gamma"
# Names of the entries of the state variable `losses`, in order.
_LOSSES = "fracture_energy", "friction_energy", "inelastic_energy", "damping_energy", "linking_energy"


def intact_medium(packing: Packing, body: Body, parameters: AutomataParameters, material_numbers: IntArray) -> Medium:
    """Return the `Medium` of a specimen whose links are all intact; `material_numbers` has one number per automaton."""
    p, layout = parameters, body.layout
    directions = len(layout.offset)
    histories = Histories(*(np.zeros(body.links.shape[1:]) for _ in Histories._fields))
    histories.weight[body.links[FACE] > 0.0] = 1.0
    spread = p.strength_scatter * (
        2.0 * uniform(p.strength_seed, 1, len(material_numbers) * directions).reshape(-1, directions) - 1.0
    )
    strengths = (1.0 + spread) * _regional_strengths(packing, p)
    factors = np.ones(body.links.shape[1:])
    for q in range(directions):
        factors[q, layout.place[packing.neighbours[:, q]] - layout.offset[q]] = strengths[:, q]
        factors[q, layout.place] = strengths[:, q]
    rows = link_law_numbers(p, material_numbers, packing, layout)
    law = LinkLaws(
        make_response(p, rows), make_criterion(p, rows), factors, p.release_ticks, p.relinking.constants(),
        p.release_ticks if p.relinking.kinds else 0,
    )  # fmt: skip
    contact_constants = _make_contact_constants(packing, body, p)
    return Medium(body, histories, make_link_moduli(body, p.has_several_materials), law, contact_constants)


class CrackingSpecimen(LinkedSpecimen):
    """A specimen whose links have histories (they weaken, yield and break), and whose contacts have friction."""

    has_histories = True

    def set_medium(self, parameters: AutomataParameters, medium: Medium) -> None:
        """Set the parameters and the intact medium."""
        p, n, field = parameters, self.count, ("f8", self.body.links.shape[1:])
        self._parameters, self.medium, criterion = p, medium, p.leading_criterion
        _refuse_double_links(self.packing)
        self.event_kinds = {**criterion.causes, **p.relinking.kinds}
        broken, linked = EventDetail(criterion.unit, "links", "criterion_ratio"), EventDetail("Pa", "links")
        self.event_details = dict.fromkeys(criterion.causes, broken) | dict.fromkeys(p.relinking.kinds, linked)
        self._histories = ("weight", *(_FLOWING if p.can_yield else ()), *(_WELDED if p.relinking.kinds else ()))
        self.fields = {**dict.fromkeys(self._histories, field), "weight": (*field, 0.0, 1.0), "losses": ("f8", (LOSSES,))}
        last = (n - 1, n - 1, 2 * len(self.body.normal) - 1, MOST_INDEX)
        self.growing = {
            "contacts": ("i8", (4,), (0, 0, -1, -MOST_INDEX), last, n * (n - 1) // 2), "slid": ("f8", ()), "rest": ("f8", ()),
        }  # fmt: skip
        self._dashpot, self._push = np.zeros((0, 2)), np.zeros(0)
        self._places = np.zeros((3, self.body.layout.size))
        self._refuse_unstable_damping(p)
        _, second, q = self._pairs.T
        self._numbers = np.zeros(self.body.links.shape[1:], np.int64)
        self._numbers[q, self.place[second] - self.body.layout.offset[q]] = np.arange(len(q))
        self._numbers[self._at] = np.arange(len(q))
        self._surface = (self.packing.face == 0.0).any(axis=1)

    def _refuse_unstable_damping(self, parameters: AutomataParameters) -> None:
        """Refuse a contact damping so large that the scheme would be unstable with this step."""
        given = parameters.contact_damping
        # For several materials, the stiffest contact and the lightest whole automaton give a safe estimate.
        whole = min(solid.density for solid in chosen_materials(parameters)) * float(self.body.cells[VOLUME, self.place].max())
        stiffest = float(self.medium.contact_constants.normal.max())
        limit = max(ALLOWED_PART * damping_limit(self.packing.lattice.slots, stiffest, whole, self.step_size), 0.0)
        if given > limit:
            expected = f"at most {limit:.3g}, the stability limit of dashpots with steps of {self.step_size:g} s"
            raise ParameterError(f"got {given:g}", expected=expected, hint="use a smaller step_size", at="contact_damping")

    def attach_state(self, block: Block) -> None:
        """Attach the arrays of the state."""
        super().attach_state(block)
        histories = self.medium.histories._replace(**{name: block[name] for name in self._histories})
        self.medium = self.medium._replace(histories=histories)
        self.losses = block["losses"]
        self.specimen = Specimen(self.medium, self.motion, self.scratch, self.losses)

    def reset_histories(self) -> None:
        """Link all pairs, and request a search for contacts before the first step."""
        self.medium.histories.weight[:] = self.body.links[FACE] > 0.0
        self.losses[TRAVEL] = NEVER_FOUND

    # -- steps ------------------------------------------------------------------------------------------------------

    def advance(self, tick: int, ticks: int) -> int:
        """Advance the motion by `ticks` steps from `tick` on, with the current loads and grips; return a status."""
        last, is_checked = tick + ticks, False
        while tick < last:
            step_limits = StepLimits(self.step_size, self.speed_limit, self.travel_limit)
            code, done = advance(self.specimen, self.inputs, self.contacts(), step_limits, tick, last - tick, is_checked)
            tick, is_checked = tick + done, code == BREAK
            if code == TOO_FAST:
                return TOO_FAST
            if code == SEARCH and (status := self.find_contacts()):
                return status
            if is_checked:
                self.update_links(tick)
        return 0

    @property
    def travel_limit(self) -> float:
        """Return the distance that the fastest automaton may move before the next search for contacts [m]."""
        return _MOST_TRAVEL * self.packing.diameter

    def update_links(self, tick: int) -> None:
        """Break the links that meet their criterion in the step `tick`, and form the links again that are due."""
        self._break_links(tick)
        if self.medium.law.linking_ticks:
            if tick % self.medium.law.linking_ticks == 0:
                self._relink_contacts(tick)
            if raise_link_weights(self.specimen, self.contacts(), tick, self.step_size, self._places):
                self._measure_links()

    def _break_links(self, tick: int) -> None:
        """Turn each link that meets its criterion into a contact, and record an event; ordered by automata and directions."""
        value, limit, cause = self._criterion_values()
        failing = np.flatnonzero((self.link_weights() == 1.0) & (value >= limit))
        if not len(failing):
            return
        failing = failing[np.lexsort((self._pairs[failing, 2], self._pairs[failing, 0]))]
        (first, second, q), known, count = self._pairs[failing].T, self._block.count("contacts"), len(failing)
        slots = np.where(first < second, q, q + len(self.body.normal))
        contacts = self.contacts(count)._replace(used=known + count)
        ends = np.minimum(first, second), np.maximum(first, second)
        contacts.pairs[known : contacts.used] = np.column_stack(np.broadcast_arrays(*ends, slots, tick))
        contacts.slid[known : contacts.used] = 0.0
        write_rest_distances(self.medium, self.motion, self.scratch, contacts, known)
        self._set_contact_count(contacts.used)
        # The weight of a link in the first step of its release: the mean of the values before and after the step.
        weight = 0.5 * (1.0 + max(0.0, 1.0 - 1 / self.medium.law.release))
        self.medium.histories.weight[q, self.place[first]] = weight
        self.medium.histories.weight[q, self.place[second] - self.body.layout.offset[q]] = weight
        self._add_events(tick, cause[failing], failing, value[failing], limit[failing])
        self._measure_links()

    def _measure_links(self) -> None:
        """Write the present strains, stresses and forces of all links."""
        write_current_fields(self.medium, self.motion, self.scratch, self.contacts()._replace(used=0))

    def _add_events(self, tick: int, *columns: npt.ArrayLike) -> None:
        """Append events to the state; for each the number of its kind, the link, the decisive value, and its limit."""
        rows = np.column_stack(np.broadcast_arrays(tick + 1, *columns))
        known = self._block.count("events")
        self._block.reserve_rows("events", len(rows))[known : known + len(rows)] = rows
        self._block.set_row_count("events", known + len(rows))

    def _relink_contacts(self, tick: int) -> None:
        contacts = self.contacts()
        least, pressure = self.medium.law.linking[0], np.zeros(contacts.used)
        write_linking_pressures(self.medium, self.motion, self.scratch.links, contacts, pressure)
        rows = np.flatnonzero(pressure >= least)
        if len(rows):
            contacts.pairs[rows, START] = -1 - tick
            links, kind = self._numbers[self._contact_links(contacts.pairs[rows])], len(self.event_kinds) - 1
            self._add_events(tick, kind, links, pressure[rows], least)

    def find_contacts(self) -> int:
        """Search again for pairs that may touch; return a status if automata are too far out or too fast."""
        reach, motion, place = (1.0 + SKIN) * self.packing.diameter, self.motion, self.place
        positions = self.packing.reference + motion[X : Y + 1, place].T
        fastest = norms(motion[VX : VY + 1, place].T).max()
        if not fastest <= self.speed_limit:
            return TOO_FAST
        if not is_within_search_range(positions, reach):
            return TOO_FAR
        pairs = find_pairs(
            positions,
            np.union1d(self.exposed_automata(), self._strained_automata()),
            reach,
            self.medium.contact_constants.period,
        )
        linked = self.packing.neighbours[pairs[:, 0]] == pairs[:, 1:]
        slots = np.where(linked.any(axis=1), linked.argmax(axis=1), -1)
        found = np.column_stack([pairs, slots, np.zeros(len(pairs), np.int64)])
        old, slid, rest = (self._block[name] for name in ("contacts", "slid", "rest"))
        weight = self._contact_weights(old)
        kept = (weight > 0.0) & (weight < 1.0)
        rows, slid, rest = merge_contacts((old, slid, rest), kept, found[self._contact_weights(found) < 1.0], self.count)
        self._set_contact_count(0)
        contacts = self.contacts(len(rows))
        contacts.pairs[: len(rows)], contacts.slid[: len(rows)], contacts.rest[: len(rows)] = rows, slid, rest
        self._set_contact_count(len(rows))
        self.losses[TRAVEL] = 0.5 * self.step_size * fastest
        return 0

    def _contact_links(self, contacts: IntArray) -> tuple[IntArray, IntArray]:
        """Return for each contact the direction of its link, and the place where the link begins, both of shape (k,)."""
        directions, slot = len(self.body.normal), contacts[:, SLOT]
        return slot % directions, self.place[np.where(slot < directions, contacts[:, FIRST], contacts[:, SECOND])]

    def _contact_weights(self, contacts: IntArray) -> FloatArray:
        """Return the weights of the links of contacts, 0 for pairs that were never linked, shape (k,)."""
        return np.where(contacts[:, SLOT] >= 0, self.medium.histories.weight[self._contact_links(contacts)], 0.0)

    def exposed_automata(self) -> IntArray:
        """Return the automata at a surface, i.e. with a free face or a broken link, shape (k,)."""
        return np.union1d(np.flatnonzero(self._surface), self._pairs[self.link_weights() < 1.0, :2].reshape(-1))

    def _strained_automata(self) -> IntArray:
        """Return the automata with a link strained so much that second neighbours could touch, shape (k,)."""
        forces = self.scratch.cells[: TORQUE + 1].copy()
        self._measure_links()
        # The copy is restored, because a coupled body still needs the forces of the last step for its next kick.
        self.scratch.cells[: TORQUE + 1] = forces
        eps, gamma = self.scratch.links[EPS : GAMMA + 1, *self._at]
        strained = ~((np.abs(eps) <= _STRAINED) & (np.abs(gamma) <= _STRAINED))
        return np.unique(self._pairs[strained, :2])

    def contact_stiffness(self) -> FloatArray:
        """Return for each automaton the normal stiffness of a contact between two automata like it, shape (n,) [N/m]."""
        return self.medium.contact_constants.part * self.medium.contact_constants.normal

    def contacts(self, spare_rows: int = 0) -> Contacts:
        """Return the `Contacts` of the state, with room for `spare_rows` more pairs."""
        pairs, slid, rest = (self._block.reserve_rows(name, spare_rows) for name in ("contacts", "slid", "rest"))
        if len(self._dashpot) < len(pairs):
            self._dashpot, self._push = np.zeros((len(pairs), 2)), np.zeros(len(pairs))
        return Contacts(pairs, slid, rest, self._dashpot, self._push, self._block.count("contacts"))

    def _set_contact_count(self, count: int) -> None:
        for name in ("contacts", "slid", "rest"):
            self._block.set_row_count(name, count)

    # -- readings ---------------------------------------------------------------------------------------------------

    def update_forces(self, *, at_start: bool = False) -> None:
        """Write strains, stresses, and the forces of links and contacts for the present motion.

        It also sets the rest distances of new contacts: in the state at the start of a coupled
        body, otherwise in copies, so that reading outputs does not change the state.
        """
        contacts = self.contacts()
        if not at_start:
            contacts = contacts._replace(slid=contacts.slid.copy(), rest=contacts.rest.copy(), dashpot=contacts.dashpot.copy())
        write_current_fields(self.medium, self.motion, self.scratch, contacts)

    def stress(self) -> FloatArray:
        """Return the stress of each automaton due to its links: xx, yy and xy, shape (n, 3) [Pa]."""
        self._measure_fields()
        return np.ascontiguousarray(self.scratch.cells[STRESS_XX:, self.place].T)

    def link_forces(self) -> FloatArray:
        """Return the force of each link, and of the contact of its pair, along the line of centres, shape (links,) [N]."""
        found, contacts = super().link_forces(), self._block["contacts"]
        of_links = contacts[:, SLOT] >= 0
        found[self._numbers[self._contact_links(contacts[of_links])]] += self._push[: len(contacts)][of_links]
        return found

    def link_weights(self) -> FloatArray:
        """Return the weight of each link: 1 for an intact link, 0 for a released one."""
        return self.medium.histories.weight[self._at]

    def broken_link_count(self) -> float:
        """Return the number of broken links."""
        return float(np.count_nonzero(self.link_weights() < 1.0))

    def criterion_ratio(self) -> FloatArray:
        """Return for each link the ratio of the quantity that its breaking criterion tests to the limit, shape (links,)."""
        return self._ratios_and_causes()[0]

    def nearest_event_kind(self, link: int) -> str:
        """Return the kind of event that a link is closest to."""
        return list(self.event_kinds)[self._ratios_and_causes()[1][link]]

    def can_break(self, link: int) -> bool:
        """Return whether a link can break: at least one of its two laws has a finite strength."""
        criterion = self.medium.law.criterion
        if not isinstance(criterion, WeakerLaw):
            return True
        direction, place = self._at
        rows = criterion.rows[direction[link] * self.body.layout.size + place[link]]
        return any(np.isfinite(criterion.laws[row][0]) for row in rows.tolist())

    def _ratios_and_causes(self) -> tuple[FloatArray, IntArray]:
        """Return for each link the ratio of its criterion's quantity to the limit, and the cause number, both (links,)."""
        self._measure_fields()
        value, limit, cause = self._criterion_values()
        held = self.link_weights() == 1.0
        ratio = np.maximum(np.divide(value, limit, out=np.zeros(len(held)), where=held), 0.0)
        return ratio, np.where(held, cause, 0.0).astype(np.int64)

    def _criterion_values(self) -> FloatArray:
        """Return for each link its criterion's quantity, the limit and the cause number, from the scratch, (3, links)."""
        found = np.zeros((3, *self.body.links.shape[1:]))
        write_criterion_values(self.medium, self.scratch, found)
        return found[:, *self._at]

    def break_events(self) -> FloatArray:
        """Return the events of broken links: tick, cause number, link, value and limit, shape (m, 5)."""
        events = self._block["events"]
        return events[events[:, 1] < len(self._parameters.leading_criterion.causes)]

    def linked_pairs(self) -> IntArray:
        """Return the pairs of linked automata, shape (m, 2)."""
        return self._pairs[self.link_weights() == 1.0, :2]

    def damage(self) -> FloatArray:
        """Return for each automaton the fraction of the area of its faces whose links are broken, shape (n,)."""
        return 1.0 - self._link_means(self.link_weights())

    def inelastic_strain(self) -> FloatArray:
        """Return for each automaton the mean accumulated inelastic strain of its links, shape (n,)."""
        return self._link_means(self.medium.histories.inelastic[self._at])

    def _link_means(self, values: FloatArray) -> FloatArray:
        """Average link values, shape (links,), over the links of each automaton, weighted by `Packing.share`; shape (n,)."""
        total, shares = np.zeros((2, self.count))
        for column, share in enumerate(self.body.links[FIRST_SHARE : SECOND_SHARE + 1, *self._at]):
            np.add.at(total, self._pairs[:, column], share * values)
            np.add.at(shares, self._pairs[:, column], share)
        return total / shares

    def pressed_contact_count(self) -> float:
        """Return the number of contacts under pressure."""
        self.load_motion()
        return float(np.count_nonzero(self._overlaps() > 0.0))

    def _overlaps(self) -> FloatArray:
        """Return the overlaps of active contacts, negative for separated automata [m]."""
        rows, constants = self._block["contacts"], self.medium.contact_constants
        (i, j), places = rows[:, FIRST : SECOND + 1].T, self.motion[X : Y + 1, self.place].T
        way = np.array(constants.unit) * (constants.places[j] - constants.places[i]) + (places[j] - places[i])
        for axis, period in enumerate(constants.period):
            way[:, axis] -= period * np.rint(way[:, axis] / period) if period > 0.0 else 0.0
        return (self._block["rest"] - norms(way))[self._contact_weights(rows) < 1.0]

    def field_energies(self, slip_time: float) -> dict[str, float]:
        """Return the energies stored at the present motion [J]; contacts have slid for `slip_time` since `slid` was set."""
        # Links only: the slip of contacts was updated with the last forces, `slip_time` before the present.
        self._measure_links()
        elastic, contact = stored_energies(self.medium, self.motion, self.scratch.links, self.contacts(), slip_time)
        return {"elastic_energy": float(elastic), "contact_energy": float(contact)}

    def report(self) -> dict[str, float]:
        """Return figures for the report: largest strains and inelastic strain, fraction of broken links, largest overlap."""
        found = super().report()
        overlap = float(self._overlaps().max(initial=0.0))
        found |= {
            "fraction of links that are broken": self.broken_link_count() / max(len(self._pairs), 1),
            "largest overlap of a contact now, in diameters": overlap / self.packing.diameter,
        }
        if self._parameters.can_yield:
            found["largest inelastic strain of a link"] = float(self.medium.histories.inelastic.max())
        return found

    def _largest_strain(self) -> float:
        h, held = self.medium.histories, self.medium.histories.weight == 1.0
        strains = self.scratch.links[EPS : GAMMA + 1] - np.stack([h.origin_eps, h.origin_gamma])
        return float(np.abs(strains[:, held]).max(initial=0.0))

    def dissipated_energies(self) -> dict[str, float]:
        """Return the energies dissipated since the reset, by name [J]."""
        return dict(zip(_LOSSES, self.losses[:TRAVEL].tolist(), strict=True))


def _refuse_double_links(packing: Packing) -> None:
    """Refuse a periodic packing so narrow that two automata are neighbours on both sides, i.e. have two common links."""
    ends = np.sort(packing.pairs()[:, :2], axis=1)
    if len(np.unique(ends, axis=0)) < len(ends):
        raise ParameterError(
            "two automata of this periodic body are neighbours on two sides",
            expected="a width of at least 3 diameters if links can break or join different materials",
            at="shape",
        )


def _regional_strengths(packing: Packing, parameters: AutomataParameters) -> FloatArray:
    """Return the factor by which strength regions multiply the strength of each pair, shape (n, slots / 2)."""
    half = packing.lattice.slots // 2
    middles = packing.reference[:, np.newaxis] + 0.5 * packing.diameter * packing.lattice.directions[:half]
    factors = np.ones(middles.shape[:2])
    for number, region in enumerate(parameters.strength_regions):
        inside = region.area.contains(middles.reshape(-1, 2)).reshape(factors.shape)
        if not inside.any():
            raise ParameterError(
                "contains no midpoint of a pair", hint="make it larger, or leave it out", at=("strength_regions", number)
            )
        factors[inside] = region.factor
    return factors


def _make_contact_constants(packing: Packing, body: Body, parameters: AutomataParameters) -> ContactConstants:
    lattice, diameter, p = packing.lattice, packing.diameter, parameters
    per_length = lattice.face * p.thickness
    share = lattice.face / (2.0 * lattice.volume)
    shear, lame = body.cells[SHEAR : LAME + 1, body.layout.place]
    left, right, low, high = p.shape.bounds
    period = np.array([right - left, high - low]) * np.array(p.periodic)
    return ContactConstants(
        places=packing.places,
        unit=tuple((lattice.unit * diameter).tolist()),
        period=tuple(period.tolist()),
        normal=per_length * (2.0 * shear + share * lame),
        tangential=per_length * 2.0 * shear,
        part=packing.volume / (lattice.volume * diameter**2),
        friction=p.friction,
        damping=p.contact_damping,
    )
