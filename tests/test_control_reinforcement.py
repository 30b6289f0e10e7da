"""PPO and SAC in studies: the batch for stable-baselines3, counting of runs, and the stored policy."""

import re
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from granular_env.components.errors import ParameterError
from granular_env.control.methods.reinforcement_learning import PPO, SAC
from granular_env.control.problem import Problem
from granular_env.control.runner import run_study
from granular_env.control.search import BudgetSpentError, Search
from granular_env.recording import verify

pytest.importorskip("stable_baselines3")
pytestmark = pytest.mark.extra

SMALL = {"grains": 6, "deadline": 60, "impulse": 0.005}
QUICK = {"environments": 4, "hold": 5, "rollout": 12, "evaluate_every": 2, "layers": [16]}
TASK = {"randomise": {"velocity": [0.0, 0.5]}, **SMALL}


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

    env = Sb3VecEnv(batch(3))
    env.seed(1)
    env.reset()
    assert env.get_attr("deadline") == [60] * 3 and env.get_attr("np_random_seed", [2]) == [3]
    env.step(np.full((3, 1), 0.5, np.float32))
    assert [state.snapshot.tick for state in env.env_method("save", indices=[0, 2])] == [3, 3]
    env.set_attr("step_error_reward", -5.0, indices=[1])
    assert env.get_attr("step_error_reward") == [-10.0, -5.0, -10.0]


def test_a_batch_that_resets_otherwise_is_refused():
    from granular_env.control.stable_baselines import Sb3VecEnv

    for wrong in (batch(mode=AutoresetMode.NEXT_STEP), gymnasium.make("granular_env/Protection-v1", **SMALL)):
        with pytest.raises(ParameterError, match="expected AutoresetMode.SAME_STEP"):
            Sb3VecEnv(wrong)


@pytest.mark.parametrize("method", [PPO(**QUICK), SAC(**QUICK, first=24, batch=32)], ids=["ppo", "sac"])
def test_a_trial_counts_every_control_step_and_finds_the_same_again(method, tmp_path):
    found = []
    for _ in range(2):
        search = Search(Problem("protection", TASK), None, 1, [5, 6], 3000)
        with pytest.raises(BudgetSpentError):
            method.run(search)
        assert 3000 - 4 * 5 * 12 - 2 * 60 < search.spent <= 3000
        # A single best policy acts as in the batch.
        actor = method.actor(search)
        problem = method.adapt_problem(search.problem)
        assert np.mean([problem.play_episode(actor, seed)[0] for seed in (5, 6)]) == search.best_return
        found.append(search.curve)
    assert found[0] == found[1]


def test_a_study_trains_and_leaves_logs_that_replay(tmp_path):
    methods = [{"type": "ppo", **QUICK}, {"type": "sac", **QUICK, "first": 24, "batch": 32}]
    task = {"name": "protection", **TASK}
    result = run_study(
        {"version": 1, "name": "learning", "budget": 3000, "episodes": 2, "task": task, "method": methods}, tmp_path
    )
    assert [trial.name for trial in result.trials] == ["ppo-1", "sac-1"]
    assert all(verify(tmp_path / "logs" / f"{trial.name}.mcap").identical for trial in result.trials)


def test_the_documented_example_of_ppo_learns():
    """As on the page: doing nothing returns -1, as did PPO after 640,000 steps without observing the time."""
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
