"""The environments in Gymnasium: its checks, registration, stepping, episodes, and custom tasks."""

from __future__ import annotations

import math
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from support.env_toys import MAKERS, SMALL, Swing, random_actions, state_parts, transcript
from support.task_check import check_task

import granular_env.envs  # noqa: F401 - registers the environments
from granular_env.components.component import Component
from granular_env.components.errors import ParameterError
from granular_env.components.oscillator import Oscillator
from granular_env.domains.chain.tasks import ENVIRONMENTS
from granular_env.domains.chain.tasks.piston import make_piston
from granular_env.envs import ComponentEnv, Task

ROOT = Path(__file__).resolve().parent.parent


# -- Gymnasium --------------------------------------------------------------------------------------------------------


@pytest.fixture(params=sorted(MAKERS))
def make(request: pytest.FixtureRequest) -> Callable[..., ComponentEnv]:
    return MAKERS[request.param]


def test_check_env_has_nothing_to_say(make: Callable[..., ComponentEnv]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Without a registered name, Gymnasium cannot make environments with other render modes, and warns.
        check_env(make(render_mode="rgb_array"), skip_render_check=True)


@pytest.mark.extra
@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_stable_baselines_has_nothing_to_say_either(name: str) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for options in ({}, {"observe": {"velocity": [0, -1]}, "noise": 0.1, "control_delay": 2}):
            checker.check_env(gymnasium.make(name, **options).unwrapped)


def run(script: str) -> str:
    """Run a script in a new process; return its output."""
    done = subprocess.run([sys.executable, "-W", "error", "-c", script], capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


MAKE = "env = gymnasium.make('granular_env/Protection-v1', grains=4); print(env.spec.id)"


@pytest.mark.parametrize(
    "imports",
    [
        "import gymnasium, granular_env",
        "import granular_env, gymnasium, granular_env.envs",
    ],
)
def test_the_environments_are_registered_whichever_is_imported_first(imports: str) -> None:
    assert run(f"{imports}; {MAKE}") == "granular_env/Protection-v1"


def test_gymnasium_imports_the_package_by_name() -> None:
    script = "import gymnasium; print(gymnasium.make('granular_env:granular_env/Piston-v1', grains=4).unwrapped.task.name)"
    assert run(script) == "piston"


# -- stepping ---------------------------------------------------------------------------------------------------------


def test_an_environment_steps_its_component_exactly(make: Callable[..., ComponentEnv]) -> None:
    env, twin = make(), make()
    env.reset(seed=3)
    twin.reset(seed=3)
    (name, scale), component = next(iter(env.task.actions.items())), twin.component
    for action in random_actions(40):
        _, _, terminated, truncated, info = env.step(action)
        component.step(twin.duration, **{name: scale * float(action[0])})
        assert info["time"] == component.time
        for output in env.task.observations:
            np.testing.assert_array_equal(info[output], component.get(output))
        if terminated or truncated:
            break
    assert env.component.save().to_bytes() == component.save().to_bytes()


def test_observations_are_scaled_and_clipped(make: Callable[..., ComponentEnv]) -> None:
    env = make()
    env.reset(seed=1)
    for action in random_actions(30):
        observation, *_, info = env.step(action)
        parts = [np.ravel(info[name]) / scale for name, scale in env.task.observations.items()]
        expected = np.clip(np.concatenate(parts), -env.task.observation_limit, env.task.observation_limit)
        # Rounding to float32, whose smallest normal number is 1.2e-38, and rounding of 1 / scale.
        np.testing.assert_allclose(observation, expected, rtol=2e-7, atol=2e-38)
    wild, _ = MAKERS["swing"]().reset(options={"position": 100.0, "velocity": -100.0})
    assert wild.tolist() == [3.0, -3.0]


def test_observations_and_info_are_fresh(make: Callable[..., ComponentEnv]) -> None:
    env = make()
    first, info = env.reset(seed=1)
    kept = first.copy(), {name: np.copy(value) for name, value in info.items()}
    for action in random_actions(20):
        observation, *_, later = env.step(action)
        assert observation is not first and later is not info
    np.testing.assert_array_equal(first, kept[0])
    for name, value in info.items():
        np.testing.assert_array_equal(value, kept[1][name])
        if isinstance(value, np.ndarray):
            assert value.dtype == np.float64


@pytest.mark.parametrize(
    "beyond",
    [
        1.5,
        -7.0,
    ],
)
def test_actions_beyond_the_bounds_are_clipped(make: Callable[..., ComponentEnv], beyond: float) -> None:
    env, twin = make(), make()
    for one, action in ((env, beyond), (twin, math.copysign(1.0, beyond))):
        one.reset(seed=1)
        one.step(np.array([action], dtype=np.float32))
    assert env.component.save().to_bytes() == twin.component.save().to_bytes()


@pytest.mark.parametrize(
    "action",
    [
        [math.nan],
        [0.1, 0.2],
        ["fast"],
        [[1.0], [1.0, 2.0]],
    ],
)
def test_an_invalid_action_is_refused_and_nothing_moves(make: Callable[..., ComponentEnv], action: Any) -> None:
    env = make()
    env.reset(seed=1)
    env.step([0.5])
    before = state_parts(env.save())
    with pytest.raises(ParameterError, match="action"):
        env.step(action)
    assert state_parts(env.save()) == before


# -- episodes ---------------------------------------------------------------------------------------------------------


def test_seeds_decide_the_start() -> None:
    env, twin = MAKERS["swing"](), MAKERS["swing"]()
    first = env.reset(seed=4)[0]
    np.testing.assert_array_equal(twin.reset(seed=4)[0], first)
    np.testing.assert_array_equal(twin.reset()[0], env.reset()[0])
    assert not np.array_equal(env.reset()[0], first)
    assert not np.array_equal(env.reset(seed=5)[0], first)


def test_reset_leaves_nothing_behind(make: Callable[..., ComponentEnv]) -> None:
    used, fresh = make(), make()
    used.reset(seed=9)
    transcript(used, random_actions(50, seed=1))
    for env in (used, fresh):
        env.reset(seed=2)
    assert state_parts(used.save()) == state_parts(fresh.save())
    assert transcript(used, random_actions(60)) == transcript(fresh, random_actions(60))


def test_options_give_start_values() -> None:
    env = make_piston(**SMALL)
    _, info = env.reset(options={"velocity": {0: 2.0, -1: -1.0}})
    assert info["velocity"].tolist() == [2.0, *[0.0] * 6, -1.0]
    before = state_parts(env.save())
    for options in ({"velocty": 1.0}, {"velocity": math.nan}, {"velocity": [1.0]}, {"snapshot": 3}):
        with pytest.raises(ParameterError):
            env.reset(options=options)
        assert state_parts(env.save()) == before
    env.step([0.0])


def test_the_deadline_truncates(make: Callable[..., ComponentEnv]) -> None:
    env = make(deadline=7, internal_steps=20)
    env.reset(seed=1)
    ends = [env.step([0.0])[2:4] for _ in range(7)]
    assert ends == [(False, False)] * 6 + [(False, True)]
    assert all(type(flag) is bool for pair in ends for flag in pair)
    with pytest.raises(ParameterError, match="reset"):
        env.step([0.0])


def test_a_refused_step_ends_the_episode_with_the_last_good_state() -> None:
    env = ComponentEnv(Oscillator(stiffness=1e300, step_size=10.0), Swing(), step_error_reward=-3.0)
    env.reset(seed=1)
    before = env.component.save().to_bytes()
    for _ in range(100):
        before = env.component.get("position"), env.component.tick
        observation, reward, terminated, truncated, info = env.step([1.0])
        if terminated:
            break
    assert (reward, terminated, truncated) == (-3.0, True, False)
    assert "step_size" in info["step_error"]
    assert (info["position"], env.component.tick) == before
    assert env.observation_space.contains(observation)
    with pytest.raises(ParameterError, match="reset"):
        env.step([0.0])
    env.reset(seed=1)
    env.step([0.0])


# -- custom tasks -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("attribute", "value", "words"),
    [
        ("actions", {"forse": 1.0}, "did you mean 'force'"),
        ("actions", {"position": 1.0}, "actions.position: got 'position', expected an input of"),
        ("actions", {"force": 0.0}, "more than 0"),
    ],
)
def test_a_task_that_does_not_fit_is_refused(attribute: str, value: dict, words: str) -> None:
    task = Swing()
    setattr(task, attribute, value)
    with pytest.raises(ParameterError, match=words):
        ComponentEnv(Oscillator(), task)


class Steady(Task):
    """A toy task for testing one error at a time."""

    name = "steady"
    actions, observations = {"force": 1.0}, {"position": 1.0}  # noqa: RUF012

    def begin_episode(self, component: Component, seen: Any) -> None:
        self.counters = {"count": 0}

    def evaluate_step(self, component: Component, seen: Any, duration: float) -> tuple[float, bool]:
        self.counters["count"] += 1
        return np.float32(self.counters["count"]), np.bool_(False)  # type: ignore[return-value]


class Hidden(Steady):
    def begin_episode(self, component: Component, seen: Any) -> None:
        self.count = 0

    def evaluate_step(self, component: Component, seen: Any, duration: float) -> tuple[float, bool]:
        self.count += 1
        return float(self.count), False


class Leftover(Steady):
    count = 0

    def begin_episode(self, component: Component, seen: Any) -> None:
        Leftover.count += 1

    def evaluate_step(self, component: Component, seen: Any, duration: float) -> tuple[float, bool]:
        return float(Leftover.count), False


class Drawing(Steady):
    def evaluate_step(self, component: Component, seen: Any, duration: float) -> tuple[float, bool]:
        return float(np.random.default_rng().random()), False


def steady(task: Task) -> ComponentEnv:
    return ComponentEnv(Oscillator(step_size=0.01), task, internal_steps=5, deadline=20)


@pytest.mark.parametrize("task", [Hidden, Leftover, Drawing])
def test_a_task_that_remembers_something_outside_its_counters_is_found(task: type[Task]) -> None:
    with pytest.raises(AssertionError, match=r"task 'steady': reward: .* after action \d"):
        check_task(steady(task()))


@pytest.mark.parametrize("name", sorted(ENVIRONMENTS))
def test_the_shipped_tasks_keep_everything_in_their_counters(name: str) -> None:
    assert check_task(gymnasium.make(name), steps=20) == 20


# -- pictures ---------------------------------------------------------------------------------------------------------


def test_pictures_show_what_moves(make: Callable[..., ComponentEnv]) -> None:
    env = make(render_mode="rgb_array")
    env.reset(seed=1)
    before = env.render()
    assert before.shape == (360, 960, 3) and before.dtype == np.uint8
    assert env.render().tobytes() == before.tobytes()
    for _ in range(12):
        env.step([1.0])
    after = env.render()
    assert (after != before).any()
    red = (after[..., 0].astype(int) - after[..., 2] > 60).sum()
    assert red > 200, "what moves to the right is red"
    assert make().render() is None
