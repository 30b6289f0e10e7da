"""The linear spring and dashpot against closed forms: restitution with and without tension, k and c of each contact."""

from __future__ import annotations

import math

import numpy as np
import pytest

import granular_env as ge

MASS, STIFFNESS = 2e-3, 1e7
REDUCED_MASS = 0.5 * MASS


def colliding(speed: float, damping_ratio: float) -> ge.Chain:
    """Return two equal grains after a collision, with a step of 1/4000 of the collision time."""
    law = {"name": "linear", "dissipation": 2.0 * damping_ratio * math.sqrt(STIFFNESS * REDUCED_MASS)}
    step_size = math.pi * math.sqrt(REDUCED_MASS / STIFFNESS) / 4000.0
    chain = ge.Chain(grains=2, mass=MASS, contact_stiffness=STIFFNESS, law=law, step_size=step_size)
    chain.reset(velocity={0: speed})
    chain.step(12_000 * step_size)
    assert chain.get("contact_force")[1] == 0.0
    return chain


def restitution_without_tension(damping_ratio: float) -> float:
    """Return e of a contact that opens at zero force (Schwager and Poeschel 2007, eq. 10)."""
    beta, omega = damping_ratio, math.sqrt(1.0 - damping_ratio**2)
    return math.exp(-beta / omega * (math.pi - math.atan2(2.0 * beta * omega, omega**2 - beta**2)))


@pytest.mark.parametrize("speed", [0.01, 1.0, 10.0])
@pytest.mark.parametrize("damping_ratio", [0.0, 0.02, 0.3, 0.7])
def test_restitution_is_that_of_the_closed_form_at_any_speed(damping_ratio: float, speed: float) -> None:
    left, right = colliding(speed, damping_ratio).get("velocity")
    assert (right - left) / speed == pytest.approx(restitution_without_tension(damping_ratio), rel=2e-6)


@pytest.mark.parametrize("wall", ["fixed_grain", "plane", "rigid_plane"])
def test_a_grain_at_a_wall_is_a_mass_on_the_given_spring(wall: str) -> None:
    """The overlap returns to 0 after half a period, pi sqrt(m / k), to second order in the step (1/4000 of that)."""
    step_size = math.pi * math.sqrt(MASS / STIFFNESS) / 4000.0
    chain = ge.Chain(grains=1, mass=MASS, contact_stiffness=STIFFNESS, law="linear", right=wall, step_size=step_size)
    chain.reset(velocity={0: 1.0})
    chain.step(2000 * step_size)
    assert chain.get("displacement")[0] == pytest.approx(math.sqrt(MASS / STIFFNESS), rel=1e-6)
    chain.step(2000 * step_size)
    assert chain.get("velocity")[0] == pytest.approx(-1.0, rel=1e-6)
    assert abs(chain.get("displacement")[0]) < 1e-6 * math.sqrt(MASS / STIFFNESS)


def test_each_contact_has_its_own_stiffness_and_dashpot() -> None:
    """Two grains compressed between walls: springs in series, F = k d in each; dashpots act only in contacts that have one."""
    stiffness, damping = [1e7, 2e7, 4e7], [0.0, 30.0, 0.0]
    chain = ge.Chain(
        grains=2, mass=MASS, contact_stiffness=stiffness, law={"name": "linear", "dissipation": damping},
        left="plane", right="plane", precompression=50.0, step_size=1e-8,
    )  # fmt: skip
    np.testing.assert_allclose(chain.get("overlap"), 50.0 / np.array(stiffness), rtol=1e-12)
    chain.reset(velocity=[0.1, -0.1])
    np.testing.assert_allclose(chain.get("contact_force"), [50.0, 50.0 + 30.0 * 0.2, 50.0], rtol=1e-12)
    chain.reset(velocity=[0.1, 0.1])  # no contact with a dashpot is loaded
    chain.step(1e-8)
    assert chain.get("dissipated_energy") < 1e-9 * chain.get("kinetic_energy")
