"""The chain against closed forms: stiffnesses, two-sphere collisions, validity figures, nominal orders of the integrators."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.chain_tools import MASS, RADIUS, unit_chain

import granular_env as ge
from granular_env.components.chain import theory

BRASS = ge.Material(density=8530.0, young=1.1e11, poisson=0.35)


def hertz(young_1: float, poisson_1: float, radius_1: float, young_2: float, poisson_2: float, radius_2: float) -> float:
    modulus = 1.0 / ((1.0 - poisson_1**2) / young_1 + (1.0 - poisson_2**2) / young_2)
    return 4.0 / 3.0 * modulus * math.sqrt(1.0 / (1.0 / radius_1 + 1.0 / radius_2))


def stiffness_of(**parameters: object) -> np.ndarray:
    """Return k of every contact of two grains and their walls, from the force at a known overlap."""
    chain = ge.make("chain", grains=2, precompression=1.0, **parameters)
    overlap = chain.get("overlap")
    return (chain.get("contact_force")[overlap > 0.0]) / overlap[overlap > 0.0] ** 1.5


def test_equal_spheres() -> None:
    k = hertz(2e11, 0.29, 3e-3, 2e11, 0.29, 3e-3)
    assert stiffness_of(radius=3e-3) == pytest.approx([k], rel=1e-12)
    # The paper's formula A = E sqrt(2R) / (3 (1 - nu^2) m) gives 6.391e12 for these values, not the printed 5.6e12.
    assert k / MASS == pytest.approx(2e11 * math.sqrt(2.0 * RADIUS) / (3.0 * (1.0 - 0.29**2)) / MASS, rel=1e-12)
    assert k / MASS == pytest.approx(6.391e12, rel=1e-3)


@pytest.mark.parametrize(
    ("wall", "ratio"), [("fixed_grain", 1.0), ("plane", math.sqrt(2.0)), ("rigid_plane", 2.0 * math.sqrt(2.0))]
)
@pytest.mark.parametrize("side", ["left", "right"])
def test_walls_against_the_grains(wall: str, ratio: float, side: str) -> None:
    k = stiffness_of(radius=3e-3, **{side: wall})
    at_wall, between = (k[0], k[1]) if side == "left" else (k[1], k[0])
    assert at_wall / between == pytest.approx(ratio, rel=1e-12)


def test_walls_of_another_material() -> None:
    k = stiffness_of(radius=3e-3, left="plane", left_wall_material=BRASS, right="fixed_grain", right_wall_material="ptfe")
    assert k[0] == pytest.approx(hertz(2e11, 0.29, 3e-3, 1.1e11, 0.35, math.inf), rel=1e-12)
    assert k[2] == pytest.approx(hertz(2e11, 0.29, 3e-3, 1.46e9, 0.46, 3e-3), rel=1e-12)


@pytest.mark.parametrize("masses", [(1.0, 1.0), (1.0, 5.0)])
def test_collision_of_two_spheres(masses: tuple[float, float]) -> None:
    """T1 = 2.94328 (5 m*/4k)^(2/5) v^(-1/5), the largest overlap (5 m* v^2/4k)^(2/5), and velocities of elastic balls."""
    chain = unit_chain(2, mass=list(masses), step_size=0.002)
    chain.reset(velocity={0: 1.0})
    reduced = masses[0] * masses[1] / sum(masses)
    overlap = []
    for _ in range(1000):
        chain.step(0.01)
        overlap.append(chain.get("overlap")[1])
    velocity = chain.get("velocity")
    assert velocity == pytest.approx([(masses[0] - masses[1]) / sum(masses), 2.0 * masses[0] / sum(masses)], abs=1e-9)
    # The grains separate at their speed of approach, so the gap gives the time since separation.
    duration = chain.time - (-overlap[-1]) / (velocity[1] - velocity[0])
    assert duration == pytest.approx(theory.collision_duration(reduced, 1.0, 1.0), rel=2e-6)
    assert duration / (1.25 * reduced) ** 0.4 == pytest.approx(2.94328, abs=5e-6)
    assert duration / (1.25 * reduced) ** 0.4 == pytest.approx(
        2.0 * math.sqrt(math.pi) * math.gamma(1.4) / math.gamma(0.9), rel=1e-8
    )
    assert max(overlap) == pytest.approx(theory.collision_overlap(reduced, 1.0, 1.0), rel=1e-4)


def test_collision_with_a_wall_turns_the_velocity_round() -> None:
    chain = ge.make("chain", grains=1, right="rigid_plane", step_size=1e-9)
    chain.reset(velocity={0: 1.0})
    chain.step(1e-4)
    assert chain.get("velocity")[0] == pytest.approx(-1.0, rel=1e-10)
    assert chain.get("impulse") == pytest.approx(-2.0 * chain.geometry.mass[0], rel=1e-10)


def test_validity_figures_against_hand_formulas() -> None:
    speed, step = 5.0, 2e-8
    chain = ge.make("chain", grains=2, radius=3e-3, material="steel", step_size=step)
    assert all(math.isnan(value) for value in chain.report().values()) and not chain.cautions()
    chain.reset(velocity={0: speed})
    chain.step(5e-5)
    k, reduced = hertz(2e11, 0.29, RADIUS, 2e11, 0.29, RADIUS), 0.5 * MASS
    overlap = (1.25 * reduced * speed**2 / k) ** 0.4
    contact_radius = math.sqrt(0.5 * RADIUS * overlap)
    pressure = 1.5 * k * overlap**1.5 / (math.pi * contact_radius**2)
    duration = 2.94328 * (1.25 * reduced / k) ** 0.4 * speed**-0.2
    sound = math.sqrt(2e11 * 0.71 / (7800.0 * 1.29 * 0.42))
    expected = [
        pressure,
        pressure / (1.6 * 2e9),
        contact_radius / RADIUS,
        duration / (2.5 * RADIUS / sound),
        4.0 * duration / step,
    ]
    assert list(chain.report().values()) == pytest.approx(expected, rel=1e-3)
    assert any("yield" in sentence for sentence in chain.cautions()) == (pressure > 3.2e9)
    assert expected[1] > 1.0


@pytest.mark.parametrize(("velocity_scale", "gap"), [(10.0, 0.0), (0.1, 0.0), (10.0, 1e-6), (3.7, 0.0)])
@pytest.mark.parametrize("radius", [1e-3, 3e-3, 0.02])
def test_suggested_step(velocity_scale: float, gap: float, radius: float) -> None:
    """The suggested step is the largest 1, 2 or 5 x 10^k s below 0.1 tau (0.03 with gaps)."""
    chain = ge.make("chain", grains=5, radius=radius, velocity_scale=velocity_scale, gap=gap)
    k, mass = hertz(2e11, 0.29, radius, 2e11, 0.29, radius), 7800.0 * 4.0 / 3.0 * math.pi * radius**3
    wanted = (0.03 if gap else 0.1) * (mass / k) ** 0.4 * velocity_scale**-0.2
    digits = f"{chain.step_size:.12e}"
    assert float(digits.split("e")[0]) in (1.0, 2.0, 5.0) and float(digits) == chain.step_size
    assert wanted / 2.5 * (1.0 - 1e-9) <= chain.step_size <= wanted


# -- nominal orders, while contacts stay closed ------------------------------------------------------------------------

FORCE = ge.Profile(np.array([0.0, 4.0]), np.array([[0.1, 0.05, -0.02, 0.003, 0.0], [0.092, 0.05, 0.0, -0.01, 0.001]]))
MOTION = ge.Profile(np.array([0.0]), np.array([[0.0, 0.0, 0.05, -0.01, 0.0005]]))
CLOSED = {
    "free": ({}, {}),
    "force": ({}, {"left_force": FORCE}),
    "force on the right": ({"left": "plane"}, {"right_force": FORCE}),
    "piston": ({"left": "piston"}, {"left_velocity": MOTION}),
    "piston on the right": ({"left": "fixed_grain", "right": "piston"}, {"right_velocity": MOTION}),
}


def closed_run(scheme: str, step_size: float, case: str) -> np.ndarray:
    """Return state, work and impulse after 8 tau of small waves in a precompressed chain with all contacts closed."""
    parameters, inputs = CLOSED[case]
    chain = unit_chain(16, precompression=1.0, overlap_limit=1.0, integrator=scheme, step_size=step_size, **parameters)
    velocity = 0.05 * np.sin(np.arange(16.0))
    if "piston" in parameters.values():
        velocity[[0, -1]] = 0.0
    chain.reset(velocity=velocity)
    lowest = 1.0
    for _ in range(8):
        chain.step(1.0, **inputs)
        inputs = {}
        lowest = min(lowest, chain.get("overlap")[1:-1].min())
    assert lowest > 0.2
    return np.concatenate((chain.get("velocity"), chain.get("displacement"), [chain.get("input_work"), chain.get("impulse")]))


@pytest.mark.parametrize("case", CLOSED)
@pytest.mark.parametrize(
    ("scheme", "order", "steps"),
    [("pefrl", 4, (0.1, 0.05, 0.025)), ("leapfrog", 2, (0.02, 0.01, 0.005)), ("rk4", 4, (0.05, 0.025, 0.0125)),
     ("hamming", 5, (0.025, 0.0125, 0.00625))],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
def test_nominal_order(scheme: str, order: int, steps: tuple[float, ...], case: str) -> None:
    """Hamming's corrector has order 4; its mop-up removes the leading error, which gives order 5 for smooth motion."""
    reference = closed_run("pefrl", 0.0025, case)
    errors = [np.abs(closed_run(scheme, step, case) - reference).max() for step in steps]
    slopes = [math.log(errors[i] / errors[i + 1]) / math.log(steps[i] / steps[i + 1]) for i in range(2)]
    assert slopes[1] == pytest.approx(order, abs=0.2 if scheme == "hamming" else 0.1)
