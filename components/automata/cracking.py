"""The steps and readings of a specimen whose links yield and break, and whose pieces touch."""

from __future__ import annotations

import numpy as np

from ..errors import ParameterError
from ..events import MOST_INDEX, EventDetail
from ..state_block import Block
from ..support.counter_random import uniform
from ..support.float_arrays import FloatArray, norms
from .breaking.criterion import Weaker
from .contacts import (
    FIRST,
    SECOND,
    SKIN,
    SLOT,
    Contacts,
    Ground,
    add_contact_forces,
    can_be_found,
    find_pairs,
    merge,
    pressing_contacts,
    slots_of_links,
    stored_energies,
)
from .energies import largest_link_strain
from .lattice import Body
from .linked import LinkedSpecimen
from .links import (
    Histories,
    Law,
    Medium,
    criterion_ratios,
    find_failing,
    make_mixture,
    make_tractions,
    measure_medium,
)
from .materials import IntArray, chosen_materials, law_rows, make_criterion, make_response
from .packing import Packing
from .pair import measure_pairs
from .parameters import AutomataParameters
from .release import LOSSES, NEVER_FOUND, TRAVEL, break_links
from .stability import ALLOWED_PART, damping_limit
from .ticks import BREAK, SEARCH, TOO_FAST, Pace, Specimen, advance
from .welding import count_linkable, link_contacts, make_neighbourhood, raise_weights

# Status of `advance` in addition to that of an automaton that is too fast.
TOO_FAR = 2
# Distance that the fastest automaton may move before contacts are found again, in diameters.
_MOST_TRAVEL = 0.5 * SKIN
# The search includes automata inside a body with a link that is strained by more. Below that, second neighbours are at least
# 2 (1 - 0.05) sin(45 degrees - 0.05) = 1.28 diameters apart, and the next search follows before they have met.
_STRAINED = 0.05
# Parts of the state of each link that flows, and of one that may be made again.
_FLOWING = "plastic_eps", "plastic_gamma", "stiffness", "inelastic"
_WELDED = "origin_eps", "origin_gamma"
# Entries of `losses` in the state, in order.
_LOSSES = "fracture_energy", "friction_energy", "inelastic_energy", "damping_energy", "linking_energy"


def intact_medium(packing: Packing, body: Body, parameters: AutomataParameters, numbers: IntArray) -> Medium:
    """Return the medium of a specimen all of whose links hold; `numbers` are those of the material of each automaton."""
    p, layout = parameters, body.layout
    directions = len(layout.offset)
    histories = Histories(*(np.zeros(body.face.shape) for _ in Histories._fields))
    histories.weight[body.face > 0.0] = 1.0
    spread = p.strength_scatter * (2.0 * uniform(p.strength_seed, 1, len(numbers) * directions).reshape(-1, directions) - 1.0)
    strengths = (1.0 + spread) * _regional_strengths(packing, p)
    factors = np.ones(body.face.shape)
    for q in range(directions):
        factors[q, layout.place[packing.neighbours[:, q]] - layout.offset[q]] = strengths[:, q]
        factors[q, layout.place] = strengths[:, q]
    rows = law_rows(p, numbers, packing, layout)
    law = Law(
        make_response(p, rows), make_criterion(p, rows), factors, p.release_ticks, np.array(p.relinking.constants()),
        p.release_ticks if p.relinking.kinds else 0,
    )  # fmt: skip
    ground = _make_ground(packing, body, p)
    return Medium(body, histories, make_mixture(body, p.several_materials), make_tractions(body), law, ground)


class CrackingSpecimen(LinkedSpecimen):
    """A specimen with histories: links that weaken, yield and break, contacts that rub."""

    def prepare(self, parameters: AutomataParameters, medium: Medium) -> None:
        """Take the parameters and the intact medium."""
        p, n, field = parameters, self.count, ("f8", self.body.face.shape)
        self._parameters, self.medium, criterion = p, medium, p.leading_criterion
        _refuse_double_links(self.packing)
        self.event_kinds = {**criterion.causes, **p.relinking.kinds}
        broken, linked = EventDetail(criterion.unit, "links", "criterion_ratio"), EventDetail("Pa", "links")
        self.event_details = dict.fromkeys(criterion.causes, broken) | dict.fromkeys(p.relinking.kinds, linked)
        self._histories = ("weight", *(_FLOWING if p.yields else ()), *(_WELDED if p.relinking.kinds else ()))
        self.fields = {**dict.fromkeys(self._histories, field), "weight": (*field, 0.0, 1.0), "losses": ("f8", (LOSSES,))}
        last = (n - 1, n - 1, 2 * len(self.body.face) - 1, MOST_INDEX)
        self.growing = {
            "contacts": ("i8", (4,), (0, 0, -1, -MOST_INDEX), last, n * (n - 1) // 2), "slid": ("f8", ()), "rest": ("f8", ()),
        }  # fmt: skip
        self._dashpot = np.zeros((0, 2))
        self._near = make_neighbourhood(self.packing.neighbours)
        self._refuse_damping(p)
        directions = len(self.body.face)
        self._link_places = self.place[self._pairs[:, 0]]
        self._numbers = np.zeros(self.body.face.shape, np.int64)
        for q in range(directions):
            own = np.flatnonzero(self._pairs[:, 2] == q)
            self._numbers[q, self.place[self._pairs[own, 1]] - self.body.layout.offset[q]] = own
            self._numbers[q, self._link_places[own]] = own
        faces = self.packing.classes.face[self.packing.kind]
        self._surface = (faces == 0.0).any(axis=1)

    def _refuse_damping(self, parameters: AutomataParameters) -> None:
        """Refuse dashpots that are not stable with this step."""
        given = parameters.contact_damping
        # Of several materials the stiffest contact with the lightest whole automaton: on the safe side.
        whole = min(solid.density for solid in chosen_materials(parameters)) * float(self.body.volume[self.place].max())
        limit = ALLOWED_PART * damping_limit(
            self.packing.lattice.slots, float(self.medium.ground.normal.max()), whole, self.step_size
        )
        if given > limit:
            raise ParameterError(
                f"got {given:g}",
                expected=(
                    f"at most {max(limit, 0.0):.3g} with steps of {self.step_size:g} s, beyond which dashpots are not stable"
                ),
                hint="use a smaller step_size",
                at="contact_damping",
            )

    def bind(self, block: Block) -> None:
        """Take the state."""
        super().bind(block)
        histories = self.medium.histories._replace(**{name: block[name] for name in self._histories})
        self.medium = self.medium._replace(histories=histories)
        self.losses = block["losses"]
        self.specimen = Specimen(self.medium, self.motion, self.scratch, self.losses)

    def start(self) -> None:
        """Link all pairs, and have contacts found before the first step."""
        self.medium.histories.weight[:] = self.body.face > 0.0
        self.losses[TRAVEL] = NEVER_FOUND

    # -- steps ------------------------------------------------------------------------------------------------------

    def advance(self, tick: int, ticks: int) -> int:
        """Advance the fields from a tick with the loads and velocities that the conditions have now; return a status."""
        last, judged = tick + ticks, False
        while tick < last:
            pace = Pace(self.step_size, self.speed_limit, self.most_travel)
            code, done = advance(self.specimen, self.inputs, self.contacts(), pace, tick, last - tick, judged)
            tick, judged = tick + done, code == BREAK
            if code == TOO_FAST:
                return TOO_FAST
            if code == SEARCH and (status := self.find_contacts()):
                return status
            if judged:
                self.change_links(tick)
        return 0

    @property
    def most_travel(self) -> float:
        """Return how far the fastest automaton may move before contacts are found again [m]."""
        return _MOST_TRAVEL * self.packing.diameter

    def change_links(self, tick: int) -> None:
        """Break the links whose criterion is met, and make links again whose time it is, in the step of that number."""
        failing = int(find_failing(self.medium, self.scratch))
        if failing:
            known = self._block.count("events")
            events = self._block.room("events", failing)[known:]
            contacts = self.contacts(failing)
            broken = break_links(
                self.medium, self.motion, self.scratch, self._pairs, self._numbers, contacts, events, tick
            )  # fmt: skip
            self._set_count(self._block.count("contacts") + broken)
            self._block.set_count("events", known + broken)
        if self.medium.law.linking_ticks:
            if tick % self.medium.law.linking_ticks == 0:
                self._link_contacts(tick)
            raise_weights(self.specimen, self.contacts(), tick, self.step_size, self._near)

    def _link_contacts(self, tick: int) -> None:
        contacts, known = self.contacts(), self._block.count("events")
        linkable = int(count_linkable(self.medium, self.motion, self.scratch, contacts))
        if linkable:
            events, kind = self._block.room("events", linkable), len(self.event_kinds) - 1
            link_contacts(self.medium, self.motion, self.scratch, self._numbers, contacts, kind, events[known:], tick)
            self._block.set_count("events", known + linkable)

    def find_contacts(self) -> int:
        """Find again which pairs may touch; a status where automata are too far out or too fast."""
        reach, motion, place = (1.0 + SKIN) * self.packing.diameter, self.motion, self.place
        positions = self.packing.reference + np.stack([motion.x[place], motion.y[place]], axis=1)
        fastest = norms(np.stack([motion.vx[place], motion.vy[place]], axis=1)).max()
        if not fastest <= self.speed_limit:
            return TOO_FAST
        if not can_be_found(positions, reach):
            return TOO_FAR
        period = tuple(self.medium.ground.period.tolist())
        pairs = find_pairs(positions, np.union1d(self.exposed(), self._strained()), reach, period)
        slots = np.empty(len(pairs), np.int64)
        slots_of_links(self.body.layout, self.medium.histories.weight, self.packing.neighbours, pairs, slots)
        old, slid, rest = (self._block[name] for name in ("contacts", "slid", "rest"))
        weight = self._weights_of(old)
        rows, slid, rest = merge(old, slid, rest, pairs, slots, (weight > 0.0) & (weight < 1.0), self.count)
        self._set_count(0)
        contacts = self.contacts(len(rows))
        contacts.pairs[: len(rows)], contacts.slid[: len(rows)], contacts.rest[: len(rows)] = rows, slid, rest
        self._set_count(len(rows))
        self.losses[TRAVEL] = 0.5 * self.step_size * fastest
        return 0

    def _weights_of(self, contacts: IntArray) -> FloatArray:
        """Return the weights of the links of contacts, 0 of those that never were linked; shape (k,)."""
        directions, slot = len(self.body.face), contacts[:, SLOT]
        first = self.place[np.where(slot < directions, contacts[:, FIRST], contacts[:, SECOND])]
        return np.where(slot >= 0, self.medium.histories.weight[slot % directions, first], 0.0)

    def exposed(self) -> IntArray:
        """Return the automata that have a free face or a broken link, shape (k,)."""
        broken = self._pairs[self.linked() < 1.0, :2]
        return np.union1d(np.flatnonzero(self._surface), broken.reshape(-1))

    def _strained(self) -> IntArray:
        """Return the automata that have a strained link, shape (k,)."""
        measure_pairs(self.body, self.motion, self.scratch)
        direction, links = self._pairs[:, 2], self.scratch.links
        eps, gamma = links.eps[direction, self._link_places], links.gamma[direction, self._link_places]
        strained = ~((np.abs(eps) <= _STRAINED) & (np.abs(gamma) <= _STRAINED))
        return np.unique(self._pairs[strained, :2])

    def contact_stiffness(self) -> FloatArray:
        """Return the stiffness of a contact of each automaton along the line of centres, shape (n,) [N/m]."""
        return self.medium.ground.part * self.medium.ground.normal

    def contacts(self, more: int = 0) -> Contacts:
        """Return the lists of contacts, with room for more of them."""
        pairs, slid, rest = (self._block.room(name, more) for name in ("contacts", "slid", "rest"))
        if len(self._dashpot) < len(pairs):
            self._dashpot = np.zeros((len(pairs), 2))
        return Contacts(pairs, slid, rest, self._dashpot, self._block.count("contacts"))

    def _set_count(self, count: int) -> None:
        for name in ("contacts", "slid", "rest"):
            self._block.set_count(name, count)

    # -- readings ---------------------------------------------------------------------------------------------------

    def update_forces(self) -> None:
        """Write strains, stresses, and the forces of links and contacts of the present fields, for readings."""
        measure_medium(self.medium, self.motion, self.scratch)
        # Contacts slide and find their rest where forces are added: here only copies of them.
        contacts = self.contacts()
        copies = contacts._replace(slid=contacts.slid.copy(), rest=contacts.rest.copy(), dashpot=contacts.dashpot.copy())
        add_contact_forces(self.medium, self.motion, copies, self.scratch.forces)

    def stress(self) -> FloatArray:
        """Return the stresses that the links of the automata carry, shape (n, 3) [Pa]."""
        self._measure()
        return np.ascontiguousarray(self.medium.tractions.stress[:, self.place].T)

    def linked(self) -> FloatArray:
        """Return the weight of each link: 1 while it holds, 0 when it is released."""
        return self.medium.histories.weight[self._pairs[:, 2], self._link_places]

    def broken_links(self) -> float:
        """Return how many links are broken."""
        return float(np.count_nonzero(self.linked() < 1.0))

    def criterion_ratio(self) -> FloatArray:
        """Return how near each link is to breaking: what decides over its limit, shape (links,)."""
        return self._judge_links()[0]

    def nearest_cause(self, link: int) -> str:
        """Return the kind of event that a link is nearest to."""
        return list(self.event_kinds)[self._judge_links()[1][link]]

    def can_break(self, link: int) -> bool:
        """Return whether one of the two laws of a link has a strength: that of what cannot break has no end."""
        criterion = self.medium.law.criterion
        if not isinstance(criterion, Weaker):
            return True
        direction, place = self._pairs[link, 2], self._link_places[link]
        rows = criterion.rows[direction * self.body.layout.size + place]
        return any(np.isfinite(criterion.laws[row][0]) for row in rows.tolist())

    def _judge_links(self) -> tuple[FloatArray, IntArray]:
        """Return what decides on each link over its limit, and the number of the cause, both of shape (links,)."""
        self._measure()
        found, cause = np.empty(len(self._pairs)), np.empty(len(self._pairs), np.int64)
        direction = np.ascontiguousarray(self._pairs[:, 2])
        criterion_ratios(self.medium, self.scratch, direction, self._link_places, found, cause)
        return found, cause

    def breaks(self) -> FloatArray:
        """Return the events of links that broke: tick, number of the cause, link, value and limit, shape (m, 5)."""
        events = self._block["events"]
        return events[events[:, 1] < len(self._parameters.leading_criterion.causes)]

    def held_pairs(self) -> IntArray:
        """Return the automata that links hold together, shape (m, 2)."""
        return self._pairs[self.linked() == 1.0, :2]

    def damage(self) -> FloatArray:
        """Return what part of the faces of each automaton is broken, shape (n,)."""
        return 1.0 - self._mean_of_links(self.linked())

    def inelastic(self) -> FloatArray:
        """Return the mean inelastic strain of the pairs of each automaton, shape (n,)."""
        return self._mean_of_links(self.medium.histories.inelastic[self._pairs[:, 2], self._link_places])

    def _mean_of_links(self, values: FloatArray) -> FloatArray:
        """Return the means of values of links, shape (links,), over the links of each automaton by their shares, shape (n,)."""
        total, shares = np.zeros((2, self.count))
        q, p = self._pairs[:, 2], self._link_places
        for column, share in enumerate((self.body.first_share[q, p], self.body.second_share[q, p])):
            np.add.at(total, self._pairs[:, column], share * values)
            np.add.at(shares, self._pairs[:, column], share)
        return total / shares

    def touching(self) -> float:
        """Return how many contacts press."""
        self.load()
        return float(pressing_contacts(self.medium, self.motion, self.contacts())[0])

    def energies(self, since: float) -> dict[str, float]:
        """Return the energies that the present fields store with the histories as they are [J]."""
        # Contacts were let slide when the forces were computed.
        elastic, contact = stored_energies(self.medium, self.motion, self.scratch, self.contacts(), since)
        return {"elastic_energy": float(elastic), "contact_energy": float(contact)}

    def report(self) -> dict[str, float]:
        """Return how far links are strained and have flowed, how much is broken, and how far contacts overlap."""
        found = super().report()
        overlap = float(pressing_contacts(self.medium, self.motion, self.contacts())[1])
        found |= {
            "part of the links that is broken": self.broken_links() / max(len(self._pairs), 1),
            "largest overlap of a contact now over the diameter": overlap / self.packing.diameter,
        }
        if self._parameters.yields:
            found["largest inelastic strain of a link"] = float(self.medium.histories.inelastic.max())
        return found

    def _largest_strain(self) -> float:
        return float(largest_link_strain(self.medium, self.scratch))

    def lost(self) -> dict[str, float]:
        """Return the energies that were lost [J]."""
        return dict(zip(_LOSSES, self.losses[:TRAVEL].tolist(), strict=True))


def _refuse_double_links(packing: Packing) -> None:
    """Refuse a closed packing so narrow that two automata are neighbours twice."""
    ends = np.sort(packing.pairs()[:, :2], axis=1)
    if len(np.unique(ends, axis=0)) < len(ends):
        raise ParameterError(
            "two automata of this periodic specimen are neighbours on two sides",
            expected="at least 3 diameters across where links may break, or join several materials",
            at="shape",
        )


def _regional_strengths(packing: Packing, parameters: AutomataParameters) -> FloatArray:
    """Return the factor of the strength of each pair that its region has, shape (n, slots / 2)."""
    half = packing.lattice.slots // 2
    middles = packing.reference[:, np.newaxis] + 0.5 * packing.diameter * packing.lattice.directions[:half]
    factors = np.ones(middles.shape[:2])
    for number, region in enumerate(parameters.strength_regions):
        inside = region.area.contains(middles.reshape(-1, 2)).reshape(factors.shape)
        if not inside.any():
            raise ParameterError(
                "contains the middle of no pair", hint="make it larger, or leave it out", at=("strength_regions", number)
            )
        factors[inside] = region.factor
    return factors


def _make_ground(packing: Packing, body: Body, parameters: AutomataParameters) -> Ground:
    lattice, diameter, p = packing.lattice, packing.diameter, parameters
    per_length = lattice.face * p.thickness
    share = lattice.face / (2.0 * lattice.volume)
    shear, lame = body.shear[body.layout.place], body.lame[body.layout.place]
    left, right, low, high = p.shape.bounds
    period = np.array([right - left, high - low]) * np.array(p.periodic)
    return Ground(
        places=packing.places,
        unit=lattice.unit * diameter,
        period=period,
        normal=per_length * (2.0 * shear + share * lame),
        tangential=per_length * 2.0 * shear,
        part=packing.classes.volume[packing.kind] / (lattice.volume * diameter**2),
        friction=p.friction,
        damping=p.contact_damping,
    )
