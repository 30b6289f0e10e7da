"""An environment's log is like a script's: complete, verified, one segment an episode."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import gymnasium
import numpy as np
import pytest

from granular_env.components.errors import GranularError, ParameterError
from granular_env.domains.chain.tasks.piston import make_piston
from granular_env.domains.chain.tasks.protection import make_protection
from granular_env.envs import RecordEnv
from granular_env.envs.registration import register_all
from granular_env.recording import open_log, verify

register_all()


def play(env: gymnasium.Env, episodes: int, seed: int = 0) -> list[float]:
    """Random episodes to their end; all rewards."""
    generator, rewards = np.random.default_rng(seed), []
    for episode in range(episodes):
        env.reset(seed=episode)
        over = False
        while not over:
            _, reward, terminated, truncated, _ = env.step(generator.uniform(-1.0, 1.0, 1).astype(np.float32))
            rewards.append(float(reward))
            over = terminated or truncated
    return rewards


@pytest.mark.parametrize("maker", [make_piston, make_protection])
def test_a_recorded_environment_verifies(maker: type, tmp_path: Path) -> None:
    path = tmp_path / "episodes.mcap"
    env = RecordEnv(maker(grains=6, deadline=25), path, every=1.5e-6)
    recorded = play(env, episodes=3)
    last = env.unwrapped.component.get("velocity")
    env.close()
    env.close()
    assert recorded == play(maker(grains=6, deadline=25), episodes=3)
    found = verify(path)
    assert found.identical and found.calls == 75, found.message
    with closing(open_log(path)) as log:
        assert log.complete
        # 25 control steps of 3 internal steps each.
        assert [segment.end for segment in log.segments] == [75, 75, 75]
        np.testing.assert_array_equal(log.series("velocity")[1][-1], last)


def test_every_action_is_in_the_log(tmp_path: Path) -> None:
    path = tmp_path / "actions.mcap"
    env = RecordEnv(make_piston(grains=6, deadline=15), path, every=1.5e-6, variables=["velocity"])
    env.reset(seed=1)
    sent = np.linspace(-1.0, 1.0, 10)
    for action in sent:
        env.step([action])
    env.close()
    with closing(open_log(path)) as log:
        times, values = log.inputs["left_velocity"]
    middles = (np.arange(10) + 0.5) * env.unwrapped.duration
    held = values[np.searchsorted(times, middles, side="right") - 1]
    assert held.tolist() == (10.0 * sent).tolist()


def test_wrappers_may_lie_between(tmp_path: Path) -> None:
    env = RecordEnv(gymnasium.make("granular_env/Piston-v1", grains=6, deadline=12), tmp_path / "made.mcap")
    play(env, episodes=1)
    env.close()
    assert verify(tmp_path / "made.mcap").identical


def test_a_restored_state_begins_a_segment(tmp_path: Path) -> None:
    path = tmp_path / "branches.mcap"
    env = RecordEnv(make_piston(grains=6, deadline=100), path)
    env.reset(seed=1)
    for _ in range(5):
        env.step([0.4])
    state = env.unwrapped.save()
    for _ in range(5):
        env.step([0.4])
    env.unwrapped.restore(state)
    for _ in range(3):
        env.step([-0.2])
    env.close()
    assert verify(path).identical
    with closing(open_log(path)) as log:
        assert [(segment.start, segment.end) for segment in log.segments] == [(0, 30), (15, 24)]


def test_only_a_component_can_be_recorded(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="ComponentEnv"):
        RecordEnv(gymnasium.make("CartPole-v1"), tmp_path / "no.mcap")
    assert list(tmp_path.iterdir()) == []


def test_an_unwritable_path_is_named(tmp_path: Path) -> None:
    with pytest.raises(GranularError, match="nowhere"):
        RecordEnv(make_piston(grains=6), tmp_path / "file" / "nowhere" / "\0.mcap")
