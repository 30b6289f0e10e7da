"""The environments as Gymnasium sees them: its own checks, stepping, episodes, save and restore."""

from __future__ import annotations

import math
import pickle
import warnings
from collections.abc import Callable, Iterable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from support.env_toys import MAKERS, SMALL, Swing, actions, transcript

from granular_env.components.drawables import Points
from granular_env.components.errors import ParameterError
from granular_env.components.oscillator import Oscillator
from granular_env.components.variables import Variable
from granular_env.domains.chain.tasks import ENVIRONMENTS
from granular_env.domains.chain.tasks.piston import make_piston
from granular_env.domains.chain.tasks.protection import make_protection
from granular_env.envs import ComponentEnv
from granular_env.envs.registration import register_all

register_all()
NAMES = ["granular_env/Piston-v1", "granular_env/Protection-v1"]


@pytest.fixture(params=sorted(MAKERS))
def make(request: pytest.FixtureRequest) -> Callable[..., ComponentEnv]:
    return MAKERS[request.param]


# -- Gymnasium --------------------------------------------------------------------------------------------------------


def test_check_env_has_nothing_to_say(make: Callable[..., ComponentEnv]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Without a registered name Gymnasium cannot make further ones with other render modes, and says so.
        check_env(make(render_mode="rgb_array"), skip_render_check=True)


@pytest.mark.parametrize("name", NAMES)
def test_the_registered_environments_pass_too(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make(name, render_mode="rgb_array")
        check_env(env.unwrapped)
        env.reset(seed=1)
        for _ in range(20):
            env.step(env.action_space.sample())
        assert env.unwrapped.observation_space.shape == (128 + env.unwrapped.clock,)
        assert env.unwrapped.duration == 3 * env.unwrapped.component.step_size
        env.close()
        env.close()


@pytest.mark.extra
@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_stable_baselines_has_nothing_to_say_either(name: str) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for options in ({}, {"observe": {"velocity": [0, -1]}, "noise": 0.1, "control_delay": 2}):
            checker.check_env(gymnasium.make(name, **options).unwrapped)


@pytest.mark.parametrize("name", NAMES)
def test_a_vector_of_environments_gives_what_single_ones_give(name: str) -> None:
    vector = gymnasium.make_vec(name, num_envs=3, vectorization_mode="sync", grains=8)
    singles = [gymnasium.make(name, grains=8) for _ in range(3)]
    observations, _ = vector.reset(seed=5)
    for index, env in enumerate(singles):
        np.testing.assert_array_equal(env.reset(seed=5 + index)[0], observations[index])
    for step in range(30):
        chosen = actions(3, seed=step)
        observations, rewards, *_ = vector.step(chosen)
        for index, env in enumerate(singles):
            observation, reward, *_ = env.step(chosen[index])
            np.testing.assert_array_equal(observation, observations[index])
            assert reward == rewards[index]
    vector.close()


def test_the_spaces_follow_the_declarations() -> None:
    env = make_piston(grains=5)
    assert env.action_space == gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float32)
    assert env.observation_space == gymnasium.spaces.Box(-10.0, 10.0, (10,), np.float32)
    swing = MAKERS["swing"]()
    assert swing.observation_space == gymnasium.spaces.Box(-3.0, 3.0, (2,), np.float32)


def test_docstrings_tell_what_gymnasium_users_look_for() -> None:
    for env in (make_piston, make_protection):
        for title in (
            "Action space",
            "Observation space",
            "Rewards",
            "Start state",
            "End of the episode",
            "Arguments",
            "Version history",
        ):
            assert f"## {title}" in (env.__doc__ or "")


# -- stepping ---------------------------------------------------------------------------------------------------------


def test_an_environment_steps_its_component_exactly(make: Callable[..., ComponentEnv]) -> None:
    env, twin = make(), make()
    env.reset(seed=3)
    twin.reset(seed=3)
    (name, scale), component = next(iter(env.task.actions.items())), twin.component
    for action in actions(40):
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
    for action in actions(30):
        observation, *_, info = env.step(action)
        parts = [np.ravel(info[name]) / scale for name, scale in env.task.observations.items()]
        expected = np.clip(np.concatenate(parts), -env.task.observation_limit, env.task.observation_limit)
        # One rounding to float32, whose smallest full-precision number is 1.2e-38, and that of 1 / scale.
        np.testing.assert_allclose(observation, expected, rtol=2e-7, atol=2e-38)
    wild, _ = MAKERS["swing"]().reset(options={"position": 100.0, "velocity": -100.0})
    assert wild.tolist() == [3.0, -3.0]


class Pair(Oscillator):
    """Two bodies in a plane, of which one moves: outputs of shape (2, 2)."""

    name = "pair"

    def _declare(self) -> Iterable[Variable]:
        yield from super()._declare()
        yield Variable("place", "output", "m", (2, 2), "x and y of each body")

    def _outputs(self) -> dict[str, Callable[[], Any]]:
        place = lambda: np.array([[float(self._block["position"]), 1.0], [2.0, -20.0]])  # noqa: E731
        return {**super()._outputs(), "place": place}

    def drawables(self) -> tuple[Points, ...]:
        return (Points("bodies", np.array([[0.0, 0.0], [2.0, 1.0]]), np.array([0.3, 0.2]), "place"),)


class Reach(Swing):
    """The toy's task, which sees an array in a plane."""

    def __init__(self) -> None:
        super().__init__()
        self.observations = {"velocity": 1.0, "place": 4.0, "position": 0.5}


def test_outputs_of_any_shape_are_observed_row_by_row() -> None:
    env = ComponentEnv(Pair(step_size=0.01), Reach(), internal_steps=5, deadline=20, render_mode="rgb_array")
    observation, info = env.reset(seed=3)
    assert env.observation_space.shape == (6,) and info["place"].shape == (2, 2)
    for action in actions(10):
        observation, *_, info = env.step(action)
        x, v = float(info["position"]), float(info["velocity"])
        expected = np.clip([v, x / 4.0, 0.25, 0.5, -5.0, x / 0.5], -3.0, 3.0)
        np.testing.assert_allclose(observation, expected, rtol=2e-7, atol=2e-38)
    picture = env.render()
    # Seen from above: the second body, 1 m higher up and moved by 20 m downwards, has left the picture.
    assert picture.shape == (360, 960, 3) and 0 < (picture[60:] != 255).any(axis=2).sum() < 20_000
    check_env(env, skip_render_check=True)


def test_observations_and_info_are_fresh(make: Callable[..., ComponentEnv]) -> None:
    env = make()
    first, info = env.reset(seed=1)
    kept = first.copy(), {name: np.copy(value) for name, value in info.items()}
    for action in actions(20):
        observation, *_, later = env.step(action)
        assert observation is not first and later is not info
    np.testing.assert_array_equal(first, kept[0])
    for name, value in info.items():
        np.testing.assert_array_equal(value, kept[1][name])
        if isinstance(value, np.ndarray):
            assert value.dtype == np.float64


@pytest.mark.parametrize("beyond", [1.5, 1e30, -7.0])
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
        [math.inf],
        [-math.inf],
        [],
        [0.1, 0.2],
        0.5,
        [[0.5]],
        ["fast"],
        None,
        [None],
        [1j],
        [[1.0], [1.0, 2.0]],
        {},
        [10**400],
    ],
)
def test_what_is_no_action_is_refused_and_nothing_moves(make: Callable[..., ComponentEnv], action: Any) -> None:
    env = make()
    env.reset(seed=1)
    env.step([0.5])
    before = pickle.dumps(env.save())
    with pytest.raises(ParameterError, match="action"):
        env.step(action)
    assert pickle.dumps(env.save()) == before
    env.step([0.5])


def test_integers_and_lists_are_actions_too(make: Callable[..., ComponentEnv]) -> None:
    env, plain = make(), make()
    env.reset(seed=1)
    plain.reset(seed=1)
    for action in ([1], (0,), np.array([1], dtype=np.int8), [np.float64(0.5)]):
        given, expected = env.step(action), plain.step(np.array(action, dtype=np.float32))
        assert given[0].tobytes() == expected[0].tobytes() and given[1] == expected[1]


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
    transcript(used, actions(50, seed=1))
    for env in (used, fresh):
        env.reset(seed=2)
    assert pickle.dumps(used.save()) == pickle.dumps(fresh.save())
    assert transcript(used, actions(60)) == transcript(fresh, actions(60))


def test_options_give_start_values() -> None:
    env = make_piston(**SMALL)
    _, info = env.reset(options={"velocity": {0: 2.0, -1: -1.0}})
    assert info["velocity"].tolist() == [2.0, *[0.0] * 6, -1.0]
    before = pickle.dumps(env.save())
    for options in ({"velocty": 1.0}, {"velocity": math.nan}, {"seed": 1.0}, {"velocity": [1.0]}, 3, ["velocity"]):
        with pytest.raises(ParameterError):
            env.reset(options=options)  # type: ignore[arg-type]
        assert pickle.dumps(env.save()) == before
    env.step([0.0])


def test_the_deadline_truncates(make: Callable[..., ComponentEnv]) -> None:
    env = make(deadline=7, internal_steps=20)
    env.reset(seed=1)
    ends = [env.step([0.0])[2:4] for _ in range(7)]
    assert ends == [(False, False)] * 6 + [(False, True)]
    assert all(type(flag) is bool for pair in ends for flag in pair)
    with pytest.raises(ParameterError, match="reset"):
        env.step([0.0])


def test_without_a_deadline_nothing_truncates() -> None:
    env = MAKERS["swing"](deadline=None)
    env.reset(seed=1)
    assert not any(env.step([0.0])[3] for _ in range(300))


def test_a_step_before_the_first_reset_is_refused(make: Callable[..., ComponentEnv]) -> None:
    with pytest.raises(ParameterError, match="reset"):
        make().step([0.0])


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


# -- save and restore -------------------------------------------------------------------------------------------------


def test_a_restored_environment_goes_on_with_the_same_bits(make: Callable[..., ComponentEnv]) -> None:
    env, other = make(), make()
    env.reset(seed=3)
    transcript(env, actions(15))
    state = pickle.loads(pickle.dumps(env.save()))
    expected = transcript(env, actions(300, seed=1))
    next_start = env.reset()[0]
    transcript(env, actions(5, seed=2))
    for one in (env, other):
        one.restore(state)
        observation, info = one.observe()
        assert one.observation_space.contains(observation)
        assert info["time"] == one.component.time
        assert transcript(one, actions(300, seed=1)) == expected
        np.testing.assert_array_equal(one.reset()[0], next_start)


def test_a_saved_state_is_not_changed_by_what_follows(make: Callable[..., ComponentEnv]) -> None:
    env = make()
    env.reset(seed=3)
    env.step([0.3])
    state = env.save()
    before = pickle.dumps(state)
    transcript(env, actions(20))
    env.restore(state)
    transcript(env, actions(20, seed=5))
    env.reset(seed=8)
    assert pickle.dumps(state) == before


def test_foreign_states_are_refused() -> None:
    env, force, longer = make_piston(**SMALL), make_protection(**SMALL), make_piston(grains=9)
    for one in (env, force, longer):
        one.reset(seed=1)
    before = pickle.dumps(env.save())
    for state in (force.save(), longer.save(), env.component.save(), None, 3):
        with pytest.raises(ParameterError):
            env.restore(state)  # type: ignore[arg-type]
    assert pickle.dumps(env.save()) == before
