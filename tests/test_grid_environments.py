"""BuriedTarget-v1: the theoretical drive is optimal, and the environment conforms to the common interface."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest

from granular_env.domains.grid.tasks.buried_target import fastest_drive, make_buried_target, target_response
from granular_env.envs.policies import OpenLoop, play

NAME = "granular_env/BuriedTarget-v1"


@pytest.mark.parametrize("hold", [1, 3])
def test_theory_returns_one_and_nothing_returns_nothing(hold: int) -> None:
    env = make_buried_target(hold=hold)
    returns = {name: play(env, policy)[0] for name, policy in env.task.baselines().items()}
    # The medium is linear up to strains of 1e-4.
    assert returns["theory"] == pytest.approx(1.0, abs=2e-3)
    assert returns["nothing"] == 0.0
    assert 0.01 < returns["one_push"] < 0.5
    if hold == 1:
        assert returns["theory"] > gymnasium.spec(NAME).reward_threshold


def test_no_other_drive_is_better() -> None:
    """Random drives are far worse, and reversing one entry of the best drive costs the gain of this entry."""
    env = make_buried_target(deadline=12, loads=4)
    task, random = env.task, np.random.default_rng(1)
    assert all(play(env, OpenLoop(random.choice([-1.0, 1.0], task.drive.shape)))[0] < 0.5 for _ in range(5))
    for row, entry in ((2, 3), (5, 0), (7, 6)):
        other = task.drive.copy()
        other[row, entry] *= -1.0
        left = 1.0 - 2.0 * abs(task.drive_gains[row, entry]) / task.best_speed
        # The velocity component across the best direction has a second-order effect.
        assert left * left - 2e-3 <= play(env, OpenLoop(other))[0] <= 1.0 + 2e-3


def test_the_response_is_that_of_any_drive() -> None:
    """Linear superposition: the target's velocity at the deadline is the sum over loads and steps."""
    env = make_buried_target(deadline=10, loads=3, force=10.0)
    drive = np.random.default_rng(2).uniform(-1.0, 1.0, (10, 6))
    env.reset()
    for row in drive:
        _, _, _, _, info = env.step(row.astype(np.float32))
    expected = np.einsum("ke,kex->x", drive.astype(np.float32), env.task.response)
    np.testing.assert_allclose(info["receiver_velocity"][-1], expected, rtol=1e-5)


def test_what_acts_too_late_has_no_effect() -> None:
    env = make_buried_target()
    response = target_response(env.component, 4, 24)
    # P waves need 19 us for 0.1 m, nine control steps; the mesh transmits a little before.
    assert np.abs(response[-6:]).max() < 1e-3 * np.abs(response).max()
    drive, gains = fastest_drive(response)
    assert set(np.unique(drive)) <= {-1.0, 0.0, 1.0} and (drive * gains >= 0.0).all()
