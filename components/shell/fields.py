"""Output fields of the solid: at its nodes and points, on its surface, at its gauges."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property, partial

import numpy as np

from ..support.float_arrays import FloatArray
from . import kernels
from .column_means import ColumnMeans, make_column_means, write_column_means
from .energies import write_largest_principal_values
from .fracture.breaking_body import BreakingBody
from .fracture.laws.principal_stress import PrincipalStress
from .kernel_arrays import Tables
from .kernel_setup import Assembly
from .outputs import Output, make_output


class Fields:
    """The outputs of a solid, computed from its state when they are read."""

    def __init__(self, assembly: Assembly, intact_tables: Tables, breaking: BreakingBody | None, temperature: float) -> None:
        """Build from the tables of the intact body, its cracks (None if it cannot break), and its initial temperature [K]."""
        self._assembly, self._breaking, self._temperature_at_start = assembly, breaking, temperature
        self._solid, self._state = intact_tables.solid, intact_tables.state
        self._lattice, self._point_count = assembly.lattice, len(assembly.points.volume)

    def outputs(self) -> Iterator[Output]:
        """Yield the outputs of the solid, including those on its cracks."""
        state, plastic, top, lattice = self._state, self._solid.plastic, self._lattice.top_nodes, self._lattice
        n, m, k, s = lattice.node_count, self._point_count, len(self._assembly.gauges), len(top)
        yield make_output(
            "nodal_displacement", "m", (n, 3), "parameters u_J of the nodes, which the field does not interpolate; without "
            "a start value of the stress, a start value of u_J also gives elastic stresses", lambda: state.displacement, "node",
            "direction", state=True,
        )  # fmt: skip
        text = "parameters of the velocity field"
        yield make_output("nodal_velocity", "m/s", (n, 3), text, lambda: state.velocity, "node", "direction", state=True)
        for name, unit, values in (("displacement", "m", state.displacement), ("velocity", "m/s", state.velocity)):
            read = partial(self.lattice_values, values)
            yield make_output(name, unit, (n, 3), f"{name} at the positions of the nodes", read, "node", "direction")
        yield make_output(
            "stress", "Pa", (m, 6), "Kirchhoff stress xx, yy, zz, xy, yz, zx of the integration points, tension positive; at "
            "steps of the wall they alternate from one column to the next", lambda: state.stress, "point", "entry", state=True,
        )  # fmt: skip
        yield make_output(
            "mean_stress", "Pa", (m, 6), "mean of the stress over neighbouring columns (weights 1-2-1 along and across), "
            "without this alternation; fracture laws and all other stress outputs use it", self.mean_stress, "point", "entry",
        )  # fmt: skip
        for name, unit, text, read, is_state in (
            ("equivalent_stress", "Pa", "von Mises stress sqrt(3/2 s:s)", self.equivalent_stress, False),
            ("plastic_strain", "1", "equivalent plastic strain", self.plastic_strain, plastic),
            ("temperature", "K", "temperature", self.temperature, plastic),
        ):
            yield make_output(name, unit, (m,), f"{text} of the points", read, "point", minimum=0.0, state=is_state)
        yield make_output(
            "triaxiality", "1", (m,), "mean stress over equivalent stress at the points, 0 without stress", self._triaxiality,
            "point",
        )  # fmt: skip
        if self.has_fracture_ratio:
            yield make_output(
                "fracture_ratio", "1", (m,), "decisive quantity of the fracture law over its limit, at the points; without a "
                "law, the largest principal stress over three times the yield stress", self.fracture_ratio, "point",
            )  # fmt: skip
        yield make_output(
            "node_stress", "Pa", (n,), "mean equivalent stress around each node",
            lambda: self.node_means(self.equivalent_stress()), "node", minimum=0.0,
        )  # fmt: skip
        yield make_output(
            "surface_displacement", "m", (s, 3), "displacement of the outer surface (upper surface of a plate)",
            lambda: self.lattice_values(state.displacement)[top], "surface_node", "direction",
        )  # fmt: skip
        for name, unit, text, values in (
            ("stress", "Pa", "equivalent stress", self.equivalent_stress),
            ("plastic_strain", "1", "plastic strain", self.plastic_strain),
        ):
            read = partial(self._surface_means, values)
            text = f"mean {text} around the nodes of the outer surface"
            yield make_output(f"surface_{name}", unit, (s,), text, read, "surface_node", minimum=0.0)
        yield make_output(
            "surface_temperature_rise", "K", (s,), "mean temperature around the nodes of the outer surface minus the initial "
            "one", lambda: self._surface_means(lambda: self.temperature() - self._temperature_at_start), "surface_node",
        )  # fmt: skip
        if lattice.bent:
            yield make_output(
                "mean_inner_radius", "m", lattice.shape[:1], "mean radius of the inner surface at each plane of nodes "
                "along the tube", self._mean_inner_radius, "station", minimum=0.0, nominal=0.01,
            )  # fmt: skip
        if self._breaking is not None:
            yield from self._breaking.outputs()
        yield make_output(
            "gauge_strain", "1", (k, 2), "Green-Lagrange strain on the outer surface at the `gauges`: along the body, and "
            "across or around it (hoop strain)", self._gauge_strain, "gauge", "strain",
        )  # fmt: skip

    def lattice_values(self, parameters: FloatArray) -> FloatArray:
        """Return the values of a field at the nodes' positions from its moving-least-squares parameters, shape (n, 3)."""
        if self._breaking is not None:
            return self._breaking.node_values(parameters)
        out = np.zeros_like(parameters)
        kernels.interpolate_field(self._assembly.node_stencils, parameters, out)
        return out

    def node_means(self, values: FloatArray) -> FloatArray:
        """Return for each node the mean of a field over the points with it in their support, 0 if there is none, shape (n,)."""
        sums, assembly = np.zeros((len(self._lattice.nodes), 2)), self._assembly
        seen = assembly.stencils if self._breaking is None else self._breaking.cracked_stencils
        kernels.weigh_points(seen, assembly.solid.nodes, assembly.points.volume, np.arange(len(sums)), values, sums)
        return np.divide(sums[:, 1], sums[:, 0], out=np.zeros(len(sums)), where=sums[:, 0] > 0.0)

    def _surface_means(self, values: Callable[[], FloatArray]) -> FloatArray:
        """Return for each node of the outer surface the mean of a field over the points around it, shape (s,)."""
        return self.node_means(values())[self._lattice.top_nodes]

    def mean_stress(self) -> FloatArray:
        """Return for each of m points the stress averaged over neighbouring columns, shape (m, 6); see `column_means`."""
        if self._breaking is not None:
            return self._breaking.mean_stress()
        write_column_means(self._state.stress, self._column_means)
        return self._column_means.stress

    @cached_property
    def _column_means(self) -> ColumnMeans:
        return make_column_means(self._lattice, self._assembly.points)

    @np.errstate(all="ignore")
    def equivalent_stress(self) -> FloatArray:
        """Return the von Mises equivalent stress at the points, shape (m,) [Pa]."""
        xx, yy, zz, xy, yz, zx = self.mean_stress().T
        spread = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
        return np.sqrt(0.5 * spread + 3.0 * (xy * xy + yz * yz + zx * zx))

    @np.errstate(all="ignore")
    def _triaxiality(self) -> FloatArray:
        equivalent, (xx, yy, zz) = self.equivalent_stress(), self.mean_stress().T[:3]
        return np.where(equivalent > 0.0, (xx + yy + zz) / 3.0 / equivalent, 0.0)

    @property
    def has_fracture_ratio(self) -> bool:
        """True if there is a fracture law, or a yield stress with which to compare stresses."""
        return self._solid.plastic or self._breaking is not None

    def fracture_ratio(self) -> FloatArray:
        """Return the fracture ratio (value over limit) of each point by its fracture law, or that of the paper, shape (m,)."""
        if self._breaking is not None:
            return self._breaking.fracture_ratios()
        out = np.zeros(self._point_count)
        write_largest_principal_values(self.mean_stress(), out)
        return out / PrincipalStress().limit(self._solid.law)

    def plastic_strain(self) -> FloatArray:
        """Return the plastic strain of the points, shape (m,)."""
        return self._state.plastic_strain if self._solid.plastic else np.zeros(self._point_count)

    def temperature(self) -> FloatArray:
        """Return the temperature of the points, shape (m,) [K]."""
        return self._state.temperature if self._solid.plastic else np.full(self._point_count, self._temperature_at_start)

    def _mean_inner_radius(self) -> FloatArray:
        """Return the mean distance of the inner surface from the axis at each station, weighted by the initial arcs [m]."""
        ring = self._lattice.axes[1]
        place = (self._lattice.nodes + self.lattice_values(self._state.displacement))[self._solid.surface.nodes]
        radius = np.sqrt(place[:, 1] * place[:, 1] + place[:, 2] * place[:, 2]).reshape(-1, ring.count)
        return (radius * ring.widths).sum(axis=1) / ring.widths.sum()

    def _gauge_strain(self) -> FloatArray:
        """Return Green's strain E = (F^T F - 1) / 2 at the gauges along both directions of the surface, shape (gauges, 2)."""
        found = np.zeros((len(self._assembly.gauges), 2))
        for row, gauge in enumerate(self._assembly.gauges):
            u = self._state.displacement[gauge.neighbours]
            for k, (x, y, z) in enumerate(gauge.directions):
                change = (u * gauge.gradients[:, k : k + 1]).sum(axis=0) * (gauge.along if k == 0 else 1.0)
                found[row, k] = change[0] * x + change[1] * y + change[2] * z + 0.5 * (change * change).sum()
        return found
