"""Linked automata against exact solutions: homogeneous strains, rigid motions, waves, and the largest stable step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from support.automata_tools import forces_and_torques, link_force_sums

import granular_env as ge
from granular_env.components.automata import Automata, theory
from granular_env.components.errors import ParameterError, StepError

ROW = 0.5 * math.sqrt(3.0)
BOTH = pytest.mark.parametrize("packing", ["square", "hexagonal"])


def solid(ratio: float = 1.0) -> ge.Material:
    """Return a material with rho = G = 1 and a given lambda / G."""
    poisson = ratio / (2.0 * (1.0 + ratio))
    return ge.Material(density=1.0, young=2.0 * (1.0 + poisson), poisson=poisson)


def block(packing: str, columns: int = 8, rows: int = 8, **parameters: object) -> Automata:
    """Return a rectangle of automata of diameter 1."""
    height = rows * (ROW if packing == "hexagonal" else 1.0)
    shape = {"name": "rectangle", "width": float(columns), "height": height}
    return Automata(**{"shape": shape, "diameter": 1.0, "packing": packing, "material": solid(), **parameters})


def residual(automata: Automata, gradient: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return forces and torques on all automata under a homogeneous displacement gradient with its rotation."""
    turn = 0.5 * (gradient[1, 0] - gradient[0, 1])
    automata.reset(displacement=automata.packing.reference @ gradient.T, rotation=turn)
    return automata.specimen.forces(), automata.specimen.torques()


# -- homogeneous strains ------------------------------------------------------------------------------------------------

# So small that squares of strains are below the bound.
GRADIENT = 1e-13 * np.array([[1.0, 3.0], [-2.0, 0.5]])


def hooke(gradient: np.ndarray, lame: float = 1.0, shear: float = 1.0) -> np.ndarray:
    strain = 0.5 * (gradient + gradient.T)
    return 2.0 * shear * strain + lame * np.trace(strain) * np.eye(2)


@BOTH
def test_a_homogeneous_strain_and_spin_costs_no_force_inside(packing: str) -> None:
    automata = block(packing)
    force, torque = residual(automata, GRADIENT)
    x, y = automata.packing.reference.T
    low, high = (0.9, 7.1) if packing == "square" else (1.9, 6.1)  # a free zigzag affects second neighbours
    inside = (x > low) & (x < high) & (y > 0.9 + (packing == "hexagonal")) & (y < y.max() - 0.9 - (packing == "hexagonal"))
    scale = np.abs(hooke(GRADIENT)).max()
    assert inside.sum() >= 9
    assert np.abs(force[inside]).max() <= 1e-12 * scale and np.abs(torque[inside]).max() <= 1e-12 * scale


@BOTH
@pytest.mark.parametrize("ratio", [0.0, 1.0, 4.0])
def test_both_moduli_are_exact(packing: str, ratio: float) -> None:
    automata = block(packing, material=solid(ratio))
    residual(automata, GRADIENT)
    expected = hooke(GRADIENT, automata.lame_modulus, automata.shear_modulus)
    middle = int(np.argmin(np.abs(automata.packing.reference - automata.packing.reference.mean(axis=0)).sum(axis=1)))
    got = automata.get("stress")[middle]
    np.testing.assert_allclose(got, [expected[0, 0], expected[1, 1], expected[0, 1]], atol=1e-12 * np.abs(expected).max())
    assert automata.get("dilation")[middle] == pytest.approx(np.trace(GRADIENT), rel=1e-12)


@BOTH
def test_link_forces_accelerate_a_stretched_and_turned_body(packing: str) -> None:
    """Without shear of the pairs, the forces along the lines of centres are all forces; tension is negative."""
    automata, turn = block(packing), 0.3
    turned = 1.001 * np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    automata.reset(displacement=automata.packing.reference @ (turned - np.eye(2)).T, rotation=turn)
    forces, bound = link_force_sums(automata), 1e-12
    assert automata.get("link_force").max() < 0.0 and np.abs(forces).max() > 1e-3
    automata.step(automata.step_size)  # its kick uses these positions, because nothing moves before
    np.testing.assert_allclose(automata.get("velocity") * automata.mass[:, None] / automata.step_size, forces, atol=bound)


def test_the_condensed_zigzag_of_a_hexagonal_packing_is_free_of_traction() -> None:
    automata = block("hexagonal")
    stretch = 1e-13
    force, torque = residual(automata, np.diag([-stretch / 3.0, stretch]))  # plane strain, lambda = G: zero stress along x
    y = automata.packing.reference[:, 1]
    ends = (y < 0.1) | (y > y.max() - 0.1)
    assert np.abs(force[~ends]).max() <= 1e-12 * stretch and np.abs(torque[~ends]).max() <= 1e-12 * stretch
    np.testing.assert_allclose(automata.get("dilation"), 2.0 / 3.0 * stretch, rtol=1e-12)
    np.testing.assert_allclose(np.abs(force[ends].sum()), 0.0, atol=1e-12 * stretch)


@pytest.mark.parametrize("laws", [{}, {"criterion": {"name": "strain", "tensile": 1.0}}], ids=["linked", "breakable"])
@pytest.mark.parametrize("ends", ["velocity", {"name": "velocity", "components": "x"}], ids=["glued", "smooth"])
def test_a_homogeneous_strain_between_walls_is_exact(laws: dict, ends: Any) -> None:
    edges = {"left": ends, "right": ends, "bottom": "periodic", "top": "periodic"}
    automata = block("square", boundaries=edges, **laws)
    stretch = 1e-13
    force, torque = residual(automata, np.diag([stretch, 0.0]))
    inside = np.setdiff1d(np.arange(automata.count), automata.conditions.grip.automata)
    assert len(inside) >= 56
    assert np.abs(force[inside]).max() <= 1e-12 * stretch and np.abs(torque).max() <= 1e-12 * stretch
    pull = 3.0 * stretch * 8  # lambda + 2 G = 3
    np.testing.assert_allclose(automata.get("right_reaction"), [pull, 0.0], rtol=1e-12, atol=1e-12 * pull)
    np.testing.assert_allclose(automata.get("left_reaction"), [-pull, 0.0], rtol=1e-12, atol=1e-12 * pull)


def test_a_held_zigzag_is_held_with_both_of_its_rows() -> None:
    automata = block("hexagonal", boundaries={"left": "fixed"})
    np.testing.assert_array_equal(automata.conditions.grip.automata, np.flatnonzero(automata.packing.reference[:, 0] <= 0.5))


@pytest.mark.parametrize("laws", [{}, {"criterion": {"name": "strain", "tensile": 1.0}}], ids=["linked", "breakable"])
@pytest.mark.parametrize("ends", ["smooth", "traction"])
@pytest.mark.parametrize("ratio", [0.0, 1.0, 4.0], ids="lambda / G = {}".format)
@BOTH
def test_a_bar_in_uniaxial_stress_is_at_rest_to_its_corners(packing: str, ratio: float, ends: str, laws: dict) -> None:
    """Corners of a hexagonal packing are quarter cells; pressure on them must not rotate them."""
    edge = {"name": "velocity", "components": "y"} if ends == "smooth" else "traction"
    automata = block(packing, 6, 8, material=solid(ratio), boundaries={"bottom": edge, "top": edge}, **laws)
    stretch, poisson = -1e-13, ratio / (2.0 * (1.0 + ratio))  # squares of strains are below the bound
    strain = np.diag([-poisson / (1.0 - poisson) * stretch, stretch])
    automata.reset(displacement=automata.packing.reference @ strain)
    stress = hooke(strain, lame=ratio)[1, 1]
    loads = {"bottom_traction": [0.0, -stress], "top_traction": [0.0, stress]} if ends == "traction" else {}
    automata.step(200 * automata.step_size, **loads)
    # Free corners would rotate at a speed of about the strain times the wave speed, which is 1.
    assert automata.get("speed").max() <= 1e-10 * abs(stretch)
    assert np.abs(automata.get("angular_velocity")).max() <= 1e-10 * abs(stretch)


# -- rigid motions --------------------------------------------------------------------------------------------------------


@BOTH
@pytest.mark.parametrize("angle", [0.5 * math.pi, 1.0, -2.5, 7.0])
def test_a_rotation_costs_no_energy(packing: str, angle: float) -> None:
    automata = block(packing)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    automata.reset(displacement=automata.packing.reference @ (turn - np.eye(2)).T, rotation=angle)
    # G V = 64 J is the energy of a shear of 1.
    assert automata.get("elastic_energy") <= 1e-10 * 1e-10 * 64.0


@BOTH
def test_a_spin_by_90_degrees_keeps_its_energy_and_its_angular_momentum(packing: str) -> None:
    automata = block(packing, 2, 2)
    rate = 1e-5  # 90 degrees in 1.6e5 s; the energy of the centrifugal strain is (rate L / c)^2 / 10 = 1e-11 of the total
    arm = automata.packing.reference - automata.packing.reference.mean(axis=0)
    automata.reset(velocity=rate * np.stack([-arm[:, 1], arm[:, 0]], axis=1), angular_velocity=rate)
    before = automata.get("angular_momentum"), automata.get("kinetic_energy") + automata.get("rotational_energy")
    automata.step(round(0.5 * math.pi / rate / automata.step_size) * automata.step_size)
    assert automata.get("rotation")[0] == pytest.approx(0.5 * math.pi, rel=1e-5)
    assert automata.get("elastic_energy") <= 1e-10 * before[1]
    assert abs(automata.get("angular_momentum_residual")) <= 1e-12 * before[0]
    assert automata.get("angular_momentum") == pytest.approx(before[0], rel=1e-12)


# -- waves ------------------------------------------------------------------------------------------------------------------


def strip(packing: str, columns: int, ends: dict[str, str] | None = None, **parameters: object) -> Automata:
    """Return a strip along x, periodic along y."""
    return block(packing, columns, 2, boundaries={"bottom": "periodic", "top": "periodic", **(ends or {})}, **parameters)


@BOTH
def test_a_plane_wave_keeps_the_discrete_energy_and_the_momentum(packing: str) -> None:
    automata = strip(packing, 64, {"left": "periodic", "right": "periodic"})
    x = automata.packing.reference[:, 0]
    wave = 1e-9 * np.sin(2.0 * math.pi * x / 32.0)
    automata.reset(velocity=np.stack([1e-9 + wave, 0.0 * wave], axis=1), displacement=np.stack([wave, 0.0 * wave], axis=1))
    mass, h = automata.mass, automata.step_size

    def force_at(displacement: np.ndarray) -> np.ndarray:
        return forces_and_torques(automata, displacement, np.zeros(automata.count))[0]

    # At mid-step of leapfrog, v is the velocity at the tick; u is known half a step before and after it.
    found, momenta = [], []
    for _ in range(300):
        u, v = automata.get("displacement"), automata.get("velocity")
        before, after = u - 0.5 * h * v, u + 0.5 * h * v
        found.append(0.5 * float((mass * (v**2).sum(axis=1)).sum()) - 0.5 * float((after * force_at(before)).sum()))
        momenta.append(automata.get("momentum"))
        automata.step()
    assert np.ptp(found) <= 1e-12 * max(found)
    # The scale is the momentum of the moving mass.
    assert np.abs(np.array(momenta) - momenta[0]).max() <= 1e-12 * 2e-9 * mass.sum()


@BOTH
@pytest.mark.parametrize(
    "parameters",
    [{}, {"boundaries": {"left": "fixed", "top": "velocity"}}, {"criterion": {"name": "strain", "tensile": 1.0}}],
    ids=["free", "held", "breakable"],
)
def test_noise_keeps_the_discrete_energy(packing: str, parameters: dict[str, Any]) -> None:
    """A thousand steps with strains of about 1e-12, so that nonlinear terms are below the bound."""
    automata = block(packing, **parameters)
    random = np.random.default_rng(1)
    automata.reset(
        velocity=1e-12 * random.standard_normal((automata.count, 2)),
        angular_velocity=1e-12 * random.standard_normal(automata.count),
    )
    begin = automata.balances()[0]
    # For noise, the leapfrog energy is a large fraction.
    assert -begin.stored["leapfrog_energy"] > 0.05 * begin.initial
    for _ in range(50):
        automata.step(20 * automata.step_size)
        assert abs(automata.get("energy_residual")) <= 1e-12 * begin.initial


@BOTH
@pytest.mark.parametrize("number", [(1, 0), (0, 2), (3, 1), (8, 3)])
def test_waves_in_a_closed_packing_have_the_frequencies_of_the_lattice(packing: str, number: tuple[int, int]) -> None:
    edges = dict.fromkeys(("left", "right", "bottom", "top"), "periodic")
    automata = block(packing, 16, 16, step_size=0.05, boundaries=edges)
    extent = np.array([16.0, 16.0 * (ROW if packing == "hexagonal" else 1.0)])
    k = 2.0 * math.pi * np.array(number) / extent
    exact = theory.lattice_frequencies(packing, k, density=1.0, shear=1.0, lame=1.0, diameter=1.0)
    # Any start with this wave vector is a sum of three modes: project the run on the wave, and fit the three frequencies.
    phase = automata.packing.reference @ k
    generator = np.random.default_rng(0)
    mix = 1e-10 * generator.standard_normal((3, 2))
    start = mix[:, :1] * np.cos(phase) + mix[:, 1:] * np.sin(phase)
    automata.reset(displacement=start[:2].T, rotation=start[2])
    values = []
    for _ in range(400):
        values.append(float(automata.get("displacement")[:, 0] @ np.cos(phase)))
        automata.step()
    # Over 20 s, three modes at the frequencies of leapfrog, sin(w h / 2) = W h / 2, reproduce the run.
    times = automata.step_size * np.arange(400)
    rates = 2.0 / automata.step_size * np.arcsin(0.5 * automata.step_size * exact)
    basis = np.concatenate([[np.cos(w * times), np.sin(w * times)] for w in rates]).T
    left = np.array(values) - basis @ np.linalg.lstsq(basis, np.array(values))[0]
    assert np.abs(left).max() <= 1e-7 * np.abs(values).max()


# -- stability --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("ratio", "limit"), [(0.0, 0.488), (1.0, 0.597), (4.0, 0.844)])
def test_the_largest_stable_step_of_a_specimen_with_surfaces(ratio: float, limit: float) -> None:
    automata = block("square", 12, 12, material=solid(ratio))
    speed = math.sqrt(2.0 * automata.shear_modulus + automata.lame_modulus)
    assert speed * 2.0 / automata.highest_frequency == pytest.approx(limit, abs=1e-3)


@BOTH
def test_a_step_above_the_limit_is_refused_and_one_far_above_would_blow_up(packing: str) -> None:
    largest = 0.9 * 2.0 / block(packing).highest_frequency
    with pytest.raises(ParameterError, match=r"step_size: got .* expected at most .* 0\.9 x 2 / omega_max"):
        block(packing, step_size=1.001 * largest)
    automata = block(packing, step_size=0.999 * largest)
    automata.reset(velocity={3: (1e-3, 0.0)}, angular_velocity={7: 1e-3})
    automata.step(2000 * automata.step_size)
    assert automata.get("kinetic_energy") < 1e-6


# -- symmetry ---------------------------------------------------------------------------------------------------------------


@BOTH
def test_mirrored_loads_give_mirrored_bits(packing: str) -> None:
    automata = block(packing, forced_automata="all")
    x, y = automata.packing.reference.T
    mirror = np.array([int(np.argmin((x - (8.0 - a)) ** 2 + (y - b) ** 2)) for a, b in zip(x, y, strict=True)])
    force = 1e-2 * np.random.default_rng(1).standard_normal((automata.count, 2))
    force = force + np.array([-1.0, 1.0]) * force[mirror]
    automata.step(200 * automata.step_size, force=force)
    u, w = automata.get("displacement"), automata.get("rotation")
    assert np.abs(u).max() > 1e-3
    np.testing.assert_array_equal(u[mirror], [-1.0, 1.0] * u)
    np.testing.assert_array_equal(w[mirror], -w)


# -- inputs and balances ------------------------------------------------------------------------------------------------------


@BOTH
def test_a_traction_stretches_a_specimen_as_hooke_says(packing: str) -> None:
    automata = block(packing, 8, 8, boundaries={"bottom": "symmetry", "top": "traction"})
    height = automata.packing.reference[:, 1].max()
    pull = ge.Profile.table([0.0, 400.0, 2000.0], [0.0, 1e-6, 1e-6]) * [0.0, 1.0]
    automata.step(800.0, top_traction=pull)
    top = automata.packing.reference[:, 1] > height - 0.1
    # Plane strain, E / (1 - nu^2) = 8/3, with oscillations of a few thousandths, because the load rose over 400 s. The
    # outermost automata of a hexagonal packing protrude from the row; they rotate, because the load acts off their centres.
    middle = np.flatnonzero(top)[2:-2]
    assert automata.get("displacement")[middle, 1].mean() / height == pytest.approx(1e-6 * 3.0 / 8.0, rel=0.01)
    assert automata.get("input_work") == pytest.approx(automata.get("elastic_energy"), rel=0.02)
    assert abs(automata.get("energy_residual")) <= 1e-3 * automata.get("input_work")


# -- refusals ---------------------------------------------------------------------------------------------------------------

# Polygons that touch themselves: along a slit, and at a common corner of two squares.


def test_a_specimen_that_is_torn_too_fast_is_refused_and_unharmed() -> None:
    automata = block("square", forced_automata=[0])
    with pytest.raises(StepError, match=r"velocity\[0\]: reached .* smaller step_size"):
        automata.step(10.0, force=1e6)
    assert automata.tick == 0 and not automata.get("velocity").any()


# -- threads --------------------------------------------------------------------------------------------------------------


# -- shapes -----------------------------------------------------------------------------------------------------------------


@BOTH
def test_a_disc_has_about_its_area_and_no_force_at_rest(packing: str) -> None:
    automata = block(packing, shape={"name": "disc", "radius": 20.0})
    # The error of the staircase is at most its outline times half a diameter, and much smaller because errors cancel.
    assert automata.get("mass") == pytest.approx(math.pi * 400.0, rel=0.03)
    automata.step(1.0)
    assert not automata.get("velocity").any()
