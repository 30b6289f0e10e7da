"""The grid as a component: a continuum in plane strain on a mesh of quadrilaterals that moves with it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..balances import Balance
from ..component import Component
from ..drawables import Cells, Drawable, Points
from ..errors import ParameterError, StepError
from ..events import EventDetail
from ..inputs import Held
from ..materials.elastic import Material, to_material
from ..materials.hypoelastic import logarithmic_strain
from ..materials.plastic_law import yield_limit
from ..profiles import CompiledProfile
from ..support.float_arrays import FloatArray, norms
from ..support.stable_step import refuse_large_step, suggest_step
from ..support.threads import thread_count
from ..variables import Variable
from . import kernel_arrays, kernels
from .boundaries import Free
from .kernel_arrays import Tables, Yields
from .kernel_setup import Assembly, assemble_grid, make_drive, mean_signals
from .mesh import IntArray, Mesh, cell_areas
from .nodal_conditions import side_cells
from .parameters import GridParameters, Place
from .stability import highest_frequency
from .yielding import NoYield

# With fewer cells a tick is too short to gain from threads: measured, see benchmarks/README.md.
LEAST_CELLS = 100_000
# A cell whose area falls below this fraction of its initial area is too compressed for the step: a caution.
_COMPRESSED = 0.5
# A caution is issued if a point is farther than this from its node, in sides of the smallest cell.
_OFF_NODE = 1e-6
# Memory per cell of a large mesh [bytes], for the state and the tables of the kernels.
_BYTES_OF_CELL = 420
_STATE = ("displacement", "velocity", "force", "stress", "hourglass_force", "energy", "plastic_strain", "plastic_work")
_YIELD = {"cell_yielded": "the equivalent stress of a cell reached its yield stress for the first time"}
_YIELD_DETAILS = {"cell_yielded": EventDetail("Pa", "grid", "yield_ratio")}


class Grid(Component):
    """A continuum in plane strain on a mesh of quadrilaterals that moves with it: Wilkins (1964), Psakhie et al. (2003).

    rho u'' = div sigma with a hypoelastic law (Jaumann rate) and plastic flow. Forces, masses and energies are those of a slab
    one metre thick. See `GridParameters`.
    """

    name = "grid"
    version = 2
    Parameters = GridParameters
    parameters: GridParameters

    # -- building ---------------------------------------------------------------------------------------------------

    @classmethod
    def memory_needed(cls, parameters: GridParameters) -> int:
        """Return the memory of mesh, state, its copy and the tables of the kernels."""
        return _BYTES_OF_CELL * parameters.mesh.cell_count

    def _build_system(self) -> None:
        p = self.parameters
        try:
            self.mesh: Mesh = p.mesh.build_mesh()
        except ParameterError as error:
            raise error.with_outer_location("mesh") from None
        for name, boundary in p.boundaries.items():
            if not isinstance(boundary, Free) and not len(self.mesh.edges[name]):
                raise ParameterError(
                    "the holes remove all cells at this edge, so its condition acts on nothing",
                    hint="leave the condition out, or make the holes smaller",
                    at=("boundaries", name),
                )
        self.cell_material: IntArray = self._cell_materials()
        self._materials: list[Material] = [to_material(one) for one in p.materials]
        self._off_nodes: list[str] = []
        self._forced = self._selected_nodes("forced_nodes", p.forced_nodes)
        self._receivers = self._selected_nodes("receivers", p.receivers)
        self._laws = {number: p.plastic_laws[number].constants() for number in np.unique(self.cell_material).tolist()}
        self._plastic = any(law is not None for law in self._laws.values())
        self.attach_mass(None)
        self._refuse_ineffective_forces()
        self.mass: FloatArray = self._assembly.mass
        self.highest_frequency: float = highest_frequency(self._grid, self._conditions, self._corner)
        self.step_size = p.step_size or suggest_step(
            self.highest_frequency, "leave an edge free, make the mesh finer, or give a step_size"
        )
        refuse_large_step(self.step_size, self.highest_frequency, "leave it out, or make the cells larger")
        self._lay_out_state()

    def _cell_materials(self) -> IntArray:
        p, count = self.parameters, len(self.mesh.cells)
        if p.cell_material is not None:
            if len(p.cell_material) != count:
                raise ParameterError(
                    f"got {len(p.cell_material)} numbers", expected=f"{count}, one for each cell", at="cell_material"
                )
            return np.array(p.cell_material, dtype=np.int64)
        numbers = np.zeros(count, dtype=np.int64)
        for place, region in enumerate(p.regions):
            inside = region.area.contains(self.mesh.centres)
            if not inside.any():
                raise ParameterError(
                    "does not contain the centre of any cell", hint="make it larger, or leave it out", at=("regions", place)
                )
            numbers[inside] = region.material
        return numbers

    def _selected_nodes(self, name: str, places: list[Place]) -> IntArray:
        """Return the nodes that the parameter `name` selects by numbers or by points."""
        found = []
        for index, place in enumerate(places):
            if isinstance(place, int) and place >= len(self.mesh.nodes):
                raise ParameterError(f"got node {place}", expected=f"0 to {len(self.mesh.nodes) - 1}", at=f"{name}[{index}]")
            found.append(place if isinstance(place, int) else self._nearest_node(f"{name}[{index}]", place))
            if found[-1] in found[:-1]:
                raise ParameterError(f"got node {found[-1]} twice", hint="give each node once", at=f"{name}[{index}]")
        return np.array(found, dtype=np.int64)

    def _refuse_ineffective_forces(self) -> None:
        """Refuse forces on nodes whose motion is prescribed along both axes: they would have no effect."""
        held = self._conditions.prescribed[self._assembly.places[self._forced]].all(axis=1)
        for index in np.flatnonzero(held).tolist():
            raise ParameterError(
                f"the motion of node {self._forced[index]} is prescribed along x and y, so a force on it has no effect",
                hint="leave it out, or free its edge",
                at=("forced_nodes", index),
            )

    def _nearest_node(self, where: str, point: Sequence[float]) -> int:
        """Return the node nearest to a point of the body, and note the node for a caution if it is not at the point."""
        squares = ((self.mesh.nodes - np.array(point)) ** 2).sum(axis=1)
        node = int(np.argmin(squares))
        (x, y), distance = self.mesh.nodes[node].tolist(), math.sqrt(squares[node])
        found = f"the nearest node, {node}, is at ({x:.6g}, {y:.6g}) m"
        if distance > 2.0 * self.mesh.cell_radii.max():
            raise ParameterError(f"got the point {list(point)} m", expected="a point of the body", hint=found, at=where)
        if distance > _OFF_NODE * math.sqrt(self.mesh.areas.min()):
            self._off_nodes.append(f"{where}: {found}, not at the point {list(point)} m")
        return node

    def attach_mass(self, mass: FloatArray | None, loaded_nodes: Sequence[int] = ()) -> None:
        """Attach masses of another body to nodes; a parent component adds the forces of that body to those of the cells.

        Call it before the first step.

        Args:
            mass: mass to be added to each node, shape (n,) [kg].
            loaded_nodes: further nodes, without added mass, to which the parent adds forces.
        """
        p = self.parameters
        self._assembly: Assembly = assemble_grid(
            self.mesh, self._materials, self.cell_material, laws=p.plastic_laws, boundaries=p.boundaries,
            forced_nodes=self._forced.tolist(), hourglass=p.hourglass, carried_mass=mass, loaded_nodes=loaded_nodes,
        )  # fmt: skip
        self._grid, self._conditions, self._corner = self._assembly.grid, self._assembly.conditions, self._assembly.corner

    def _lay_out_state(self) -> None:
        n, m = len(self.mesh.nodes), len(self.mesh.cells)
        plastic = m if self._plastic else 0
        if self._plastic:  # other grids have no events
            self._declare_events(_YIELD, _YIELD_DETAILS)
        self._define_state(
            displacement=("f8", (n, 2)), velocity=("f8", (n, 2)), force=("f8", (n, 2)), stress=("f8", (m, 4)),
            hourglass_force=("f8", (m, 2)), energy=("f8", (m,)), plastic_strain=("f8", (plastic,), 0.0),
            plastic_work=("f8", (plastic,)), static_force=("f8", self._assembly.absorbing_sides.shape),
            tally=("f8", (kernel_arrays.TALLY,)), start=("f8", (4,)),
        )  # fmt: skip
        self._state = kernel_arrays.State(*(self._block[name] for name in _STATE))
        self._driven_by: Mapping[str, Held] | None = None
        self._signals: list[CompiledProfile] = []
        self.failed_at = np.zeros(2, dtype=np.int64)

    def _state_contradiction(self, state: Mapping[str, np.ndarray]) -> str:
        # Each cell records one event, when its plastic strain first exceeds 0.
        yielded = np.count_nonzero(state["plastic_strain"])
        if not self._plastic or len(state["events"]) == yielded:
            return ""
        return f"got {yielded} yielded cells, but {len(state['events'])} events"

    # -- the contract -----------------------------------------------------------------------------------------------

    def _declare_variables(self) -> Iterable[Variable]:
        n, m, k = len(self.mesh.nodes), len(self.mesh.cells), len(self._receivers)
        nodes, cells, received = ("node", "direction"), ("cell",), ("receiver", "direction")
        for one in self._assembly.inputs:
            yield one.variable
        yield Variable("displacement", "output", "m", (n, 2), "displacement of the nodes", state=True, axes=nodes)
        yield Variable("velocity", "output", "m/s", (n, 2), "velocity of the nodes", state=True, axes=nodes)
        yield Variable("speed", "output", "m/s", (n,), "magnitude of the velocity", minimum=0.0, axes=("node",))
        yield Variable(
            "stress", "output", "Pa", (m, 4), "stresses xx, yy, zz, xy of the cells, tension positive; without "
            "a start value, they follow elastically from a start value of the displacement", state=True, axes=("cell", "entry"),
        )  # fmt: skip
        yield Variable("pressure", "output", "Pa", (m,), "mean of the normal stresses, compression positive", axes=cells)
        yield Variable("equivalent_stress", "output", "Pa", (m,), "von Mises stress sqrt(3/2 s:s)", minimum=0.0, axes=cells)
        yield Variable("plastic_strain", "output", "1", (m,), "equivalent plastic strain of the cells", minimum=0.0, axes=cells)
        if self._plastic:
            text = "equivalent stress over the yield stress: 1 in a yielding cell, 0 if the material cannot yield"
            yield Variable("yield_ratio", "output", "1", (m,), text, minimum=0.0, axes=cells)
        yield Variable(
            "internal_energy", "output", "J", (m,), "work of stresses on the cells, plastic work included", axes=cells
        )
        for edge in self._assembly.held_edges:
            yield Variable(
                f"{edge}_reaction", "output", "N", (2,), f"force of the {edge} edge on its cells along x and y; 0 for a "
                "component that it does not prescribe", axes=("direction",),
            )  # fmt: skip
        yield Variable("receiver_displacement", "output", "m", (k, 2), "displacement of the `receivers`", axes=received)
        yield Variable("receiver_velocity", "output", "m/s", (k, 2), "velocity of the `receivers`", axes=received)

    def _output_readers(self) -> dict[str, Callable[[], Any]]:
        state = self._state
        return {
            "displacement": lambda: state.displacement,
            "velocity": lambda: state.velocity,
            "speed": lambda: norms(state.velocity),
            "stress": lambda: state.stress,
            "pressure": self._pressure,
            "equivalent_stress": self._equivalent_stress,
            "plastic_strain": lambda: state.plastic_strain if self._plastic else np.zeros(len(self.mesh.cells)),
            "internal_energy": lambda: state.energy,
            **({"yield_ratio": self._yield_ratio} if self._plastic else {}),
            **{f"{edge}_reaction": lambda edge=edge: self._reaction(edge) for edge in self._assembly.held_edges},
            "receiver_displacement": lambda: state.displacement[self._receivers],
            "receiver_velocity": lambda: state.velocity[self._receivers],
        }

    def _reaction(self, edge: str) -> FloatArray:
        """Return the reaction [N] of an edge, shape (2,): minus the cell forces on its nodes along prescribed components."""
        nodes, own = self._assembly.held_edges[edge]
        share = self._conditions.share[self._assembly.places[nodes], None]
        return 0.0 - np.where(own, share * self._state.force[nodes], 0.0).sum(axis=0)

    def _pressure(self) -> FloatArray:
        return -self._state.stress[:, :3].sum(axis=1) / 3.0

    def _equivalent_stress(self) -> FloatArray:
        xx, yy, zz, xy = self._state.stress.T
        spread = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
        return np.sqrt(0.5 * spread + 3.0 * xy * xy)

    def _yield_ratio(self) -> FloatArray:
        ratio, strain, pressure = np.zeros(len(self.mesh.cells)), self._state.plastic_strain, self._pressure()
        equivalent = self._equivalent_stress()
        for number, law in self._laws.items():
            if law is not None:
                cells = self.cell_material == number
                limit = yield_limit(law, strain[cells], pressure[cells])
                # At the tip of the yield cone (strength 0) no stress can grow.
                at_tip = limit <= 1e-9 * yield_limit(law, 0.0, 0.0)
                ratio[cells] = np.where(at_tip, 1.0, equivalent[cells] / np.where(at_tip, 1.0, limit))
        return ratio

    def has_limit(self, ratio: str, index: int) -> bool:
        """Return whether the material of the cell with number `index` can yield."""
        return self._laws[int(self.cell_material[index])] is not None

    def _write_start_state(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        state = self._state
        for name in ("displacement", "velocity"):
            if name in values:
                self._refuse_separation(name, values[name])
        if "displacement" in values:
            state.displacement[:] = values["displacement"]
            if (cell := self._update_forces(0.0)) >= 0:
                raise ParameterError(
                    f"cell {cell} would be inverted", hint="give smaller displacements", at="start.displacement"
                )
            self._write_elastic_stresses()
        if "stress" in values:
            state.stress[:] = values["stress"]
        if values.keys() & {"displacement", "stress"}:
            self._update_forces(0.0)
            self._block["static_force"][:] = self._static_force()
        kernels.write_stress_energies(self._grid, state)
        if "velocity" in values:
            state.velocity[:] = values["velocity"]
        self._driven_by = None
        sums = self._energies_and_momenta()
        self._block["start"][:] = sums["energy"], *sums["momentum"], sums["angular_momentum"]
        return {}

    def _static_force(self) -> FloatArray:
        """Return for each side of the absorbing edges the force sigma n L that balances the stress of its cell, (k, 2) [N]."""
        sides, positions = self._assembly.absorbing_sides, self.mesh.nodes + self._state.displacement
        x, y = (positions[sides[:, 1]] - positions[sides[:, 0]]).T
        xx, yy, _, xy = self._state.stress[side_cells(self.mesh, sides)].T
        return np.stack([xx * y - xy * x, xy * y - yy * x], axis=1)

    def _write_elastic_stresses(self) -> None:
        """Write the elastic stresses and hourglass forces of the present displacements, for rotations of any angle."""
        state, corners = self._state, self.mesh.nodes[self.mesh.cells]
        moved = state.displacement[self.mesh.cells]
        first, second = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
        along, across = moved[:, 2] - moved[:, 0], moved[:, 3] - moved[:, 1]
        twice = (2.0 * self.mesh.areas)[:, None]
        by_x = (second[:, 1:] * along - first[:, 1:] * across) / twice
        by_y = (first[:, :1] * across - second[:, :1] * along) / twice
        xx, yy, xy = logarithmic_strain(by_x[:, 0], by_y[:, 0], by_x[:, 1], by_y[:, 1])
        first_lame, shear = self._grid.moduli[self.cell_material].T
        volume, double = first_lame * (xx + yy), 2.0 * shear
        state.stress[:] = np.stack([volume + double * xx, volume + double * yy, volume, double * xy], axis=1)
        pattern, bent = ((some[:, 0] + some[:, 2]) - (some[:, 1] + some[:, 3]) for some in (corners, moved))
        state.hourglass_force[:] = self._grid.hourglass[:, None] * (bent - by_x * pattern[:, :1] - by_y * pattern[:, 1:])

    def _update_forces(self, step: float) -> int:
        """Advance stresses elastically by strains of velocity x step, and write the forces; return an inverted cell, or -1."""
        elastic = self._grid._replace(laws=NoYield())
        return int(kernels.update_forces(elastic, self._state, self._conditions.groups, self._corner, step))

    def _refuse_separation(self, name: str, value: FloatArray) -> None:
        for group in self._assembly.joined:
            members = group[group >= 0]
            if (value[members] != value[members[0]]).any():
                raise ParameterError(
                    f"the nodes {members.tolist()} are joined by periodic edges",
                    hint="give them equal values",
                    at=f"start.{name}",
                )

    @property
    def joined_nodes(self) -> IntArray:
        """Groups of nodes that periodic edges join, rows padded with -1, shape (k, 4)."""
        return self._assembly.joined

    @property
    def tally(self) -> FloatArray:
        """Return the work and impulses of the conditions since the reset; see `kernel_arrays`."""
        return self._block["tally"]

    def tables(self) -> Tables:
        """Return the arrays of the kernels, for a parent component that calls the kernels directly."""
        return Tables(self._grid, self._state, self._conditions, self._corner)

    def drive_factors(self, tick: int, ticks: int) -> FloatArray:
        """Set up `Conditions.drive` of the held inputs; return its signals' means over each of `ticks` ticks from `tick` on."""
        if self._held is not self._driven_by:
            self._signals, drive = make_drive(self._assembly, self._held, self._block["static_force"])
            self._conditions = self._conditions._replace(drive=drive)
            self._driven_by = self._held
        return mean_signals(self._signals, tick, ticks)

    def _advance_state(self, ticks: int) -> int:
        factors, yields = self.drive_factors(self._tick, ticks), self.free_event_rows()
        given = (self.tables(), factors, self._block["tally"], self.step_size, self._tick, yields, self.failed_at)
        parts = 1 if self._plastic or len(self.mesh.cells) < LEAST_CELLS else thread_count()
        status = kernels.advance(*given) if parts == 1 else kernels.advance_in_parts(*given, parts)
        self.set_event_count(yields)
        return int(status)

    def free_event_rows(self) -> Yields:
        """Return free rows in the list of events, one for each cell that can yield."""
        if not self._plastic:
            return Yields(np.zeros((1, 5)), np.zeros(1, dtype=np.int64))
        count = self._block.count("events")
        return Yields(self._block.reserve_rows("events", len(self.mesh.cells) - count), np.array([count]))

    def set_event_count(self, yields: Yields) -> None:
        """Set the number of rows of `free_event_rows` that are in use."""
        if self._plastic:
            self._block.set_row_count("events", int(yields.used[0]))

    def _step_error(self, status: int) -> StepError:
        cell, tick = (int(number) for number in self.failed_at)
        time = tick * self.step_size
        area = float(self._smallest_corner_area(cell))
        return StepError(
            f"cell {cell} has been inverted at {time:.9g} s: the triangle area at a corner is {area:.6g} m2, not above 0; "
            f"load the grid less, or take a smaller step_size (now {self.step_size:g} s)",
            time=time, at="displacement", variable="displacement", index=cell, value=area, limit=0.0,
        )  # fmt: skip

    def _smallest_corner_area(self, cell: int) -> Any:
        """Return the smallest of the triangle areas at the corners of a cell [m2]; negative for an angle above 180 degrees."""
        nodes = self.mesh.cells[cell]
        with np.errstate(all="ignore"):
            corners = self.mesh.nodes[nodes] + self._state.displacement[nodes]
            onward, back = np.roll(corners, -1, axis=0) - corners, np.roll(corners, 1, axis=0) - corners
            return 0.5 * (onward[:, 0] * back[:, 1] - onward[:, 1] * back[:, 0]).min()

    # -- reading ----------------------------------------------------------------------------------------------------

    def _energies_and_momenta(self) -> dict[str, Any]:
        """Return the present energies, momentum and angular momentum."""
        sums = np.zeros(6)
        with np.errstate(all="ignore"):
            kernels.write_energy_sums(self._grid, self._state, self.mass, sums)
            kinetic, hourglass, pulled = (float(number) for number in sums[:3])
            some = self._conditions
            force = np.where(some.prescribed > 0, 0.0, self._state.force[some.nodes])
            pulled += float(((force * force).sum(axis=1) / some.mass * some.share).sum())
            plastic = float(self._state.plastic_work.sum())
            elastic = float(self._state.energy.sum()) - plastic
        correction = -0.125 * self.step_size * self.step_size * pulled
        return {
            "kinetic": kinetic, "elastic": elastic, "hourglass": hourglass, "correction": correction, "plastic": plastic,
            "energy": kinetic + elastic + hourglass + correction, "momentum": sums[3:5].copy(),
            "angular_momentum": float(sums[5]),
        }  # fmt: skip

    def report(self) -> dict[str, float]:
        """Return figures for the report: step over the largest stable step, smallest relative cell area, yielded fraction."""
        moved = self.mesh.nodes + self._state.displacement
        return {
            "step over the largest stable one, at rest": 0.5 * self.highest_frequency * self.step_size,
            "smallest area of a cell over that at rest": float((cell_areas(moved, self.mesh.cells) / self.mesh.areas).min()),
            "fraction of cells that have yielded": self.event_count / len(self.mesh.cells),
        }

    def cautions(self) -> list[str]:
        """Return cautions about points that are not at nodes, and about cells too compressed for the step."""
        smallest = self.report()["smallest area of a cell over that at rest"]
        compressed = (
            f"a cell has {smallest:.2g} of its area at rest: the elastic law is valid for small elastic strains, and the step "
            f"(now {self.step_size:g} s) is chosen for cells at rest; load the grid less, or take a smaller step_size"
        )
        return [*self._off_nodes, *([] if smallest > _COMPRESSED else [compressed])]

    def balances(self) -> tuple[Balance, ...]:
        """Return balances of energy, momentum, mass and, without periodic edges, angular momentum about the origin.

        `leapfrog_energy` is -h^2/8 times the sum of force^2 / mass; with it, the scheme conserves the energy to rounding.
        """
        sums, tally, start = self._energies_and_momenta(), self._block["tally"].copy(), self._block["start"].copy()
        stored = {
            "kinetic_energy": sums["kinetic"],
            "elastic_energy": sums["elastic"],
            "hourglass_energy": sums["hourglass"],
            "leapfrog_energy": sums["correction"],
        }
        lost = {"plastic_work": sums["plastic"], "absorbed_energy": float(tally[kernel_arrays.ABSORBED])}
        impulse = {
            "impulse": tally[kernel_arrays.IMPULSE : kernel_arrays.IMPULSE + 2],
            "boundary_impulse": tally[kernel_arrays.BOUNDARY_IMPULSE : kernel_arrays.BOUNDARY_IMPULSE + 2],
        }
        mass = float(self.mass.sum())
        found = [
            Balance("energy", "J", stored, {"input_work": float(tally[kernel_arrays.WORK])}, lost, float(start[0])),
            Balance("momentum", "kg m/s", {"momentum": sums["momentum"]}, impulse, initial=start[1:3]),
            Balance("mass", "kg", {"mass": mass}, initial=mass),
        ]
        if not len(self._assembly.joined):
            turning = {
                "angular_impulse": float(tally[kernel_arrays.ANGULAR]),
                "boundary_angular_impulse": float(tally[kernel_arrays.BOUNDARY_ANGULAR]),
            }
            turned = {"angular_momentum": sums["angular_momentum"]}
            found.insert(2, Balance("angular_momentum", "kg m2/s", turned, turning, initial=float(start[3])))
        return tuple(found)

    def drawables(self) -> tuple[Drawable, ...]:
        """Return the grid and its nodes, coloured by speed."""
        mesh = self.mesh
        # The radius of a node is a quarter of the side of a square with the mean area of its cells.
        around = np.maximum(np.bincount(mesh.cells.ravel(), minlength=len(mesh.nodes)), 1)
        area = np.bincount(mesh.cells.ravel(), np.repeat(mesh.areas, 4), len(mesh.nodes)) / around
        return (
            Cells("grid", mesh.nodes, mesh.cells, "speed", "displacement"),
            Points("nodes", mesh.nodes, 0.25 * np.sqrt(area), "displacement", "speed"),
        )
