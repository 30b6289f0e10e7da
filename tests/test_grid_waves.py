"""Waves in the grid against theory: dispersion, pulses, interfaces, absorbing edges."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.grid_tools import MEDIUM, P_SPEED, S_SPEED, SMALL, axis_values, bar, block, pulse, start_pulse

import granular_env as ge
from granular_env.components.coupled.theory import reflection, transmission
from granular_env.components.grid import Grid
from granular_env.components.grid.theory import mesh_frequencies, reflected_energy
from granular_env.components.materials.elastic import Material


@pytest.mark.parametrize("shear", [False, True])
@pytest.mark.parametrize(("waves_x", "waves_y"), [(2, 0), (1, 2), (3, 3)])
def test_a_standing_wave_has_the_frequency_of_the_mesh(waves_x: int, waves_y: int, shear: bool) -> None:
    """The velocity of a mode of the periodic mesh is v0 cos(Omega t), with Omega from `mesh_frequencies`."""
    n, h = 12, 0.5
    sides = dict.fromkeys(("left", "right", "bottom", "top"), "periodic")
    grid = Grid(
        mesh={"name": "rectangle", "columns": n, "rows": n, "cell_size": h, "centre": [0.0, 0.0]}, material=MEDIUM,
        boundaries=sides, step_size=0.2,
    )  # fmt: skip
    wave = 2.0 * math.pi * np.array([waves_x, waves_y]) / (n * h)
    a, b = 0.5 * h * wave
    along = np.array([math.sin(a) * math.cos(b), math.cos(a) * math.sin(b)])
    direction = np.array([-along[1], along[0]]) if shear else along
    mode = np.cos(np.round(grid.mesh.nodes / h) @ (h * wave))[:, None] * direction
    mode[np.abs(mode) < 1e-9] = 0.0
    for group in grid._assembly.joined:
        mode[group[group >= 0]] = mode[group[0]]
    grid.reset(velocity=SMALL * mode)
    frequency = mesh_frequencies((wave[0], wave[1]), h, MEDIUM, step_size=0.2)[shear]
    for _ in range(50):
        grid.step(0.6)
        # Velocities of velocity Verlet at whole ticks are exactly v0 cos(Omega t).
        np.testing.assert_allclose(grid.get("velocity"), SMALL * mode * math.cos(frequency * grid.time), atol=1e-10 * SMALL)


@pytest.mark.parametrize("shear", [False, True])
def test_long_waves_run_at_the_speeds_of_the_medium(shear: bool) -> None:
    """The error of the speed is second-order in the cell size, measured with pulses of 40 and 80 cells."""
    speed = S_SPEED if shear else P_SPEED
    errors = []
    for length in (40.0, 80.0):
        grid = bar(int(4.5 * length))
        start_pulse(grid, length, 0.25 * length, shear=shear)
        grid.step(round(3.0 * length / speed / 0.5) * 0.5)
        x, v = axis_values(grid, grid.get("velocity")[:, int(shear)] / SMALL)
        shape = x - 0.25 * length - speed * grid.time
        expected, slope = pulse(shape, length), (pulse(shape + 1e-4, length) - pulse(shape - 1e-4, length)) / 2e-4
        # The best-fit shift, divided by the path.
        errors.append(abs((slope * (v - expected)).sum() / (slope * slope).sum()) / (speed * grid.time))
    assert errors[1] <= 6e-4
    assert 3.5 <= errors[0] / errors[1] <= 4.5


def test_a_pulse_comes_back_from_a_rigid_end() -> None:
    length = 80.0
    grid = bar(240, boundaries={"right": "fixed"})
    start_pulse(grid, length, 40.0)
    grid.step(round(2.0 * (240.0 - 40.0 - 0.5 * length) / P_SPEED / 0.5) * 0.5)
    x, v = axis_values(grid, grid.get("velocity")[:, 0] / SMALL)
    way = P_SPEED * grid.time
    expected = -pulse(2.0 * 240.0 - 40.0 - way - x, length)
    assert 0.9987 <= -v.min() <= 1.0007
    assert math.sqrt(((v - expected) ** 2).sum() / (expected**2).sum()) <= 0.014


@pytest.mark.parametrize(
    "second", [Material(density=4.0, young=2.5, poisson=0.25), Material(density=1.0, young=10.0, poisson=0.25)]
)
def test_an_interface_reflects_by_impedance(second: Material) -> None:
    """The second medium is half or twice as fast, with twice the impedance of the first medium."""
    length, face = 80.0, 160.0
    region = {"area": {"name": "box", "x": [face, 1e9], "y": [-1.0, 9.0]}, "material": 1}
    grid = bar(400, material=[MEDIUM, second], regions=[region], step_size=0.2)
    start_pulse(grid, length, 60.0)
    grid.step(round((face - 60.0 + 10.0) / P_SPEED / 0.2) * 0.2)
    x, v = axis_values(grid, grid.get("velocity")[:, 0] / SMALL)
    assert reflection(MEDIUM, second) == pytest.approx(-1.0 / 3.0)
    # Second-order: (2 pi / 80)^2 / 24 = 3e-4 in the speed, several times that in the amplitude.
    assert v[x < face].min() == pytest.approx(reflection(MEDIUM, second), abs=3e-3)
    assert v[x > face].max() == pytest.approx(transmission(MEDIUM, second), abs=3e-3)


# -- absorbing edges -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shear", [False, True])
def test_dashpots_absorb_waves_at_right_angles(shear: bool) -> None:
    """The reflection of a pulse decreases with the square of cell size over length; it is less than 1 % at 20 cells."""
    left = []
    for length in (20.0, 40.0):
        grid = bar(int(2.0 * length), boundaries={"right": "absorbing"})
        start_pulse(grid, length, 0.5 * length, shear=shear)
        energy = grid.get("kinetic_energy") + grid.get("elastic_energy")
        grid.step(round(1.7 * length / (S_SPEED if shear else P_SPEED) / 0.5) * 0.5)
        left.append(float(np.abs(grid.get("velocity")).max()) / SMALL)
        assert grid.get("absorbed_energy") == pytest.approx(energy, rel=1e-4)
    assert left[0] <= 0.01 and left[1] <= left[0] / 3.0


IN_SITU = np.array([-1e-4, -1.6e-4, -0.65e-4, 0.2e-4])


def test_absorbing_edges_keep_the_stress_of_the_start() -> None:
    """The initial stress remains, within 1 % ten transits after a force pulse with twice that stress in adjacent cells."""
    edges = dict.fromkeys(("left", "right", "bottom", "top"), "absorbing")
    grid = block(24, 24, boundaries=edges, forced_nodes=[[0.0, 0.0]])
    grid.reset(stress=np.tile(IN_SITU, (576, 1)))
    kept = grid.save()
    grid.step(140.0)
    # Only rounding changes the stress.
    assert np.abs(grid.get("stress") - IN_SITU).max() <= 1e-12 * 1.6e-4 and np.abs(grid.get("velocity")).max() <= 1e-18
    grid.restore(kept)
    grid.step(140.0, force=ge.Profile.half_sine(1.0, 10.0) * [[3e-4, 1.5e-4]])
    assert np.abs(grid.get("stress") - IN_SITU).max() <= 0.01 * 1.6e-4
    assert grid.get("absorbed_energy") > 1e-8
    # Nonlinear effects of strains of 1e-4.
    assert abs(grid.get("energy_residual")) <= 1e-4 * grid.get("absorbed_energy")
    # After a reset without initial stress, an older snapshot must restore its initial stress.
    final = grid.save()
    grid.reset()
    grid.step(1.0)
    grid.restore(kept)
    grid.step(140.0, force=ge.Profile.half_sine(1.0, 10.0) * [[3e-4, 1.5e-4]])
    assert grid.save().to_bytes() == final.to_bytes()


def test_absorbing_edges_keep_the_traction_of_a_turned_and_loaded_start() -> None:
    """A load on top that balances the initial stress leaves the body on dashpots at rest; an additional load makes it sink."""
    edges = {"bottom": "absorbing", "top": "traction", "left": "symmetry", "right": "symmetry"}
    grid = block(6, 10, boundaries=edges)
    grid.reset(displacement=grid.mesh.nodes * [0.0, -1e-4])
    pressure = -grid.get("stress")[0, 1]
    grid.step(100.0, top_traction=[0.0, -pressure])
    # Stress and traction refer to deformed and undeformed areas, which differ by a relative 1e-4.
    assert np.abs(grid.get("velocity")).max() <= 1e-15
    grid.step(200.0, top_traction=[0.0, -1.5 * pressure])
    # Mean over the body, because the sudden load leaves oscillations between cells.
    assert grid.get("velocity")[:, 1].mean() == pytest.approx(-0.5 * pressure / P_SPEED, rel=5e-3)


@pytest.mark.parametrize("rows", [1, 2, 4, 8])
@pytest.mark.parametrize("hourglass", [0.5, 1.0])
def test_a_beam_bends_with_the_stiffness_of_its_cells(rows: int, hourglass: float) -> None:
    """The stiffness E' (1 + (hourglass (lambda + 3 mu) / E' - 1) / N^2) N^3 / 12, E' = E / (1 - nu^2), from both energies."""
    beam = block(10, rows, hourglass=hourglass)
    x, y = beam.mesh.nodes.T
    # Pure bending in plane strain, with free upper and lower sides.
    beam.reset(displacement=SMALL * np.stack([x * y, -0.5 * (x * x + y * y / 3.0)], axis=1))
    modulus = 2.5 / (1.0 - 0.25**2)
    exact = 0.5 * modulus * SMALL**2 * 10.0 * rows**3 / 12.0
    found = beam.get("elastic_energy") + beam.get("hourglass_energy")
    assert found == pytest.approx(exact * (1.0 + (hourglass * 4.0 / modulus - 1.0) / rows**2), rel=1e-9)


def sent_back(angle: float, edge: dict, shear: bool) -> float:
    """Return the root of the energy fraction that an edge reflects of a packet of plane waves of wavelength 24 cells.

    The packet is one Fourier mode along the edge of a periodic strip. The left edge absorbs the initial wave to the left.
    """
    rows = max(2, round(24.0 / math.sin(angle))) if angle > 0.0 else 2
    wave = np.array([2.0 * math.pi / 24.0 * math.cos(angle), 2.0 * math.pi / rows if angle > 0.0 else 0.0])
    number, speed, columns = math.hypot(*wave), S_SPEED if shear else P_SPEED, 320
    grid = Grid(
        mesh={"name": "rectangle", "columns": columns, "rows": rows, "cell_size": 1.0}, material=MEDIUM, step_size=0.5,
        boundaries={"bottom": "periodic", "top": "periodic", "right": edge, "left": SPONGE},
    )  # fmt: skip
    x, y = grid.mesh.nodes.T
    along = wave / number
    direction = np.array([-along[1], along[0]]) if shear else along
    phase, envelope = wave[0] * x + wave[1] * np.where(y == rows, 0.0, y), pulse(x - 60.0, 160.0)
    velocity = SMALL * (envelope * np.cos(phase))[:, None] * direction
    displacement = -SMALL * (envelope * np.sin(phase))[:, None] * direction / (number * speed)
    for group in grid._assembly.joined:
        velocity[group[1]], displacement[group[1]] = velocity[group[0]], displacement[group[0]]
    grid.reset(velocity=velocity, displacement=displacement)
    before = grid.get("kinetic_energy") + grid.get("elastic_energy")
    # Run until the reflected packet is at its initial position.
    grid.step(round(2.0 * (columns - 140.0) / (speed * wave[0] / number) / 0.5) * 0.5)
    return math.sqrt((grid.get("kinetic_energy") + grid.get("elastic_energy")) / before)


LYSMER = {"name": "absorbing"}
SPONGE = {"name": "absorbing", "sponge_width": 48.0, "sponge_strength": 12.0}


@pytest.mark.parametrize("shear", [False, True])
@pytest.mark.parametrize("degrees", [0.0, 30.0, 45.0])
def test_dashpots_send_back_what_theory_says(degrees: float, shear: bool) -> None:
    angle = math.radians(degrees)
    # The tolerance covers the range of angles in the packet, several degrees.
    assert sent_back(angle, LYSMER, shear) == pytest.approx(math.sqrt(reflected_energy(MEDIUM, angle, shear=shear)), abs=0.03)


@pytest.mark.parametrize("shear", [False, True])
def test_a_sponge_of_two_wavelengths_sends_back_little(shear: bool) -> None:
    assert all(sent_back(math.radians(degrees), SPONGE, shear) <= 0.05 for degrees in (0.0, 45.0))


@pytest.mark.parametrize(("shear", "expected"), [(False, 0.24), (True, 0.27)])
def test_a_sponge_sends_back_a_quarter_of_a_push_of_one_sign(shear: bool, expected: float) -> None:
    """Most wavelengths of the pulse exceed the layer; dashpots alone reflect less than 1 %."""
    length, speed = 20.0, S_SPEED if shear else P_SPEED
    sponge = {"name": "absorbing", "sponge_width": 2.0 * length, "sponge_strength": 12.0}
    grid = bar(int(4.0 * length), boundaries={"right": sponge})
    start_pulse(grid, length, 0.5 * length, shear=shear)
    before = grid.get("kinetic_energy") + grid.get("elastic_energy")
    grid.step(round(5.7 * length / speed / 0.5) * 0.5)
    assert math.sqrt((grid.get("kinetic_energy") + grid.get("elastic_energy")) / before) == pytest.approx(expected, abs=0.01)
