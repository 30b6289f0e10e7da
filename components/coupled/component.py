"""A grid and movable cellular automata that share an interface, as one component."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from ..automata.component import Automata
from ..automata.conclusions import describe_pieces
from ..automata.contacts import SKIN
from ..automata.cracking_specimen import CrackingSpecimen
from ..automata.lattice import FORCE_Y, MASS, TORQUE, VX, X, Y, copy_to_ghosts
from ..automata.linked_specimen import TOO_FAST as TOO_FAST_ALONE
from ..automata.loads import TALLY_ROWS, WORK
from ..balances import Balance
from ..component import Component
from ..drawables import Drawable, Points
from ..errors import StepError
from ..grid import kernel_arrays
from ..grid.component import Grid
from ..grid.mesh import IntArray
from ..inputs import Held
from ..parts import make_part, part_drawable, part_readers, part_values, part_variables
from ..state_block import Layout
from ..support.float_arrays import FloatArray, ordered_sum
from ..variables import Variable
from .automaton_search import AutomatonSearch, find_interface_sides, points_in_cells
from .edge_loads import EdgeInputs
from .energy_sums import EnergySums, leapfrog_energy, make_energy_sums
from .exchange import EXCHANGE_TALLY, IMPULSE, WORK_ON_AUTOMATA, WORK_ON_GRID, Exchange, assemble_interface_forces
from .interface import Interface, carried_mass, find_interface
from .kernels import BREAK, DONE, INVERTED, MICRO, PROGRESS, ROW, SEARCH, TOO_FAST, CallProgress, advance
from .parameters import CoupledParameters
from .parts import AutomataPart, CrackingPart, GridPart, Seam
from .schemes import Impulses, Literal, Lockstep
from .side_contacts import (
    Sides,
    add_side_forces,
    extend_interface,
    find_close_pairs,
    free_sides,
    make_sides,
)
from .step_sizes import choose_steps

# Largest displacement of an automaton in one of its steps, as a fraction of its diameter.
_LARGEST_MOVE = 0.1
# The energies of the parts that are declared as outputs.
_PART_ENERGIES = ("grid_kinetic_energy", "grid_elastic_energy", "automata_kinetic_energy", "automata_elastic_energy")
# `_advance_state` returns `kernels.INVERTED` if the grid fails, and this number plus the status of the automata if they fail.
_AUTOMATA_FAILED = 16


class Coupled(Component):
    """A grid and movable cellular automata that share an interface: Psakhie et al. (2003), section 2.3.

    Nodes on the interface belong to both parts: m a = F with the masses and the forces of both. See `CoupledParameters`.
    """

    name = "coupled"
    version = 6
    Parameters = CoupledParameters
    parameters: CoupledParameters

    # -- building ---------------------------------------------------------------------------------------------------

    @classmethod
    def memory_needed(cls, parameters: CoupledParameters) -> int:
        """Return the memory that both parts need."""
        return Grid.memory_needed(parameters.grid) + Automata.memory_needed(parameters.automata)

    def _build_system(self) -> None:
        # Both parts are first built alone: their highest frequencies bound the step, and the sizes of their states are needed.
        grid, automata = make_part(Grid, self, "grid"), make_part(Automata, self, "automata")
        self._find_interface(grid, automata)
        chosen = choose_steps(self.parameters, 2.0 / grid.highest_frequency, 2.0 / automata.highest_frequency)
        self.step_size, self.micro_steps = chosen.step, chosen.micro
        self.grid_step_part, self.automata_step_part = chosen.grid_part, chosen.automata_part
        self._lay_out_state(grid, automata)
        self.carried_mass: FloatArray = carried_mass(self.interface, len(self.grid.mesh.nodes), self._automata_mass)
        self.mass: FloatArray = np.concatenate([self.grid.mass, self._automata_mass])
        self.grid.attach_mass(self.carried_mass, self.interface.nodes.tolist())
        self._make_parts()

    def _find_interface(self, grid: Grid, automata: Automata) -> None:
        """Find the interface."""
        mesh, packing, shape = grid.mesh, automata.packing, automata.parameters.shape
        origin = np.array(self.parameters.origin)
        search = AutomatonSearch(packing, shape, origin, automata.parameters.periodic)
        self.interface: Interface = find_interface(
            mesh, grid.parameters.boundaries, grid.joined_nodes, packing, automata.mass, shape, origin, search
        )
        self._automata_mass: FloatArray = automata.mass
        if self.parameters.side_contacts:
            self._free_sides: IntArray = free_sides(mesh, find_interface_sides(mesh, shape, origin))
            self.interface = extend_interface(self.interface, self._free_sides.reshape(-1))

    def _lay_out_state(self, grid: Grid, automata: Automata) -> None:
        n, rows = automata.count, len(self.interface.nodes)
        growing: Layout = {}
        if self.parameters.side_contacts:
            sides = len(self._free_sides)
            growing = {"side_pairs": ("i8", (2,), 0, (n - 1, sides - 1), n * sides)}
        self._define_state(
            grid=("f8", (grid.memory.size,)), automata=("f8", (automata.memory.size,)), automata_force=("f8", (n, 2)),
            automata_torque=("f8", (n,)), exchanged_forces=("f8", (2, rows, 2)), tallies=("f8", (2, TALLY_ROWS)),
            exchange=("f8", (EXCHANGE_TALLY,)), start=("f8", (4,)), growing=growing,
        )  # fmt: skip
        micro = self.step_size / self.micro_steps
        self.grid = make_part(Grid, self, "grid", step_size=self.step_size, memory=self._block["grid"])
        self.automata = make_part(Automata, self, "automata", step_size=micro, memory=self._block["automata"])
        self._include_part(self.grid, "grid")
        self._include_part(self.automata, "automata", self.micro_steps)

    def _make_parts(self) -> None:
        rows, automata = len(self.interface.nodes), self.automata
        nodes = self.grid.tables()[2].nodes.astype(np.int64)
        self.reference: FloatArray = automata.packing.reference + np.array(self.parameters.origin)
        forces = self._block["exchanged_forces"]
        before, start, given = np.zeros((3, rows, 2))
        places = np.searchsorted(nodes, self.interface.nodes)
        exchange = Exchange(places, forces[0], forces[1], before, start, given, self._block["exchange"])
        self._seam = Seam(self.interface, exchange)
        self._edge_inputs = EdgeInputs(automata.conditions, self.interface, self._block["tallies"])
        self._edge_inputs.refuse_free_nodes(self.grid.mesh, self.grid.tables()[2])
        specimen, body, place = automata.specimen, automata.body, automata.body.layout.place
        cells = body.cells.copy()
        cells[X : Y + 1, place] = self.reference.T
        cells[MASS, place[self.interface.automata]] = np.inf
        self._automata_part = AutomataPart(
            body._replace(cells=cells), specimen.motion, specimen.scratch, self._edge_inputs.edges
        )
        limit = _LARGEST_MOVE * automata.packing.diameter / (self.step_size / self.micro_steps)
        scheme = self.parameters.scheme
        kind = Literal if scheme == "literal" else Lockstep if self.micro_steps == 1 else Impulses
        self._steps = kind(self.step_size, self.micro_steps, scheme == "momentum", limit)
        self._cracking = specimen if isinstance(specimen, CrackingSpecimen) else None
        self._sides = self._make_free_sides()
        self._call = CallProgress(np.zeros(PROGRESS, dtype=np.int64), np.zeros(2, dtype=np.int64))
        self._divided: Mapping[str, Held] | None = None

    def _make_free_sides(self) -> Sides | None:
        """Return the free sides of the grid that automata can touch, or None without side contacts."""
        if self._cracking is None or not self.parameters.side_contacts:
            return None
        stiffness = self._cracking.contact_stiffness()
        radius = 0.5 * self.automata.packing.diameter
        return make_sides(self.interface, self._free_sides, self.grid.mesh.nodes, self.reference, radius, stiffness)

    # -- description ------------------------------------------------------------------------------------------------

    def _declare_variables(self) -> Iterable[Variable]:
        yield from part_variables({"grid": self.grid, "automata": self.automata})
        for name in _PART_ENERGIES:
            text = f"{name.replace('_', ' ')}; interface nodes count with the mass of this part"
            yield Variable(name, "output", "J", (), text)
        yield Variable("interface_work_on_grid", "output", "J", (), "work of the automata on the grid since the reset")
        yield Variable("interface_work_on_automata", "output", "J", (), "work of the grid on the automata since the reset")
        yield Variable("interface_work_difference", "output", "J", (), "sum of both works, 0 except for rounding")
        yield Variable("interface_impulse", "output", "N s", (2,), "impulse of the grid on the automata", axes=("direction",))
        yield Variable("mass_difference", "output", "kg", (), "moving mass minus the masses of the cells and automata")
        yield Variable(
            "grid_step_part", "output", "1", (), "internal step over the grid's largest stable one", variability="constant"
        )
        yield Variable(
            "automata_step_part", "output", "1", (), "micro-step over the automata's largest stable one", variability="constant"
        )

    def _output_readers(self) -> dict[str, Callable[[], Any]]:
        tally = self._block["exchange"]
        found: dict[str, Callable[[], Any]] = {
            "interface_work_on_grid": lambda: float(tally[WORK_ON_GRID]),
            "interface_work_on_automata": lambda: float(tally[WORK_ON_AUTOMATA]),
            "interface_work_difference": lambda: float(tally[WORK_ON_GRID] + tally[WORK_ON_AUTOMATA]),
            "interface_impulse": lambda: tally[IMPULSE : IMPULSE + 2],
            "mass_difference": self._mass_difference,
            "grid_step_part": lambda: self.grid_step_part,
            "automata_step_part": lambda: self.automata_step_part,
        }
        for name in _PART_ENERGIES:
            found[name] = lambda name=name: self._part_energies()[name]
        for prefix, part in (("grid", self.grid), ("automata", self.automata)):
            found |= part_readers(prefix, part)
        return found

    def _part_energies(self) -> dict[str, float]:
        found = self._energies_and_momenta()
        links = self.automata.specimen.stored_energies(0.0)
        amounts = found.kinetic, found.elastic, found.automata_kinetic, links["elastic_energy"]
        return dict(zip(_PART_ENERGIES, map(float, amounts), strict=True))

    def _mass_difference(self) -> float:
        """Return the mass of nodes and of automata outside the interface, minus density times area of both parts [kg]."""
        conditions = self.grid.tables()[2]
        free = self._automata_mass[self.interface.free > 0].sum()
        own = self.grid.mass.copy()
        own[conditions.nodes] = conditions.share * conditions.mass
        return float((own.sum() + free) - (self.grid.mass.sum() + self.automata.mass.sum()))

    def report(self) -> dict[str, float]:
        """Return figures for the report: steps over the largest stable steps, mismatch of interface works, breakage, yield."""
        tally = self._block["exchange"]
        largest = float(np.abs(tally[[WORK_ON_GRID, WORK_ON_AUTOMATA]]).max())
        difference = float(abs(tally[WORK_ON_GRID] + tally[WORK_ON_AUTOMATA]))
        found = {f"grid: {name}": figure for name, figure in self.grid.report().items()}
        found |= {f"automata: {name}": figure for name, figure in self.automata.report().items()}
        found |= {
            "micro-steps in a step": float(self.micro_steps),
            "interface: sum of the works of both sides over the larger": difference / largest if largest > 0.0 else 0.0,
        }
        if self._cracking is not None:
            found["automata: pieces inside cells of the grid"] = float(len(self._stray_automata()))
        return found

    def _stray_automata(self) -> IntArray:
        """Return automata with broken links whose centres lie inside cells."""
        if self._cracking is None:
            return np.zeros(0, dtype=np.int64)
        loose = np.flatnonzero((self._cracking.damage() > 0.0) & (self.interface.free > 0))
        nodes, centres = self._positions()
        return loose[points_in_cells(nodes, self.grid.mesh.cells, centres[loose])[0]]

    def _positions(self) -> tuple[FloatArray, FloatArray]:
        """Return the positions of nodes and automata, shape (nodes, 2) and (n, 2) [m]."""
        return self.grid.mesh.nodes + self.grid.peek("displacement"), self.reference + self.automata.peek("displacement")

    def cautions(self) -> list[str]:
        """Return the cautions of the parts, and one if broken-off automata lie inside the grid."""
        said = [f"grid: {text}" for text in self.grid.cautions()] + [f"automata: {text}" for text in self.automata.cautions()]
        if len(strays := self._stray_automata()):
            x, y = self._positions()[1][strays[0]]
            said.append(
                f"{len(strays)} automata with broken links lie in cells of the grid, e.g. automaton {strays[0]} at ({x:.6g}, "
                f"{y:.6g}) m: pieces pass through the free sides of the grid unless side_contacts = true"
            )
        return said

    def drawables(self) -> tuple[Drawable, ...]:
        """Return the grid, automata and links for drawing; both coloured by speed, so that waves cross the interface."""
        shown = [part_drawable("grid", one) for one in self.grid.drawables()]
        for one in self.automata.drawables():
            drawn = part_drawable("automata", one)
            is_body = isinstance(drawn, Points)
            shown.append(dataclasses.replace(drawn, reference=self.reference, colour="automata_speed") if is_body else drawn)
        return tuple(shown)

    def nearest_kind(self, ratio: str, index: int) -> str:
        """Return the kind of event that a cell or a link, the one with number `index`, is closest to."""
        for prefix, part in (("grid", self.grid), ("automata", self.automata)):
            if ratio.startswith(f"{prefix}_") and (kind := part.nearest_kind(ratio.removeprefix(f"{prefix}_"), index)):
                return f"{prefix}_{kind}"
        return ""

    def has_limit(self, ratio: str, index: int) -> bool:
        """Return whether the cell with number `index` can yield, or the link break."""
        part = self.grid if ratio.startswith("grid_") else self.automata
        return part.has_limit(ratio.partition("_")[2], index)

    def conclusions(self) -> list[str]:
        """Return the state of the breakable links, and the number of pieces of grid and automata together."""
        if self._cracking is None or not self.automata.parameters.breakable:
            return []
        said = [f"automata: {self.automata.describe_links(self.reference, self.step_size, self.micro_steps)}"]
        if len(self._cracking.break_events()):
            said.append(f"grid and automata: {describe_pieces(self._connected_pairs(), self.mass)}")
        return said

    def _connected_pairs(self) -> IntArray:
        """Return pairs of connected nodes and automata, shape (m, 2); automata are numbered after the nodes."""
        assert self._cracking is not None
        cells, nodes, face = self.grid.mesh.cells.astype(np.int64), len(self.grid.mesh.nodes), self.interface
        joined = self.grid.joined_nodes
        held = [cells[:, k : k + 2] for k in range(3)] + [nodes + self._cracking.linked_pairs()]
        held += [np.stack([face.automata + nodes, ends], axis=1) for ends in face.ends.T]
        held += [joined[joined[:, k] >= 0][:, [0, k]] for k in range(1, joined.shape[1])]
        return np.concatenate(held)

    # -- stepping ---------------------------------------------------------------------------------------------------

    def _write_start_state(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        for prefix, part in (("grid", self.grid), ("automata", self.automata)):
            part._write_start_state(seed, part_values(prefix, values))
        self._divided = None
        self.automata.specimen.load_motion()
        self._move_interface_automata()
        if self._cracking is None:
            self.automata.specimen.update_forces()
        else:
            # Initial contacts act from the first half kick on. If the search for them fails, the first step reports the reason.
            self._cracking.store_motion()
            self._find_contacts()
            self._cracking.update_forces(at_start=True)
        self._write_interface_forces()
        self._store_automata()
        found = self._energies_and_momenta()
        self._block["start"][:] = self._total_energy(found), *found.momentum, found.angular_momentum
        return {}

    def _move_interface_automata(self) -> None:
        """Give the interface automata the positions and velocities of their nodes, and record the cell forces on these."""
        state, face, motion, layout = (
            self.grid.tables()[1],
            self.interface,
            self._automata_part.motion,
            self.automata.body.layout,
        )
        for row, nodal in ((X, state.displacement), (VX, state.velocity)):
            moved = face.weights[:, :1] * nodal[face.ends[:, 0]] + face.weights[:, 1:] * nodal[face.ends[:, 1]]
            motion[row : row + 2, layout.place[face.automata]] = moved.T
        copy_to_ghosts(layout, motion)
        self._seam.exchange.grid_force[:] = state.force[face.nodes]

    def _write_interface_forces(self) -> None:
        """Write the initial forces of automata on interface nodes; in lockstep also the sum of both parts, for half a kick."""
        grid, face, exchange, steps = self._grid_part(), self.interface, self._seam.exchange, self._steps
        forces = self._automata_part.scratch.cells[: FORCE_Y + 1, self.automata.body.layout.place].T
        exchange.automata_force[:] = 0.0
        rows = np.repeat(np.arange(len(face.nodes)), np.diff(face.first))
        np.add.at(exchange.automata_force, rows, face.shares[:, None] * forces[face.automata[face.acting]])
        sides = self._current_sides()
        if sides is not None:
            nodes = grid.grid.reference, grid.state.displacement
            add_side_forces(sides, nodes, self._automata_part, exchange.automata_force)
        if self._is_lockstep:
            assemble_interface_forces(self._seam, grid.state, grid.conditions, 0.5 * steps.step, steps.by_momentum)

    def _load_automata(self) -> None:
        """Copy the state of the automata, with their forces, to the fields."""
        self.automata.specimen.load_motion()
        cells, place = self._automata_part.scratch.cells, self.automata.body.layout.place
        cells[: FORCE_Y + 1, place], cells[TORQUE, place] = self._block["automata_force"].T, self._block["automata_torque"]

    def _store_automata(self) -> None:
        """Copy the fields of the automata to the state."""
        self.automata.specimen.store_motion()
        cells, place = self._automata_part.scratch.cells, self.automata.body.layout.place
        self._block["automata_force"].T[:], self._block["automata_torque"][:] = (
            cells[: FORCE_Y + 1, place],
            cells[TORQUE, place],
        )

    @property
    def _is_lockstep(self) -> bool:
        return self.micro_steps == 1 or self.parameters.scheme == "literal"

    def _grid_part(self) -> GridPart:
        grid, state, conditions, corner = self.grid.tables()
        return GridPart(grid, state, conditions, corner, self.grid.tally, self.grid.free_event_rows())

    def _cracking_part(self) -> CrackingPart | None:
        """Return the automata part with histories and contacts for kernels, or None if links neither break nor yield."""
        specimen = self._cracking
        if specimen is None:
            return None
        return CrackingPart(specimen.specimen, specimen.contacts(), specimen.travel_limit, self._current_sides())

    def _current_sides(self) -> Sides | None:
        """Return the free sides of the grid with the current pairs of automata and sides, or None without side contacts."""
        if self._sides is None:
            return None
        return self._sides._replace(pairs=self._block.reserve_rows("side_pairs", 0), used=self._block.count("side_pairs"))

    def _find_contacts(self) -> int:
        """Search again for pairs that may touch (automata, sides); return a status if automata are too far out or too fast."""
        assert self._cracking is not None
        status = self._cracking.find_contacts()
        if not status and self._sides is not None:
            exposed = self._cracking.exposed_automata()
            loose = exposed[self.interface.free[exposed] > 0]
            place, motion = self.automata.body.layout.place, self._automata_part.motion
            centres = self.reference + motion[X : Y + 1, place].T
            pairs = find_close_pairs(self._sides, self._positions()[0], centres, loose, SKIN * self.automata.packing.diameter)
            self._block.set_row_count("side_pairs", 0)
            self._block.reserve_rows("side_pairs", len(pairs))[: len(pairs)] = pairs
            self._block.set_row_count("side_pairs", len(pairs))
        return status

    def _advance_state(self, ticks: int) -> int:
        if self._held is not self._divided:
            self._divide_inputs()
        self._load_automata()
        status, pieces = 0, [(self._tick, ticks)]
        if self._automata_follow_profile:
            pieces = [(tick, 1) for tick in range(self._tick, self._tick + ticks)]
        for tick, count in pieces:
            self._apply_automata_inputs(tick)
            status = self._advance_ticks(tick, count)
            if status:
                break
        self._store_automata()
        return status

    def _divide_inputs(self) -> None:
        """Pass to each part those held inputs that are its own."""
        for prefix, part in (("grid", self.grid), ("automata", self.automata)):
            part._hold_inputs(part_values(prefix, self._held))
        self._automata_follow_profile = self.automata.has_profile_input
        self._divided = self._held

    def _apply_automata_inputs(self, tick: int) -> None:
        """Set the loads and grips of the automata for a tick, from their inputs."""
        self.automata.conditions.apply_inputs(self.automata.held_inputs, tick, has_central_kick=False)
        self._edge_inputs.fill_loads()

    def _advance_ticks(self, tick: int, ticks: int) -> int:
        factors = self.grid.drive_factors(tick, ticks)
        grid = self._grid_part()
        loads = self._edge_inputs.loads_on_nodes(grid.conditions, self._seam.exchange.places)
        if loads is not None:
            drive = np.concatenate([grid.conditions.drive, loads[None]])
            grid = grid._replace(conditions=grid.conditions._replace(drive=drive))
            factors = np.concatenate([factors, np.ones((ticks, 1))], axis=1)
        status = self._run_kernel(grid, factors, tick)
        self.grid.set_event_count(grid.yields)
        return status

    def _run_kernel(self, grid: GridPart, factors: FloatArray, tick: int) -> int:
        """Advance by one tick per row of `factors`, the values of the grid's signals; return 0 or a status."""
        progress, failure = self._call
        progress[:] = 0
        while True:
            cracking, linked = self._cracking_part(), None if self._cracking else self.automata.body
            parts = grid, self._automata_part, linked, cracking, self._seam
            status = advance(*parts, factors, self._steps, tick, self._call)
            if status in (DONE, INVERTED):
                return int(status)
            if status == TOO_FAST or self._cracking is None:
                return _AUTOMATA_FAILED + TOO_FAST_ALONE
            if status == SEARCH and (failed := self._find_contacts()):
                failure[1] = tick + progress[ROW] + 1
                return _AUTOMATA_FAILED + failed
            if status == BREAK:
                self._cracking.update_links((tick + int(progress[ROW])) * self.micro_steps + int(progress[MICRO]))

    def _step_error(self, status: int) -> StepError:
        if status == INVERTED:
            self.grid.failed_at[:] = self._call.failure
            return self.grid._step_error(1).with_part_prefix("grid")
        return self._explain_automata(status - _AUTOMATA_FAILED)

    def _explain_automata(self, status: int) -> StepError:
        """Return the error for a status of the automata, worded for the coupled body."""
        self.automata.set_progress(max(int(self._call.failure[1]) - 1, 0) * self.micro_steps, {})
        return self.automata._step_error(status).with_part_prefix("automata")

    # -- reading ----------------------------------------------------------------------------------------------------

    def forces_on_nodes(self) -> FloatArray:
        """Return the forces of cells and automata on the nodes of the grid, shape (n, 2) [N]."""
        found, exchange = self.grid.tables()[1].force.copy(), self._seam.exchange
        found[self.interface.nodes] = exchange.grid_force + exchange.automata_force
        return found

    def forces_on_automata(self) -> tuple[FloatArray, FloatArray]:
        """Return the forces [N] and torques [N m] of the links on the automata, shape (n, 2) and (n,)."""
        return self._block["automata_force"].copy(), self._block["automata_torque"].copy()

    def _energies_and_momenta(self) -> EnergySums:
        self._load_automata()
        with np.errstate(all="ignore"):
            return make_energy_sums(self._grid_part(), self._automata_part, self._seam, self.grid.mass, self._is_lockstep)

    def _stored_energies(self, sums: EnergySums) -> dict[str, float]:
        links = self.automata.specimen.stored_energies(0.0)
        elastic = sums.elastic + links.pop("elastic_energy")
        sides = self._current_sides()
        if sides is not None:
            grid, forces = self._grid_part(), self._seam.exchange.automata_force.copy()
            nodes = grid.grid.reference, grid.state.displacement
            links["contact_energy"] += add_side_forces(sides, nodes, self._automata_part, forces)
        return {
            "kinetic_energy": sums.kinetic + sums.automata_kinetic,
            "rotational_energy": sums.rotational,
            "elastic_energy": elastic,
            "hourglass_energy": sums.hourglass,
            **links,
            "leapfrog_energy": leapfrog_energy(sums, self.step_size, self.micro_steps),
        }

    def _dissipated_energies(self, sums: EnergySums) -> dict[str, float]:
        absorbed = {"absorbed_energy": float(self.grid.tally[kernel_arrays.ABSORBED])}
        plastic = {"plastic_work": sums.plastic} if self.grid.event_kinds else {}
        return {**absorbed, **plastic, **self.automata.specimen.dissipated_energies()}

    def _total_energy(self, sums: EnergySums) -> float:
        return ordered_sum(*self._stored_energies(sums).values())

    def balances(self) -> tuple[Balance, ...]:
        """Return balances of energy, momentum, mass and, without periodic edges, angular momentum about the origin.

        An interface node counts in each part with the mass from that part. `leapfrog_energy` is -h^2/8 times the sum of
        force^2 / mass. With it, the scheme `lockstep` conserves the energy to rounding.
        """
        found, start = self._energies_and_momenta(), self._block["start"].copy()
        tally, (load, grip) = self.grid.tally.copy(), self._block["tallies"].copy()
        work = {"input_work": float(tally[kernel_arrays.WORK] + load[WORK] + grip[WORK])}
        impulse = {
            "impulse": tally[kernel_arrays.IMPULSE : kernel_arrays.IMPULSE + 2] + load[1:3],
            "boundary_impulse": tally[kernel_arrays.BOUNDARY_IMPULSE : kernel_arrays.BOUNDARY_IMPULSE + 2] + grip[1:3],
        }
        mass = float(self.mass.sum())
        balances = [
            Balance("energy", "J", self._stored_energies(found), work, self._dissipated_energies(found), float(start[0])),
            Balance("momentum", "kg m/s", {"momentum": found.momentum}, impulse, initial=start[1:3]),
            Balance("mass", "kg", {"mass": mass}, initial=mass),
        ]
        if not len(self.grid.joined_nodes) and not any(self.automata.parameters.periodic):
            turning = {
                "angular_impulse": float(tally[kernel_arrays.ANGULAR] + load[3]),
                "boundary_angular_impulse": float(tally[kernel_arrays.BOUNDARY_ANGULAR] + grip[3]),
            }
            turned = {"angular_momentum": found.angular_momentum}
            balances.insert(2, Balance("angular_momentum", "kg m2/s", turned, turning, initial=float(start[3])))
        return tuple(balances)
