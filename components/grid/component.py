"""The grid as a component: a continuum in plane strain on a mesh of quadrilaterals that moves with it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from ..component import Component
from ..contract import Balance, Variable
from ..drawables import Cells, Drawable, Points
from ..errors import ParameterError, StepError
from ..inputs import Held
from ..materials.elastic import Material, material
from ..profiles import CompiledProfile
from ..snapshot import EVENT_ROWS, FloatArray
from ..support.roots import round_down_to_125
from . import conditions, kernels, layout
from .boundaries import Boundary
from .mesh import IntArray, Mesh
from .parameters import GridParameters, Place
from .schedule import make_schedule
from .stability import ALLOWED, SUGGESTED, highest_frequency

# The state, and what kernels keep beside it, for each cell of a large mesh.
_BYTES_OF_CELL = 420
_STATE = ("displacement", "velocity", "force", "stress", "hourglass_force", "energy", "plastic_strain", "plastic_work")
_YIELD = {"cell_yielded": "the equivalent stress of a cell reached its yield stress for the first time"}


class Grid(Component):
    """A continuum in plane strain on a mesh of quadrilaterals that moves with it: Wilkins (1964), Psakhie et al. (2003).

    rho u'' = div sigma with a hypoelastic law (Jaumann rate) and plasticity. Forces, masses and energies are those of a slab
    one metre thick. See `GridParameters`.
    """

    name = "grid"
    Parameters = GridParameters
    parameters: GridParameters

    # -- building ---------------------------------------------------------------------------------------------------

    @classmethod
    def memory_needed(cls, parameters: GridParameters) -> int:
        """Return what mesh, state, its copy and the kernels' tables take."""
        return _BYTES_OF_CELL * parameters.mesh.cell_count

    def _build(self) -> None:
        p = self.parameters
        try:
            self.mesh: Mesh = p.mesh.build()
            self.joined: IntArray = conditions.joined_nodes(self.mesh, p.boundaries)
            self._prescribed = conditions.prescribed_components(self.mesh, p.boundaries)
        except ValueError as error:
            raise ParameterError(f"component 'grid': {error}") from None
        self.cell_material: IntArray = self._materials_of_cells()
        self._materials: list[Material] = [material(one) for one in p.materials]
        self._forced = self._nodes_at("forced_nodes", p.forced_nodes)
        self._receivers = self._nodes_at("receivers", p.receivers)
        self._edge_inputs = conditions.edge_inputs(self.mesh, p.boundaries, self._forced.tolist())
        self._plastic = any(p.plastic_laws[number].code for number in np.unique(self.cell_material))
        self.mass = self._lump(np.array([one.density for one in self._materials])[self.cell_material] * self.mesh.areas)
        self._make_tables(np.zeros(len(self.mesh.nodes)))
        self.highest_frequency: float = highest_frequency(self._grid, self._conditions, self._corner)
        self.step_size = self._suggest_step() if p.step_size is None else p.step_size
        self._refuse_large_step()
        self._lay_out_state()

    def _materials_of_cells(self) -> IntArray:
        p, count = self.parameters, len(self.mesh.cells)
        if p.cell_material is not None:
            if len(p.cell_material) != count:
                raise ParameterError(f"cell_material: got {len(p.cell_material)} numbers, expected {count}, one for each cell")
            return np.array(p.cell_material, dtype=np.int64)
        numbers = np.zeros(count, dtype=np.int64)
        for place, region in enumerate(p.regions):
            inside = region.area.contains(self.mesh.centres)
            if not inside.any():
                raise ParameterError(f"regions[{place}]: contains the middle of no cell")
            numbers[inside] = region.material
        return numbers

    def _nodes_at(self, name: str, places: list[Place]) -> IntArray:
        """Return the nodes that are meant by numbers or points."""
        found = []
        for index, place in enumerate(places):
            if isinstance(place, int) and place >= len(self.mesh.nodes):
                raise ParameterError(f"{name}[{index}]: got node {place}, expected 0 to {len(self.mesh.nodes) - 1}")
            found.append(place if isinstance(place, int) else self.mesh.nearest_node(place[0], place[1]))
            if found[-1] in found[:-1]:
                raise ParameterError(f"{name}[{index}]: node {found[-1]} is there already; give each node once")
        return np.array(found, dtype=np.int64)

    def _lump(self, amounts: FloatArray) -> FloatArray:
        """Return what each node has of amounts of the cells: a quarter of each cell around it, shape (n,)."""
        corners = np.zeros((len(self.mesh.nodes), 4))
        for corner in range(4):
            np.add.at(corners[:, corner], self.mesh.cells[:, corner], 0.25 * amounts)
        # In two pairs, so that mirror images have the same bits.
        return (corners[:, 0] + corners[:, 1]) + (corners[:, 2] + corners[:, 3])

    def attach(self, mass: FloatArray) -> None:
        """Let nodes carry masses of another body too, whose forces a parent adds to those of the cells; shape (n,) [kg].

        They become nodes with conditions. To be called before the first step.
        """
        self._make_tables(mass)

    def _make_tables(self, attached: FloatArray) -> None:
        p, mesh, count = self.parameters, self.mesh, len(self.mesh.nodes)
        moduli = np.array([[one.first_lame, one.shear_modulus] for one in self._materials])
        density, longitudinal, shear = (
            np.array([getattr(one, name) for one in self._materials])[self.cell_material]
            for name in ("density", "longitudinal_speed", "shear_speed")
        )
        damped = conditions.dashpots(mesh, p.boundaries, density, longitudinal, shear, self.mass)
        plan = make_schedule(count, mesh.cells)
        nodes = conditions.special_nodes(
            self.joined, self._edge_inputs, self._prescribed, damped,
            np.concatenate([plan.further[:, 0].astype(np.int64), np.flatnonzero(attached)]),
        )  # fmt: skip
        places = np.full(count, -1, dtype=np.int64)
        places[nodes] = np.arange(len(nodes))
        self._places = places
        own = conditions.join_rows(self.mass[nodes, None], places, self.joined)[:, 0]
        mass = self.mass + attached
        mass[nodes] = conditions.join_rows(mass[nodes, None], places, self.joined)[:, 0]
        damping = np.array([damped.get(node, np.zeros(3)) for node in nodes.tolist()]).reshape(-1, 3)
        self._conditions = layout.Conditions(
            nodes=nodes.astype(np.uint32),
            mass=mass[nodes],
            damping=conditions.join_rows(damping, places, self.joined),
            prescribed=self._prescribed_flags(nodes),
            share=self.mass[nodes] / own,
            groups=self.joined.astype(np.int32),
            drive=np.zeros((1, len(nodes), 2)),
            begin=np.zeros((len(nodes), 5, 2)),
        )
        special = np.zeros(count, dtype=np.uint8)
        special[nodes] = 1
        self._grid = layout.Grid(
            reference=mesh.nodes,
            cells=mesh.cells.astype(np.uint32),
            mass=mass,
            half_inverse=0.5 / mass,
            material=self.cell_material.astype(np.uint32),
            moduli=moduli,
            laws=np.array([[float(law.code), *law.constants()] for law in p.plastic_laws]),
            hourglass=self._hourglass_stiffness(moduli),
            slots=plan.slots,
            node_slots=plan.node_slots,
            further=plan.further,
            order=plan.order,
            tiles=plan.tiles,
            special=special,
        )
        self._corner = np.zeros((plan.rows, 2))

    def _prescribed_flags(self, nodes: IntArray) -> np.ndarray:
        flags = np.zeros((len(nodes), 2))
        for node, components in self._prescribed.items():
            flags[self._places[node], list(components)] = 1.0
        return (conditions.join_rows(flags, self._places, self.joined) > 0.0).astype(np.uint8)

    def _hourglass_stiffness(self, moduli: FloatArray) -> FloatArray:
        """Return kappa (lambda + 3 mu) / 12 of each cell, times (w^2 + h^2) / 2 w h for its width and height, shape (m,) [Pa].

        That is the trace of what full integration gives a rectangle; 1 for a square.
        """
        corners = self.mesh.nodes[self.mesh.cells]
        diagonals = ((corners[:, 2] - corners[:, 0]) ** 2).sum(axis=1) + ((corners[:, 3] - corners[:, 1]) ** 2).sum(axis=1)
        stiffness = self.parameters.hourglass * (moduli[:, 0] + 3.0 * moduli[:, 1]) / 12.0
        return stiffness[self.cell_material] * (diagonals / (4.0 * self.mesh.areas))

    def _suggest_step(self) -> float:
        if self.highest_frequency == 0.0:
            raise ParameterError("boundaries: no node can move; leave an edge free, or make the mesh finer")
        return round_down_to_125(SUGGESTED * 2.0 / self.highest_frequency)

    def _refuse_large_step(self) -> None:
        if self.highest_frequency * self.step_size > 2.0 * ALLOWED:
            largest = 2.0 / self.highest_frequency
            raise ParameterError(
                f"step_size: got {self.step_size:g} s, expected at most {ALLOWED * largest:.4g} s, {ALLOWED:g} of the largest "
                f"stable one, 2 / omega = {largest:.4g} s; leave it out, or make the cells larger"
            )

    def _lay_out_state(self) -> None:
        n, m = len(self.mesh.nodes), len(self.mesh.cells)
        plastic = m if self._plastic else 0
        self._lay_out(
            growing={"events": EVENT_ROWS} if self._plastic else None,
            displacement=("f8", (n, 2)), velocity=("f8", (n, 2)), force=("f8", (n, 2)), stress=("f8", (m, 4)),
            hourglass_force=("f8", (m, 2)), energy=("f8", (m,)), plastic_strain=("f8", (plastic,)),
            plastic_work=("f8", (plastic,)), tally=("f8", (layout.TALLY,)), start=("f8", (4,)),
        )  # fmt: skip
        if self._plastic:  # only then can anything happen that is an event
            vars(self)["event_kinds"] = _YIELD
        self._state = layout.State(*(self._block[name] for name in _STATE))
        self._driven_by: Mapping[str, Held] | None = None
        self._signals: list[CompiledProfile] = []
        self.failed = np.zeros(2, dtype=np.int64)

    # -- the contract -----------------------------------------------------------------------------------------------

    def _declare(self) -> Iterable[Variable]:
        n, m, k = len(self.mesh.nodes), len(self.mesh.cells), len(self._receivers)
        nodes, cells, received = ("node", "direction"), ("cell",), ("receiver", "direction")
        for one in self._edge_inputs:
            yield one.variable
        yield Variable("displacement", "output", "m", (n, 2), "displacement of the nodes from the mesh", state=True, axes=nodes)
        yield Variable("velocity", "output", "m/s", (n, 2), "velocity of the nodes", state=True, axes=nodes)
        yield Variable("speed", "output", "m/s", (n,), "magnitude of the velocity", minimum=0.0, axes=("node",))
        yield Variable(
            "stress", "output", "Pa", (m, 4), "stresses xx, yy, zz, xy of the cells, tension positive; a start value of the "
            "displacement gives them too, elastically, where they have none of their own", state=True, axes=("cell", "entry"),
        )  # fmt: skip
        yield Variable("pressure", "output", "Pa", (m,), "mean of the normal stresses, compression positive", axes=cells)
        yield Variable("equivalent_stress", "output", "Pa", (m,), "of von Mises: sqrt(3/2 s:s)", minimum=0.0, axes=cells)
        yield Variable("plastic_strain", "output", "1", (m,), "equivalent plastic strain of the cells", minimum=0.0, axes=cells)
        yield Variable("internal_energy", "output", "J", (m,), "work that stresses have done on the cells", axes=cells)
        yield Variable("receiver_displacement", "output", "m", (k, 2), "displacement of the `receivers`", axes=received)
        yield Variable("receiver_velocity", "output", "m/s", (k, 2), "velocity of the `receivers`", axes=received)

    def _outputs(self) -> dict[str, Callable[[], Any]]:
        state = self._state
        return {
            "displacement": lambda: state.displacement,
            "velocity": lambda: state.velocity,
            "speed": lambda: np.sqrt((state.velocity * state.velocity).sum(axis=1)),
            "stress": lambda: state.stress,
            "pressure": lambda: -state.stress[:, :3].sum(axis=1) / 3.0,
            "equivalent_stress": self._equivalent_stress,
            "plastic_strain": lambda: state.plastic_strain if self._plastic else np.zeros(len(self.mesh.cells)),
            "internal_energy": lambda: state.energy,
            "receiver_displacement": lambda: state.displacement[self._receivers],
            "receiver_velocity": lambda: state.velocity[self._receivers],
        }

    def _equivalent_stress(self) -> FloatArray:
        xx, yy, zz, xy = self._state.stress.T
        spread = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
        return np.sqrt(0.5 * spread + 3.0 * xy * xy)

    def _start(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        state = self._state
        for name in ("displacement", "velocity"):
            if name in values:
                self._refuse_parting(name, values[name])
        if "displacement" in values:
            # As if it had happened in one tick.
            state.displacement[:] = state.velocity[:] = values["displacement"]
            self._refuse_inverted_start(self._update_forces(1.0))
            state.velocity[:] = 0.0
        if "stress" in values:
            state.stress[:] = values["stress"]
            self._update_forces(0.0)
        kernels.stress_energies(self._grid, state)
        if "velocity" in values:
            state.velocity[:] = values["velocity"]
        self._driven_by = None
        sums = self._sums()
        self._block["start"][:] = sums["energy"], *sums["momentum"], sums["angular_momentum"]
        return {}

    def _update_forces(self, step: float) -> int:
        """Advance stresses elastically by velocity x step [s], and write the forces; return a cell that is inverted, or -1."""
        elastic = self._grid._replace(laws=np.zeros_like(self._grid.laws))
        groups, events, counts = self._conditions.groups, np.zeros((1, 5)), np.zeros(1, dtype=np.int64)
        return int(kernels.forces(elastic, self._state, groups, self._corner, step, 0, events, counts))

    def _refuse_parting(self, name: str, value: FloatArray) -> None:
        for group in self.joined:
            members = group[group >= 0]
            if (value[members] != value[members[0]]).any():
                raise ParameterError(
                    f"start.{name}: the nodes {members.tolist()} are joined by periodic edges; give them one value"
                )

    def _refuse_inverted_start(self, cell: int) -> None:
        if cell >= 0:
            raise ParameterError(f"start.displacement: cell {cell} would be inverted; give smaller displacements")

    def tables(self) -> tuple[layout.Grid, layout.State, layout.Conditions, FloatArray]:
        """Return what the kernels work on, for a parent that calls them itself; the last one is their scratch."""
        return self._grid, self._state, self._conditions, self._corner

    @property
    def tally(self) -> FloatArray:
        """What came in, or went out, through the conditions since the reset; see `layout`."""
        return self._block["tally"]

    def signal_factors(self, tick: int, ticks: int) -> FloatArray:
        """Lay out what the held inputs do; return the factors of the signals in the middle of so many ticks from `tick` on."""
        if self._held is not self._driven_by:
            self._assemble_drive()
        factors = np.ones((ticks, 1 + len(self._signals)))
        for place, profile in enumerate(self._signals):
            factors[:, 1 + place] = profile_factors(profile, tick, ticks)
        return factors

    def _advance(self, ticks: int) -> int:
        factors = self.signal_factors(self._tick, ticks)
        events, counts = np.zeros((1, 5)), np.zeros(1, dtype=np.int64)
        if self._plastic:
            counts[0] = self._block.count("events")
            events = self._block.room("events", len(self.mesh.cells) - int(counts[0]))
        status = kernels.advance(
            self._grid, self._state, self._conditions, factors, self._corner, self._block["tally"], self.step_size, self._tick,
            events, counts, self.failed,
        )  # fmt: skip
        if self._plastic:
            self._block.set_count("events", int(counts[0]))
        return int(status)

    def _assemble_drive(self) -> None:
        """Lay what the held inputs do to nodes into the signals: the first holds all that does not change."""
        held = [self._held[one.variable.name] for one in self._edge_inputs]
        self._signals = [value for value in held if isinstance(value, CompiledProfile)]
        nodes = self._conditions.nodes
        drive = np.zeros((1 + len(self._signals), len(nodes), 2))
        forces, velocities = np.zeros_like(drive), np.zeros_like(drive)
        signal = 0
        for one, value in zip(self._edge_inputs, held, strict=True):
            profile = isinstance(value, CompiledProfile)
            signal += profile
            target, rows = (velocities if one.velocity else forces)[signal if profile else 0], self._places[one.nodes]
            given = one.act(value.pattern if profile else value)
            if one.velocity:
                self._prescribe(target, one, rows, given)
            else:
                target[rows] += given
        flags = self._conditions.prescribed > 0
        for place in range(len(drive)):
            forces_joined = conditions.join_rows(forces[place], self._places, self.joined)
            drive[place] = np.where(flags, self._share_velocities(velocities[place]), forces_joined)
        self._conditions = self._conditions._replace(drive=drive)
        self._driven_by = self._held

    def _prescribe(self, target: FloatArray, one: conditions.EdgeInput, rows: IntArray, given: FloatArray) -> None:
        """Write velocities where this edge is the one that prescribes them."""
        edge = one.variable.name.removesuffix("_velocity")
        for component in (0, 1):
            own = [self._prescribed.get(node, {}).get(component) == edge for node in one.nodes.tolist()]
            target[rows[own], component] = given[own, component]

    def _share_velocities(self, velocities: FloatArray) -> FloatArray:
        """Return velocities with those of joined nodes set to the one that is prescribed for the first of them."""
        shared = velocities.copy()
        for group in self.joined:
            members = group[group >= 0]
            for component in (0, 1):
                own = [node for node in members.tolist() if component in self._prescribed.get(node, {})]
                if own:
                    shared[self._places[members], component] = velocities[self._places[own[0]], component]
        return shared

    def _explain(self, status: int) -> StepError:
        cell, tick = (int(number) for number in self.failed)
        time = tick * self.step_size
        area = float(self._area(cell))
        return StepError(
            f"displacement: cell {cell} has been inverted at {time:.9g} s, its area is {area:.6g} m2, expected more than 0; "
            f"load the grid less, or take a smaller step_size (now {self.step_size:g} s)",
            time=time, variable="displacement", index=cell, value=area, limit=0.0,
        )  # fmt: skip

    def _area(self, cell: int) -> Any:
        nodes = self.mesh.cells[cell]
        with np.errstate(all="ignore"):
            corners = self.mesh.nodes[nodes] + self._state.displacement[nodes]
            first, second = corners[2] - corners[0], corners[3] - corners[1]
            return 0.5 * (first[0] * second[1] - first[1] * second[0])

    # -- reading ----------------------------------------------------------------------------------------------------

    def _sums(self) -> dict[str, Any]:
        """Return energies, momentum, angular momentum as they are."""
        sums = np.zeros(6)
        with np.errstate(all="ignore"):
            kernels.energies(self._grid, self._state, self.mass, sums)
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

    def balances(self) -> tuple[Balance, ...]:
        """Return energy, momentum, angular momentum about the origin (not where edges are periodic), and mass.

        `leapfrog_energy` is -h^2/8 times the sum of force^2 / mass: with it, the energy that the scheme conserves to rounding.
        """
        sums, tally, start = self._sums(), self._block["tally"].copy(), self._block["start"].copy()
        stored = {
            "kinetic_energy": sums["kinetic"],
            "elastic_energy": sums["elastic"],
            "hourglass_energy": sums["hourglass"],
            "leapfrog_energy": sums["correction"],
        }
        lost = {"plastic_work": sums["plastic"], "absorbed_energy": float(tally[layout.ABSORBED])}
        impulse = {
            "impulse": tally[layout.IMPULSE : layout.IMPULSE + 2],
            "boundary_impulse": tally[layout.BOUNDARY_IMPULSE : layout.BOUNDARY_IMPULSE + 2],
        }
        mass = float(self.mass.sum())
        found = [
            Balance("energy", "J", stored, {"input_work": float(tally[layout.WORK])}, lost, float(start[0])),
            Balance("momentum", "kg m/s", {"momentum": sums["momentum"]}, impulse, initial=start[1:3]),
            Balance("mass", "kg", {"mass": mass}, initial=mass),
        ]
        if not len(self.joined):
            turning = {
                "angular_impulse": float(tally[layout.ANGULAR]),
                "boundary_angular_impulse": float(tally[layout.BOUNDARY_ANGULAR]),
            }
            turned = {"angular_momentum": sums["angular_momentum"]}
            found.insert(2, Balance("angular_momentum", "kg m2/s", turned, turning, initial=float(start[3])))
        return tuple(found)

    def drawables(self) -> tuple[Drawable, ...]:
        """Return the grid, coloured by speed, and the receivers."""
        shown: list[Drawable] = [Cells("grid", self.mesh.nodes, self.mesh.cells, "speed", "displacement")]
        if len(self._receivers):
            radius = np.full(len(self._receivers), 0.5 * float(np.sqrt(self.mesh.areas.min())))
            shown.append(Points("receivers", self.mesh.nodes[self._receivers], radius, "receiver_displacement"))
        return tuple(shown)

    def boundary_of(self, edge: str) -> Boundary | None:
        """Return what an edge does; None where it is free."""
        return self.parameters.boundaries.get(edge)


def profile_factors(profile: CompiledProfile, tick: int, ticks: int) -> FloatArray:
    """Return the factor of a profile in the middle of each of so many ticks, shape (ticks,)."""
    now = np.arange(tick, tick + ticks)
    piece = np.searchsorted(profile.ticks, now, side="right") - 1
    rows = profile.coefficients[np.maximum(piece, 0)]
    since = (now - profile.ticks[np.maximum(piece, 0)]).astype(np.float64) + 0.5
    value = np.zeros(ticks)
    for power in range(rows.shape[1] - 1, -1, -1):
        value = value * since + rows[:, power]
    return np.where(piece < 0, 0.0, value)
