"""The native batch is bitwise identical to Gymnasium's SyncVectorEnv of the single environment."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from support.env_toys import MAKERS, state_parts

import granular_env.envs  # noqa: F401 - registers the environments
from granular_env.components.errors import ParameterError
from granular_env.domains.chain.tasks.piston import make_piston
from granular_env.domains.chain.tasks.protection import make_protection
from granular_env.domains.chain.tasks.pulse_forming import make_pulse_forming
from granular_env.domains.chain.tasks.soliton_train import make_soliton_train
from granular_env.envs import ComponentVectorEnv, make_batch

COUNT, EPISODES = 4, 25
MODES = list(AutoresetMode)
PUSHED: dict[str, Any] = {"deadline": 8, "internal_steps": 40, "impulse": 1e-3, "clock": 0}

# Case name -> environment factory and arguments.
CASES: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
    "clock": (make_protection, {"grains": 6, **PUSHED, "clock": 3}),
    "held": (make_piston, {"grains": 5, "deadline": 20, "internal_steps": 13, "hold": 3, "control_delay": 2, "noise": 0.1}),
    "held with a clock": (
        make_pulse_forming,
        {"grains": 9, "amplitude": 3.0, "place": 3, "deadline": 40, "hold": 7, "randomise": {"radius": (2.9e-3, 3e-3)}},
    ),
    "goal": (
        make_soliton_train,
        {"grains": 12, "waves": 2, "spacing": (3.0, 4.0), "front": (7.0, 8.0), "deadline": 60, "internal_steps": 6,
         "hold": 5, "randomise": {"radius": (2.9e-3, 3e-3)}},
    ),
    "sensors": (
        make_protection,
        {"grains": 5, **PUSHED, "observe": {"velocity": [0, -1, 3], "contact_force": [-1], "right_wall_force": "all"},
         "noise": 0.02},
    ),
    "slow actuator": (
        make_piston,
        {"grains": 4, "deadline": 14, "internal_steps": 20, "action_rate": 0.3, "control_delay": 3, "noise": 0.1},
    ),
    "drawn": (
        make_protection,
        {"grains": 6, **PUSHED, "chain": {"law": {"name": "viscous", "dissipation": 0.5}},
         "randomise": {"radius": (2e-3, 3e-3), "contact_stiffness": (1e9, 2e9), "velocity": (0.0, 3.0)}},
    ),
    "each grain drawn": (
        make_piston,
        {"grains": 6, "deadline": 9, "internal_steps": 30,
         "randomise": {"radius": {"low": 2e-3, "high": 3e-3}, "velocity": {1: (0.0, 2.0)}}},
    ),
    "plastic": (
        make_protection,
        {"grains": 5, **PUSHED, "chain": {"law": {"name": "elastic_plastic", "yield_pressure": 1e9}, "integrator": "leapfrog"}},
    ),
    "refused": (
        make_protection,
        {"grains": 3, "deadline": 5, "impulse": 10.0, "clock": 0, "hold": 2, "action_scale": 2e5,
         "chain": {"overlap_limit": 0.005}},
    ),
}  # fmt: skip


def batch(make: Callable[..., Any], count: int, **arguments: Any) -> Any:
    """Return a native batch."""
    made = make_batch(make, count, **arguments)
    assert isinstance(made, ComponentVectorEnv)
    return made


def pair(case: str, mode: AutoresetMode, info: str) -> tuple[Any, SyncVectorEnv]:
    make, arguments = CASES[case]
    native = batch(make, COUNT, autoreset_mode=mode, info=info, **arguments)
    return native, SyncVectorEnv([lambda: make(info=info, **arguments)] * COUNT, autoreset_mode=mode)


def same(found: Any, expected: Any, where: str = "") -> None:
    """Assert equality in value, type, shape and bits."""
    if isinstance(expected, dict):
        assert found.keys() == expected.keys(), where
        for name, value in expected.items():
            same(found[name], value, f"{where}.{name}")
    elif isinstance(expected, tuple):
        assert len(found) == len(expected), where
        for index, (one, other) in enumerate(zip(found, expected, strict=True)):
            same(one, other, f"{where}[{index}]")
    elif isinstance(expected, np.ndarray) and expected.dtype != object:
        assert found.dtype == expected.dtype and found.shape == expected.shape, where
        assert found.tobytes() == expected.tobytes(), where
    elif isinstance(expected, np.ndarray):
        assert found.dtype == object and found.shape == expected.shape, where
        for index, value in enumerate(expected):
            same(found[index], value, f"{where}[{index}]")
    else:
        assert type(found) is type(expected) and found == expected, where


def play(native: Any, sync: SyncVectorEnv, episodes: int, seed: int) -> dict[str, int]:
    """Play random actions in both until `episodes` episodes are over; return their endings."""
    shape, ends = (native.num_envs, 1), {"terminated": 0, "truncated": 0}
    generator, disabled = np.random.default_rng(seed), native.autoreset_mode == AutoresetMode.DISABLED
    same(native.reset(seed=seed), sync.reset(seed=seed))
    bias = generator.uniform(-0.3, 0.8, shape)
    while sum(ends.values()) < episodes:
        actions = (bias + generator.normal(0.0, 0.5, shape)).astype(np.float32)
        found, expected = native.step(actions), sync.step(actions)
        same(found, expected)
        ends["terminated"] += int(expected[2].sum())
        ends["truncated"] += int(expected[3].sum())
        ended = expected[2] | expected[3]
        if disabled and ended.any():
            same(native.reset(options={"reset_mask": ended.copy()}), sync.reset(options={"reset_mask": ended.copy()}))
    return ends


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("case", sorted(CASES))
@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
def test_a_batch_gives_what_single_environments_give(case: str, mode: AutoresetMode) -> None:
    seed = sorted(CASES).index(case)
    native, sync = pair(case, mode, "full" if seed % 2 else "brief")
    ends = play(native, sync, EPISODES, seed)
    timed = case in ("clock", "held with a clock", "goal")
    assert (ends["truncated"] == 0) == timed or ends["terminated"] > 0
    native.close()
    sync.close()


def test_make_vec_picks_the_batch() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make_vec("granular_env/Protection-v1", num_envs=3, grains=5)
    assert isinstance(env.unwrapped, ComponentVectorEnv) and env.num_envs == 3
    assert env.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    observations, _ = env.reset(seed=1)
    assert env.observation_space.contains(observations) and observations.shape == (3, 18)
    assert env.observation_space.contains(env.step(env.action_space.sample())[0])
    env.close()


def test_a_task_in_python_gets_gymnasiums_own_batch() -> None:
    env = make_batch(MAKERS["swing"], 2, autoreset_mode="SameStep", deadline=3)
    assert isinstance(env, SyncVectorEnv) and env.metadata["autoreset_mode"] == AutoresetMode.SAME_STEP
    env.reset(seed=1)
    assert [bool(env.step(np.zeros((2, 1)))[3].all()) for _ in range(4)] == [False, False, True, False]


def test_observations_and_infos_are_fresh() -> None:
    env = batch(make_protection, 2, grains=4, info="full")
    observations, infos = env.reset(seed=1)
    kept = observations.copy(), {name: value.copy() for name, value in infos.items()}
    for _ in range(5):
        env.step(np.ones((2, 1), np.float32))
    same(observations, kept[0])
    same(infos, kept[1])


def test_a_mask_resets_some() -> None:
    env = batch(make_protection, 3, grains=4, clock=0, autoreset_mode="Disabled")
    env.reset(seed=1)
    before, *_ = env.step(np.ones((3, 1)))
    mask = np.array([False, True, False])
    observations, infos = env.reset(seed=[1, 2, 3], options={"reset_mask": mask})
    same(observations[~mask], before[~mask])
    assert not observations[1].any() and infos["_time"].tolist() == mask.tolist()


@pytest.mark.parametrize(
    ("actions", "words"),
    [
        (np.array([[0.0], [np.nan], [0.0]]), r"actions\[1,0\]: got nan"),
        (np.zeros((2, 1)), r"shape \(2, 1\), expected numbers from -1 to 1 of shape \(3, 1\)"),
        ([["a"], ["b"], ["c"]], "actions"),
    ],
)
def test_invalid_actions_are_refused_and_nothing_moves(actions: Any, words: str) -> None:
    env = batch(make_protection, 3, grains=4)
    with pytest.raises(ParameterError):
        env.step(np.zeros((3, 1)))  # before the first reset
    env.reset(seed=1)
    env.step(np.ones((3, 1)))
    before = [state_parts(state) for state in env.save()]
    with pytest.raises(ParameterError, match=words):
        env.step(actions)
    assert [state_parts(state) for state in env.save()] == before


@pytest.mark.parametrize("arguments", [{"num_envs": 0}, {"autoreset_mode": "sometimes"}, {"grians": 3}])
def test_batches_that_cannot_be_are_refused(arguments: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="num_envs|sometimes|did you mean .grains."):
        make_batch(make_protection, **{"num_envs": 3, "grains": 4, **arguments})


def test_seeds_are_given_to_each() -> None:
    env = batch(make_protection, 2, grains=4, randomise={"velocity": (0.0, 1.0)}, info="full")
    first = env.reset(seed=5)[1]["velocity"][:, 0].tolist()
    assert env.reset(seed=[6, 5])[1]["velocity"][:, 0].tolist()[::-1] == [first[0], first[1]]
    assert env.np_random_seed == (6, 5) and len(env.np_random) == 2


def test_pictures_of_all() -> None:
    env = batch(make_protection, 2, grains=4, render_mode="rgb_array")
    env.reset(seed=1)
    env.step(np.array([[1.0], [0.0]]))
    first, second = env.render()
    assert first.shape == (360, 960, 3) and (first != second).any()
