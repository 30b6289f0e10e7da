"""Copies of environments, batches and components: independent, and bit-equal from there on."""

from __future__ import annotations

import copy
import pickle
import warnings
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from support.env_toys import MAKERS, actions, transcript

import granular_env as ge
from granular_env.components.errors import GranularWarning, ParameterError
from granular_env.domains.chain import ChainVectorEnv
from granular_env.domains.chain.tasks import ENVIRONMENTS
from granular_env.domains.chain.tasks.piston import make_piston
from granular_env.domains.chain.tasks.protection import make_protection
from granular_env.envs import RecordEnv
from granular_env.envs.registration import register_all

register_all()
cloudpickle = pytest.importorskip("cloudpickle")
WAYS: dict[str, Callable[[Any], Any]] = {
    "deepcopy": copy.deepcopy,
    "copy": copy.copy,
    "pickle": lambda one: pickle.loads(pickle.dumps(one)),
    "cloudpickle": lambda one: cloudpickle.loads(cloudpickle.dumps(one)),
}
HARD: dict[str, Any] = {
    "grains": 6, "deadline": 60, "control_delay": 3, "action_rate": 0.3, "noise": 0.05, "hold": 2,
    "randomise": {"radius": {"low": 2.5e-3, "high": 3e-3}, "velocity": (0.0, 1.0)},
}  # fmt: skip


def same_from_here(one: Any, other: Any) -> None:
    """Both get the same, also in the next episode, and neither moves the other."""
    before = other.save().to_bytes()
    expected = transcript(one, actions(20, seed=1))
    assert other.save().to_bytes() == before, "the copy has not moved with the original"
    assert transcript(other, actions(20, seed=1)) == expected
    np.testing.assert_array_equal(other.reset()[0], one.reset()[0])
    assert transcript(other, actions(5)) == transcript(one, actions(5))


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("maker", sorted(MAKERS))
def test_a_copy_in_mid_episode_goes_on_alike(maker: str, way: str) -> None:
    env = MAKERS[maker]()
    env.reset(seed=3)
    transcript(env, actions(7))
    same_from_here(env, WAYS[way](env))


COARSE: dict[str, Any] = {"grains": 6, "step_size": 2e-6, "internal_steps": 1, "deadline": 20}


def cautions_of(call: Callable[[], Any]) -> tuple[Any, list[str]]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = call()
    return found, [str(one.message).split(":")[0][:26] for one in caught if issubclass(one.category, GranularWarning)]


def pushed(env: Any, value: float = 1.0) -> Any:
    env.reset(seed=0)
    for _ in range(4):
        env.step(np.full(env.action_space.shape, value, np.float32))
    return env


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("kind", ["single", "drawn", "batch"])
def test_a_copy_warns_of_nothing_that_was_told(kind: str, way: str) -> None:
    """Neither when it is made, nor when it comes to where the original has been; nor does what a reset draws."""
    makers: dict[str, Callable[[], Any]] = {
        "single": lambda: make_protection(**COARSE),
        "drawn": lambda: make_protection(**COARSE, randomise={"radius": (2.9e-3, 3e-3)}),
        "batch": lambda: ChainVectorEnv(make_protection, 3, **COARSE),
    }
    env, made = cautions_of(makers[kind])
    assert made[-1] == "deadline"
    unwarned = copy.deepcopy(env)
    _, stepped = cautions_of(lambda: pushed(env))
    assert len(made + stepped) == 2 and "contacts get fewer than th" in made + stepped
    assert cautions_of(lambda: pushed(WAYS[way](env)))[1] == []
    # Copies share what they have said, whichever says it first.
    assert cautions_of(lambda: pushed(unwarned))[1] == []


def test_a_copy_of_a_component_warns_of_nothing_that_was_told() -> None:
    chain = ge.make("chain", grains=6, step_size=2e-6)
    chain.reset(velocity={0: 3.0})
    twin = copy.deepcopy(chain)
    assert cautions_of(lambda: chain.step(2e-5))[1] == ["contacts get fewer than th"]
    for one in (twin, chain.clone(), pickle.loads(pickle.dumps(chain))):
        one.reset(velocity={0: 3.0})
        assert cautions_of(lambda one=one: one.step(2e-5))[1] == []
    # One that is made anew is another run.
    other = ge.make("chain", grains=6, step_size=2e-6)
    other.reset(velocity={0: 3.0})
    assert cautions_of(lambda: other.step(2e-5))[1] != []


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_registered_environments_are_copied_with_their_wrappers(name: str, way: str) -> None:
    env = gymnasium.make(name)
    env.reset(seed=3)
    env.step([0.2])
    if way == "copy":  # Gymnasium's wrappers share what they wrap; the environment inside does not
        other = copy.copy(env.unwrapped)
        same_from_here(env.unwrapped, other)
        return
    other = WAYS[way](env)
    assert other.spec == env.spec and other.unwrapped.np_random_seed == 3
    same_from_here(env.unwrapped, other.unwrapped)
    env.step([0.1])
    other.step([0.1])


def test_a_copy_of_what_is_drawn_delayed_and_held_goes_on_alike() -> None:
    env = make_piston(**HARD)
    env.reset(seed=2)
    transcript(env, actions(4))
    same_from_here(env, copy.deepcopy(env))


def test_a_copy_made_before_the_first_reset_has_the_same_future() -> None:
    env = make_piston(**HARD)
    other = copy.deepcopy(env)
    np.testing.assert_array_equal(env.reset()[0], other.reset()[0])


def test_what_the_caller_does_to_its_arguments_later_does_not_count() -> None:
    chain = {"precompression": 10.0}
    env = make_protection(grains=5, chain=chain)
    chain["precompression"] = 20.0
    assert copy.deepcopy(env).component.identity == env.component.identity


@pytest.mark.parametrize("way", WAYS)
def test_a_batch_is_copied_lane_by_lane(way: str) -> None:
    batch = ChainVectorEnv(make_piston, 3, **HARD)
    batch.reset(seed=4)
    for step in range(5):
        batch.step(actions(3, seed=step))
    other = WAYS[way](batch)
    held = [state.to_bytes() for state in other.save()]
    for step in range(30):
        found = batch.step(actions(3, seed=step))
        if step == 0:
            assert [state.to_bytes() for state in other.save()] == held
        expected = other.step(actions(3, seed=step))
        for one, two in zip(found[:4], expected[:4], strict=True):
            np.testing.assert_array_equal(one, two)
    assert other.np_random_seed == batch.np_random_seed


def test_made_batches_are_copied_with_their_spec() -> None:
    batch = gymnasium.make_vec("granular_env/Piston-v1", num_envs=2, grains=5)
    batch.reset(seed=1)
    spaces = ("action_space", "observation_space", "single_action_space", "single_observation_space")
    for space in spaces:
        getattr(batch, space).seed(2)
    other = pickle.loads(pickle.dumps(batch))
    assert other.spec.id == batch.spec.id and other.unwrapped.save() == batch.unwrapped.save()
    for space in spaces:
        np.testing.assert_array_equal(getattr(other, space).sample(), getattr(batch, space).sample())


COMPONENTS: dict[str, Callable[[], Any]] = {
    "chain": lambda: ge.Chain(grains=6, left="piston", precompression=5.0),
    "dimer": lambda: ge.Chain(
        grains=6, arrangement={"name": "dimer", "radius": [3e-3, 2e-3]}, law={"name": "viscous", "dissipation": 0.1}
    ),
    "oscillator": lambda: ge.make("oscillator"),
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", COMPONENTS)
def test_components_are_copied_with_their_state_and_inputs(name: str, way: str) -> None:
    component = COMPONENTS[name]()
    component.reset()
    duration = 50 * component.step_size
    name_of_input = next(v.name for v in component.variables.values() if v.causality == "input")
    component.step(duration, **{name_of_input: ge.Profile.half_sine(0.5, 2 * duration)})
    other = WAYS[way](component)
    before = other.save().to_bytes()
    assert before == component.save().to_bytes()
    component.step(duration)
    assert other.save().to_bytes() == before
    other.step(duration)
    assert other.save().to_bytes() == component.save().to_bytes()


def test_a_recorded_environment_is_not_copied_but_what_is_in_it_is(tmp_path: Any) -> None:
    env = RecordEnv(make_piston(grains=5), tmp_path / "one.mcap")
    env.reset(seed=1)
    for way in ("deepcopy", "pickle"):
        with pytest.raises(ParameterError, match="copy env.unwrapped"):
            WAYS[way](env)
    inner = copy.deepcopy(env.unwrapped)
    env.close()
    same_from_here(env.unwrapped, inner)


@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
def test_used_fresh_copied_and_batched_environments_refuse_the_same_steps() -> None:
    """Pushed beyond what the chain allows: what an environment did before changes no reward, time or message."""
    arguments: dict[str, Any] = {"grains": 12, "action_scale": 1e5}
    used, batch = make_protection(**arguments), ChainVectorEnv(make_protection, 1, **arguments)
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
    """Return reward, end, time and the message of a refusal, for each step until the episode is over."""
    steps = []
    for push in pushes:
        _, reward, over, late, info = env.step(push)
        steps.append((float(reward), bool(over), info["time"], info.get("step_error", "")))
        if over or late:
            break
    return steps
