"""The options of environments: sensors, noise, actuators, clocks, holds, and sampled components."""

from __future__ import annotations

import math
import pickle
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from support.env_toys import MAKERS, SMALL, random_actions, state_parts, transcript

import granular_env.envs  # noqa: F401 - registers the environments
from granular_env.components.chain import Chain
from granular_env.components.errors import ParameterError
from granular_env.components.support.counter_random import normal, stream_key
from granular_env.domains.chain.tasks import ENVIRONMENTS
from granular_env.domains.chain.tasks.piston import make_piston
from granular_env.domains.chain.tasks.protection import make_protection
from granular_env.recording import open_log, record, verify

PRESSED = {"grains": 6, "deadline": 50, "chain": {"precompression": 20.0}}
DRAWN: dict[str, Any] = {"randomise": {"radius": (2e-3, 3e-3)}}


def shaken(**options: Any) -> make_protection:
    env = make_protection(clock=0, **{**PRESSED, **options})
    env.reset(seed=3)
    transcript(env, random_actions(20, seed=2))
    return env


# -- sensors ------------------------------------------------------------------------------------------------------------


def test_sensors_read_what_the_component_says() -> None:
    places = {"velocity": [0, -1, 2], "displacement": 4, "contact_force": [-1, 1, 2], "right_wall_force": "all"}
    env = shaken(observe=places)
    observation, _ = env.observe()
    chain = env.component
    velocity, force = chain.get("velocity") / 10.0, chain.get("contact_force") / 500.0
    expected = [
        *velocity[[0, 5, 2]], chain.get("displacement")[4] / 1e-3, *force[[6, 1, 2]], chain.get("right_wall_force") / 500.0,
    ]  # fmt: skip
    # Rounding of the factor 1 / scale, and rounding to float32.
    np.testing.assert_allclose(observation, expected, rtol=2e-7)
    assert env.observation_space.shape == (len(expected),) and np.count_nonzero(observation) > 5


def test_any_component_has_the_same_options() -> None:
    """Return a toy that observes only its position, with noise and clock; force delayed and limited; mass sampled."""
    options: dict[str, Any] = {
        "observe": {"position": "all"}, "noise": 0.1, "clock": 2, "control_delay": 1, "action_rate": 0.25,
        "randomise": {"mass": (1.0, 2.0), "velocity": (3.0, 4.0)}, "info": "full",
    }  # fmt: skip
    env = MAKERS["swing"](**options)
    observation, info = env.reset(seed=1)
    assert observation.shape == (3,) and 1.0 <= info["drawn_mass"] == env.component.parameters.mass <= 2.0
    assert 3.0 <= info["velocity"] <= 4.0 and observation[0] != np.float32(info["position"] / 0.5)
    assert [env.step([1.0])[4]["force"] for _ in range(4)] == [0.0, 0.5, 1.0, 1.5]
    state = env.save()
    expected = transcript(env, random_actions(10))
    other = MAKERS["swing"](**options)
    other.restore(pickle.loads(pickle.dumps(state)))
    assert transcript(other, random_actions(10)) == expected


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        ({"velocty": [0]}, "did you mean 'velocity'"),
        ({"velocity": [8]}, "-8"),
        ({}, "at least one"),
    ],
)
def test_sensors_that_are_not_there_are_refused(choice: Any, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        make_protection(clock=0, **SMALL, observe=choice)


# -- noise --------------------------------------------------------------------------------------------------------------


def test_noise_is_a_function_of_seed_step_and_reading() -> None:
    env, twin, quiet = shaken(noise=0.1), shaken(noise=0.1), shaken()
    np.testing.assert_array_equal(env.observe()[0], env.observe()[0])
    np.testing.assert_array_equal(env.observe()[0], twin.observe()[0])
    blurred, clear = env.observe()[0], quiet.observe()[0]
    assert (blurred != clear).all() and env.component.save().data == quiet.component.save().data
    env.step([0.0])
    twin.reset(seed=4)
    transcript(twin, random_actions(21, seed=2))
    assert (env.observe()[0] != blurred).all() and (twin.observe()[0] != env.observe()[0]).all()


def test_noise_has_the_moments_of_a_normal_distribution() -> None:
    env = make_protection(clock=0, grains=64, noise=0.5, deadline=None)
    seen = [env.reset(seed=seed)[0] for seed in range(200)]
    drawn = np.concatenate(seen).astype(float) / 0.5
    count = len(drawn)
    assert count == 25600
    # Four standard errors of mean, variance, third and fourth moment; the sum of twelve uniform numbers has fourth moment 2.9.
    assert abs(drawn.mean()) < 4.0 / math.sqrt(count)
    assert abs(drawn.var() - 1.0) < 4.0 * math.sqrt(2.0 / count)
    assert abs((drawn**3).mean()) < 4.0 * math.sqrt(15.0 / count)
    assert abs((drawn**4).mean() - 2.9) < 4.0 * math.sqrt(96.0 / count)
    assert abs(drawn).max() <= 6.0
    # Neighbours in place and in time are uncorrelated.
    for one, other in ((np.array(seen)[:, 1:], np.array(seen)[:, :-1]), (np.array(seen)[1:], np.array(seen)[:-1])):
        assert abs(np.corrcoef(one.ravel(), other.ravel())[0, 1]) < 4.0 / math.sqrt(count)


def test_the_noise_is_what_whole_numbers_say() -> None:
    """The same sums in Python integers, without rounding, so that the bits are the same on every machine."""
    golden, modulus = 0x9E3779B97F4A7C15, 2**64

    def mixed(word: int) -> int:
        word = (word ^ (word >> 30)) * 0xBF58476D1CE4E5B9 % modulus
        word = (word ^ (word >> 27)) * 0x94D049BB133111EB % modulus
        return word ^ (word >> 31)

    key = mixed((mixed((7 + golden) % modulus) + 3 * golden) % modulus)
    for index in range(5):
        words = [mixed((key + (3 * index + place) * golden) % modulus) for place in (1, 2, 3)]
        total = sum(word >> shift & 0xFFFF for word in words for shift in (0, 16, 32, 48))
        with np.errstate(over="ignore"):
            assert normal(stream_key(7, 3), index) == (total - 12 * 32767.5) / 65536


# -- the actuator -------------------------------------------------------------------------------------------------------


def applied(env: make_protection | make_piston, commands: list[float]) -> list[float]:
    (name,) = env.task.actions
    return [env.step([command])[4][name] / env.task.actions[name] for command in commands]


def test_a_rate_limits_each_change() -> None:
    env = make_protection(clock=0, **SMALL, action_rate=0.25)
    env.reset(seed=1)
    assert applied(env, [1.0, 1.0, 0.4, -1.0, 9.0]) == [0.25, 0.5, 0.4, 0.15000000000000002, 0.4]


def test_a_delay_holds_back_each_action() -> None:
    env = make_protection(clock=0, **SMALL, control_delay=2)
    env.reset(seed=1)
    assert applied(env, [0.1, 0.2, 0.3, 0.4]) == [0.0, 0.0, 0.1, 0.2]
    env.reset(seed=1)
    assert applied(env, [0.5]) == [0.0], "nothing is left on its way"


def test_a_refused_step_leaves_the_actuator_as_it_was() -> None:
    env = make_protection(clock=0, grains=3, action_scale=1e6, control_delay=1)
    env.reset(seed=1)
    terminated, before = False, env.save()
    while not terminated:
        before = env.save()
        _, reward, terminated, _, info = env.step([1.0])
    assert reward == -10.0 and "limit" in info["step_error"]
    assert env.save().snapshot.data == before.snapshot.data
    changed = np.flatnonzero(np.frombuffer(env.save().memory) != np.frombuffer(before.memory))
    assert changed.tolist() == [1], "only that the episode is over"


@pytest.mark.parametrize(
    "options",
    [
        {"noise": -1.0},
        {"control_delay": 1.5},
        {"hold": 0},
    ],
)
def test_options_that_are_not_valid_are_refused(options: dict[str, Any]) -> None:
    with pytest.raises(ParameterError, match=next(iter(options))):
        make_protection(**{**SMALL, **options})


# -- time ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("maker", sorted(MAKERS))
def test_the_clock_tells_the_time_and_makes_the_deadline_an_end(maker: str) -> None:
    env, without = MAKERS[maker](deadline=6, internal_steps=20, clock=3), MAKERS[maker](deadline=6, internal_steps=20, clock=0)
    size = without.observation_space.shape[0]
    assert env.observation_space.shape == (size + 3,)
    assert env.observation_space.high[size:].tolist() == [1.0] * 3 == (-env.observation_space.low[size:]).tolist()
    observation, _ = env.reset(seed=1)
    expected, _ = without.reset(seed=1)
    for elapsed in range(7):
        times = [math.cos(math.pi * k * elapsed / 6) for k in (1, 2, 3)]
        np.testing.assert_allclose(observation[size:], times, atol=1e-6)
        np.testing.assert_array_equal(observation[:size], expected)
        if elapsed < 6:
            observation, reward, terminated, truncated, _ = env.step([0.1])
            expected, same, _, cut, _ = without.step([0.1])
            assert reward == same and (terminated, truncated, cut) == (elapsed == 5, False, elapsed == 5)


@pytest.mark.parametrize("maker", sorted(MAKERS))
def test_a_held_action_is_that_action_for_several_control_steps(maker: str) -> None:
    env, single = MAKERS[maker](deadline=30, hold=12), MAKERS[maker](deadline=30)
    env.reset(seed=1)
    single.reset(seed=1)
    for action, count in ((0.5, 12), (-0.2, 12), (0.7, 6)):
        observation, reward, terminated, truncated, info = env.step([action])
        rewards = []
        for _ in range(count):
            seen, gained, over, cut, told = single.step([action])
            rewards.append(float(gained))
        np.testing.assert_array_equal(observation, seen)
        assert reward == sum(rewards) and (terminated, truncated) == (over, cut)
        assert info["time"] == told["time"]
    assert truncated


def test_rates_and_delays_count_control_steps_while_an_action_is_held() -> None:
    arguments = {"grains": 5, "action_rate": 0.1, "control_delay": 2, "noise": 0.1}
    env, single = make_piston(hold=3, **arguments), make_piston(**arguments)
    for one in (env, single):
        one.reset(seed=1)
    for action in (1.0, -1.0):
        told = env.step([action])
        for _ in range(3):
            expected = single.step([action])
        np.testing.assert_array_equal(told[0], expected[0])
        assert told[4]["left_velocity"] == expected[4]["left_velocity"]


# If the reward depends on the time, the agent observes it.
TIMED = {"PulseForming", "Protection", "EnergyDelivery", "SolitonTrain"}


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_the_clock_is_on_where_the_goal_has_a_time(name: str) -> None:
    env, short = gymnasium.make(name), name.rpartition("/")[2].partition("-")[0]
    timed = short in TIMED
    assert (env.unwrapped.clock > 0) == timed
    steps = int(env.unwrapped.deadline)
    assert env.spec.max_episode_steps is None and env.spec.reward_threshold is not None
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env.reset(seed=1)
        for count in range(steps):
            _, _, terminated, truncated, _ = env.step([0.0])
            assert (terminated or truncated) == (count == steps - 1)
        env.reset()
    assert (terminated, truncated) == (timed, not timed), "one flag, and the environment's own"


@pytest.mark.parametrize("deadline", [45, 703])
def test_an_episode_lasts_to_whichever_deadline_was_given(deadline: int) -> None:
    name, made = "granular_env/Protection-v1", dict[str, Any](grains=4, deadline=deadline)
    env = gymnasium.make(name, **made)
    assert gymnasium.make(env.spec).spec == env.spec
    env.reset(seed=1)
    assert [env.step([0.0])[2:4] for _ in range(deadline)] == [(False, False)] * (deadline - 1) + [(True, False)]
    for mode in ("sync", "vector_entry_point"):
        batch = gymnasium.make_vec(name, 2, vectorization_mode=mode, **made)
        batch.reset(seed=1)
        ends = [batch.step(np.zeros((2, 1)))[2:4] for _ in range(deadline)]
        assert [terminated.all() for terminated, _ in ends].index(True) == deadline - 1
        assert not any(truncated.any() for _, truncated in ends)


def test_without_a_deadline_an_episode_does_not_end() -> None:
    made: dict[str, Any] = {"grains": 4, "deadline": None}
    env = gymnasium.make("granular_env/Protection-v1", **made)
    batch = gymnasium.make_vec("granular_env/Protection-v1", 2, **made)
    env.reset(seed=1)
    batch.reset(seed=1)
    assert not any(any(env.step([0.0])[2:4]) for _ in range(1500))
    assert not any(np.any(batch.step(np.zeros((2, 1)))[2:4]) for _ in range(1500))


def test_a_clock_needs_a_deadline() -> None:
    with pytest.raises(ParameterError, match="the environment has no deadline"):
        make_protection(grains=4, deadline=None, clock=2)
    assert make_protection(grains=4, deadline=None).clock == 0


# -- sampling -----------------------------------------------------------------------------------------------------------


def test_the_seed_of_the_reset_decides_the_chain_and_each_episode_has_its_own() -> None:
    env = make_protection(clock=0, grains=4, randomise={"contact_stiffness": (1e9, 2e9), "radius": (2e-3, 3e-3)})
    drawn = []
    for seed in (0, 1, None, 0, None):
        info = env.reset(seed=seed)[1]
        drawn.append((info["drawn_radius"], info["drawn_contact_stiffness"]))
        assert drawn[-1] == (env.component.get("radius"), env.component.get("contact_stiffness"))
        assert env.step([0.5])[4]["drawn_radius"] == drawn[-1][0]
    assert drawn[0] == drawn[3] and len(set(drawn[:3])) == 3 and drawn[4] not in drawn[:4]
    assert all(2e-3 <= radius <= 3e-3 and 1e9 <= stiffness <= 2e9 for radius, stiffness in drawn)


def test_a_distribution_of_the_component_gets_a_seed_for_each_episode() -> None:
    env = make_protection(clock=0, grains=5, randomise={"radius": {"low": 2e-3, "high": 3e-3}})
    radii, seeds = [], []
    for seed in (0, 1):
        seeds.append(env.reset(seed=seed)[1]["drawn_radius_seed"])
        radii += env.component.geometry.radius.tolist()
    assert len(set(radii)) == 10 and min(radii) >= 2e-3 and max(radii) <= 3e-3 and seeds[0] != seeds[1]


def test_impacts_are_drawn_for_each_episode() -> None:
    env = make_protection(clock=0, **SMALL, randomise={"velocity": {0: (1.0, 2.0), -1: (-3.0, -2.0)}})
    starts = [env.reset(seed=1)[1]["velocity"], env.reset()[1]["velocity"], env.reset(seed=1)[1]["velocity"]]
    for start in starts:
        assert 1.0 <= start[0] <= 2.0 and -3.0 <= start[-1] <= -2.0 and not start[1:-1].any()
    assert starts[0].tolist() == starts[2].tolist() != starts[1].tolist()
    assert env.reset(options={"velocity": 0.5})[1]["velocity"].tolist() == [0.5] * 8


@pytest.mark.parametrize(
    ("randomise", "words"),
    [
        ({"raduis": (1.0, 2.0)}, "did you mean 'radius'"),
        ({"grains": (3, 5)}, "changes the size"),
        ({"radius": (2.0, 1.0)}, "low <= high"),
        ({"velocity": {9: (0.0, 1.0)}}, "-8 to 7"),
    ],
)
def test_draws_that_are_none_are_refused(randomise: Any, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        make_protection(clock=0, **SMALL, randomise=randomise).reset()


@pytest.mark.parametrize("vectoriser", ["sync", pytest.param("async", marks=pytest.mark.slow)])
def test_every_vectoriser_draws_the_same_chains(vectoriser: str) -> None:
    def radii(mode: str) -> list[list[float]]:
        made = {"grains": 6, "deadline": 24, **DRAWN}
        env = gymnasium.make_vec("granular_env/Protection-v1", 4, vectorization_mode=mode, **made)
        found = [env.reset(seed=0)[1]["drawn_radius"].tolist()]
        for _ in range(26):  # the next episode begins within these steps
            infos = env.step(np.zeros((4, 1), np.float32))[4]
        env.close()
        return [*found, infos["drawn_radius"].tolist()]

    native = radii("vector_entry_point")
    assert len({radius for row in native for radius in row}) == 8 and radii(vectoriser) == native


def test_the_constants_of_the_task_are_those_of_the_chain_that_was_drawn() -> None:
    env = make_piston(grains=5, **DRAWN)
    for seed in range(3):
        fixed = make_piston(grains=5, radius=env.reset(seed=seed)[1]["drawn_radius"])
        assert env.task.constants == fixed.task.constants
        env.reset(seed=seed)
        fixed.reset(seed=seed)
        told, expected = env.step([0.4]), fixed.step([0.4])
        assert told[1] == expected[1] and told[0].tobytes() == expected[0].tobytes()


def test_a_state_carries_the_chain_that_was_drawn() -> None:
    made = {"grains": 6, "deadline": 24}
    env, other, plain = make_protection(**made, **DRAWN), make_protection(**made, **DRAWN), make_protection(**made)
    for one in (env, other, plain):
        one.reset(seed=1)
    env.reset(seed=2)
    state = pickle.loads(pickle.dumps(env.save()))
    other.restore(state)
    assert other.component.identity == env.component.identity
    assert transcript(other, random_actions(20, seed=1)) == transcript(env, random_actions(20, seed=1))
    for one, foreign in ((plain, state), (other, plain.save())):
        before = state_parts(one.save())
        with pytest.raises(ParameterError, match="randomise"):
            one.restore(foreign)
        assert state_parts(one.save()) == before


def test_a_recorded_episode_of_a_drawn_chain_can_be_branched(tmp_path: Path) -> None:
    env, path = make_protection(grains=6, deadline=24, **DRAWN), tmp_path / "episode.mcap"
    env.reset(seed=2)
    with record(env.component, path):
        env.reset(seed=2)
        transcript(env, random_actions(8))
    assert verify(path).identical
    with open_log(path) as log:
        branched = log.branch(8 * env.duration).component
    fresh = make_protection(grains=6, deadline=24, radius=branched.get("radius"))
    fresh.reset(options={"snapshot": branched.save()})
    assert fresh.component.save().data == env.component.save().data


def test_a_recorder_is_not_left_behind_on_the_last_chain(tmp_path: Path) -> None:
    env = make_protection(grains=6, deadline=24, **DRAWN)
    env.reset(seed=1)
    with record(env.component, tmp_path / "one.mcap"):
        env.reset(seed=1)  # the same chain again
        transcript(env, random_actions(5))
        with pytest.raises(ParameterError, match="the same seed"):
            env.reset(seed=2)
    assert verify(tmp_path / "one.mcap").calls == 5


ARRANGED = {
    "dimer": {"name": "dimer", "radius": [3e-3, 1.5e-3]},
}


@pytest.mark.parametrize("arrangement", ARRANGED)
@pytest.mark.parametrize("name", ENVIRONMENTS)
@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
def test_every_task_takes_arranged_grains_and_may_draw_what_they_leave_open(name: str, arrangement: str) -> None:
    chain = {"arrangement": ARRANGED[arrangement]}
    # SolitonTrain allows no precompression, which would change its waves.
    drawn = {"velocity": (0.0, 0.5)} if "Soliton" in name else {"precompression": (5.0, 10.0)}
    env = gymnasium.make(name, grains=65, chain=chain, randomise=drawn, deadline=260)
    expected = Chain(**chain, grains=65).geometry.radius
    for seed in range(2):
        _, info = env.reset(seed=seed)
        assert env.unwrapped.component.geometry.radius.tolist() == expected.tolist()
        assert "precompression" not in drawn or 5.0 <= info["drawn_precompression"] <= 10.0
        for _ in range(5):
            assert np.isfinite(env.step([0.1])[1])
