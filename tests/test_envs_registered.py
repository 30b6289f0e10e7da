"""Requirements on every registered environment of all domains; new environments are tested automatically."""

import copy
import pickle
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from support.env_toys import state_parts

from granular_env.components.errors import GranularWarning
from granular_env.domains import load_environments
from granular_env.envs import ComponentEnv

STEPS = 3


def made(name: str) -> ComponentEnv:
    """Return the unwrapped environment; the tests of its domain cover its cautions."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GranularWarning)
        env = gymnasium.make(name).unwrapped
    assert isinstance(env, ComponentEnv)
    return env


def actions(env: ComponentEnv) -> list[np.ndarray]:
    """Return a few actions of moderate size, equal for equal spaces."""
    random = np.random.default_rng(3)
    return [0.3 * random.uniform(-1.0, 1.0, env.action_space.shape).astype(np.float32) for _ in range(STEPS)]


def rewards_and_state(env: ComponentEnv, moves: list[np.ndarray]) -> tuple[list[float], bytes]:
    """Continue an episode with these actions; return its rewards and final state."""
    return [float(env.step(move)[1]) for move in moves], state_parts(env.save())


@pytest.fixture(scope="module", params=load_environments())
def env(request: pytest.FixtureRequest) -> ComponentEnv:
    return made(request.param)


@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
def test_gymnasium_has_nothing_to_say(env: ComponentEnv) -> None:
    check_env(env, skip_render_check=True)


def test_an_episode_is_repeated_bit_for_bit(env: ComponentEnv) -> None:
    moves, runs = actions(env), []
    for _ in range(2):
        observation, _ = env.reset(seed=5)
        runs.append((observation.tobytes(), rewards_and_state(env, moves)))
    assert runs[0] == runs[1]


def test_a_state_is_restored_in_mid_episode(env: ComponentEnv) -> None:
    first, *rest = actions(env)
    env.reset(seed=5)
    env.step(first)
    state = env.save()
    expected = rewards_and_state(env, rest)
    env.restore(pickle.loads(pickle.dumps(state)))
    assert rewards_and_state(env, rest) == expected


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))], ids=["copy", "pickle"])
def test_a_copy_goes_on_as_the_first_one(env: ComponentEnv, duplicate) -> None:  # noqa: ANN001
    first, *rest = actions(env)
    env.reset(seed=5)
    env.step(first)
    env.action_space.seed(1)
    env.observation_space.seed(1)
    other = duplicate(env)
    for space in ("action_space", "observation_space"):
        assert getattr(other, space).sample().tolist() == getattr(env, space).sample().tolist()
    assert rewards_and_state(other, rest) == rewards_and_state(env, rest)


@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
def test_two_of_a_batch_are_two_single_ones(env: ComponentEnv) -> None:
    moves = actions(env)
    batch = gymnasium.make_vec(env.spec.id, num_envs=2, autoreset_mode="SameStep")
    assert batch.metadata["autoreset_mode"] == gymnasium.vector.AutoresetMode.SAME_STEP
    batch.reset(seed=[5, 6])
    paid = np.array([batch.step(np.stack([move, -move]))[1] for move in moves])
    for place, (seed, sign) in enumerate(((5, 1.0), (6, -1.0))):
        env.reset(seed=seed)
        assert [float(env.step(sign * move)[1]) for move in moves] == paid[:, place].tolist()
    batch.close()
