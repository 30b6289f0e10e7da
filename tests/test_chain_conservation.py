"""Invariants of the chain: momentum, energy, the balances, the scaling (3.1), mirror images, moving frames, rest."""

from __future__ import annotations

import numpy as np
import pytest
from support.chain_tools import INTEGRATORS, PUSH, SPEED, advance_chain, momentum_magnitude, paper_chain, unit_chain

import granular_env as ge

pytestmark = pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")

# Two moving grains, N = 100, T = 60 tau: tabulated largest |dv| and |dE/E| relative to PEFRL with a step of 0.002.
PUBLISHED_ERRORS = {
    ("leapfrog", 0.0125): (3.1e-4, 6e-6),
    ("rk4", 0.1): (1.7e-4, 7e-5),
    ("hamming", 0.1): (2.6e-5, 5e-5),
    ("pefrl", 0.2): (2.7e-5, 3e-6),
    ("pefrl", 0.1): (9.1e-6, 2e-6),
}


@pytest.fixture(scope="module")
def reference() -> np.ndarray:
    chain = unit_chain(step_size=0.002)
    chain.reset(velocity={0: 1.0, 1: 1.0})
    chain.step(60.0)
    assert abs(chain.get("energy_residual")) <= 1e-9
    return chain.get("velocity")


@pytest.mark.parametrize(("scheme", "step_size"), PUBLISHED_ERRORS)
def test_error_and_energy_are_the_tabulated_ones(scheme: str, step_size: float, reference: np.ndarray) -> None:
    chain = unit_chain(integrator=scheme, step_size=step_size)
    chain.reset(velocity={0: 1.0, 1: 1.0})
    advance_chain(chain, 60.0)
    error, drift = PUBLISHED_ERRORS[scheme, step_size]
    # The tabulated values are rounded to one or two digits, i.e. to half a unit of the last digit.
    assert np.abs(chain.get("velocity") - reference).max() <= 1.06 * error
    assert abs(chain.get("energy_residual")) <= 1.5 * drift


CASES = {
    "3.1": ({}, {0: SPEED, 1: SPEED}, {}),
    "3.2 A, no momentum in all": ({}, {0: SPEED, 1: SPEED, 98: -SPEED, 99: -SPEED}, {}),
    "piston": ({"left": "piston"}, {0: SPEED}, {}),
    "walls": ({"left": "rigid_plane", "right": "plane"}, {3: SPEED, 50: -SPEED}, {}),
    "forces": ({"left": "free"}, {}, {"left_force": ge.Profile.triangle(500.0, 1e-4), "right_force": -20.0}),
    "pressed": ({"precompression": 50.0, "right": "fixed_grain"}, {5: 1.0}, {"left_force": PUSH}),
    "pressed between pistons": (
        {"precompression": 50.0, "left": "piston", "right": "piston"},
        {0: 1.0, 99: 1.0},
        {"right_velocity": -1.0},
    ),
}


@pytest.mark.parametrize("scheme", INTEGRATORS)
@pytest.mark.parametrize("case", CASES)
def test_momentum_to_rounding(case: str, scheme: str) -> None:
    parameters, velocity, inputs = CASES[case]
    chain = paper_chain(integrator=scheme, step_size=2e-7 if scheme != "leapfrog" else 5e-8, **parameters)
    chain.reset(velocity=velocity)
    largest, worst = momentum_magnitude(chain), 0.0
    for _ in range(30):
        chain.step(1e-5, **inputs)
        inputs = {}
        largest = max(largest, momentum_magnitude(chain))
        worst = max(worst, abs(chain.get("momentum_residual")))
    assert worst <= 1e-13 * largest
    if case == "3.1":
        assert abs(chain.get("momentum") - 2.0 * SPEED * chain.geometry.mass[0]) <= 1e-13 * largest
    if case.startswith("3.2"):
        assert abs(chain.get("momentum")) <= 1e-13 * largest


def test_the_static_force_does_work_on_a_free_end() -> None:
    """A precompressed chain with a moving end: without the work of F0 the balance would be off by F0 times the displacement."""
    chain = paper_chain(20, precompression=100.0)
    chain.reset(velocity={0: 1.0})
    chain.step(1e-4)
    u, balances = chain.get("displacement"), chain.balance_values()
    assert balances["input_work"] == pytest.approx(100.0 * (u[0] - u[-1]), rel=1e-9)
    assert abs(balances["input_work"]) > 1e3 * abs(balances["energy_residual"])


@pytest.mark.parametrize("scheme", INTEGRATORS)
def test_scaling(scheme: str) -> None:
    """Equation (3.1): dimensionless velocities at equal dimensionless times are equal for v0 = 0.05, 5 and 500 m/s."""
    seen = []
    for speed in (0.05, 5.0, 500.0):
        unit_of_time = (5.6e12**2 * speed) ** -0.2
        chain = paper_chain(
            integrator=scheme, step_size=unit_of_time * (0.02 if scheme == "leapfrog" else 0.1), overlap_limit=2.0
        )
        chain.reset(velocity={0: speed, 1: speed})
        advance_chain(chain, 60.0 * unit_of_time)
        seen.append(chain.get("velocity") / speed)
    assert np.abs(seen[0] - seen[1]).max() <= 4e-11
    assert np.abs(seen[2] - seen[1]).max() <= 4e-11


@pytest.mark.parametrize("scheme", INTEGRATORS)
def test_a_mirrored_chain_moves_as_the_mirror_image_bit_for_bit(scheme: str) -> None:
    random = np.random.default_rng(1)
    radius, velocity = random.uniform(1e-3, 3e-3, 30), random.uniform(-3.0, 3.0, 30)
    one = ge.make("chain", grains=30, radius=radius.tolist(), right="plane", integrator=scheme, step_size=5e-8)
    other = ge.make("chain", grains=30, radius=radius[::-1].tolist(), left="plane", integrator=scheme, step_size=5e-8)
    one.reset(velocity=velocity)
    other.reset(velocity=-velocity[::-1])
    push = ge.Profile.half_sine(50.0, 2e-5)
    one.step(1e-4, left_force=push)
    other.step(1e-4, right_force=ge.Profile(push.starts, -push.coefficients))
    for name in ("velocity", "displacement"):
        assert np.array_equal(one.get(name), -other.get(name)[::-1])
    assert np.array_equal(one.get("contact_force"), other.get("contact_force")[::-1])
    assert one.get("right_wall_force") == -other.get("left_wall_force")


@pytest.mark.parametrize("scheme", INTEGRATORS)
@pytest.mark.parametrize("ends", [("free", "free"), ("plane", "free"), ("rigid_plane", "fixed_grain"), ("piston", "free")])
def test_a_pressed_chain_stays_at_rest(ends: tuple[str, str], scheme: str) -> None:
    radius = np.random.default_rng(4).uniform(1e-3, 3e-3, 40).tolist()
    chain = ge.make("chain", grains=40, radius=radius, left=ends[0], right=ends[1], precompression=100.0, integrator=scheme)
    rest = chain.get("overlap")[chain.geometry.contact_slice].min()
    chain.step(2000 * chain.step_size)
    assert np.abs(chain.get("displacement")).max() <= 1e-10 * rest
    assert chain.get("contact_force")[chain.geometry.contact_slice] == pytest.approx(100.0, rel=1e-10)
