"""Movable cellular automata as a component."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

import numpy as np

from ..balances import Balance
from ..component import Component
from ..drawables import Drawable, Links, Points
from ..errors import ParameterError, StepError
from ..materials.elastic import Material
from ..profiles import CompiledProfile
from ..support.float_arrays import FloatArray, norms, ordered_sum
from ..support.round_numbers import round_down_to_125
from ..variables import Variable
from . import linked_specimen, loads
from .conclusions import describe_links, describe_pieces
from .contacts import empty_contacts
from .cracking_specimen import TOO_FAR, CrackingSpecimen, intact_medium
from .edge_conditions import Conditions
from .kernels import write_current_fields
from .lattice import MASS, Body, make_body
from .linked_specimen import LinkedSpecimen
from .materials import chosen_materials, lame_constants, material_numbers
from .packing import LATTICES, Packing, pack_shape
from .parameters import AutomataParameters
from .stability import ALLOWED_PART, DEFAULT_PART, highest_frequency, step_limit

# Largest displacement of an automaton in an internal step, as a fraction of its diameter.
_LARGEST_MOVE = 0.1
# A caution is issued if two linked automata come closer than this distance, in diameters.
_NEAREST = 0.9
# Memory per automaton [bytes]: its state with a copy, fields, packing and temporary arrays of the build; and its histories.
_BYTES, _HISTORY_BYTES = 1100, 1400


class Automata(Component):
    """Movable cellular automata: equal discs whose pair forces depend on pair and volume strains (Psakhie 2003).

    m u'' = sum of F_n n + F_t t over the pairs, J w'' = sum of (r / 2) F_t; K and G are exact for both packings. See
    `AutomataParameters`, `pair_strains` and `linked_specimen`.
    """

    name = "automata"
    version = 5
    Parameters = AutomataParameters
    parameters: AutomataParameters

    # -- building ---------------------------------------------------------------------------------------------------

    @classmethod
    def memory_needed(cls, parameters: AutomataParameters) -> int:
        """Return the memory for the automata that fit into the rectangle around the shape, in bytes."""
        left, right, low, high = parameters.shape.bounds
        cells = (right - left) * (high - low) / (parameters.diameter**2 * LATTICES[parameters.packing].volume)
        return int(min(cells, 1e15)) * (_BYTES + _HISTORY_BYTES * parameters.has_individual_links)

    def _build_system(self) -> None:
        p = self.parameters
        self.packing: Packing = pack_shape(p.packing, p.shape, p.diameter, p.periodic)
        self.reference: FloatArray = self.packing.reference
        self.count = len(self.packing.places)
        self._make_body()
        self.conditions = Conditions(p, self.packing, self.body.layout)
        self._medium = intact_medium(self.packing, self.body, p, self.automaton_material) if p.has_individual_links else None
        self._highest_frequency = self._compute_frequency()
        self.step_size = self._choose_step_size()
        self._pairs = self.packing.pairs()
        self.specimen = self._make_specimen()
        # The kinds of events depend on the breaking criterion of this specimen.
        self._declare_events(self.specimen.event_kinds, self.specimen.event_details)
        n = self.count
        self._define_state(
            displacement=("f8", (n, 2)), velocity=("f8", (n, 2)), rotation=("f8", (n,)), spin=("f8", (n,)),
            tallies=("f8", (2, loads.TALLY_ROWS)), start=("f8", (4,)), growing=self.specimen.growing, **self.specimen.fields,
        )  # fmt: skip
        self.specimen.attach_state(self._block)
        self.mass: FloatArray = self.body.cells[MASS, self.body.layout.place]

    def _state_contradiction(self, state: Mapping[str, np.ndarray]) -> str:
        lengths = {name: len(state[name]) for name in self.specimen.growing}
        return f"got lists of different lengths, {lengths}" if len(set(lengths.values())) > 1 else ""

    def _make_body(self) -> None:
        """Build the automata and their materials."""
        p, solids = self.parameters, chosen_materials(self.parameters)
        self.materials: list[Material] = solids
        self.automaton_material = material_numbers(p, self.packing)
        constants = np.array([lame_constants(solid) for solid in solids])
        self.shear_modulus, self.lame_modulus = (np.nan, np.nan) if p.has_several_materials else constants[0].tolist()
        density = np.array([solid.density for solid in solids])
        numbers = self.automaton_material
        self.body: Body = make_body(self.packing, density[numbers], constants[numbers], p.thickness)

    def _compute_frequency(self) -> float:
        # The frequency is computed with the kernels that the steps use, so that numba need not compile others.
        update = partial(linked_specimen.update_forces, self.body)
        if self._medium is not None:
            medium, contacts = self._medium, empty_contacts()
            update = lambda motion, scratch: write_current_fields(medium, motion, scratch, contacts)  # noqa: E731
        return highest_frequency(self.body, update, self._medium is not None)

    @property
    def highest_frequency(self) -> float:
        """Return the highest frequency of small motions [rad/s]."""
        return self._highest_frequency

    def _make_specimen(self) -> LinkedSpecimen:
        self._speed_limit = _LARGEST_MOVE * self.parameters.diameter / self.step_size
        given = (self.packing, self.body, self.conditions, self.step_size, self._speed_limit)
        if self._medium is None:
            return LinkedSpecimen(*given)
        specimen = CrackingSpecimen(*given)
        specimen.set_medium(self.parameters, self._medium)
        return specimen

    def _choose_step_size(self) -> float:
        limit, given = step_limit(self.highest_frequency), self.parameters.step_size
        if given is None:
            return round_down_to_125(DEFAULT_PART * limit)
        if given > ALLOWED_PART * limit:
            raise ParameterError(
                f"got {given:g} s",
                expected=f"at most {ALLOWED_PART * limit:.6g} s, {ALLOWED_PART:g} x 2 / omega_max of this packing",
                hint=f"use {round_down_to_125(ALLOWED_PART * limit):g} s, or larger automata",
                at="step_size",
            )
        return given

    # -- description ------------------------------------------------------------------------------------------------

    def _declare_variables(self) -> Iterable[Variable]:
        n, plane = self.count, ("automaton", "direction")
        yield from self.conditions.inputs()
        yield Variable("displacement", "output", "m", (n, 2), "displacement from the initial position", state=True, axes=plane)
        yield Variable("velocity", "output", "m/s", (n, 2), "velocity", state=True, axes=plane)
        yield Variable("rotation", "output", "rad", (n,), "rotation angle, counter-clockwise", state=True, axes=("automaton",))
        yield Variable("angular_velocity", "output", "rad/s", (n,), "rate of rotation", state=True, axes=("automaton",))
        yield Variable("speed", "output", "m/s", (n,), "magnitude of the velocity", minimum=0.0, axes=("automaton",))
        yield Variable("dilation", "output", "1", (n,), "volumetric strain", axes=("automaton",))
        yield Variable(
            "stress",
            "output",
            "Pa",
            (n, 3),
            "in-plane stress xx, yy, xy, tension positive",
            axes=("automaton", "entry"),
        )
        links = len(self._pairs)
        yield Variable("linked", "output", "1", (links,), "1 for a linked pair, 0 for a broken pair", axes=("link",))
        text = "present force of each linked or broken pair along its line of centres, with its contact; compression positive"
        yield Variable("link_force", "output", "N", (links,), text, axes=("link",))
        yield Variable("damage", "output", "1", (n,), "broken fraction of the automaton's faces", axes=("automaton",))
        yield Variable("broken_links", "output", "1", (), "number of broken links")
        yield Variable("touching", "output", "1", (), "number of contacts (unlinked pairs) under pressure")
        for edge in self.conditions.held_edges:
            text = f"force of the {edge} edge on its automata along x and y; 0 for a component that it does not prescribe"
            yield Variable(f"{edge}_reaction", "output", "N", (2,), text, axes=("direction",))
        if self.parameters.has_several_materials:
            yield Variable("material_number", "output", "1", (n,), "material number, from 0", axes=("automaton",))
        if self.parameters.breakable:
            text = "decisive quantity of the criterion divided by its limit: a pair breaks at 1; 0 if broken or unloaded"
            yield Variable("criterion_ratio", "output", "1", (links,), text, minimum=0.0, axes=("link",))
        if self.parameters.can_yield:
            yield Variable("inelastic_strain", "output", "1", (n,), "mean inelastic strain of its pairs", axes=("automaton",))

    def _output_readers(self) -> dict[str, Callable[[], Any]]:
        specimen = self.specimen
        found: dict[str, Callable[[], Any]] = {
            **{name: (lambda view=self._block[name]: view) for name in ("displacement", "velocity", "rotation")},
            "angular_velocity": lambda: self._block["spin"],
            "speed": lambda: norms(self._block["velocity"]),
            "dilation": specimen.dilation,
            "stress": specimen.stress,
            "linked": specimen.link_weights,
            "link_force": specimen.link_forces,
            "damage": specimen.damage,
            "broken_links": specimen.broken_link_count,
            "touching": specimen.pressed_contact_count,
            **{f"{edge}_reaction": lambda edge=edge: self._reaction(edge) for edge in self.conditions.held_edges},
        }
        if self.parameters.has_several_materials:
            found["material_number"] = lambda: self.automaton_material.astype(np.float64)
        if isinstance(specimen, CrackingSpecimen) and self.parameters.breakable:
            found["criterion_ratio"] = specimen.criterion_ratio
        if isinstance(specimen, CrackingSpecimen) and self.parameters.can_yield:
            found["inelastic_strain"] = specimen.inelastic_strain
        return found

    # -- stepping ---------------------------------------------------------------------------------------------------

    def _write_start_state(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        for name, value in values.items():
            self._block["spin" if name == "angular_velocity" else name][...] = value
        self.specimen.reset_histories()
        sums = self.specimen.momenta_and_energies()
        self._block["start"][:] = sums[3] + sums[4] + ordered_sum(*self._stored_energies().values()), *sums[:3]
        return {}

    def _advance_state(self, ticks: int) -> int:
        status = 0
        held, specimen = self._held, self.specimen
        specimen.load_motion()
        if not any(isinstance(value, CompiledProfile) for value in held.values()):
            self.conditions.apply_inputs(held, self._tick)
            status = specimen.advance(self._tick, ticks)
        else:
            for tick in range(self._tick, self._tick + ticks):
                self.conditions.apply_inputs(held, tick)
                status = specimen.advance(tick, 1)
                if status:
                    break
        specimen.store_motion()
        return status

    def _step_error(self, status: int) -> StepError:
        variable, unit, limit = "velocity", "m/s", self._speed_limit
        meaning = f"{_LARGEST_MOVE:g} diameters per internal step"
        if status == TOO_FAR:
            variable, unit, limit, meaning = "displacement", "m", 1e9 * self.parameters.diameter, "10^9 diameters"
        advice = f"{meaning}; take a smaller step_size, or load the specimen less"
        return self._excess_error(variable, unit, norms(self._block[variable]), limit, advice)

    # -- reading ----------------------------------------------------------------------------------------------------

    def _reaction(self, edge: str) -> FloatArray:
        """Return the reaction of an edge, shape (2,) [N]: minus the forces on its automata along prescribed components."""
        automata, own = self.conditions.held_edges[edge]
        return 0.0 - np.where(own, self.specimen.forces()[automata], 0.0).sum(axis=0)

    def _stored_energies(self) -> dict[str, float]:
        """Return the energies of links and contacts [J], and `leapfrog_energy`; forces are those of mid-step positions."""
        half = 0.5 * self.step_size
        mean, found = self.specimen.mean_energy(half), self.specimen.stored_energies(half)
        return {**found, "leapfrog_energy": ordered_sum(*found.values()) - mean}

    def balances(self) -> tuple[Balance, ...]:
        """Return balances since the reset: energy, momentum, mass and, unless periodic, angular momentum about the origin.

        `leapfrog_energy` is -h^2/8 times v K v, where K is the stiffness of links and contacts. With it the scheme conserves
        the energy to rounding if strains are small.
        """
        sums, start, (load, grip) = (
            self.specimen.momenta_and_energies(),
            self._block["start"].copy(),
            self._block["tallies"].copy(),
        )
        stored = {
            "kinetic_energy": float(sums[3]),
            "rotational_energy": float(sums[4]),
            **self._stored_energies(),
        }
        work = {"input_work": float(load[loads.WORK] + grip[loads.WORK])}
        impulse = {"impulse": load[1:3], "boundary_impulse": grip[1:3]}
        turning = {
            "angular_impulse": float(load[loads.ANGULAR_IMPULSE]),
            "boundary_angular_impulse": float(grip[loads.ANGULAR_IMPULSE]),
        }
        found = [
            Balance("energy", "J", stored, work, self.specimen.dissipated_energies(), float(start[0])),
            Balance("momentum", "kg m/s", {"momentum": sums[:2]}, impulse, initial=start[1:3]),
        ]
        if not any(self.parameters.periodic):
            angular = {"angular_momentum": float(sums[2])}
            found.append(Balance("angular_momentum", "kg m2/s", angular, turning, initial=float(start[3])))
        mass = float(self.mass.sum())
        return (*found, Balance("mass", "kg", {"mass": mass}, initial=mass))

    def report(self) -> dict[str, float]:
        """Return figures for the report: the ratio of the step to the largest stable one, link strains, broken fraction."""
        part = 0.5 * self.highest_frequency * self.step_size
        return {"step over the largest stable one, at rest": part, **self.specimen.report()}

    def cautions(self) -> list[str]:
        """Return a caution if linked automata are much closer than a diameter."""
        first, second, slots = self._pairs[self.specimen.link_weights() == 1.0].T
        u, p = self._block["displacement"], self.parameters
        length = norms(p.diameter * self.packing.lattice.directions[slots] + u[second] - u[first]) / p.diameter
        short = np.flatnonzero(length < _NEAREST)
        if not len(short):
            return []
        least = short[length[short].argmin()]
        return [
            f"{len(short)} links are shorter than {_NEAREST:g} diameters; the shortest, between automata {first[least]} and "
            f"{second[least]}, has {length[least]:.2g} diameters. Yielding links do not break and let automata overlap; choose "
            "a criterion that breaks links, load the specimen less, and check the energy balance"
        ]

    def nearest_kind(self, ratio: str, index: int) -> str:
        """Return the kind of event (the cause of breaking) that the link with number `index` is closest to."""
        return self.specimen.nearest_event_kind(index) if isinstance(self.specimen, CrackingSpecimen) else ""

    def has_limit(self, ratio: str, index: int) -> bool:
        """Return whether the link with number `index` can break."""
        return not isinstance(self.specimen, CrackingSpecimen) or self.specimen.can_break(index)

    def conclusions(self) -> list[str]:
        """Return sentences on the broken links, or on the link closest to breaking, and on the number of pieces."""
        if not isinstance(self.specimen, CrackingSpecimen) or not self.parameters.breakable:
            return []
        said = [self.describe_links(self.packing.reference, self.step_size)]
        return said + ([describe_pieces(self.specimen.linked_pairs(), self.mass)] if len(self.specimen.break_events()) else [])

    def describe_links(self, reference: FloatArray, step_size: float, micro_steps: int = 1) -> str:
        """Return a sentence on the links that can break, with the automata at `reference`; see `conclusions.describe_links`."""
        assert isinstance(self.specimen, CrackingSpecimen)
        points = dataclasses.replace(self._drawable_points(), reference=reference)
        return describe_links(self.specimen, points, self._pairs[:, :2], step_size, micro_steps)

    def drawables(self) -> tuple[Drawable, ...]:
        """Return the automata, rotated and coloured by damage (by speed if nothing can break), and their links."""
        pairs = np.ascontiguousarray(self._pairs[:, :2])
        return self._drawable_points(), Links("links", "automata", pairs, "linked", "link_force")

    def _drawable_points(self) -> Points:
        radius = np.full(self.count, 0.5 * self.parameters.diameter)
        colour = "damage" if self.parameters.has_history else "speed"
        left, right, low, high = self.parameters.shape.bounds
        closed = self.parameters.periodic
        period = np.where(closed, (right - left, high - low), 0.0) if any(closed) else np.zeros(0)
        return Points("automata", self.packing.reference, radius, "displacement", colour, "rotation", period)
