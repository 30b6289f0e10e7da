"""States of environments within an episode: as bytes, in a batch, copied, recorded, and at a time of a log."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from support.env_toys import MAKERS, SMALL, random_actions, state_parts, transcript

import granular_env as ge
import granular_env.envs
from granular_env.components.errors import ParameterError
from granular_env.components.snapshot import Snapshot
from granular_env.domains.chain.tasks.piston import make_piston
from granular_env.domains.chain.tasks.protection import make_protection
from granular_env.envs import ComponentEnv, make_batch
from granular_env.recording import open_log, record, verify

cloudpickle = pytest.importorskip("cloudpickle")
HARD: dict[str, Any] = {
    "grains": 6, "deadline": 200, "control_delay": 3, "action_rate": 0.3, "noise": 0.05, "hold": 2,
    "randomise": {"radius": {"low": 2.5e-3, "high": 3e-3}, "velocity": (0.0, 1.0)},
}  # fmt: skip
NOISY: dict[str, Any] = {
    "grains": 6, "deadline": 60, "control_delay": 4, "action_rate": 0.2, "noise": 0.05, "randomise": {"velocity": (0.0, 2.0)},
}  # fmt: skip
WAYS: dict[str, Callable[[Any], Any]] = {
    "deepcopy": copy.deepcopy,
    "pickle": lambda one: pickle.loads(pickle.dumps(one)),
    "cloudpickle": lambda one: cloudpickle.loads(cloudpickle.dumps(one)),
}


# -- save and restore -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("maker", sorted(MAKERS))
def test_a_restored_environment_goes_on_with_the_same_bits(maker: str) -> None:
    env, other = MAKERS[maker](), MAKERS[maker]()
    env.reset(seed=3)
    transcript(env, random_actions(15))
    state = pickle.loads(pickle.dumps(env.save()))
    expected = transcript(env, random_actions(300, seed=1))
    next_start = env.reset()[0]
    transcript(env, random_actions(5, seed=2))
    for one in (env, other):
        one.restore(state)
        observation, info = one.observe()
        assert one.observation_space.contains(observation) and info["time"] == one.component.time
        assert transcript(one, random_actions(300, seed=1)) == expected
        np.testing.assert_array_equal(one.reset()[0], next_start)


def test_foreign_states_are_refused() -> None:
    env, force, longer = make_piston(**SMALL), make_protection(**SMALL), make_piston(grains=9)
    for one in (env, force, longer):
        one.reset(seed=1)
    before = state_parts(env.save())
    for state in (force.save(), longer.save(), env.component.save(), None, 3):
        with pytest.raises(ParameterError):
            env.restore(state)  # type: ignore[arg-type]
    assert state_parts(env.save()) == before


# -- in a batch -----------------------------------------------------------------------------------------------------------


def test_states_move_between_batches_and_single_environments() -> None:
    batch, env = make_batch(make_piston, 3, **NOISY, info="full"), make_piston(**NOISY)
    batch.reset(seed=4)
    env.reset(seed=20)
    chosen = [random_actions(3, seed=step) for step in range(30)]
    for some in chosen[:10]:
        batch.step(some)
        env.step(some[0])
    states = batch.save()
    first = [batch.step(some) for some in chosen[10:]]
    # One environment goes back, one takes the state of the single environment, one continues.
    now = batch.save()
    batch.restore([states[1], env.save()], environments=[1, 2])
    assert state_parts(batch.save([0])[0]) == state_parts(now[0])
    for step, some in enumerate(chosen[10:]):
        observations, rewards, *_ = batch.step(some)
        observation, reward, *_ = env.step(some[2])
        np.testing.assert_array_equal(observations[1], first[step][0][1])
        np.testing.assert_array_equal(observations[2], observation)
        assert rewards[1] == first[step][1][1] and rewards[2] == reward


def test_states_that_do_not_fit_a_batch_are_refused() -> None:
    batch = make_batch(make_piston, 2, **SMALL)
    batch.reset(seed=1)
    states = batch.save()
    for wrong, words in ((states[:1], "got 1, expected 2"), ([None, states[1]], "state")):
        batch.step(np.ones((2, 1)))
        before = [state_parts(state) for state in batch.save()]
        with pytest.raises(ParameterError, match=words):
            batch.restore(wrong)  # type: ignore[arg-type]
        assert [state_parts(state) for state in batch.save()] == before, "nothing has changed"


# -- copies ---------------------------------------------------------------------------------------------------------------


def same_from_here(one: Any, other: Any) -> None:
    """Original and copy give equal results, also in the next episode, and do not affect each other."""
    before = state_parts(other.save())
    expected = transcript(one, random_actions(20, seed=1))
    assert state_parts(other.save()) == before, "the copy has not moved with the original"
    assert transcript(other, random_actions(20, seed=1)) == expected
    np.testing.assert_array_equal(other.reset()[0], one.reset()[0])
    assert transcript(other, random_actions(5)) == transcript(one, random_actions(5))


def test_a_copy_of_what_is_drawn_delayed_and_held_goes_on_alike() -> None:
    env = make_piston(**HARD)
    env.reset(seed=2)
    transcript(env, random_actions(4))
    same_from_here(env, copy.deepcopy(env))


@pytest.mark.parametrize("way", WAYS)
def test_a_batch_is_copied_lane_by_lane(way: str) -> None:
    batch = make_batch(make_piston, 3, **HARD)
    batch.reset(seed=4)
    for step in range(5):
        batch.step(random_actions(3, seed=step))
    other = WAYS[way](batch)
    held = [state_parts(one) for one in other.save()]
    for step in range(30):
        found = batch.step(random_actions(3, seed=step))
        if step == 0:
            assert [state_parts(one) for one in other.save()] == held
        expected = other.step(random_actions(3, seed=step))
        for one, two in zip(found[:4], expected[:4], strict=True):
            np.testing.assert_array_equal(one, two)
    assert other.np_random_seed == batch.np_random_seed


@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
def test_used_fresh_copied_and_batched_environments_refuse_the_same_steps() -> None:
    """With pushes beyond the chain's limits, an environment's history changes no reward, time or message."""
    arguments: dict[str, Any] = {"grains": 12, "action_scale": 1e5}
    used, batch = make_protection(**arguments), make_batch(make_protection, 1, **arguments)
    refused = 0
    for seed in range(12):
        pushes = np.random.default_rng(seed).uniform(-0.5, 1.5, (12, 1)).astype(np.float32) * 10.0 ** (-seed / 12.0)
        fresh = make_protection(**arguments)
        played = []
        for env in (used, fresh, copy.deepcopy(used)):
            env.reset(seed=seed)
            played.append(episode(env, pushes))
        assert played[1:] == [played[0]] * 2
        batch.reset(seed=seed)
        steps = [batch.step(push[None]) for push in pushes[: len(played[0])]]
        assert [(float(step[1][0]), bool(step[2][0])) for step in steps] == [one[:2] for one in played[0]]
        refused += played[0][-1][3] != ""
    assert refused > 3


def episode(env: Any, pushes: np.ndarray) -> list[tuple[float, bool, float, str]]:
    """Return reward, termination, time and refusal message of each step until the episode is over."""
    steps = []
    for push in pushes:
        _, reward, over, late, info = env.step(push)
        steps.append((float(reward), bool(over), info["time"], info.get("step_error", "")))
        if over or late:
            break
    return steps


# -- records --------------------------------------------------------------------------------------------------------------


def play(env: gymnasium.Env, episodes: int, seed: int = 0) -> list[float]:
    """Play random episodes to their end; return all rewards."""
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
    path, env = tmp_path / "episodes.mcap", maker(grains=6, deadline=25)
    with record(env.component, path, every=1.5e-6):
        recorded = play(env, episodes=3)
    last = env.component.get("velocity")
    assert recorded == play(maker(grains=6, deadline=25), episodes=3)
    found = verify(path)
    assert found.identical and found.calls == 75, found.message
    with closing(open_log(path)) as log:
        assert log.complete
        # 25 control steps of 3 internal steps each.
        assert [segment.end for segment in log.segments][-3:] == [75, 75, 75]
        np.testing.assert_array_equal(log.series("velocity")[1][-1], last)


def test_a_restored_state_begins_a_segment(tmp_path: Path) -> None:
    path, env = tmp_path / "branches.mcap", make_piston(grains=6, deadline=100)
    with record(env.component, path):
        env.reset(seed=1)
        for _ in range(5):
            env.step([0.4])
        state = env.save()
        for _ in range(5):
            env.step([0.4])
        env.restore(state)
        for _ in range(3):
            env.step([-0.2])
    assert verify(path).identical
    with closing(open_log(path)) as log:
        assert [(segment.start, segment.end) for segment in log.segments] == [(0, 30), (15, 24)]


# -- at a time of a log ---------------------------------------------------------------------------------------------------


def snapshot_at(path: Path, at: float) -> Snapshot:
    with open_log(path) as log:
        return log.branch(at).component.save()


@pytest.mark.parametrize("instant", [0, 7, 23, 39])
@pytest.mark.parametrize("maker", [make_piston, make_protection])
def test_a_log_goes_on_as_an_environment(maker: type[ComponentEnv], instant: int, tmp_path: Path) -> None:
    """With the same inputs, the result is bitwise identical to the log's continuation."""
    chosen, path = random_actions(40), tmp_path / "episode.mcap"
    env = maker(**SMALL)
    passed = [b""]
    with record(env.component, path, every=1.5e-6):
        env.reset(seed=1)
        for action in chosen:
            env.step(action)
            passed.append(env.component.save().data)
    fresh = maker(**SMALL)
    observation, info = fresh.reset(seed=3, options={"snapshot": snapshot_at(path, instant * fresh.duration)})
    assert fresh.observation_space.contains(observation) and info["time"] == fresh.component.time
    for number in range(instant, 40):
        fresh.step(chosen[number])
        assert fresh.component.save().data == passed[number + 1]
    assert fresh.component.tick == env.component.tick


def test_an_episode_from_a_log_is_one_of_its_own(tmp_path: Path) -> None:
    chain, path = (
        ge.make("chain", grains=8, step_size=5e-7, left="piston", radius=3e-3, velocity_scale=10.0),
        tmp_path / "run.mcap",
    )
    with record(chain, path):
        chain.reset()
        chain.step(3e-5, left_velocity=ge.Profile.half_sine(2.0, 3e-5))
    env = make_piston(**SMALL)
    assert env.component.identity == chain.identity
    env.reset(options={"snapshot": snapshot_at(path, 3e-5)})
    rewards = [env.step([0.0])[1] for _ in range(20)]
    # The episode is not charged for the profile's work, but the wave is present.
    assert rewards[0] == pytest.approx(0.0, abs=1e-3)
    assert np.abs(env.component.get("velocity")).max() > 0.1
    _, _, _, truncated, _ = env.step([0.0])
    assert not truncated and env.save().snapshot.tick == chain.tick + 63


def test_a_log_of_another_chain_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    other = make_piston(grains=9, radius=2e-3)
    with record(other.component, path):
        other.reset(seed=1)
        other.step([0.5])
    env = make_piston(**SMALL)
    env.reset(seed=1)
    before = env.component.save().to_bytes()
    with pytest.raises(ParameterError, match="the same parameters and version"):
        env.reset(options={"snapshot": snapshot_at(path, 0.0)})
    assert env.component.save().to_bytes() == before


def test_any_component_can_be_branched(tmp_path: Path) -> None:
    path, env, other = tmp_path / "swing.mcap", MAKERS["swing"](), MAKERS["swing"]()
    with record(env.component, path):
        env.reset(seed=1)
        transcript(env, random_actions(10))
    other.reset(options={"snapshot": snapshot_at(path, 10 * other.duration)})
    assert other.component.save().data == env.component.save().data
    other.step([0.1])
