"""Walton and Braun's law against closed forms: restitution, residual overlap, reloading, dissipation."""

from __future__ import annotations

import math

import numpy as np
import pytest

import granular_env as ge

MASS, LOADING = 2e-3, 1e7


def pair(speed: float, ratio: float, **parameters: object) -> ge.Chain:
    """Return two equal grains before a collision, k1/k2 = ratio, with a step of 1/4000 of the elastic collision time."""
    law = {"name": "walton_braun", "unloading_stiffness": LOADING / ratio}
    step_size = math.pi * math.sqrt(0.5 * MASS / LOADING) / 4000.0
    chain = ge.Chain(
        **({"grains": 2, "mass": MASS, "contact_stiffness": LOADING, "law": law, "step_size": step_size} | parameters)
    )
    chain.reset(velocity={0: speed})
    return chain


@pytest.mark.parametrize("speed", [0.01, 1.0, 10.0])
@pytest.mark.parametrize("ratio", [1.0, 0.64, 0.25, 0.04])
def test_restitution_is_the_root_of_the_ratio_at_any_speed(ratio: float, speed: float) -> None:
    chain = pair(speed, ratio)
    chain.step(6000 * chain.step_size)
    assert chain.get("contact_force")[1] == 0.0
    left, right = chain.get("velocity")
    assert (right - left) / speed == pytest.approx(math.sqrt(ratio), rel=2e-6)
    assert chain.get("dissipated_energy") == pytest.approx(0.25 * MASS * speed**2 * (1.0 - ratio), rel=1e-5, abs=1e-12)


def test_the_contact_opens_at_the_residual_overlap_and_reloads_along_the_unloading_line() -> None:
    """A second loading is elastic along k2 (d - d_r) up to the deepest overlap."""
    ratio, wall = 0.25, {"grains": 1, "right": "rigid_plane"}
    chain = pair(1.0, ratio, **wall)
    deepest, opened = 0.0, None
    for _ in range(8000):
        chain.step()
        overlap, force = chain.get("overlap")[1], chain.get("contact_force")[1]
        deepest = max(deepest, overlap)
        if force == 0.0 and chain.get("velocity")[0] < 0.0:
            opened = overlap
            break
    assert opened == pytest.approx(deepest * (1.0 - ratio), rel=3e-3)
    lost = chain.get("dissipated_energy")
    state = chain.save()
    for _ in range(6000):  # push back to less than the deepest overlap
        chain.step(left_force=20.0)
        overlap, force = chain.get("overlap")[1], chain.get("contact_force")[1]
        line = LOADING / ratio * (overlap - deepest * (1.0 - ratio))
        assert force == pytest.approx(max(0.0, line), abs=1e-3 * LOADING * deepest)
    assert chain.get("dissipated_energy") == lost
    chain.restore(state)
    assert chain.get("dissipated_energy") == lost


def test_equal_stiffnesses_are_a_spring_without_loss() -> None:
    """Identical, up to rounding, to the power law with exponent 1."""
    chain = pair(1.0, 1.0)
    spring = ge.Chain(
        grains=2, mass=MASS, contact_stiffness=LOADING, step_size=chain.step_size, law={"name": "power", "exponent": 1.0}
    )
    spring.reset(velocity={0: 1.0})
    for run in (chain, spring):
        run.step(2500 * chain.step_size)
    assert chain.get("velocity") == pytest.approx(spring.get("velocity"), rel=1e-12)
    assert chain.get("dissipated_energy") == 0.0


def test_each_contact_has_its_own_stiffnesses_and_a_pressed_chain_starts_on_the_loading_line() -> None:
    loading, unloading = [1e7, 2e7, 4e7], [2e7, 2e7, 8e7]
    law = {"name": "walton_braun", "unloading_stiffness": unloading}
    chain = ge.Chain(grains=2, contact_stiffness=loading, law=law, left="plane", right="plane", precompression=50.0)
    np.testing.assert_allclose(chain.get("overlap"), 50.0 / np.array(loading), rtol=1e-12)
    np.testing.assert_allclose(chain.get("contact_force"), 50.0, rtol=1e-12)
    assert chain.get("dissipated_energy") == 0.0
