"""The steps and readings of a specimen whose links yield and break, and whose pieces touch."""

from __future__ import annotations

import numpy as np

from ..errors import ParameterError
from ..events import MOST_INDEX, EventDetail
from ..state_block import Block
from ..support.counter_random import uniform
from ..support.float_arrays import FloatArray, norms
from . import cracking_steps
from .breaking import CRITERIA
from .breaking.dispatch import KNOWN
from .contact import (
    FIRST,
    SLOT,
    Contacts,
    Ground,
    add_contact_forces,
    all_contact_energy,
    count_touching,
    largest_overlap,
)
from .cracking_steps import Inputs, Judgement, Medium, Pace, Specimen
from .drift_work import make_neighbourhood
from .inelastic_links import Law, bond_energy, criterion_ratios, measure_bonds, update_bond_forces
from .kernel_arrays import Body, Motion
from .link_formation import count_linkable, link_contacts, raise_weights
from .link_histories import Bonds, largest_bond_strain
from .link_release import LOSSES, NEVER_FOUND, TRAVEL
from .linked_specimen import LinkedSpecimen
from .material_mixture import Mixture
from .material_tables import IntArray, chosen_materials, law_rows, law_tables
from .neighbours import SKIN, can_be_found, find_pairs, merge, slots_of_links
from .packing import Packing
from .pair import mark_strained, orient
from .parameters import AutomataParameters
from .rupture import break_bonds
from .stability import ALLOWED_PART, damping_limit

# Status of `advance` beside that of an automaton that is too fast.
TOO_FAR = 2
# So far may the fastest automaton move before contacts are found anew, in diameters.
_MOST_TRAVEL = 0.5 * SKIN
# The search includes automata inside a body with a link that is strained by more. Below that, second neighbours are at least
# 2 (1 - 0.05) sin(45 degrees - 0.05) = 1.28 diameters apart, and the next search follows before they have met.
_STRAINED = 0.05
# Parts of the state of each link.
_HISTORIES = "weight", "plastic", "stiffness", "inelastic", "origin"
# What `losses` of the state hold, in its order.
_LOSSES = "fracture_energy", "friction_energy", "inelastic_energy", "damping_energy", "linking_energy"


class CrackingSpecimen(LinkedSpecimen):
    """A specimen with histories: links that weaken, yield and break, contacts that rub."""

    def _prepare_sweeps(self) -> None:
        """Make nothing: sweeps know no histories."""

    def prepare(self, parameters: AutomataParameters, mixture: Mixture, numbers: IntArray) -> None:
        """Make the laws and the scratch, from the parameters, the moduli, and the number of each automaton's material."""
        p, n, slots = parameters, self.count, self.packing.lattice.slots
        self._parameters, self._materials = p, numbers
        self._mixture, criterion = mixture, p.leading_criterion
        _refuse_double_links(self.packing)
        if criterion.code not in KNOWN:
            raise ParameterError(
                f"no kernel judges {criterion.name!r}", expected=f"one of {', '.join(CRITERIA)}",
                hint="a new criterion needs a line in `automata.breaking.dispatch` too", at="criterion",
            )  # fmt: skip
        self.event_kinds = {**criterion.causes, **p.relinking.kinds}
        broken, linked = EventDetail(criterion.unit, "links", "criterion_ratio"), EventDetail("Pa", "links")
        self.event_details = dict.fromkeys(criterion.causes, broken) | dict.fromkeys(p.relinking.kinds, linked)
        self.fields = {
            "weight": ("f8", (n, slots)), "plastic": ("f8", (n, slots, 2)), "stiffness": ("f8", (n, slots)),
            "inelastic": ("f8", (n, slots)), "origin": ("f8", (n, slots, 2) if p.relinking.kinds else (0, slots)),
            "losses": ("f8", (LOSSES,)),
        }  # fmt: skip
        last = (n - 1, n - 1, slots - 1, MOST_INDEX)
        self.growing = {
            "contacts": ("i8", (4,), (0, 0, -1, -MOST_INDEX), last, n * (n - 1) // 2), "slid": ("f8", ()), "rest": ("f8", ()),
        }  # fmt: skip
        self._dashpot = np.zeros((0, 2))
        self._near = make_neighbourhood(slots)
        half = slots // 2
        spread = p.strength_scatter * (2.0 * uniform(p.strength_seed, 1, n * half).reshape(n, half) - 1.0)
        response, strength, rows = _make_laws(p, numbers, self.packing)
        self._law = Law(
            not p.yields, response, criterion.code, strength, rows, (1.0 + spread) * _regional_strengths(self.packing, p),
            p.release_ticks,
            np.array(p.relinking.constants()), p.release_ticks if p.relinking.kinds else 0,
        )  # fmt: skip
        self._ground = _make_ground(self.packing, self.body, p, mixture)
        self._refuse_damping(p)
        self.judgement = Judgement(np.zeros((n, 3)), np.zeros((n, half)))
        self._pairs = self.packing.pairs()
        self._numbers = np.zeros((n, half), np.int64)
        self._numbers[self._pairs[:, 0], self._pairs[:, 2]] = np.arange(len(self._pairs))
        self._surface = (self.body.face[self.body.kind] == 0.0).any(axis=1)

    def _refuse_damping(self, parameters: AutomataParameters) -> None:
        """Refuse dashpots that the step does not bear."""
        given = parameters.contact_damping
        # Of several materials the stiffest contact with the lightest whole automaton: on the safe side.
        whole = min(solid.density for solid in chosen_materials(parameters)) * float(self.body.volume.max())
        limit = ALLOWED_PART * damping_limit(
            self.packing.lattice.slots, float(self._ground.normal.max()), whole, self.step_size
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
        self._block, self.losses = block, block["losses"]
        self._make_medium()

    def _make_medium(self) -> None:
        histories = {name: self._block[name] for name in _HISTORIES}
        bonds = Bonds(**histories, mixture=self._mixture)
        self.medium = Medium(self.body, self._ground, bonds, self._law)

    def start(self) -> None:
        """Link all pairs, and have contacts found before the first step."""
        self._block["weight"][:] = 1.0
        self.losses[TRAVEL] = NEVER_FOUND

    # -- steps ------------------------------------------------------------------------------------------------------

    def advance(self, tick: int, ticks: int) -> int:
        """Advance from a tick with the loads and velocities that the conditions have now; 0, or a status."""
        last, judged = tick + ticks, False
        while tick < last:
            code, done = self._run(tick, last - tick, judged)
            tick, judged = tick + done, code == cracking_steps.BREAK
            if code == cracking_steps.TOO_FAST:
                return cracking_steps.TOO_FAST
            if code == cracking_steps.SEARCH:
                status = self.find_contacts()
                if status:
                    return status
            if judged:
                self.change_links(tick)
        return 0

    def _run(self, tick: int, ticks: int, judged: bool) -> tuple[int, int]:
        edge = self.conditions
        specimen = Specimen(self.medium, self.packing.reference, self.motion, self.scratch, self.judgement, self.losses)
        inputs = Inputs(edge.load, edge.load_before, edge.grip, edge.grip_before, self.tallies)
        pace = Pace(self.step_size, self.speed_limit, self.most_travel)
        return cracking_steps.advance(specimen, inputs, self.contacts(), self.count_contacts(), pace, tick, ticks, judged)

    @property
    def most_travel(self) -> float:
        """Return how far the fastest automaton may move before contacts are found anew [m]."""
        return _MOST_TRAVEL * self.packing.diameter

    def change_links(self, tick: int) -> None:
        """Break the links that are marked, and make anew those whose time it is, in the internal step of that number."""
        marked = int(np.count_nonzero(self.judgement.mark))
        if marked:
            self._break_links(marked, tick)
        if self._law.linking_ticks:
            if tick % self._law.linking_ticks == 0:
                self._link_contacts(tick)
            contacts, count = self.contacts(), self.count_contacts()
            raise_weights(
                self.medium, self.motion, self.scratch, contacts, count, self.losses, tick, self.step_size, self._near
            )

    def _break_links(self, marked: int, tick: int) -> None:
        contacts, events = self.contacts(marked), self._block.room("events", marked)
        count, known = break_bonds(
            self.medium, self.motion, self.scratch, self.judgement, self._numbers, contacts, self.count_contacts(), events,
            self._block.count("events"), tick,
        )  # fmt: skip
        self._set_count(count)
        self._block.set_count("events", known)

    def _link_contacts(self, tick: int) -> None:
        contacts, count = self.contacts(), self.count_contacts()
        linkable = int(count_linkable(self.medium, self.motion, self.scratch.half, contacts, count))
        if linkable:
            events, kind = self._block.room("events", linkable), len(self.event_kinds) - 1
            known = link_contacts(
                self.medium, self.motion, self.scratch.half, self._numbers, contacts, count, kind, events,
                self._block.count("events"), tick,
            )  # fmt: skip
            self._block.set_count("events", known)

    def find_contacts(self) -> int:
        """Find anew which pairs may touch; a status where automata are too far out or too fast."""
        reach = (1.0 + SKIN) * self.packing.diameter
        positions = self.packing.reference + self.motion.displacement
        fastest = norms(self.motion.velocity).max()
        if not fastest <= self.speed_limit:
            return cracking_steps.TOO_FAST
        if not can_be_found(positions, reach):
            return TOO_FAR
        weight = self._block["weight"]
        pairs = find_pairs(positions, np.union1d(self.exposed(), self._strained()), reach, tuple(self._ground.period.tolist()))
        slots = np.empty(len(pairs), np.int64)
        slots_of_links(self.body.neighbours, weight, pairs, slots)
        old, slid, rest = (self._block[name] for name in ("contacts", "slid", "rest"))
        held = np.where(old[:, SLOT] >= 0, weight[old[:, FIRST], old[:, SLOT]], 0.0)
        rows, slid, rest = merge(old, slid, rest, pairs, slots, (held > 0.0) & (held < 1.0), self.count)
        self._set_count(0)
        contacts = self.contacts(len(rows))
        contacts.pairs[: len(rows)], contacts.slid[: len(rows)], contacts.rest[: len(rows)] = rows, slid, rest
        self._set_count(len(rows))
        self.losses[TRAVEL] = 0.5 * self.step_size * fastest
        return 0

    def exposed(self) -> IntArray:
        """Return the automata that have a free face or a broken link, shape (k,)."""
        return np.flatnonzero(self._surface | (self._block["weight"] < 1.0).any(axis=1))

    def _strained(self) -> IntArray:
        """Return the automata that have a strained link, shape (k,)."""
        found, half = np.zeros(self.count, bool), self.scratch.half
        orient(self.motion.rotation, half, 0, self.count)
        mark_strained(self.body, self.motion.displacement, half, _STRAINED, found)
        return np.flatnonzero(found)

    def contact_stiffness(self) -> FloatArray:
        """Return the stiffness of a contact of each automaton along the line of centres, shape (n,) [N/m]."""
        return self._ground.part * self._ground.normal

    def contacts(self, more: int = 0) -> Contacts:
        """Return the lists of contacts, with room for so many more."""
        pairs, slid, rest = (self._block.room(name, more) for name in ("contacts", "slid", "rest"))
        if len(self._dashpot) < len(pairs):
            self._dashpot = np.zeros((len(pairs), 2))
        return Contacts(pairs, slid, rest, self._dashpot)

    def count_contacts(self) -> int:
        """Return how many contacts there are."""
        return self._block.count("contacts")

    def _set_count(self, count: int) -> None:
        for name in ("contacts", "slid", "rest"):
            self._block.set_count(name, count)

    # -- readings ---------------------------------------------------------------------------------------------------

    def dilation(self) -> FloatArray:
        """Compute the rotations and volumetric strains of the present state; return the strains, in the scratch."""
        self.stress()
        return self.scratch.dilation

    def forces(self) -> FloatArray:
        """Return the forces of links and contacts in the present state, shape (n, 2) [N]."""
        scratch, contacts, count = self.scratch, self.contacts(), self.count_contacts()
        update_bond_forces(self.body, self.medium.bonds, self.motion, scratch)
        # Contacts slide and find their rest where forces are added: here only copies of them.
        shown = Contacts(contacts.pairs, contacts.slid.copy(), contacts.rest.copy(), np.zeros_like(contacts.dashpot))
        add_contact_forces(self.medium, self.motion, shown, count, scratch.force, scratch.torque)
        return scratch.force

    def stress(self) -> FloatArray:
        """Return the stresses that the links of the automata carry, shape (n, 3) [Pa]."""
        found = np.empty((self.count, 3))
        measure_bonds(self.body, self.medium.bonds, self.motion, self.scratch, found)
        return found

    def linked(self) -> FloatArray:
        """Return the weight of each link: 1 while it holds, 0 when it is released."""
        return self._block["weight"][self._pairs[:, 0], self._pairs[:, 2]]

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
        strength, rows = self._law.strength, self._law.rows
        if strength.ndim == 1:
            return True
        automaton, _, slot = self._pairs[link]
        return bool(np.isfinite(strength[rows[automaton, slot], 0]).any())

    def _judge_links(self) -> tuple[FloatArray, IntArray]:
        """Return what decides on each link over its limit, and the number of the cause, both of shape (links,)."""
        stress, found, cause = self.stress(), np.empty(len(self._pairs)), np.empty(len(self._pairs), np.int64)
        u, scratch = self.motion.displacement, self.scratch
        criterion_ratios(
            self.body, self.medium.bonds, self._law, u, scratch.half, scratch.dilation, stress, self._pairs, found, cause
        )
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
        share = self.body.share[self.body.kind]
        return 1.0 - (share * self._block["weight"]).sum(axis=1) / share.sum(axis=1)

    def inelastic(self) -> FloatArray:
        """Return the mean inelastic strain of the pairs of each automaton, shape (n,)."""
        share = self.body.share[self.body.kind]
        return (share * self._block["inelastic"]).sum(axis=1) / share.sum(axis=1)

    def touching(self) -> float:
        """Return how many contacts press."""
        contacts = self.contacts()
        return float(count_touching(self._ground, self.medium.bonds, self.motion, contacts, self.count_contacts()))

    def _energies(self, motion: Motion, since: float) -> dict[str, float]:
        """Return the energies that a motion stores with the histories as they are [J]; its rotations stay in the scratch."""
        bonds, half = self.medium.bonds, self.scratch.half
        orient(motion.rotation, half, 0, self.count)
        elastic = bond_energy(self.body, bonds, motion.displacement, half)
        # Contacts were let slide when the forces were computed.
        contact = all_contact_energy(self._ground, bonds, motion, self.contacts(), self.count_contacts(), since)
        return {"elastic_energy": elastic, "contact_energy": contact}

    def report(self) -> dict[str, float]:
        """Return how far links are strained and have flowed, how much is broken, and how far contacts overlap."""
        found = {
            **super().report(),
            "part of the links that is broken": self.broken_links() / max(self._links, 1),
            "largest overlap of a contact now over the diameter": self._largest_overlap() / self.packing.diameter,
        }
        if self._parameters.yields:
            found["largest inelastic strain of a link"] = float(self._block["inelastic"].max())
        return found

    def _largest_strain(self) -> float:
        u, half = self.motion.displacement, self.scratch.half
        orient(self.motion.rotation, half, 0, self.count)
        return float(largest_bond_strain(self.body, self.medium.bonds, u, half))

    def _largest_overlap(self) -> float:
        contacts, count = self.contacts(), self.count_contacts()
        return float(largest_overlap(self._ground, self.medium.bonds, self.motion, contacts, count))

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


def _make_laws(parameters: AutomataParameters, numbers: IntArray, packing: Packing) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return response, strength and rows of a `Law`."""
    if not parameters.several_materials:
        none = np.zeros(0, np.int64)
        return np.array(parameters.responses[0].constants()), np.array(parameters.criteria[0].constants()), none
    response, strength, rows = law_tables(parameters)
    return response, strength, law_rows(rows, numbers, packing)


def _make_ground(packing: Packing, body: Body, parameters: AutomataParameters, mixture: Mixture) -> Ground:
    lattice, diameter, p = packing.lattice, packing.diameter, parameters
    per_length = lattice.face * p.thickness
    share = lattice.face / (2.0 * lattice.volume)
    shear, lame = mixture.moduli.T if p.several_materials else (body.shear, body.lame)
    left, right, low, high = p.shape.bounds
    period = np.array([right - left, high - low]) * np.array(p.periodic)
    return Ground(
        places=packing.places,
        unit=lattice.unit * diameter,
        period=period,
        normal=np.array(per_length * (2.0 * shear + share * lame)),
        tangential=np.array(per_length * 2.0 * shear),
        part=packing.classes.volume[packing.kind] / (lattice.volume * diameter**2),
        friction=p.friction,
        damping=p.contact_damping,
    )
