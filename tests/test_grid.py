"""The grid against exact results: patch tests, rigid motion, conserved quantities, symmetry, step size."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from support.component_examples import GRIDS, PINWHEEL, Example
from support.conformance_tools import drive_component, state_bits
from support.grid_tools import MEDIUM, P_SPEED, SMALL, bar, block, distorted_block, inner_nodes, pulse, start_pulse

import granular_env as ge
from granular_env.components.errors import ParameterError, StepError
from granular_env.components.grid import Grid, component, kernels
from granular_env.components.grid.kernel_arrays import Yields
from granular_env.components.profiles import Profile

ROOT = Path(__file__).resolve().parent.parent


# -- patches and rigid motion --------------------------------------------------------------------------------------------


def rotation(angle: float) -> np.ndarray:
    """Return the rotation matrix of an angle."""
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])


# Displacement gradients: stretch, shear, rotation, and all together.
GRADIENTS = [[[1.0, 0.0], [0.0, 0.0]], [[0.0, 1.0], [1.0, 0.0]], [[0.0, -1.0], [1.0, 0.0]], [[0.7, -1.1], [0.4, 0.3]]]


def patches() -> list[Grid]:
    return [block(7, 5), distorted_block(7, 6), Grid(mesh=PINWHEEL, material=MEDIUM)]


@pytest.mark.parametrize("gradient", GRADIENTS)
def test_a_homogeneous_strain_leaves_inner_nodes_without_force(gradient: list[list[float]]) -> None:
    for grid in patches():
        grid.reset(displacement=SMALL * grid.mesh.nodes @ np.array(gradient).T)
        strain = 0.5 * (np.array(gradient) + np.array(gradient).T)
        volume = np.trace(strain)
        exact = SMALL * np.array([volume + 2 * strain[0, 0], volume + 2 * strain[1, 1], volume, 2 * strain[0, 1]])
        np.testing.assert_allclose(grid.get("stress"), np.tile(exact, (len(grid.mesh.cells), 1)), atol=1e-12 * SMALL)
        assert inner_nodes(grid).any()
        assert np.abs(grid._state.force[inner_nodes(grid)]).max() <= 1e-12 * SMALL


@pytest.mark.parametrize("angle", [0.3, -1.2, 0.5 * math.pi, 3.0])
@pytest.mark.parametrize("stretch", [(1.0, 1.0), (1.01, 0.995), (1.4, 0.6)])
def test_a_start_displacement_gives_the_stress_of_its_stretch_in_any_rotation(
    angle: float, stretch: tuple[float, float]
) -> None:
    """Stress C : ln U, rotated with the body, and its energy."""
    stretches, turned = np.diag(stretch), rotation(angle)
    first, second = np.log(stretch)
    exact = np.diag([3.0 * first + second, first + 3.0 * second])
    along_z = first + second
    density = 0.5 * (exact[0, 0] * first + exact[1, 1] * second)
    for grid in patches():
        # Stretch along 20 degrees to the mesh, which includes shear in mesh axes.
        axes = rotation(math.radians(20.0))
        gradient = turned @ axes @ stretches @ axes.T
        grid.reset(displacement=grid.mesh.nodes @ gradient.T - grid.mesh.nodes)
        xx, yy, zz, xy = grid.get("stress").T
        back = (turned @ axes).T @ np.array([[xx, xy], [xy, yy]]).transpose(2, 0, 1) @ (turned @ axes)
        np.testing.assert_allclose(back, np.broadcast_to(exact, back.shape), atol=1e-13)
        np.testing.assert_allclose(zz, along_z, atol=1e-13)
        area = stretch[0] * stretch[1] * grid.mesh.areas.sum()
        assert grid.get("elastic_energy") == pytest.approx(area * density, rel=1e-11, abs=1e-20)
        # A homogeneous strain has no hourglass mode.
        assert grid.get("hourglass_energy") <= 1e-24


def test_stresses_turn_with_a_body_that_spins() -> None:
    """After a rotation by 90 degrees, the stresses of a stretched square are along the other axis."""
    grid = block(1, 1, step_size=1e-3)
    stress = np.array([[1.0, 0.0, 0.0, 0.0]])
    spin = 0.5 * math.pi
    # The test keeps the distance of each node from the centre.
    grid.reset(stress=stress)
    velocity = grid._state.velocity
    for tick in range(1000):
        angle, onward = spin * tick * 1e-3, spin * (tick + 1) * 1e-3
        there, here = (
            grid.mesh.nodes @ np.array([[math.cos(one), math.sin(one)], [-math.sin(one), math.cos(one)]])
            for one in (onward, angle)
        )
        velocity[:] = (there - here) / 1e-3
        grid._state.displacement[:] = there - grid.mesh.nodes
        grid._update_forces(1e-3)
    # Each of a thousand steps has several rounding errors.
    np.testing.assert_allclose(grid.get("stress"), [[0.0, 1.0, 0.0, 0.0]], atol=1e-12)


# -- conservation --------------------------------------------------------------------------------------------------------


def test_energy_and_momentum_of_a_plane_wave_are_conserved() -> None:
    grid = bar(300, boundaries={"right": "fixed"})
    start_pulse(grid, 80.0, 40.0)
    energy = grid.get("kinetic_energy") + grid.get("elastic_energy")
    momentum = grid.get("momentum")[0]
    grid.step(200.0)
    assert abs(grid.get("energy_residual")) <= 1e-12 * energy
    assert abs(grid.get("momentum_residual")[0]) <= 1e-12 * momentum
    # The wave has reflected from the rigid end, which received twice its momentum.
    assert grid.get("boundary_impulse")[0] == pytest.approx(-2.0 * momentum, rel=1e-3)


@pytest.mark.parametrize("seed", [1, 2])
def test_noise_on_a_distorted_mesh_keeps_energy_and_momenta(seed: int) -> None:
    grid = distorted_block(12, 9, seed)
    grid.reset(velocity=SMALL * np.random.default_rng(seed).standard_normal(grid.mesh.nodes.shape))
    energy, turning = grid.get("kinetic_energy"), abs(grid.get("angular_momentum"))
    grid.step(400 * grid.step_size)
    assert grid.get("hourglass_energy") > 0.01 * energy and grid.get("elastic_energy") > 0.1 * energy
    assert abs(grid.get("energy_residual")) <= 1e-12 * energy
    # Linear and angular momentum are sums over 130 nodes of about SMALL, at distances up to 10.
    assert np.abs(grid.get("momentum_residual")).max() <= 1e-12 * 130 * SMALL
    assert abs(grid.get("angular_momentum_residual")) <= 1e-12 * max(turning, 130 * SMALL)


def test_work_of_every_condition_is_accounted_for() -> None:
    """In linear motion with forces, tractions, driven, absorbing and fixed edges, the energy closes to rounding."""
    grid = block(
        8, 6, forced_nodes=[20], boundaries={
            "left": {"name": "velocity", "along": "nodes"}, "right": "traction",
            "top": {"name": "absorbing", "sponge_width": 2.0},
        },
    )  # fmt: skip
    motion = SMALL * np.random.default_rng(3).standard_normal((7, 2))
    signal = Profile.half_sine(1.0, 40 * grid.step_size)
    grid.step(50 * grid.step_size, left_velocity=signal * motion, right_traction=signal * (SMALL * np.array([1.0, -2.0])))
    grid.step(50 * grid.step_size, left_velocity=motion, force=SMALL)
    grid.step(100 * grid.step_size, left_velocity=0.0, force=0.0)
    assert grid.get("absorbed_energy") > 0.1 * grid.get("kinetic_energy") > 0.0
    assert abs(grid.get("energy_residual")) <= 1e-12 * abs(grid.get("input_work"))
    assert np.abs(grid.get("momentum_residual")).max() <= 1e-12 * np.abs(grid.get("boundary_impulse")).max()
    assert abs(grid.get("angular_momentum_residual")) <= 1e-12 * abs(grid.get("boundary_angular_impulse"))


def test_the_residual_of_finite_strains_falls_with_them() -> None:
    residuals = []
    for strain in (1e-2, 1e-3, 1e-4):
        grid = block(10, 8)
        grid.reset(velocity=strain * np.sin(grid.mesh.nodes @ np.array([[0.5, 0.3], [0.2, 0.7]])))
        energy = grid.get("kinetic_energy")
        grid.step(100.0)
        residuals.append(abs(grid.get("energy_residual")) / energy)
    # Proportional to the strain: a factor of 10 per step, within a factor of 3.
    assert residuals[0] < 1e-3 and residuals[1] < residuals[0] / 3 and residuals[2] < residuals[1] / 3


def bend_and_turn(plasticity: object, angle: float, steps: int) -> np.ndarray:
    """Stretch and bend a cell while it rotates; return stress and hourglass force in rotating axes."""
    nodes = np.array([[0.0, 0.0], [1.1, -0.1], [1.3, 0.9], [-0.2, 1.0]])
    mesh = {"name": "quadrilaterals", "nodes": nodes, "cells": [[0, 1, 2, 3]]}
    grid = Grid(mesh=mesh, material=MEDIUM, plasticity=plasticity)
    bending = 0.002 * np.outer([1.0, -1.0, 1.0, -1.0], [1.0, 0.5])
    places = [
        (nodes * (1.0 + np.array([0.01, -0.006]) * part) + part * bending) @ rotation(angle * part).T
        for part in np.arange(steps + 1) / steps
    ]
    state, yields = grid._state, Yields(np.zeros((steps, 5)), np.zeros(1, dtype=np.int64))
    for tick, (before, after) in enumerate(pairwise(places)):
        state.velocity[:], state.displacement[:] = after - before, after - nodes
        kernels.advance_cell_range(grid.tables(), 1.0, tick, yields, 0, 1)
    assert isinstance(plasticity, str) or grid.get("plastic_strain")[0] > 1e-3
    (xx, yy, zz, xy), turned = state.stress[0], rotation(angle)
    plane = turned.T @ np.array([[xx, xy], [xy, yy]]) @ turned
    return np.concatenate([plane.ravel(), [zz], turned.T @ state.hourglass_force[0]])


@pytest.mark.parametrize(
    "plasticity",
    ["elastic", {"name": "von_mises", "yield_stress": 5e-3, "hardening": 0.1},
     {"name": "drucker_prager", "yield_stress": 4e-3, "friction": 0.6, "dilatancy": 0.3, "hardening": 0.05}],
    ids=["elastic", "von Mises", "Drucker-Prager"],
)  # fmt: skip
@pytest.mark.parametrize("degrees", [30.0, 60.0, 90.0])
def test_rotation_adds_an_error_of_second_order_to_the_stress_update(plasticity: object, degrees: float) -> None:
    """Stress and hourglass force relative to the same steps without rotation: half the step leaves a quarter of the error."""
    errors = np.array([
        np.abs(bend_and_turn(plasticity, math.radians(degrees), steps) - bend_and_turn(plasticity, 0.0, steps))
        for steps in (10, 20, 40, 80)
    ])  # fmt: skip
    for part in (errors[:, :5].max(axis=1), errors[:, 5:].max(axis=1)):
        # Terms of the next order contribute a tenth at 10 steps.
        np.testing.assert_allclose(part[:-1] / part[1:], 4.0, rtol=0.1)


def test_the_residual_of_finite_strains_is_of_second_order_in_the_step() -> None:
    """A sheared bar rotates under stress; using the already rotated stress would make the work first-order."""
    residuals = []
    for step in (0.2, 0.05):
        bar = block(8, 6, boundaries={"left": "fixed", "right": "velocity"}, step_size=step)
        bar.step(40.0, right_velocity=ge.Profile.half_sine(1.0, 30.0) * [0.01, 0.02])
        residuals.append(abs(bar.get("energy_residual")) / abs(bar.get("input_work")))
    assert residuals[0] < 1e-5 and 9.0 <= residuals[0] / residuals[1] <= 25.0


def test_a_traction_gives_its_impulse() -> None:
    grid = block(6, 4, boundaries={"right": "traction"})
    grid.step(3.0, right_traction=SMALL * np.array([2.0, -1.0]))
    # Traction on 4 m of edge for 3 s.
    np.testing.assert_allclose(grid.get("momentum"), 12.0 * SMALL * np.array([2.0, -1.0]), rtol=1e-12)
    np.testing.assert_allclose(grid.get("impulse"), 12.0 * SMALL * np.array([2.0, -1.0]), rtol=1e-12)


def test_linear_tractions_have_their_force_and_their_moment() -> None:
    grid = block(2, 4, boundaries={"right": {"name": "traction", "along": "nodes"}})
    y = np.arange(-2.0, 3.0)
    traction = np.stack([SMALL * (3.0 + y), np.zeros(5)], axis=1)
    grid.step(grid.step_size, right_traction=traction)
    # Integrals of 3 + y and of -y (3 + y) from -2 to 2.
    assert grid.get("impulse")[0] == pytest.approx(12.0 * SMALL * grid.step_size, rel=1e-12)
    assert grid.get("angular_impulse") == pytest.approx(-16.0 / 3.0 * SMALL * grid.step_size, rel=1e-9)


# -- symmetry, order of operations----------------------------------------------------------------------------------------


@pytest.mark.parametrize("axis", [0, 1])
def test_mirror_images_have_mirrored_bits(axis: int) -> None:
    """Finite plastic motion on a mesh with a notch and a hole, compared with its mirror image."""
    slot, middle = ([-0.4, 0.4], [-1.85, -0.7]), [0.0, 0.37]
    x, y = slot if axis == 0 else slot[::-1]
    holes = [
        {"name": "box", "x": x, "y": y},
        {"name": "disc", "centre": middle if axis == 0 else middle[::-1], "radius": 0.45},
    ]
    mesh = {"name": "rectangle", "columns": 10, "rows": 10, "cell_size": 0.37, "centre": [0.0, 0.0], "holes": holes}
    grid = Grid(mesh=mesh, material=MEDIUM, plasticity={"name": "von_mises", "yield_stress": 0.05})
    assert len(grid.mesh.cells) < 96
    nodes = grid.mesh.nodes
    flip = np.array([-1.0, 1.0]) if axis == 0 else np.array([1.0, -1.0])
    partner = np.array([int(np.flatnonzero((nodes == nodes[n] * flip).all(axis=1))[0]) for n in range(len(nodes))])
    velocity = 0.05 * np.random.default_rng(5).standard_normal(nodes.shape)
    grid.reset(velocity=velocity)
    grid.step(60 * grid.step_size)
    one, events = grid.get("velocity"), grid.event_count
    grid.reset(velocity=velocity[partner] * flip)
    grid.step(60 * grid.step_size)
    assert events == grid.event_count > 10
    # Zeros may have either sign.
    np.testing.assert_array_equal(grid.get("velocity"), one[partner] * flip)


@pytest.mark.parametrize("example", GRIDS, ids=lambda example: example.label)
def test_the_bits_do_not_depend_on_the_number_of_parts(example: Example, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = example.make_started()
    drive_component(whole, example, 60)
    monkeypatch.setattr(component, "LEAST_CELLS", 1)
    for threads in ("2", "4"):
        monkeypatch.setenv("GRANULAR_ENV_THREADS", threads)
        parted = example.make_started()
        drive_component(parted, example, 60)
        assert state_bits(parted) == state_bits(whole)


def test_parts_name_the_first_cell_that_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(component, "LEAST_CELLS", 1)
    monkeypatch.setenv("GRANULAR_ENV_THREADS", "2")
    grid = block(6, 6)
    for node, cells in ((24, range(18)), (38, range(18, 36))):
        grid.reset(velocity={node: (3.0, 0.0)})
        with pytest.raises(StepError) as caught:
            grid.step(10.0)
        assert caught.value.index in cells and grid.tick == 0


_WITHOUT_JIT = """
import sys
sys.path.insert(0, sys.argv[1])
from support.component_examples import GRIDS
from support.conformance_tools import drive_component, state_bits
for example in GRIDS:
    component = example.make_started()
    drive_component(component, example, 12)
    print(__import__("hashlib").sha256(state_bits(component)).hexdigest())
"""


def test_kernels_give_the_same_bits_without_the_jit() -> None:
    command = [sys.executable, "-c", _WITHOUT_JIT, str(ROOT / "tests")]
    answers = [
        subprocess.run(
            command, capture_output=True, text=True, check=True, cwd=ROOT, env={**os.environ, **extra}
        ).stdout.split()
        for extra in ({}, {"NUMBA_DISABLE_JIT": "1"})
    ]
    assert len(answers[0]) == len(GRIDS) and answers[0] == answers[1]


# -- the step ------------------------------------------------------------------------------------------------------------


def test_the_highest_frequency_is_that_of_the_mesh() -> None:
    # Frequency of P waves along an axis at the zone boundary, 2 c_p / h; power iteration converges from below.
    frequency = block(40, 40).highest_frequency
    assert 0.985 * 2.0 * P_SPEED <= frequency <= 2.0 * P_SPEED * (1.0 + 1e-9)


@pytest.mark.parametrize("make", [lambda h: block(12, 12, step_size=h), lambda h: distorted_block(12, 12, step_size=h)])
def test_a_step_is_stable_up_to_what_is_allowed_and_refused_beyond(make) -> None:  # noqa: ANN001
    largest = 2.0 / make(0.01).highest_frequency
    grid = make(0.899 * largest)
    grid.reset(velocity=SMALL * np.random.default_rng(1).standard_normal(grid.mesh.nodes.shape))
    energy = grid.get("kinetic_energy")
    grid.step(3000 * grid.step_size)
    assert grid.get("kinetic_energy") < 2.0 * energy
    with pytest.raises(ParameterError, match="step_size: got .* expected at most"):
        make(0.901 * largest)


# -- invalid input -------------------------------------------------------------------------------------------------------

SQUARE = {"name": "rectangle", "columns": 4, "rows": 4, "cell_size": 1.0}
NODES = [[0, 0], [1, 0], [1, 1], [0, 1], [2, 0], [2, 1]]


def mesh_of(cells: list[list[int]], nodes: list | None = None, **edges: list[int]) -> dict:
    return {"name": "quadrilaterals", "nodes": NODES if nodes is None else nodes, "cells": cells, "edges": edges}


def test_inputs_of_an_edge_keep_the_order_of_its_nodes() -> None:
    mesh = mesh_of([[0, 1, 2, 3], [1, 4, 5, 2]], rim=[5, 2, 3], whole=[3, 0, 1, 4, 5, 2, 3])
    velocities = np.array([[5.0, 0.0], [2.0, 0.0], [3.0, 0.0]])
    driven = ge.make("grid", mesh=mesh, boundaries={"rim": {"name": "velocity", "along": "nodes"}})
    driven.step(driven.step_size, rim_velocity=velocities)
    np.testing.assert_array_equal(driven.get("velocity")[[5, 2, 3]], velocities)
    assert "`mesh.edges.rim`" in driven.variables["rim_velocity"].description
    loaded = ge.make("grid", mesh=mesh, boundaries={"whole": {"name": "traction", "along": "nodes"}})
    assert loaded.mesh.edge_nodes("whole").tolist() == [3, 0, 1, 4, 5, 2]
    traction = np.zeros((6, 2))
    traction[3] = 1.0, 0.0
    loaded.step(loaded.step_size, whole_traction=traction)
    assert loaded.get("velocity")[:, 0].argmax() == 4


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"mesh": mesh_of([[0, 1, 2, 3], [1, 2, 5, 4]])}, ["cells[1]", "inverted", "clockwise"]),
        ({"mesh": mesh_of([[0, 1, 2, 3], [1, 4, 5, 1]])}, ["cells[1]", "four different nodes"]),
        ({"mesh": mesh_of([[0, 1, 2, 3]])}, ["nodes[4]", "does not belong to any cell"]),
        ({"mesh": mesh_of([[0, 1, 2, 3]], [[0, 0], [1, 0], [0.2, 0.2], [0, 1]])}, ["cells[0]", "not convex"]),
        ({"mesh": mesh_of([[0, 1, 2, 3], [1, 4, 5, 2]], side=[0, 2])}, ["edges.side", "nodes 0 and 2", "not joined by a side"]),
        ({"mesh": {**SQUARE, "holes": [{"name": "box", "x": [9, 10], "y": [0, 1]}]}}, ["holes[0]", "the centre of any cell"]),
        (
            {"mesh": mesh_of([[0, 1, 2, 3], [4, 5, 6, 7]], [*NODES[:4], [0.5, 0.5], [1.5, 0.5], [1.5, 1.5], [0.5, 1.5]])},
            ["nodes[4]", "lies in cell 0 or on a side of it", "overlap"],
        ),
        (
            {"mesh": mesh_of([[0, 1, 2, 3], [1, 4, 5, 6]], [*NODES[:4], [2, 0], [2, 0.5], [1, 0.5]])},
            ["nodes[6]", "lies in cell 0 or on a side of it", "are not connected", "divide that cell"],
        ),
        ({"boundaries": {"left": "periodic"}}, ["boundaries.left", "partner"]),
        ({"boundaries": {"left": {"name": "absorbing", "sponge_width": 9.0}}}, ["left.sponge_width", "the whole mesh"]),
        ({"cell_material": [0, 0]}, ["cell_material", "got 2 numbers, expected 16"]),
        ({"plasticity": ["elastic", "elastic"]}, ["plasticity", "2 laws for 1 materials"]),
        ({"forced_nodes": [7, 0], "boundaries": {"left": "fixed"}}, ["forced_nodes[1]: the motion of node 0 is prescribed"]),
        ({"receivers": [[5.0, 77.0]]}, ["receivers[0]", "expected a point of the body"]),
    ],
)  # fmt: skip
def test_bad_parameters_are_refused(parameters: dict, words: list[str]) -> None:
    with pytest.raises(ParameterError) as caught:
        ge.make("grid", **{"mesh": SQUARE, "material": MEDIUM, **parameters})
    for word in words:
        assert word in str(caught.value)


def test_an_inverting_cell_is_named_and_the_last_state_kept() -> None:
    grid = block(4, 4)
    grid.reset(velocity={12: (3.0, 0.0)})
    with pytest.raises(StepError, match=r"displacement: cell \d+ has been inverted") as caught:
        grid.step(10.0)
    assert caught.value.index in range(16) and grid.tick == 0 and grid.get("velocity")[12, 0] == 3.0


# -- reading -------------------------------------------------------------------------------------------------------------


def test_held_edges_tell_what_they_hold() -> None:
    """Slow uniaxial compression: each side carries its stress, lambda e or (lambda + 2 mu) e."""
    edges = {"left": "fixed", "right": {"name": "velocity", "components": "x"}, "bottom": "symmetry", "top": "symmetry"}
    grid = block(6, 3, boundaries=edges)
    strain, duration = 1e-8, 600.0
    ramp = Profile.half_sine(0.5 * math.pi * 6.0 * strain / duration, duration)
    grid.step(duration, right_velocity=ramp * np.array([-1.0, 0.0]))
    pressed = 3.0 * strain * 3.0
    np.testing.assert_allclose(grid.get("left_reaction"), [pressed, 0.0], rtol=1e-3, atol=1e-3 * pressed)
    np.testing.assert_allclose(grid.get("right_reaction"), [-pressed, 0.0], rtol=1e-3, atol=1e-3 * pressed)
    # Six metres of edge, of which the node at the left end belongs to the fixed edge.
    held = 6.0 * strain * 5.5 / 6.0
    np.testing.assert_allclose(grid.get("bottom_reaction"), [0.0, held], rtol=1e-3, atol=1e-12)
    np.testing.assert_array_equal(grid.get("top_reaction"), -grid.get("bottom_reaction"))


def test_outputs_agree_with_each_other() -> None:
    grid = block(4, 4, receivers=[7, [0.0, 0.0]], plasticity={"name": "von_mises", "yield_stress": 0.05})
    grid.reset(velocity=0.1 * pulse(grid.mesh.nodes + 2.0, 4.0))
    grid.step(2.0)
    np.testing.assert_array_equal(grid.get("receiver_velocity"), grid.get("velocity")[[7, 12]])
    xx, yy, zz, xy = grid.get("stress").T
    np.testing.assert_allclose(grid.get("pressure"), -(xx + yy + zz) / 3.0)
    p = grid.get("pressure")
    norm = (xx + p) ** 2 + (yy + p) ** 2 + (zz + p) ** 2 + 2.0 * xy**2
    np.testing.assert_allclose(grid.get("equivalent_stress"), np.sqrt(1.5 * norm))
    assert grid.get("internal_energy").sum() == pytest.approx(grid.get("elastic_energy") + grid.get("plastic_work"))
    assert grid.get("mass") == 16.0


def test_nothing_moves_far_ahead_of_a_wave_whose_step_is_tiny() -> None:
    """Values ahead of a front are not denormal, which would slow processors down, and any partition gives equal bits."""
    once, often = (block(40, 12, forced_nodes=[[-20.0, 0.0]], step_size=1e-3) for _ in range(2))
    once.step(0.3, force=[[1e-3, 0.0]])
    for _ in range(60):
        often.step(5e-3, force=[[1e-3, 0.0]])
    assert once.save().to_bytes() == often.save().to_bytes()
    tiny = np.finfo(float).tiny
    for name in ("displacement", "velocity", "stress", "internal_energy"):
        values = np.abs(once.get(name))
        assert (values == 0.0).any() and values[values > 0.0].min() > tiny
