"""PPO and SAC in studies: the batch as stable-baselines3 wants it, weights as arrays, and going on after an end."""

import json
import re
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from granular_env.components.errors import ParameterError
from granular_env.control.study import load_study
from granular_env.control.study.runner import run_study
from granular_env.control.task_problem import TaskProblem
from granular_env.recording import verify

pytest.importorskip("stable_baselines3")
pytestmark = pytest.mark.extra

SMALL = {"grains": 6, "deadline": 60, "impulse": 0.005}
QUICK = {"environments": 4, "hold": 5, "rollout": 12, "evaluate_every": 2, "layers": [16]}
STUDY = {
    "version": 1, "name": "learning", "budget": 3000, "episodes": 2, "test_episodes": 2,
    "task": {"name": "protection", "randomise": {"velocity": [0.0, 0.5]}, **SMALL},
    "method": [
        {"type": "ppo", **QUICK},
        {"type": "sac", **QUICK, "first": 24, "batch": 32},
    ],
}  # fmt: skip


def batch(count: int = 3, mode: AutoresetMode = AutoresetMode.SAME_STEP, **changes) -> gymnasium.vector.VectorEnv:
    return gymnasium.make_vec("granular_env/Protection-v1", count, autoreset_mode=mode, **{"clock": 0, **SMALL, **changes})


def test_the_batch_gives_stable_baselines_what_it_gives_itself():
    from granular_env.control.stable_baselines import Sb3VecEnv

    ours, theirs = batch(), Sb3VecEnv(batch())
    theirs.seed(5)
    assert np.array_equal(theirs.reset(), ours.reset(seed=5)[0])
    draw, ended = np.random.default_rng(0), 0
    for _ in range(130):
        actions = draw.uniform(-1.0, 1.0, (3, 1)).astype(np.float32)
        observations, rewards, terminated, truncated, infos = ours.step(actions)
        seen, gained, over, told = theirs.step(actions)
        assert np.array_equal(seen, observations)
        assert np.array_equal(gained, rewards.astype(np.float32))
        assert np.array_equal(over, terminated | truncated)
        for place in np.flatnonzero(over):
            assert np.array_equal(told[place]["terminal_observation"], infos["final_obs"][place])
            assert told[place]["TimeLimit.truncated"] == bool(truncated[place])
            ended += 1
    assert ended >= 6


def test_infos_of_every_environment_come_through():
    from granular_env.control.stable_baselines import Sb3VecEnv

    theirs, single = Sb3VecEnv(batch(2, deadline=4, internal_steps=20)), batch(1, deadline=4, internal_steps=20)
    theirs.seed(3)
    theirs.reset()
    single.reset(seed=3)
    names = {"time", "left_force", "delivered_impulse", "wall_force", "peak_wall_force"}
    assert [info.keys() for info in theirs.reset_infos] == [names] * 2
    for step in range(4):
        _, _, over, told = theirs.step(np.full((2, 1), 0.3, np.float32))
        expected = single.step(np.full((1, 1), 0.3, np.float32))[4]
        expected = expected["final_info"] if step == 3 else expected
        assert over.all() == (step == 3)
        for name in names:
            assert told[0][name] == expected[name][0] and type(told[0][name]) is float
    assert theirs.reset_infos[0]["time"] == 0.0


def test_a_clock_makes_the_deadline_an_end_that_is_not_looked_beyond():
    from granular_env.control.stable_baselines import Sb3VecEnv

    for clock in (0, 2):
        env = Sb3VecEnv(batch(2, deadline=8, internal_steps=10, hold=4, clock=clock))
        assert env.observation_space.shape == (12 + clock,)
        env.reset()
        rest = np.zeros((2, 1), np.float32)
        assert not env.step(rest)[2].any()
        _, _, over, told = env.step(rest)
        assert over.all() and told[1]["TimeLimit.truncated"] == (clock == 0)


def test_single_environments_are_reached_by_their_indices():
    from granular_env.control.stable_baselines import Sb3VecEnv

    env = Sb3VecEnv(batch(3, render_mode="rgb_array"))
    env.seed(1)
    env.reset()
    assert env.get_attr("deadline") == [60] * 3 and env.get_attr("np_random_seed", [2]) == [3]
    states = env.env_method("save", indices=[0, 2])
    assert len(states) == 2
    env.step(np.full((3, 1), 0.5, np.float32))
    env.env_method("restore", states[0], indices=0)
    assert [state.snapshot.tick for state in env.env_method("save")] == [0, 3, 3]
    env.set_attr("step_error_reward", -5.0, indices=[1])
    assert env.get_attr("step_error_reward") == [-10.0, -5.0, -10.0]
    with pytest.raises(ParameterError, match="cannot be set in a batch"):
        env.set_attr("deadline", 3)
    assert [image.shape for image in env.get_images()] == [(360, 960, 3)] * 3


def test_a_batch_that_resets_otherwise_is_refused():
    from granular_env.control.stable_baselines import Sb3VecEnv

    with pytest.raises(ParameterError, match="its autoreset_mode is .*, expected AutoresetMode.SAME_STEP"):
        Sb3VecEnv(batch(mode=AutoresetMode.NEXT_STEP))
    for wrong in (3, gymnasium.make("granular_env/Protection-v1", **SMALL)):
        with pytest.raises(ParameterError, match="expected a VectorEnv"):
            Sb3VecEnv(wrong)


@pytest.mark.parametrize("place", [0, 1])
def test_weights_and_optimisers_come_back_from_arrays(place):
    from granular_env.control.stable_baselines import Sb3VecEnv
    from granular_env.control.study.methods.reinforcement_learning import arrays_of, put_arrays

    method = load_study(STUDY).method[place]
    trained, fresh = (method.algorithm(Sb3VecEnv(batch(4, hold=5, clock=4)), seed) for seed in (0, 1))
    trained.learn(96)
    arrays = arrays_of(trained)
    assert any("optimizer" in name and "exp_avg" in name for name in arrays)
    put_arrays(fresh, arrays)
    again = arrays_of(fresh)
    assert again.keys() == arrays.keys()
    assert all(np.array_equal(again[name], arrays[name]) for name in arrays)
    seen = np.random.default_rng(0).normal(size=(5, 16)).astype(np.float32)
    assert np.array_equal(trained.predict(seen, deterministic=True)[0], fresh.predict(seen, deterministic=True)[0])
    fresh.learn(96, reset_num_timesteps=False)
    assert any(not np.array_equal(array, arrays[name]) for name, array in arrays_of(fresh).items())


def test_a_study_trains_counts_every_control_step_and_goes_on(tmp_path):
    result = run_study(STUDY, tmp_path)
    for trial in result.trials:
        assert trial.record.finished and trial.score is not None and verify(trial.log).identical
        training = 4 * 5 * 12
        assert 3000 - training - 2 * 60 < trial.record.spent <= 3000
    before = json.loads((tmp_path / "results.json").read_text())
    longer = run_study({**STUDY, "budget": 4000}, tmp_path)
    for trial, old in zip(longer.trials, before["trials"], strict=True):
        assert old["control_steps"] < trial.record.spent <= 4000
        assert trial.record.best_return >= old["search_return"]


def test_a_trained_policy_acts_alike_alone_and_in_a_batch(tmp_path):
    result = run_study({**STUDY, "method": STUDY["method"][:1]}, tmp_path)
    problem = TaskProblem(STUDY["task"]["name"], {key: value for key, value in STUDY["task"].items() if key != "name"})
    method = load_study(STUDY).method[0]
    actor = method.actor(result.trials[0].record.best, None, problem)
    batched, _ = problem.policy_returns(lambda episodes: actor._policies, 1, [3, 4, 5])
    alone = [problem.play(actor, seed).value for seed in (3, 4, 5)]
    assert batched[0] == np.mean(alone)


def test_the_documented_example_of_ppo_learns():
    """The page's own lines: doing nothing returns -1, and so did PPO after 640,000 steps where it did not see the time."""
    import torch

    page = (Path(__file__).resolve().parent.parent / "docs" / "control.md").read_text()
    (code,) = re.findall(r"^```py\n(.*?)^```$", page, flags=re.MULTILINE | re.DOTALL)
    threads, names = torch.get_num_threads(), {"gym": gymnasium}
    try:
        exec(compile(code, "docs/control.md", "exec"), names)
    finally:
        torch.set_num_threads(threads)
    assert names["terminated"] and not names["truncated"]
    assert -names["info"]["distance"] > -0.3
