"""Moving least squares and integration rules of the solid: reproduction, and detection of deformation modes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import granular_env as ge
from granular_env.components.shell.geometry.axis import Axis, closed_axis, even_axis
from granular_env.components.shell.geometry.bodies import Plate, Rod, Tube
from granular_env.components.shell.geometry.lattice import Lattice
from granular_env.components.shell.quadrature import gauss_points, integration_points
from granular_env.components.shell.shape_functions import quartic_spline
from granular_env.components.shell.stencils import make_stencils
from granular_env.components.shell.zero_modes import RIGID_MOTIONS, gradient_matrices, zero_mode_count

BODIES = {
    "plate": Plate(along=6, across=5),
    "tube": Tube(along=4, around=24),
    "half-tube": Tube(along=4, around=13, half=True),
    "rod": Rod(along=5, across=4),
}


def value_matrix(nodes: int, stencils: Any) -> np.ndarray:
    """Return the shape functions of all nodes at all points, shape (m, n)."""
    begin = stencils.begin.astype(int)
    found = np.zeros((len(begin) - 1, nodes))
    for point, kind in enumerate(stencils.kind):
        rows = slice(stencils.first[kind], stencils.first[kind + 1])
        found[point, stencils.neighbours(point)] = stencils.values[rows]
    return found


@pytest.mark.parametrize("rule", ["column", "cell"])
@pytest.mark.parametrize("name", BODIES)
def test_shape_functions_sum_to_one_and_give_a_linear_field_its_gradient(name: str, rule: Any) -> None:
    lattice = BODIES[name].lattice()
    points = integration_points(lattice, rule, 2, 1.7)
    stencils = make_stencils(lattice, points.lines, 1.7, "linear")
    n, x = lattice.node_count, lattice.nodes
    values = value_matrix(n, stencils)
    np.testing.assert_allclose(values.sum(axis=1), 1.0, rtol=0.0, atol=1e-12)
    gradient = np.array([[0.3, -0.2, 0.5], [0.1, 0.4, -0.6], [-0.7, 0.2, 0.9]])
    for k, slope in enumerate(gradient_matrices(n, points, stencils)):
        np.testing.assert_allclose(slope @ (x @ gradient.T), np.tile(gradient[:, k], (len(values), 1)), rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(slope.sum(axis=1) * 1e-3, 0.0, rtol=0.0, atol=1e-12)


def test_the_quadratic_basis_gives_a_quadratic_field_its_value_and_gradient() -> None:
    lattice = BODIES["plate"].lattice()
    points = integration_points(lattice, "cell", 2, 1.7)
    stencils = make_stencils(lattice, points.lines, 2.7, "quadratic")
    along, across, through = np.meshgrid(
        *(axis.coordinates(line.at) for axis, line in zip(lattice.axes, points.lines, strict=True)), indexing="ij"
    )
    place = lattice.positions(along.ravel(), across.ravel(), through.ravel())

    def field(x: np.ndarray) -> np.ndarray:
        return x[:, 0] ** 2 - 3.0 * x[:, 0] * x[:, 2] + 2.0 * x[:, 1]

    size = np.abs(field(lattice.nodes)).max()
    np.testing.assert_allclose(
        value_matrix(lattice.node_count, stencils) @ field(lattice.nodes), field(place), rtol=0, atol=1e-12 * size
    )
    slope = gradient_matrices(lattice.node_count, points, stencils)[0] @ field(lattice.nodes)
    np.testing.assert_allclose(slope, 2.0 * place[:, 0] - 3.0 * place[:, 2], rtol=0.0, atol=1e-10 * np.abs(slope).max())


def test_gradients_are_derivatives_of_the_shape_functions() -> None:
    """Gradients against differences along the tube, around it and through its wall, with second-order errors."""
    lattice = BODIES["tube"].lattice()
    field = np.sin(300.0 * lattice.nodes[:, 0]) + lattice.nodes[:, 1] * lattice.nodes[:, 2] * 1e3

    def at(shift: tuple[float, float, float]) -> tuple[np.ndarray, Any, Any]:
        points = integration_points(lattice, "column", 2, 1.7)
        lines = tuple(line._replace(at=line.at + 0.2 + one) for line, one in zip(points.lines, shift, strict=True))
        lines = (
            lines[0]._replace(at=lines[0].at[1:2]),
            lines[1]._replace(at=lines[1].at[:1]),
            lines[2]._replace(at=lines[2].at[:1]),
        )
        stencils = make_stencils(lattice, lines, 1.7, "linear")
        return value_matrix(lattice.node_count, stencils) @ field, stencils, lines

    _, stencils, lines = at((0.0, 0.0, 0.0))
    local = np.array([stencils.gradients[:, k] @ field[stencils.nodes] for k in range(3)])
    radius = float(lattice.axes[2].coordinates(lines[2].at)[0])
    for k, scale in enumerate((1.0, radius, 1.0)):
        step = 1e-4
        shift = tuple(step if k == place else 0.0 for place in range(3))
        back = tuple(-one for one in shift)
        length = 2.0 * step * float(lattice.axes[k].slope(lines[k].at)[0]) * scale
        difference = float((at(shift)[0] - at(back)[0])[0]) / length
        assert local[k] == pytest.approx(difference, rel=1e-5, abs=1e-5 * np.abs(local).max())


@pytest.mark.parametrize("rule", ["column", "cell"])
@pytest.mark.parametrize("ratio", [1.0, 1.138, 1.6])
def test_a_constant_stress_leaves_no_force_on_the_nodes_inside_a_graded_lattice(rule: Any, ratio: float) -> None:
    """Patch test of forces: sum_p V_p dN_I/dX = 0 two columns away from the edges, to rounding."""
    steps = ratio ** np.array([4.0, 3.0, 2.0, 1.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0])
    graded = Axis(1e-3 * np.concatenate([[0.0], np.cumsum(steps)]))
    lattice = Lattice((graded, graded, even_axis(0.001, 3)), bent=False)
    points = integration_points(lattice, rule, 2, 1.7)
    stencils = make_stencils(lattice, points.lines, 1.7, "linear")
    for k, slope in enumerate(gradient_matrices(lattice.node_count, points, stencils)):
        weighted = (points.volume[:, None] * slope).reshape(-1, *lattice.shape)[:, 2:-2, 2:-2]
        left = weighted.sum(axis=0)
        # For derivatives through the wall use only the middle layer, because the outer layers have surfaces.
        assert np.abs(left if k < 2 else left[:, :, 1]).max() < 1e-10 * np.abs(weighted).sum(axis=0).max()


@pytest.mark.parametrize("rule", [(3, "column", 2), (3, "cell", 2), (4, "column", 3), (5, "cell", 4), (3, "column", 3)])
def test_a_free_patch_has_the_rigid_motions_as_its_only_modes_without_energy(rule: Any) -> None:
    assert zero_mode_count(*rule, "linear", 1.7) == RIGID_MOTIONS


def test_rules_that_are_blind_to_deformations_are_refused() -> None:
    assert zero_mode_count(3, "column", 1, "linear", 1.7) > RIGID_MOTIONS
    with pytest.raises(ge.GranularError, match=r"integration: got 'column' with 1 points through 3 layers.* 147 zero-energy"):
        ge.make("shell", integration={"through": 1})
    for radius in (0.9, 0.3, 1e-15):
        with pytest.raises(ge.ParameterError, match=rf"radius: got {radius:g} spacings: .*has too few neighbours"):
            ge.make("shell", body="plate", radius=radius)
    for body in ("plate", "rod"):
        with pytest.raises(
            ge.ParameterError, match=r"the point at x, y, z = 0, 0, .* has too few neighbours for the basis 'linear'"
        ):
            ge.make("shell", body={"name": body, "across": 5}, radius=0.9)
    with pytest.raises(ge.GranularError, match=r"radius: got 1.7 spacings: .*has too few neighbours for the basis 'quadratic'"):
        ge.make("shell", body="plate", basis="quadratic", radius=1.7)


def test_volumes_are_those_of_the_bodies() -> None:
    tube, plate = BODIES["tube"], BODIES["plate"]
    ring = math.pi * ((tube.inner_radius + tube.wall) ** 2 - tube.inner_radius**2) * tube.length
    for body, volume in ((tube, ring), (plate, plate.length * plate.width * plate.thickness)):
        lattice = body.lattice()
        assert lattice.volumes.sum() == pytest.approx(volume, rel=1e-13)
        for rule in ("column", "cell"):
            assert integration_points(lattice, rule, 2, 1.7).volume.sum() == pytest.approx(volume, rel=1e-13)


def test_points_and_planes_of_an_even_tube_share_their_stencils() -> None:
    lattice = Lattice((even_axis(0.1, 50), closed_axis(2 * math.pi, 64), even_axis(0.001, 3)), bent=False)
    points = integration_points(lattice, "column", 2, 1.7)
    stencils = make_stencils(lattice, points.lines, 1.7, "linear")
    # Along the body: two ends and the interior; through the wall: two points.
    assert len(stencils.first) - 1 == 3 * 2


@pytest.mark.parametrize("count", range(1, 9))
def test_gauss_points_integrate_polynomials(count: int) -> None:
    x, weight = gauss_points(count)
    for power in range(2 * count):
        assert (weight * x**power).sum() == pytest.approx((1 + (-1) ** power) / (power + 1), abs=1e-14)


def test_the_spline_is_smooth_where_it_ends() -> None:
    value, slope = quartic_spline(np.array([0.0, 0.5, 1.0 - 1e-9, 1.0, -0.5]))
    np.testing.assert_allclose(value, [1.0, 0.3125, 0.0, 0.0, 0.3125], atol=1e-15)
    np.testing.assert_allclose(slope, [0.0, -1.5, 0.0, 0.0, 1.5], atol=1e-15)
