"""The solid against theoretical beams, bars, rings and tubes, and its refusals."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.golden_logs import final_hash, play_case
from support.solid_tools import (
    ALUMINIUM,
    RADIUS,
    WALL,
    cantilever_frequency,
    cantilever_shape,
    clamped_bar_frequency,
    displacement_history,
    frequency,
    make_callable,
    ring,
    strip,
)

import granular_env as ge
from granular_env.components.materials.thermoviscoplastic import Thermoviscoplastic, flow_stress
from granular_env.components.shell import ticks
from granular_env.components.shell.theory import (
    breathing_frequency,
    critical_speed,
    lame_displacement,
    static_hoop_stress,
)

ROOT = Path(__file__).resolve().parent.parent
MIDDLE = RADIUS + 0.5 * WALL


def test_theory_gives_the_figures_of_the_paper() -> None:
    young, poisson, density = ALUMINIUM["young"], ALUMINIUM["poisson"], ALUMINIUM["density"]
    assert breathing_frequency(young, poisson, density, MIDDLE) == pytest.approx(42.06e3, rel=1e-4)
    assert critical_speed(young, poisson, density, MIDDLE, WALL) == pytest.approx(827.0, rel=1e-3)
    assert static_hoop_stress(RADIUS, WALL, 6.2e6) == pytest.approx(138e6, rel=5e-3)


@pytest.mark.parametrize("poisson", [0.0, 0.33])
def test_a_strip_bends_as_a_beam_and_stretches_as_a_bar(poisson: float) -> None:
    solid = strip(poisson)
    x = solid.nodes[:, 0]
    tip = int(np.argmax(x + solid.nodes[:, 2]))
    velocity = np.zeros_like(solid.nodes)
    velocity[:, 2] = 0.1 * cantilever_shape(x, 0.02)
    solid.reset(nodal_velocity=velocity)
    exact = cantilever_frequency(69e9, 2719.0, 0.02, WALL)
    moved = displacement_history(solid, tip, 2, round(1.1 / exact / solid.step_size / 20), ticks=20)
    # The extremes are at a quarter and three quarters of a period, i.e. half a period apart.
    measured = 0.5 / ((np.argmin(moved) - np.argmax(moved)) * 20 * solid.step_size)
    if poisson == 0.0:
        assert measured / exact == pytest.approx(1.0, abs=0.02)
    else:  # between a beam and a plate in cylindrical bending
        assert 1.0 < measured / exact < 1.0 / math.sqrt(1.0 - poisson**2)
    velocity[:] = 0.0
    velocity[:, 0] = 0.1 * np.sin(0.5 * math.pi * x / 0.02)
    solid.reset(nodal_velocity=velocity)
    exact = clamped_bar_frequency(69e9, 2719.0, 0.02)
    moved = displacement_history(solid, tip, 0, round(2.3 / exact / solid.step_size))
    assert frequency(moved, solid.step_size) / exact == pytest.approx(1.0, abs=0.015)


def test_a_ring_breathes_at_its_frequency_around_the_static_state_and_swings_twice_as_far() -> None:
    solid = ring()
    exact = breathing_frequency(69e9, 0.33, 2719.0, MIDDLE)
    middle = 1  # middle of the three nodes at angle 0 through the wall, which is along z
    moved = displacement_history(solid, middle, 2, round(2.3 / exact / solid.step_size), pressure=1e6)
    assert frequency(moved, solid.step_size) / exact == pytest.approx(1.0, abs=3e-3)
    static = lame_displacement(69e9, 0.33, RADIUS, WALL, 1e6, MIDDLE)
    assert 0.5 * (moved.max() + moved.min()) / static == pytest.approx(1.0, abs=0.015)
    assert moved.max() / (0.5 * (moved.max() + moved.min())) == pytest.approx(2.0, abs=0.02)
    energy, momentum, _ = solid.balances()
    assert abs(energy.residual) < 1e-6 * energy.entries["pressure_work"]
    assert np.abs(momentum.residual).max() < 1e-12


def test_a_half_tube_breathes_as_the_whole() -> None:
    body = {"name": "tube", "length": 0.002, "along": 3, "around": 49, "half": True}
    whole, half = ring(step_size=5e-8), ring(body=body, step_size=5e-8)
    for solid in (whole, half):
        solid.step(6e-6, pressure=1e6)
    assert half.mass.sum() == pytest.approx(0.5 * whole.mass.sum(), rel=1e-12)
    a = whole.get("displacement")[: 3 * 49].reshape(49, 3, 3)
    b = half.get("displacement")[: 3 * 49].reshape(49, 3, 3)
    # At a plane of symmetry the support of points is one-sided: errors of a percent, a tenth of that elsewhere.
    np.testing.assert_allclose(b, a, rtol=0.0, atol=1e-2 * np.abs(a).max())
    np.testing.assert_allclose(b[4:-4], a[4:-4], rtol=0.0, atol=1e-3 * np.abs(a).max())


def test_stress_turns_with_the_body() -> None:
    """A rotation by 90 degrees in 1000 ticks, to rounding: strain and spin of a rigid rotation are exact for any step."""
    solid = ge.make("shell", body={"name": "plate", "length": 0.003, "width": 0.003, "along": 4, "across": 4})
    stretched = solid.nodes * [1e-3, -3e-4, -3e-4]
    solid.reset(nodal_displacement=stretched)
    before = solid.get("stress")
    tables, state, scratch, _ = solid.tables()
    for tick in range(1, 1001):
        angle = 0.5 * math.pi * tick / 1000
        turn = np.array([[math.cos(angle), -math.sin(angle), 0.0], [math.sin(angle), math.cos(angle), 0.0], [0.0, 0.0, 1.0]])
        state.displacement[:] = (solid.nodes + stretched) @ turn.T - solid.nodes
        assert ticks.update_forces(tables, state, scratch, np.zeros(2, dtype=np.int64)) == 0
    turned = before[:, [1, 0, 2, 3, 5, 4]]  # xx and yy are exchanged, and yz and zx
    np.testing.assert_allclose(state.stress[:, :3], turned[:, :3], rtol=0.0, atol=1e-10 * np.abs(before).max())
    assert np.abs(state.stress[:, 3:]).max() < 1e-10 * np.abs(before).max()
    assert np.abs(state.force).max() > 0.0
    # The total force and torque are zero.
    place = solid.nodes + state.displacement
    scale = np.abs(state.force).max()
    assert np.abs(state.force.sum(axis=0)).max() < 1e-10 * scale
    assert np.abs(np.cross(place, state.force).sum(axis=0)).max() < 1e-10 * scale * 0.003


def test_a_free_body_keeps_energy_momentum_and_angular_momentum() -> None:
    solid = ge.make("shell", body={"name": "plate", "length": 0.004, "width": 0.003, "along": 5, "across": 4})
    x = solid.nodes
    spin = np.cross([300.0, -2000.0, 5000.0], x) + [3.0, 1.0, -2.0] + 5.0 * np.sin(1000.0 * x[:, ::-1])
    solid.reset(nodal_velocity=spin)

    def turning() -> np.ndarray:
        return np.cross(x + solid.get("nodal_displacement"), solid.mass[:, None] * solid.get("nodal_velocity")).sum(axis=0)

    before = turning()
    solid.step(400 * solid.step_size)
    energy, momentum, _ = solid.balances()
    assert abs(energy.residual) < 1e-4 * energy.initial
    assert np.abs(momentum.residual).max() < 1e-12 * np.abs(momentum.initial).max()
    np.testing.assert_allclose(turning(), before, rtol=0.0, atol=1e-11 * np.abs(before).max())


def test_the_energy_closes_to_second_order() -> None:
    residuals = []
    for step in (4e-8, 2e-8):
        solid = ring(step_size=step, body={"name": "tube", "length": 0.004, "along": 5, "around": 24}, boundaries={})
        solid.step(4e-6, pressure=2e7 * np.linspace(1.0, 0.2, 5))
        energy = solid.balances()[0]
        residuals.append(abs(energy.residual) / energy.entries["pressure_work"])
    assert residuals[0] < 1e-4
    assert residuals[0] / residuals[1] > 3.0


def test_hourglass_control_holds_what_the_points_do_not_see() -> None:
    """Without it, displacements that alternate between columns cost almost no energy; it does not affect a bent strip."""
    body = {"name": "tube", "length": 0.006, "along": 7, "around": 48}
    solid = ge.make("shell", body=body)
    alternating = np.zeros((7, 48, 3, 3))
    alternating[..., 0] = 1e-7 * (-1.0) ** np.arange(48)[None, :, None]
    solid.reset(nodal_displacement=alternating.reshape(-1, 3))
    # Reference: the energy of a shear of two amplitudes over the distance of the columns.
    sheared = 0.5 * 69e9 * (2e-7 / (2.0 * math.pi * MIDDLE / 48)) ** 2 * solid.mass.sum() / 2719.0
    assert solid.get("elastic_energy") < 0.05 * sheared
    assert solid.get("hourglass_energy") == pytest.approx(0.05 * sheared, rel=0.05)
    bent = strip(0.33)
    displacement = np.zeros_like(bent.nodes)
    x, z = bent.nodes[:, 0], bent.nodes[:, 2] - 0.5 * WALL
    displacement[:, 2], displacement[:, 0] = 5.0 * x * x, -10.0 * x * z
    bent.reset(nodal_displacement=displacement)
    assert bent.get("hourglass_energy") < 0.01 * bent.get("elastic_energy")


def test_means_over_columns_have_nothing_of_what_alternates_and_all_of_what_is_even() -> None:
    """A hoop stress in a tube plus stresses alternating along and around it, also across the seam; exact to rounding."""
    solid: Any = ge.make("shell", body={"name": "tube", "length": 0.006, "along": 7, "around": 24})
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    sine, cosine = np.sin(angle)[None, :, None], np.cos(angle)[None, :, None]
    signs = (-1.0) ** np.arange(7)[:, None, None], (-1.0) ** np.arange(24)[None, :, None]
    hoop = np.zeros((7, 24, 2, 6))
    for amplitude, sign in ((0.0, 1.0), (0.3, signs[0]), (0.3, signs[1]), (0.3, signs[0] * signs[1])):
        size = 1e8 * (1.0 + amplitude * sign * np.ones((7, 24, 2)))
        hoop[..., 1], hoop[..., 2], hoop[..., 4] = size * cosine**2, size * sine**2, -size * sine * cosine
        solid.reset(stress=hoop.reshape(-1, 6))
        np.testing.assert_allclose(solid.get("equivalent_stress"), 1e8, rtol=1e-12)
    assert np.abs(solid.get("stress") - solid.get("mean_stress")).max() > 2e7


def test_metal_under_tension_follows_its_law() -> None:
    """A block under uniform tension at 1000/s: each point follows the law, work becomes heat, and energy closes."""
    edges = {"start": "symmetry", "end": "platen", "left": "symmetry", "bottom": "symmetry"}
    body = {"name": "plate", "length": 0.004, "width": 0.002, "thickness": 0.001, "along": 5, "across": 4}
    solid = ge.make("shell", body=body, boundaries=edges, material="thermoviscoplastic")
    rate, law = 1e3, Thermoviscoplastic()
    solid.reset(nodal_velocity=solid.nodes * [rate, -0.5 * rate, -0.5 * rate])
    # Constant rate of true strain.
    times = np.linspace(0.0, 6e-5, 13)
    pull = ge.Profile.table(times, 0.004 * rate * np.exp(rate * times))
    solid.step(round(5e-5 / solid.step_size) * solid.step_size, end_velocity=pull)
    strain, heat = solid.get("plastic_strain"), solid.get("temperature")
    # Use the stresses of the points, because strains and temperatures are not averaged over columns.
    xx, yy, zz, xy, yz, zx = solid.get("stress").T
    stress = np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * (xy**2 + yz**2 + zx**2))
    np.testing.assert_allclose(strain + stress / law.young, 0.05, rtol=0.05)
    constants = law.constants(solid.step_size)
    expected = (
        np.array([make_callable(flow_stress)(constants, e, t) for e, t in zip(strain, heat, strict=True)])
        * (rate / 1e-3) ** 0.01
    )
    np.testing.assert_allclose(stress, expected, rtol=1e-3)
    work, volume = solid.get("plastic_work"), solid.assembly.points.volume
    warmed = float((volume * (heat - 293.0)).sum()) * law.density * law.specific_heat
    assert warmed / (0.9 * work) == pytest.approx(1.0, abs=5e-3)
    energy = solid.balances()[0]
    assert abs(energy.residual) < 1e-4 * energy.entries["plastic_work"]


def test_a_body_bounces_off_a_wall_with_its_energy() -> None:
    solid = ge.make(
        "shell", body={"name": "rod", "length": 0.006, "side": 0.003, "along": 7, "across": 4}, boundaries={"start": "wall"}
    )
    solid.reset(nodal_velocity=(-2.0, 0.0, 0.0))
    # Sound runs to the free end and back in 2.4 us.
    solid.step(round(5e-6 / solid.step_size) * solid.step_size)
    energy, momentum, _ = solid.balances()
    assert momentum.entries["momentum"][0] == pytest.approx(-momentum.initial[0], rel=0.1)  # type: ignore[index]
    assert abs(energy.residual) < 1e-3 * energy.initial
    assert abs(momentum.residual).max() < 1e-12 * abs(momentum.initial).max()  # type: ignore[union-attr]


def test_gauges_measure_the_strain_of_the_outer_surface() -> None:
    solid = ring(gauges=[[0.001, 0.5 * math.pi], [0.0, 0.0]])
    radial = solid.nodes * [0.0, 1.0, 1.0]
    solid.reset(nodal_displacement=1e-3 * radial)
    np.testing.assert_allclose(solid.get("gauge_strain"), [[0.0, 1e-3 + 0.5e-6]] * 2, atol=1e-12)
    with pytest.raises(ge.GranularError, match=r"gauges\[0,0\]: got 0.5 m, expected 0 to 0.002 m"):
        ring(gauges=[[0.5, 0.0]])


def test_displacements_are_reported_where_nodes_are_not_as_their_parameters() -> None:
    """The parameters of a linear field are its values, but not the parameters of a pulse at one node."""
    solid = strip(0.0, boundaries={})
    linear = solid.nodes @ np.array([[1e-3, 2e-4, 0.0], [0.0, -1e-3, 1e-4], [3e-4, 0.0, 5e-4]])
    solid.reset(nodal_displacement=linear)
    np.testing.assert_allclose(solid.get("displacement"), linear, rtol=0.0, atol=1e-15)
    place = 10 * 12 + 4
    solid.reset(nodal_displacement={place: (0.0, 0.0, 1e-7)})
    assert 0.2 < solid.get("displacement")[place, 2] / 1e-7 < 0.8


def test_other_bases_and_rules_bend_as_well() -> None:
    for changes in ({"integration": {"surface": "cell"}}, {"basis": "quadratic"}):
        solid = strip(0.0, **changes)
        velocity = np.zeros_like(solid.nodes)
        velocity[:, 0] = 0.1 * np.sin(0.5 * math.pi * solid.nodes[:, 0] / 0.02)
        solid.reset(nodal_velocity=velocity)
        exact = clamped_bar_frequency(69e9, 2719.0, 0.02)
        tip = int(np.argmax(solid.nodes[:, 0]))
        moved = displacement_history(solid, tip, 0, round(1.1 / exact / solid.step_size))
        measured = 0.5 / ((np.argmin(moved) - np.argmax(moved)) * solid.step_size)
        assert measured / exact == pytest.approx(1.0, abs=0.02)


def test_a_load_beyond_measure_stops_the_run_where_it_is_and_keeps_the_last_good_state() -> None:
    solid = ring()
    solid.step(1e-6, pressure=1e6)
    before = solid.get("stress")
    with pytest.raises(
        ge.GranularError, match=r"stress: .* at point \d+ \(x = .* m, angle .* rad, radius .* m\) at .* s; load"
    ):
        solid.step(5e-6, pressure=1e12)
    np.testing.assert_array_equal(solid.get("stress"), before)
    assert solid.time == pytest.approx(1e-6)


def test_the_bits_are_those_of_the_kernels_as_plain_python() -> None:
    names = ("shell-bulging", "shell-cracking")
    code = (
        "import sys; sys.path.insert(0, 'tests')\nfrom support.golden_logs import final_hash, play_case\n"
        f"print(*[final_hash(play_case(name)) for name in {names}])"
    )
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    found = subprocess.run([sys.executable, "-c", code], cwd=ROOT, env=environment, capture_output=True, text=True, check=True)
    assert found.stdout.split() == [final_hash(play_case(name)) for name in names]
