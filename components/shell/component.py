"""The solid as a component: thin walls in three dimensions, by moving least squares, in total Lagrangian form."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
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
from .boundaries import pattern_of, tick_signals
from .column_means import ColumnMeans, make_column_means, write_column_means
from .fracture.breaking_body import KINDS, LOST_KINDS, BreakingBody
from .fracture.judgement import write_triaxiality
from .fracture.law import FractureLaw
from .fracture.outcome import BULGED, BULGED_STRAIN, OUTCOMES, WHOLE
from .fracture.principal_stress import PrincipalStress
from .geometry.lattice import Lattice
from .kernel_arrays import IntArray, Solid, State, Tables
from .kernel_setup import Assembly, assemble, station_means, surface_quads
from .parameters import ShellParameters
from .quadrature import RuleName
from .stability import CRACKED, WALL_STIFFNESS, highest_frequency
from .ticks import advance, update_forces

_STATE = ("displacement", "velocity", "force", "gradient", "stress", "plastic_strain", "temperature", "plastic_work", "area")
# What a node, and an integration point, take at least: tables, state, its copy, scratch, and the stencils by which fields are
# read. A notch adds up to a twentieth.
_BYTES_OF_NODE, _BYTES_OF_POINT = 350, 540
# What a node takes besides where the body can break: its points, pairs and surfaces, whole and as they are.
_BYTES_OF_BREAKING = 190
_POINTS_OF_CELL: dict[RuleName, int] = {"column": 1, "cell": 4}
# Status -> what happened, and to which output.
_FAILURES = {
    kernel_arrays.INVERTED: ("the body is inverted, its volume {value:.3g} of that at the start", "stress"),
    kernel_arrays.STRAINED: ("a strain of {value:.3g} in one tick, more than {limit:g},", "stress"),
    kernel_arrays.FLOWN: ("a plastic strain of {value:.3g}, more than {limit:g},", "plastic_strain"),
    kernel_arrays.HEATED: ("{value:.4g} K, more than {limit:g} K,", "temperature"),
}
# Part of the energy that hourglass control may hold without a caution.
_HOURGLASS_PART = 0.05
# Part of the mass that may bear nothing any more without a caution.
_ERODED_PART = 0.1


class Shell(Component):
    """A solid with thin walls, meshfree and in three dimensions: the tube of Gato & Shie (2010).

    Displacements are sums of moving-least-squares functions in material coordinates; weak form, central differences. See
    `ShellParameters`.
    """

    name = "shell"
    version = 5
    Parameters = ShellParameters
    parameters: ShellParameters

    # -- building ---------------------------------------------------------------------------------------------------

    @classmethod
    def memory_needed(cls, parameters: ShellParameters) -> int:
        """Return what tables, state, its copy and the kernels' scratch take."""
        along, across, layers = parameters.body.counts
        points = along * across * parameters.rule.through * _POINTS_OF_CELL[parameters.rule.surface]
        of_node = _BYTES_OF_NODE + (_BYTES_OF_BREAKING if isinstance(parameters.fracture, FractureLaw) else 0)
        return of_node * along * across * layers + _BYTES_OF_POINT * points

    def _build(self) -> None:
        p = self.parameters
        self.assembly: Assembly = assemble(p)
        self.lattice: Lattice = self.assembly.lattice
        self.nodes: FloatArray = self.lattice.nodes
        self.mass: FloatArray = self.assembly.solid.body.mass
        self.highest_frequency: float = highest_frequency(self.assembly.solid)
        law = p.fracture
        bounding = self.highest_frequency * (CRACKED if isinstance(law, FractureLaw) else 1.0)
        suggested = suggest_step(bounding, "leave an edge free, or give more nodes")
        self.longest_suggested_step: float = longest_suggested_step(bounding)
        self.step_size = p.step_size or suggested
        refuse_large_step(self.step_size, bounding, "leave it out, or give fewer nodes")
        self._whole: Solid = self._finish_solid()
        self._breaking = BreakingBody(p, law, self.assembly, self._whole) if isinstance(law, FractureLaw) else None
        if self._breaking is not None:
            self._declare_events(KINDS, self._breaking.details)
        self._lay_out_state()

    def _finish_solid(self) -> Solid:
        """Return the tables with what depends on the step."""
        p, conditions = self.parameters, self.assembly.conditions
        stiffness = WALL_STIFFNESS * self.highest_frequency * self.highest_frequency * self.mass
        body = self.assembly.solid.body._replace(bounce=stiffness if conditions.wall[1] else np.zeros(0))
        return self.assembly.solid._replace(
            body=body, law=p.material.constants(self.step_size), plastic=p.material.name != "elastic", step=self.step_size,
            wall=conditions.wall,
        )  # fmt: skip

    def _lay_out_state(self) -> None:
        n, m, s = len(self.nodes), self.point_count, len(self._whole.surface.nodes)
        plastic = m if self._whole.plastic else 0
        growing, fields = ({}, {}) if self._breaking is None else (self._breaking.growing, self._breaking.fields)
        self._lay_out(
            growing,
            displacement=("f8", (n, 3)), velocity=("f8", (n, 3)), force=("f8", (n, 3)), gradient=("f8", (m, 9)),
            stress=("f8", (m, 6)), plastic_strain=("f8", (plastic,)), temperature=("f8", (plastic,)),
            plastic_work=("f8", (plastic,)), area=("f8", (s, 3)), tally=("f8", (kernel_arrays.TALLY,)), start=("f8", (4,)),
            **fields,
        )  # fmt: skip
        self._state = State(*(self._block[name] for name in _STATE))
        self._scratch = kernel_arrays.make_scratch(m, len(self._whole.hourglass.partner), s)
        self._failed = np.zeros(2, dtype=np.int64)

    def _contradiction(self, state: Mapping[str, np.ndarray]) -> str:
        return "" if self._breaking is None else self._breaking.contradiction(state)

    @property
    def _solid(self) -> Solid:
        """The tables of the kernels, with the cracks that the state has."""
        return self._whole if self._breaking is None else self._breaking.solid(self._block)

    @property
    def point_count(self) -> int:
        """Number of integration points."""
        return len(self.assembly.points.volume)

    # -- the contract -----------------------------------------------------------------------------------------------

    def _declare(self) -> Iterable[Variable]:
        n, m, k, s = len(self.nodes), self.point_count, len(self.assembly.gauges), len(self._whole.surface.nodes)
        stations, nodes, points = self.lattice.shape[0], ("node", "direction"), ("point",)
        yield Variable(
            "pressure", "input", "Pa", (stations,), "pressure on the inner surface (of a plate the lower one) at each plane of "
            "nodes along the body; it follows the surface", start=0.0, axes=("station",), nominal=1e6,
        )  # fmt: skip
        for edge, axis in self.assembly.conditions.moved.items():
            shape, text = ((3,), "velocity") if axis < 0 else ((), f"velocity along {'xyz'[axis]}")
            yield Variable(
                f"{edge}_velocity", "input", "m/s", shape, f"{text} of the {edge} edge", start=0.0,
                axes=("direction",)[: len(shape)],
            )  # fmt: skip
        yield Variable(
            "nodal_displacement", "output", "m", (n, 3), "parameters u_J of the nodes, which the field does not pass "
            "through; a start value gives stresses too, elastically, where they have none of their own", state=True, axes=nodes,
        )  # fmt: skip
        yield Variable("nodal_velocity", "output", "m/s", (n, 3), "parameters of the velocity", state=True, axes=nodes)
        yield Variable("displacement", "output", "m", (n, 3), "displacement where the nodes are", axes=nodes)
        yield Variable("velocity", "output", "m/s", (n, 3), "velocity where the nodes are", axes=nodes)
        yield Variable(
            "stress", "output", "Pa", (m, 6), "Kirchhoff stress xx, yy, zz, xy, yz, zx of the integration points, tension "
            "positive; at steps of the wall they alternate from column to column", state=True, axes=("point", "entry"),
        )  # fmt: skip
        yield Variable(
            "mean_stress", "output", "Pa", (m, 6), "mean of the stress over neighbouring columns, 1-2-1 along and across, "
            "which does not alternate: it is judged, and all outputs below are computed from it", axes=("point", "entry"),
        )  # fmt: skip
        yield Variable("equivalent_stress", "output", "Pa", (m,), "of von Mises: sqrt(3/2 s:s)", minimum=0.0, axes=points)
        yield Variable(
            "plastic_strain", "output", "1", (m,), "equivalent plastic strain of the points", minimum=0.0, axes=points,
            state=self._whole.plastic,
        )  # fmt: skip
        yield Variable(
            "temperature", "output", "K", (m,), "temperature of the points", minimum=0.0, axes=points,
            state=self._whole.plastic,
        )  # fmt: skip
        yield Variable(
            "triaxiality",
            "output",
            "1",
            (m,),
            "mean stress over the equivalent one at the points, 0 without stress",
            axes=points,
        )
        if self._judges:
            yield Variable(
                "fracture_ratio", "output", "1", (m,), "what decides on fracture over its limit, at the points; without a law "
                "the largest principal stress over three times the yield stress", axes=points,
            )  # fmt: skip
        yield Variable(
            "node_stress", "output", "Pa", (n,), "mean equivalent stress around each node", minimum=0.0, axes=("node",)
        )
        yield Variable(
            "surface_displacement", "output", "m", (s, 3), "displacement of the outer surface, of a plate the upper one",
            axes=("surface_node", "direction"),
        )  # fmt: skip
        yield Variable(
            "surface_stress", "output", "Pa", (s,), "mean equivalent stress around the nodes of the outer surface", minimum=0.0,
            axes=("surface_node",),
        )  # fmt: skip
        yield Variable(
            "surface_plastic_strain", "output", "1", (s,), "mean plastic strain around the nodes of the outer surface",
            minimum=0.0, axes=("surface_node",),
        )  # fmt: skip
        yield Variable(
            "surface_temperature_rise", "output", "K", (s,), "mean temperature around the nodes of the outer surface less that "
            "at the start", axes=("surface_node",),
        )  # fmt: skip
        if self.lattice.bent:
            yield Variable(
                "mean_inner_radius", "output", "m", (stations,), "mean radius of the inner surface at each plane of nodes "
                "along the tube", minimum=0.0, axes=("station",), nominal=0.01,
            )  # fmt: skip
        if self._breaking is not None:
            yield from self._breaking.declare()
        yield Variable(
            "gauge_strain", "output", "1", (k, 2), "Green-Lagrange strain on the outer surface at the `gauges`: along the "
            "body, and across or around it (hoop strain)", axes=("gauge", "direction"),
        )  # fmt: skip

    def _outputs(self) -> dict[str, Callable[[], Any]]:
        state, top = self._state, self.surface_nodes
        return {
            "nodal_displacement": lambda: state.displacement,
            "nodal_velocity": lambda: state.velocity,
            "displacement": lambda: self._field(state.displacement),
            "velocity": lambda: self._field(state.velocity),
            "stress": lambda: state.stress,
            "mean_stress": self._mean_stress,
            "equivalent_stress": self._equivalent_stress,
            "plastic_strain": self._plastic_strain,
            "temperature": self._temperature,
            "triaxiality": self._triaxiality,
            **({"fracture_ratio": self._fracture_ratio} if self._judges else {}),
            **({} if self._breaking is None else self._breaking.outputs(self._block, state)),
            "node_stress": lambda: self._at_nodes(self._equivalent_stress()),
            "surface_displacement": lambda: self._field(state.displacement)[top],
            "surface_stress": lambda: self._at_nodes(self._equivalent_stress())[top],
            "surface_plastic_strain": lambda: self._at_nodes(self._plastic_strain())[top],
            "surface_temperature_rise": lambda: self._at_nodes(self._temperature() - self.parameters.initial_temperature)[top],
            "gauge_strain": self._gauge_strain,
            **({"mean_inner_radius": self._mean_inner_radius} if self.lattice.bent else {}),
        }

    @property
    def surface_nodes(self) -> IntArray:
        """Numbers of the nodes of the outer surface, of a plate the upper one."""
        return self.lattice.top_nodes

    def _field(self, parameters: FloatArray) -> FloatArray:
        """Return a field where the nodes are, from its parameters, shape (n, 3)."""
        if self._breaking is not None:
            return self._breaking.node_field(self._block, parameters)
        out = np.zeros_like(parameters)
        kernels.interpolate(self.assembly.node_stencils, parameters, out)
        return out

    def _at_nodes(self, values: FloatArray) -> FloatArray:
        """Return means of a field of the points around each node, shape (n,)."""
        out = np.zeros(len(self.nodes))
        solid = self._solid
        seen = self.assembly.stencils.values if self._breaking is None else self._breaking.values
        kernels.spread_to_nodes(solid.body, seen, values, out)
        return out

    def _mean_stress(self) -> FloatArray:
        """Return the mean stress over neighbouring columns, shape (m, 6); see `column_means`."""
        if self._breaking is not None:
            return self._breaking.mean_stress(self._block, self._state)
        write_column_means(self._state.stress, self._means)
        return self._means.stress

    @cached_property
    def _means(self) -> ColumnMeans:
        return make_column_means(self.lattice, self.assembly.points)

    @np.errstate(all="ignore")
    def _equivalent_stress(self) -> FloatArray:
        xx, yy, zz, xy, yz, zx = self._mean_stress().T
        spread = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
        return np.sqrt(0.5 * spread + 3.0 * (xy * xy + yz * yz + zx * zx))

    @property
    def _judges(self) -> bool:
        """True where there is a fracture law, or a yield stress to compare with."""
        return self._whole.plastic or self._breaking is not None

    def _fracture_ratio(self) -> FloatArray:
        """Return how near each point is to parting, by the fracture law, or by the paper's where there is none, shape (m,)."""
        if self._breaking is not None:
            return self._breaking.ratios(self._block, self._state)
        out = np.zeros(self.point_count)
        energies.write_largest_principal(self._mean_stress(), out)
        return out / PrincipalStress().limit(self._whole.law)

    def _triaxiality(self) -> FloatArray:
        out = np.zeros(self.point_count)
        write_triaxiality(self._mean_stress(), out)
        return out

    def _plastic_strain(self) -> FloatArray:
        return self._state.plastic_strain if self._whole.plastic else np.zeros(self.point_count)

    def _temperature(self) -> FloatArray:
        at_start = self.parameters.initial_temperature
        return self._state.temperature if self._whole.plastic else np.full(self.point_count, at_start)

    def _mean_inner_radius(self) -> FloatArray:
        """Return the mean distance of the inner surface from the axis at each station, weighted by the arcs at rest."""
        ring = self.lattice.axes[1]
        place = (self.nodes + self._field(self._state.displacement))[self._whole.surface.nodes]
        radius = np.sqrt(place[:, 1] * place[:, 1] + place[:, 2] * place[:, 2]).reshape(-1, ring.count)
        return (radius * ring.widths).sum(axis=1) / ring.widths.sum()

    def _gauge_strain(self) -> FloatArray:
        """Return E = (F^T F - 1) / 2 along the first two directions of the surface, shape (gauges, 2)."""
        found = np.zeros((len(self.assembly.gauges), 2))
        for row, gauge in enumerate(self.assembly.gauges):
            u = self._state.displacement[gauge.neighbours]
            for k, (x, y, z) in enumerate(gauge.directions):
                change = (u * gauge.gradients[:, k : k + 1]).sum(axis=0) * (gauge.along if k == 0 else 1.0)
                found[row, k] = change[0] * x + change[1] * y + change[2] * z + 0.5 * (change * change).sum()
        return found

    def _start(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        state = self._state
        if self._whole.plastic:
            state.temperature[:] = values.get("temperature", self.parameters.initial_temperature)
            state.plastic_strain[:] = values.get("plastic_strain", 0.0)
            self._refuse_bad_start()
        if "nodal_displacement" in values:
            # As if it had happened in one tick.
            self._write_start("nodal_displacement", state.displacement, values)
        if self._update_forces():
            raise ParameterError(
                f"the body would be inverted or strained beyond measure at point {self._failed[0]}",
                expected="smaller displacements", at=("start", "nodal_displacement"),
            )  # fmt: skip
        if "stress" in values:
            state.stress[:] = values["stress"]
            self._update_forces()
        if "nodal_velocity" in values:
            self._write_start("nodal_velocity", state.velocity, values)
        if self._whole.wall[1]:
            kernels.measure_wall(self._solid, state, self._block["tally"])
        kernels.write_areas(self._solid, state)
        sums = self._sums()
        self._block["start"][:] = sums["energy"], *sums["momentum"]
        return {}

    def _update_forces(self) -> int:
        """Advance stresses elastically to the displacements of now, and write the forces; return 0 or a status."""
        elastic = self._solid._replace(plastic=False)
        return update_forces(elastic, self._state, self._scratch, self._failed)

    def _refuse_bad_start(self) -> None:
        if not (self._state.temperature > 0.0).all():
            raise ParameterError("got 0 or less", expected="more than 0 everywhere", at=("start", "temperature"))
        if not (self._state.plastic_strain >= 0.0).all():
            raise ParameterError("got less than 0", expected="0 or more everywhere", at=("start", "plastic_strain"))

    def _write_start(self, name: str, part: FloatArray, values: Mapping[str, FloatArray]) -> None:
        """Write a start value of the nodes."""
        part[:] = values[name]
        self._refuse_held(name, part)

    def _refuse_held(self, name: str, value: FloatArray) -> None:
        held = self._whole.body.prescribed == 255
        if (value[held] != 0.0).any():
            node, direction = (int(one[0]) for one in np.nonzero(held & (value != 0.0)))
            raise ParameterError(
                f"got {value[node, direction]:g} where a boundary holds the node",
                expected="0",
                at=("start", name, node, direction),
            )

    def tables(self) -> Tables:
        """Return the arrays of the kernels, for a parent that calls them itself."""
        return Tables(self._solid, self._state, self._scratch, self._block["tally"])

    def _advance(self, ticks: int) -> int:
        signals = tick_signals(self._held, self.assembly.conditions.moved, self._tick, ticks)
        if self._breaking is not None:
            pressures = pattern_of(self._held["pressure"])
            return self._breaking.advance(
                self._block, self._state, self._scratch, signals, pressures, self._tick, self._failed, self._add_event
            )
        return advance(
            self._solid, self._state, self._scratch, signals, pattern_of(self._held["pressure"]), self._block["tally"],
            self._tick, self._failed,
        )  # fmt: skip

    def _explain(self, status: int) -> StepError:
        point, tick = (int(number) for number in self._failed)
        time, where = tick * self.step_size, self._describe_place(point)
        value, limit = (float(number) for number in self._scratch.pull[point, :2])
        what, variable = _FAILURES[status]
        return StepError(
            f"{what.format(value=value, limit=limit)} at point {point} ({where}) at {time:.9g} s; load the body "
            f"less, or take a smaller step_size (now {self.step_size:g} s; as compressed as the body was, the largest stable "
            f"one is {self.step_size / self._compressed_step():.2g} s)",
            time=time, at=variable, variable=variable, index=point, value=value, limit=limit,
        )  # fmt: skip

    def place_of_point(self, point: int) -> tuple[float, ...]:
        """Return where an integration point is in the undeformed body: x, y, z [m], or x [m], angle [rad], radius [m]."""
        lines = self.assembly.points.lines
        indices = np.unravel_index(point, [len(line.at) for line in lines])
        axes = self.lattice.axes
        return tuple(float(axis.at(line.at[[i]])[0]) for axis, line, i in zip(axes, lines, indices, strict=True))

    def _describe_place(self, point: int) -> str:
        """Return where an integration point is, in words."""
        return self.lattice.describe(self.place_of_point(point))

    # -- reading ----------------------------------------------------------------------------------------------------

    @np.errstate(all="ignore")
    def _sums(self) -> dict[str, Any]:
        """Return energies and momentum as they are."""
        return energies.measure(self._solid, self._state)

    def balances(self) -> tuple[Balance, ...]:
        """Return energy, momentum, and mass.

        `leapfrog_energy` is -h^2/8 times the sum of force^2 / mass: with it, the energy that the scheme conserves for a
        linear body. What is left over is of second order in the step.
        """
        sums, tally, start = self._sums(), self._block["tally"].copy(), self._block["start"].copy()
        stored = {name: sums[name] for name in energies.STORED}
        supplied = {
            "pressure_work": float(tally[kernel_arrays.PRESSURE_WORK]),
            "boundary_work": float(tally[kernel_arrays.BOUNDARY_WORK]),
        }
        lost = {"plastic_work": sums["plastic_work"]}
        if self._breaking is not None:
            lost |= self._breaking.losses(self._block)
        wall = np.array([tally[kernel_arrays.WALL_IMPULSE], 0.0, 0.0])
        impulse = {
            "pressure_impulse": tally[kernel_arrays.PRESSURE_IMPULSE : kernel_arrays.PRESSURE_IMPULSE + 3],
            "boundary_impulse": tally[kernel_arrays.BOUNDARY_IMPULSE : kernel_arrays.BOUNDARY_IMPULSE + 3],
            "wall_impulse": wall,
        }
        mass = float(self.mass.sum())
        return (
            Balance("energy", "J", stored, supplied, lost, float(start[0])),
            Balance("momentum", "kg m/s", {"momentum": sums["momentum"]}, impulse, initial=start[1:4]),
            Balance("mass", "kg", {"mass": mass}, initial=mass),
        )

    def report(self) -> dict[str, float]:
        """Return how close the step is to the largest stable one, and what the body has borne."""
        sums = self._sums()
        stored = sums["elastic_energy"] + sums["kinetic_energy"] + sums["plastic_work"]
        found = {
            "step over the largest stable one, at rest": 0.5 * self.highest_frequency * self.step_size,
            "step over the largest stable one, as compressed as it is": self._compressed_step(),
            "largest equivalent stress now, Pa": float(self._equivalent_stress().max()),
            "hourglass energy over that of the body": sums["hourglass_energy"] / stored if stored > 0.0 else 0.0,
        }
        if self._whole.plastic:
            found |= {
                "largest plastic strain": float(self._state.plastic_strain.max()),
                "highest temperature, K": float(self._state.temperature.max()),
            }
        if self._judges:
            ratio = self._fracture_ratio()
            nearest = int(ratio.argmax())
            across, through = (len(line.at) for line in self.assembly.points.lines[1:])
            along = self.assembly.points.lines[0].at[nearest // (across * through)]
            found |= {
                "largest fracture ratio now": float(ratio[nearest]),
                "where along the body, m": float(self.lattice.axes[0].at(along)),
            }
        if self._breaking is not None:
            found |= self._breaking.report(self._block, self.step_size)
        return found

    def conclusions(self) -> list[str]:
        """Return whether the body is whole, has bulged or cracked, how far and how fast cracks ran, and how near it came."""
        if self._breaking is not None:
            return self._breaking.conclusions(self._block, self._state, self.step_size)
        if not self._whole.plastic:
            return []
        strain, report = float(station_means(self.assembly, self._state.plastic_strain).max()), self.report()
        return [
            f"outcome: {OUTCOMES[BULGED if strain > BULGED_STRAIN else WHOLE]}; no fracture law is chosen",
            f"the largest principal stress is {report['largest fracture ratio now']:.3g} of three times the yield stress now, "
            f"{1e3 * report['where along the body, m']:.4g} mm along the body",
        ]

    def cautions(self) -> list[str]:
        """Return a sentence where hourglass control holds too much, and where the body is compressed too far for the step."""
        found, report = [], self.report()
        part, step = report["hourglass energy over that of the body"], self._compressed_step()
        if part > _HOURGLASS_PART:
            found.append(
                f"hourglass control holds {part:.1%} of the energy: displacements alternate from column to column; give more "
                "nodes, or integration = {surface = 'cell'}"
            )
        if step > 1.0:
            found.append(
                f"where the body is compressed most, the step (now {self.step_size:g} s) is {step:.2f} times the "
                "largest stable one; take a smaller step_size"
            )
        found += self._caution_of_melting()
        return found if self._breaking is None else [*found, *self._caution_of_eroded_mass(self._breaking)]

    def _caution_of_melting(self) -> list[str]:
        """Return a sentence where the material is hotter than its flow stress reaches."""
        melting = self.parameters.material.melting_temperature
        temperature = self._temperature()
        if melting is None or not temperature.max() > melting:
            return []
        part = float(np.mean(temperature > melting))
        return [
            f"{part:.0%} of the points are above {melting:.4g} K, where the flow stress of this material has fallen to its "
            f"end, up to {temperature.max():.4g} K: they are as good as liquid, which the law does not know"
        ]

    def _caution_of_eroded_mass(self, breaking: BreakingBody) -> list[str]:
        """Return a sentence where too much of the body has been taken out of it: that stays, whatever comes after."""
        part = float(self.get("eroded_mass")) / float(self.mass.sum())
        if part <= _ERODED_PART:
            return []
        first = next(event for event in self.events() if event.kind in LOST_KINDS)
        assert first.index is not None
        time = 1e6 * first.tick * self.step_size
        return [
            f"{part:.0%} of the mass bears nothing any more, the first of it from {time:.4g} us on, "
            f"{breaking.place_words(first.index)}: what is left does not stand for the body; load it less, or give more nodes"
        ]

    def _compressed_step(self) -> float:
        """Return the step over the largest stable one where the body is compressed most, and its frequencies are highest."""
        return 0.5 * self.highest_frequency * self.step_size / float(energies.smallest_stretch(self._state.gradient))

    def drawables(self) -> tuple[Drawable, ...]:
        """Return the outer surface and all nodes, coloured by the equivalent stress."""
        lattice = self.lattice
        size = 0.15 * float(min(axis.slope(np.zeros(1))[0] for axis in lattice.axes[::2]))
        breaks = "" if self._breaking is None else "surface_cells"
        drawn: tuple[Drawable, ...] = (
            Cells(
                "surface", self.nodes[self.surface_nodes], surface_quads(lattice), "surface_stress", "surface_displacement",
                breaks,
            ),
            Points("nodes", self.nodes, np.full(len(self.nodes), size), "displacement", "node_stress"),
        )  # fmt: skip
        return drawn if self._breaking is None else (*drawn, *self._breaking.drawables(self.nodes, size))
