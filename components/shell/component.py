"""The solid as a component: thin walls in three dimensions, by moving least squares, in total Lagrangian form."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from ..balances import Balance
from ..component import Component
from ..drawables import Cells, Drawable, Points
from ..errors import ParameterError, StepError
from ..support.float_arrays import FloatArray
from ..support.stable_step import longest_suggested_step, refuse_large_step, suggest_step
from ..variables import Variable
from . import energies, kernel_arrays, kernels
from .boundaries import AT_REST, signal_pattern, tick_signals
from .fields import Fields
from .fracture.breaking_body import KINDS, BreakingBody
from .fracture.laws.fracture_law import FractureLaw
from .fracture.outcome import BULGED, BULGED_STRAIN, OUTCOMES, WHOLE
from .geometry.lattice import Lattice
from .kernel_arrays import IntArray, Solid, State, Tables
from .kernel_setup import Assembly, assemble_solid, station_means, surface_quads
from .parameters import ShellParameters
from .quadrature import RuleName
from .stability import CRACKED, WALL_STIFFNESS, highest_frequency
from .ticks import advance, update_forces, write_wall_force

_STATE = ("displacement", "velocity", "force", "gradient", "stress", "plastic_strain", "temperature", "plastic_work", "area")
# Memory per node and per integration point [bytes], at least: tables, state, its copy, scratch, stencils for reading fields. A
# notch adds up to a twentieth.
_BYTES_OF_NODE, _BYTES_OF_POINT = 385, 670
# Additional memory per node of a body that can break [bytes]: its points, pairs and surfaces, intact and cracked.
_BYTES_OF_BREAKING = 190
_POINTS_OF_CELL: dict[RuleName, int] = {"column": 1, "cell": 4}
# Status of a tick -> description of the failure, and the output that it concerns.
_FAILURES = {
    kernel_arrays.INVERTED: ("the body is inverted (its volume is {value:.3g} of the initial one)", "stress"),
    kernel_arrays.STRAINED: ("a strain of {value:.3g} in one tick (limit {limit:g})", "stress"),
    kernel_arrays.FLOWN: ("a plastic strain of {value:.3g} (limit {limit:g})", "plastic_strain"),
    kernel_arrays.HEATED: ("{value:.4g} K, more than {limit:g} K,", "temperature"),
}
# A caution is issued if hourglass control stores a larger fraction of the energy.
_HOURGLASS_PART = 0.05


class Shell(Component):
    """A solid with thin walls, meshfree and in three dimensions: the tube of Gato & Shie (2010).

    Displacements are sums of moving-least-squares functions in material coordinates; weak form, central differences. See
    `ShellParameters`.
    """

    name = "shell"
    version = 6
    Parameters = ShellParameters
    parameters: ShellParameters

    # -- building ---------------------------------------------------------------------------------------------------

    @classmethod
    def memory_needed(cls, parameters: ShellParameters) -> int:
        """Return the memory of tables, state, its copy and the scratch of the kernels."""
        along, across, layers = parameters.body.node_counts
        points = along * across * parameters.integration_rule.through * _POINTS_OF_CELL[parameters.integration_rule.surface]
        of_node = _BYTES_OF_NODE + (_BYTES_OF_BREAKING if isinstance(parameters.fracture, FractureLaw) else 0)
        return of_node * along * across * layers + _BYTES_OF_POINT * points

    def _build_system(self) -> None:
        p, law = self.parameters, self.parameters.fracture
        self.assembly: Assembly = assemble_solid(p)
        self.lattice: Lattice = self.assembly.lattice
        self.nodes: FloatArray = self.lattice.nodes
        self.mass: FloatArray = self.assembly.solid.nodes.mass
        self.highest_frequency: float = highest_frequency(self.assembly.solid)
        bounding = self.highest_frequency * (CRACKED if isinstance(law, FractureLaw) else 1.0)
        suggested = suggest_step(bounding, "leave an edge free, or give more nodes")
        self.longest_suggested_step: float = longest_suggested_step(bounding)
        self.step_size = p.step_size or suggested
        refuse_large_step(self.step_size, bounding, "leave it out, or give fewer nodes")
        whole = self._complete_solid()
        self._plastic = whole.plastic
        self._breaking = BreakingBody(p, law, self.assembly, whole) if isinstance(law, FractureLaw) else None
        if self._breaking is not None:
            self._declare_events(KINDS, self._breaking.details)
        self._lay_out_state(whole)

    def _complete_solid(self) -> Solid:
        """Return the tables of the kernels, with those that depend on the step."""
        p, wall = self.parameters, self.assembly.conditions.wall
        stiffness = WALL_STIFFNESS * self.highest_frequency * self.highest_frequency * self.mass
        return self.assembly.solid._replace(
            law=p.material.constants(self.step_size), plastic=p.material.name != "elastic", step=self.step_size, wall=wall,
            bounce=stiffness if wall[1] else np.zeros(0),
        )  # fmt: skip

    def _lay_out_state(self, intact_solid: Solid) -> None:
        n, m, s = len(self.nodes), self.point_count, len(intact_solid.surface.nodes)
        plastic = m if intact_solid.plastic else 0
        growing, fields = ({}, {}) if self._breaking is None else (self._breaking.growing, self._breaking.fields)
        self._define_state(
            growing,
            displacement=("f8", (n, 3)), velocity=("f8", (n, 3)), force=("f8", (n, 3)), gradient=("f8", (m, 9)),
            stress=("f8", (m, 6)), plastic_strain=("f8", (plastic,)), temperature=("f8", (plastic,)),
            plastic_work=("f8", (plastic,)), area=("f8", (s, 3)), tally=("f8", (kernel_arrays.TALLY,)), start=("f8", (4,)),
            **fields,
        )  # fmt: skip
        self._state = State(*(self._block[name] for name in _STATE))
        self._scratch = kernel_arrays.make_scratch(m, len(intact_solid.hourglass.partner), s)
        self._whole = Tables(intact_solid, self._state, self._scratch, self._block["tally"])
        self._failed = np.zeros(2, dtype=np.int64)
        self._fields = Fields(self.assembly, self._whole, self._breaking, self.parameters.initial_temperature)
        if self._breaking is not None:
            self._breaking.attach_state(self._block, self._whole, self._add_event)

    def _state_contradiction(self, state: Mapping[str, np.ndarray]) -> str:
        return "" if self._breaking is None else self._breaking.contradiction(state)

    def tables(self) -> Tables:
        """Return the tables of the kernels with the cracks of the state, for a parent component that calls `ticks` directly."""
        return self._whole if self._breaking is None else self._breaking.tables()

    @property
    def point_count(self) -> int:
        """Number of integration points."""
        return len(self.assembly.points.volume)

    @property
    def surface_nodes(self) -> IntArray:
        """Numbers of the nodes on the outer surface of a tube, or the upper one of a plate."""
        return self.lattice.top_nodes

    # -- inputs and outputs -----------------------------------------------------------------------------------------

    def _declare_variables(self) -> Iterable[Variable]:
        yield Variable(
            "pressure", "input", "Pa", self.lattice.shape[:1], "pressure on the inner surface (lower surface of a plate) at "
            "each plane of nodes along the body, normal to the deformed surface", start=0.0, axes=("station",), nominal=1e6,
        )  # fmt: skip
        for edge, axis in self.assembly.conditions.moved.items():
            shape, text = ((3,), "velocity") if axis < 0 else ((), f"velocity along {'xyz'[axis]}")
            axes = ("direction",)[: len(shape)]
            yield Variable(f"{edge}_velocity", "input", "m/s", shape, f"{text} of the {edge} edge", start=0.0, axes=axes)
        for one in self._fields.outputs():
            yield one.variable

    def _output_readers(self) -> dict[str, Callable[[], Any]]:
        return {one.variable.name: one.read for one in self._fields.outputs()}

    # -- stepping ---------------------------------------------------------------------------------------------------

    def _write_start_state(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        state, solid = self._state, self.tables().solid
        if self._plastic:
            state.temperature[:] = values.get("temperature", self.parameters.initial_temperature)
            state.plastic_strain[:] = values.get("plastic_strain", 0.0)
            for name, is_sound, expected in (
                ("temperature", (state.temperature > 0.0).all(), "more than 0 everywhere"),
                ("plastic_strain", (state.plastic_strain >= 0.0).all(), "0 or more everywhere"),
            ):
                if not is_sound:
                    raise ParameterError("got a value that is too small", expected=expected, at=("start", name))
        if "nodal_displacement" in values:
            # The stresses are computed as if the displacements had been made in one tick.
            self._write_start_value("nodal_displacement", state.displacement, values)
        if update_forces(solid, state, self._scratch, self._failed):
            raise ParameterError(
                f"the body would be inverted or strained beyond the limit at point {self._failed[0]}",
                expected="smaller displacements", at=("start", "nodal_displacement"),
            )  # fmt: skip
        if "stress" in values:
            state.stress[:] = values["stress"]
            update_forces(solid, state, self._scratch, self._failed)
        if "nodal_velocity" in values:
            self._write_start_value("nodal_velocity", state.velocity, values)
        write_wall_force(solid, state, self._block["tally"])
        kernels.write_areas(solid.surface, state.displacement, state.area)
        sums = self._energies_and_momenta()
        self._block["start"][:] = sums["energy"], *sums["momentum"]
        return {}

    def _write_start_value(self, name: str, part: FloatArray, values: Mapping[str, FloatArray]) -> None:
        """Write the start value of a variable of the nodes."""
        part[:] = values[name]
        moving = (self._whole.solid.nodes.prescribed == AT_REST) & (part != 0.0)
        if moving.any():
            node, direction = (int(one[0]) for one in np.nonzero(moving))
            came = f"got {part[node, direction]:g} for a node that a boundary fixes"
            raise ParameterError(came, expected="0", at=("start", name, node, direction))

    def _advance_state(self, ticks: int) -> int:
        signals = tick_signals(self._held, self.assembly.conditions.moved, self._tick, ticks)
        pressures = signal_pattern(self._held["pressure"])
        if self._breaking is not None:
            return self._breaking.advance(signals, pressures, self._tick, self._failed)
        return advance(self._whole, signals, pressures, self._tick, self._failed)

    def _step_error(self, status: int) -> StepError:
        point, tick = (int(number) for number in self._failed)
        time, where = tick * self.step_size, self.assembly.describe_position(point)
        value, limit = (float(number) for number in self._scratch.pull[point, :2])
        what, variable = _FAILURES[status]
        return StepError(
            f"{what.format(value=value, limit=limit)} at point {point} ({where}) at {time:.9g} s; load the body "
            f"less, or take a smaller step_size (now {self.step_size:g} s; the largest stable step at the compression "
            f"reached is {self.step_size / self._compressed_step_part():.2g} s)",
            time=time, at=variable, variable=variable, index=point, value=value, limit=limit,
        )  # fmt: skip

    # -- reading ----------------------------------------------------------------------------------------------------

    @np.errstate(all="ignore")
    def _energies_and_momenta(self) -> dict[str, Any]:
        """Return the present energies and momentum."""
        return energies.energies_and_momentum(self.tables())

    def balances(self) -> tuple[Balance, ...]:
        """Return the balances of energy, momentum, and mass.

        `leapfrog_energy` is -h^2/8 times the sum of force^2 / mass; with it, the scheme conserves the energy of a linear body.
        For other bodies an error of second order in the step remains.
        """
        sums, tally, start = self._energies_and_momenta(), self._block["tally"].copy(), self._block["start"].copy()
        stored = {name: sums[name] for name in energies.STORED}
        supplied = {
            "pressure_work": float(tally[kernel_arrays.PRESSURE_WORK]),
            "boundary_work": float(tally[kernel_arrays.BOUNDARY_WORK]),
        }
        lost = {
            "plastic_work": sums["plastic_work"],
            **({} if self._breaking is None else self._breaking.dissipated_energies()),
        }
        impulse = {
            "pressure_impulse": tally[kernel_arrays.PRESSURE_IMPULSE : kernel_arrays.PRESSURE_IMPULSE + 3],
            "boundary_impulse": tally[kernel_arrays.BOUNDARY_IMPULSE : kernel_arrays.BOUNDARY_IMPULSE + 3],
            "wall_impulse": np.array([tally[kernel_arrays.WALL_IMPULSE], 0.0, 0.0]),
        }
        mass = float(self.mass.sum())
        return (
            Balance("energy", "J", stored, supplied, lost, float(start[0])),
            Balance("momentum", "kg m/s", {"momentum": sums["momentum"]}, impulse, initial=start[1:4]),
            Balance("mass", "kg", {"mass": mass}, initial=mass),
        )

    def report(self) -> dict[str, float]:
        """Return figures for the report: ratio of the step to the largest stable one, and the largest loads and strains."""
        sums = self._energies_and_momenta()
        stored = sums["elastic_energy"] + sums["kinetic_energy"] + sums["plastic_work"]
        found = {
            "step over the largest stable one, at rest": 0.5 * self.highest_frequency * self.step_size,
            "step over the largest stable one, at the present compression": self._compressed_step_part(),
            "largest equivalent stress now, Pa": float(self._fields.equivalent_stress().max()),
            "hourglass energy over that of the body": sums["hourglass_energy"] / stored if stored > 0.0 else 0.0,
        }
        if self._plastic:
            found |= {
                "largest plastic strain": float(self._state.plastic_strain.max()),
                "highest temperature, K": float(self._state.temperature.max()),
            }
        if self._fields.has_fracture_ratio:
            ratio = self._fields.fracture_ratio()
            nearest = int(ratio.argmax())
            found |= {
                "largest fracture ratio now": float(ratio[nearest]),
                "where along the body, m": self.assembly.coordinates(nearest)[0],
            }
        return found if self._breaking is None else {**found, **self._breaking.report(self.step_size)}

    def conclusions(self) -> list[str]:
        """Return sentences: whether the body is whole, bulged or cracked, the extent of cracks, the largest fracture ratio."""
        if self._breaking is not None:
            return self._breaking.conclusions(self.step_size)
        if not self._plastic:
            return []
        strain, report = float(station_means(self.assembly, self._state.plastic_strain).max()), self.report()
        return [
            f"outcome: {OUTCOMES[BULGED if strain > BULGED_STRAIN else WHOLE]}; no fracture law is chosen",
            f"largest principal stress now: {report['largest fracture ratio now']:.3g} of three times the yield stress, at "
            f"{1e3 * report['where along the body, m']:.4g} mm along the body",
        ]

    def cautions(self) -> list[str]:
        """Return cautions if hourglass control stores too much energy, or if the body is compressed too much for the step."""
        found, report = [], self.report()
        part, step = report["hourglass energy over that of the body"], self._compressed_step_part()
        if part > _HOURGLASS_PART:
            found.append(
                f"hourglass control stores {part:.1%} of the energy: displacements alternate from column to column; give more "
                "nodes, or integration = {surface = 'cell'}"
            )
        if step > 1.0:
            found.append(
                f"at the largest compression of the body, the step (now {self.step_size:g} s) is {step:.2f} times the "
                "largest stable one; take a smaller step_size"
            )
        melting, temperature = self.parameters.material.melting_temperature, self._fields.temperature()
        if melting is not None and temperature.max() > melting:
            found.append(
                f"{np.mean(temperature > melting):.0%} of the points are above {melting:.4g} K, the melting temperature of "
                f"this material (highest: {temperature.max():.4g} K); the material law does not describe liquids"
            )
        if self._breaking is not None:
            found += self._breaking.cautions(self.events(), self.step_size, float(self.mass.sum()))
        return found

    def _compressed_step_part(self) -> float:
        """Return the ratio of the step to the largest stable one at the largest compression, where frequencies are highest."""
        return 0.5 * self.highest_frequency * self.step_size / energies.smallest_stretch(self._state.gradient)

    def drawables(self) -> tuple[Drawable, ...]:
        """Return the outer surface and all nodes, coloured by the equivalent stress."""
        lattice, top = self.lattice, self.surface_nodes
        size = 0.15 * float(min(axis.slope(np.zeros(1))[0] for axis in lattice.axes[::2]))
        breaks = "" if self._breaking is None else "surface_cells"
        drawn: tuple[Drawable, ...] = (
            Cells("surface", self.nodes[top], surface_quads(lattice), "surface_stress", "surface_displacement", breaks),
            Points("nodes", self.nodes, np.full(len(self.nodes), size), "displacement", "node_stress"),
        )
        return drawn if self._breaking is None else (*drawn, *self._breaking.drawables(size))
