"""Time in environments: the clock, held actions, deadlines and how they end, Gymnasium's own time limit."""

from __future__ import annotations

import copy
import math
import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from support.env_toys import MAKERS

from granular_env.components.chain import Chain
from granular_env.components.errors import GranularWarning, ParameterError
from granular_env.domains.chain import ChainEnv, ChainTask, ChainVectorEnv
from granular_env.domains.chain.tasks import ENVIRONMENTS
from granular_env.domains.chain.tasks.piston import make_piston
from granular_env.domains.chain.tasks.protection import make_protection
from granular_env.domains.chain.tasks.pulse_forming import make_pulse_forming
from granular_env.domains.chain.tasks.soliton_train import make_soliton_train
from granular_env.envs.policies import Constant, play
from granular_env.envs.registration import register_all

register_all()
# Where the reward speaks of a time, the agent is shown it.
TIMED = {"PulseForming", "Protection", "EnergyDelivery", "SolitonTrain"}


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


def test_a_step_that_breaks_while_it_is_held_keeps_what_went_before() -> None:
    arguments: dict[str, Any] = {"grains": 3, "impulse": 10.0, "action_scale": 2e5, "chain": {"overlap_limit": 0.005}}
    held, single = make_protection(hold=50, **arguments), make_protection(**arguments)
    batch = ChainVectorEnv(make_protection, 1, hold=50, autoreset_mode="Disabled", **arguments)
    for one in (held, single, batch):
        one.reset(seed=1)
    _, reward, terminated, _, info = held.step([1.0])
    total, over = 0.0, False
    while not over:
        _, gained, over, _, told = single.step([1.0])
        total += float(gained)
    assert terminated and info["step_error"] == told["step_error"] and reward == total
    assert batch.step([[1.0]])[1].tolist() == [reward]


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_the_clock_is_on_where_the_goal_has_a_time(name: str) -> None:
    env, short = gymnasium.make(name), name.rpartition("/")[2].partition("-")[0]
    timed = short in TIMED
    assert (env.unwrapped.clock > 0) == timed
    spec, steps = gymnasium.spec(name), int(env.unwrapped.deadline)
    assert spec.max_episode_steps is None and env.spec.max_episode_steps == steps + 1 and spec.reward_threshold is not None
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env.reset(seed=1)
        for count in range(steps):
            _, _, terminated, truncated, _ = env.step([0.0])
            assert (terminated or truncated) == (count == steps - 1)
        env.reset()
    assert (terminated, truncated) == (timed, not timed), "one flag, and the environment's own"


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_gymnasiums_own_clock_works(name: str) -> None:
    env = gymnasium.wrappers.TimeAwareObservation(gymnasium.make(name), normalize_time=True)
    env.reset(seed=1)
    first, second = (env.step([0.0])[0][-1] for _ in range(2))
    assert second == pytest.approx(2 * first) and first > 0.0


@pytest.mark.parametrize("deadline", [45, 703])
def test_an_episode_lasts_to_whichever_deadline_was_given(deadline: int) -> None:
    name, made = "granular_env/Protection-v1", dict[str, Any](grains=4, deadline=deadline)
    env = gymnasium.make(name, **made)
    assert gymnasium.make(env.spec).spec == env.spec and env.spec.max_episode_steps == deadline + 1
    assert gymnasium.make(name, hold=2, **made).spec.max_episode_steps == (deadline + 1) // 2 + 1
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
    assert env.spec.max_episode_steps is None
    env.reset(seed=1)
    batch.reset(seed=1)
    assert not any(any(env.step([0.0])[2:4]) for _ in range(1500))
    assert not any(np.any(batch.step(np.zeros((2, 1)))[2:4]) for _ in range(1500))


def test_a_time_limit_of_the_batch_is_that_of_the_single_environments() -> None:
    made: dict[str, Any] = {"grains": 4, "max_episode_steps": 5, "hold": 2}
    native, sync = (
        gymnasium.make_vec("granular_env/Protection-v1", 3, vectorization_mode=mode, **made)
        for mode in ("vector_entry_point", "sync")
    )
    native.reset(seed=1)
    sync.reset(seed=1)
    for step in range(14):
        action = np.full((3, 1), 0.1 * (step % 3), np.float32)
        for one, other in zip(native.step(action)[:4], sync.step(action)[:4], strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    "arguments", [{"clock": -1}, {"clock": 1.5}, {"clock": True}, {"hold": 0}, {"hold": None}, {"clock": 101}]
)
def test_clocks_and_holds_that_are_none_are_refused(arguments: Any) -> None:
    with pytest.raises(ParameterError, match=next(iter(arguments))):
        make_piston(grains=4, **arguments)


def test_a_clock_needs_a_deadline() -> None:
    with pytest.raises(ParameterError, match="there is no deadline"):
        make_protection(grains=4, deadline=None, clock=2)
    assert make_protection(grains=4, deadline=None).clock == 0


def test_baselines_hold_as_the_environment_does() -> None:
    # Theory's push lasts some 30 control steps. Held for 3 each it is still that push; played three times slower it is not.
    for environment in (make_pulse_forming, make_soliton_train):
        env = environment(hold=3)
        assert play(env, env.task.baselines()["theory"], seed=1)[0] > -0.1
        assert "best" not in env.task.baselines()


# -- deadlines that no wave can meet -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("place", "deadline"), [(60, 50), (16, 60), (40, 160), ([40, 60], 180)])
def test_a_wave_that_would_have_to_be_there_already_is_refused_with_the_least_deadline(place: Any, deadline: int) -> None:
    heights = [5.0] * len(np.atleast_1d(place))
    with pytest.raises(ParameterError, match=r"deadline: .* expected \d+ or more") as caught:
        make_pulse_forming(place=place, amplitude=heights, deadline=deadline)
    least = int(str(caught.value).partition("expected ")[2].partition(" ")[0])
    env = make_pulse_forming(place=place, amplitude=heights, deadline=least)
    assert play(env, Constant(0.0), seed=1)[0] == pytest.approx(-1.0, abs=2e-3), "doing nothing is not paid for"
    with pytest.raises(ParameterError):
        make_pulse_forming(place=place, amplitude=heights, deadline=least - 1)


def test_trains_are_asked_for_in_time() -> None:
    with pytest.raises(ParameterError, match="deadline: .* a wave of 3 m/s"):
        make_soliton_train(deadline=150)
    env = make_soliton_train()
    with pytest.raises(ParameterError, match=r"options.goal: .* a wave of 3 m/s .* to grain 60"):
        env.reset(options={"goal": [[3.0, 60.0]]})
    for seed in range(20):
        assert play(env, Constant(0.0), seed=seed)[0] == pytest.approx(-1.0, abs=2e-3)


@pytest.mark.parametrize("deadline", [250, 400])
@pytest.mark.parametrize("name", ["Protection", "EnergyDelivery", "Absorption", "Piston"])
def test_doing_nothing_earns_nothing_whatever_the_deadline(name: str, deadline: int) -> None:
    env = gymnasium.make(f"granular_env/{name}-v1", deadline=deadline)
    assert play(env, Constant(0.0), seed=1)[0] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(
    ("name", "least", "unit"), [("EnergyDelivery", 197, "J"), ("Protection", 277, "N s")], ids=["energy", "protection"]
)
def test_a_deadline_by_which_too_little_arrives_is_cautioned(name: str, least: int, unit: str) -> None:
    """Nothing that is held back arrives sooner than the full drive from the first moment on."""
    with pytest.warns(GranularWarning, match=f"deadline: {least - 1} control steps .* {unit} of the wanted"):
        gymnasium.make(f"granular_env/{name}-v1", deadline=least - 1)
    with warnings.catch_warnings():
        warnings.simplefilter("error", GranularWarning)
        gymnasium.make(f"granular_env/{name}-v1", deadline=least)


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("Piston-v1", {}), ("PulseForming-v1", {}), ("Protection-v1", {}), ("Absorption-v1", {}), ("EnergyDelivery-v1", {}),
        ("SolitonTrain-v1", {}), ("Splitting-v1", {}), ("BuriedTarget-v1", {}), ("Relief-v1", {}),
        ("EnergyDelivery-v1", {"action": "piston"}), ("Absorption-v1", {"action": "force"}),
        ("Protection-v1", {"chain": {"arrangement": {"name": "dimer", "radius": [3e-3, 1.5e-3]}}}),
        ("Splitting-v1", {"columns": 200, "target": 100}), ("BuriedTarget-v1", {"target": (0.0, -0.15)}),
    ],
)  # fmt: skip
def test_a_deadline_before_the_first_arrival_is_refused_with_the_least_one(name: str, arguments: dict[str, Any]) -> None:
    with pytest.raises(ParameterError, match=r"deadline: got 3 control steps of .*, expected \d+ or more, because") as caught:
        gymnasium.make(f"granular_env/{name}", deadline=3, **arguments)
    least = int(str(caught.value).partition("expected ")[2].partition(" ")[0])
    with pytest.raises(ParameterError, match=f"expected {least} or more"):
        gymnasium.make(f"granular_env/{name}", deadline=least - 1, **arguments)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GranularWarning)  # too little may arrive
        assert gymnasium.make(f"granular_env/{name}", deadline=least, **arguments).unwrapped.deadline == least


# -- what an environment cannot do -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"amplitude": [5.0, 5.0], "place": [40, 40]}, "lie over each other"),
        ({"amplitude": [5.0, 4.0], "place": [40, 38]}, "lie over each other"),
        ({"place": 0, "deadline": 50}, "place: a wave at grain 0 hangs over the end"),
        ({"place": 63, "deadline": 300}, "place: a wave at grain 63 hangs over the end"),
    ],
)
def test_waves_that_no_chain_can_hold_are_refused(arguments: Any, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        make_pulse_forming(**arguments)


def test_trains_that_no_chain_can_hold_are_refused() -> None:
    env = make_soliton_train()
    for goal, words in (([[3.0, 30.0], [6.0, 29.0]], "lie over each other"), ([[3.0, 0.0]], "hangs over the end")):
        with pytest.raises(ParameterError, match=f"options.goal: .*{words}"):
            env.reset(options={"goal": goal})
    env.reset(options={"goal": [[3.0, 20.0], [5.0, 40.0]]})
    with pytest.raises(ParameterError, match="spacing"):
        make_soliton_train(spacing=(1.0, 4.0))
    with pytest.raises(ParameterError, match="front: .* hangs over the end"):
        make_soliton_train(spacing=(18.0, 18.0), front=(36.0, 40.0))


@pytest.mark.parametrize("name", ["deadline", "hold", "clock", "internal_steps", "info", "noise", "observe", "randomise"])
def test_options_that_are_read_once_cannot_be_set_later(name: str) -> None:
    env = gymnasium.make("granular_env/Protection-v1", grains=4).unwrapped
    with pytest.raises(ParameterError, match=f"{name}: .*make another one with {name}="):
        setattr(env, name, getattr(env, name, 1))
    env.step_error_reward = -3.0
    assert copy.deepcopy(env).deadline == env.deadline == 700


@pytest.mark.parametrize("name", ["amplitude", "place", "grains", "action_scale", "step_size", "chain"])
def test_arguments_of_a_task_cannot_be_set_later(name: str) -> None:
    """Nothing reads them any more: the agent would go on with the old goal."""
    env = gymnasium.make("granular_env/PulseForming-v1").unwrapped
    with pytest.raises(ParameterError, match=f"{name}: .*make another one with {name}="):
        setattr(env, name, 3.0)


def test_attributes_of_ones_own_can_be_set() -> None:
    class Counting(ChainEnv):
        def __init__(self, component: Chain, task: ChainTask, bonus: float = 1.0) -> None:
            super().__init__(component, task)
            self.bonus = bonus

    given = make_pulse_forming()
    env = Counting(given.component, given.task, bonus=2.0)
    env.bonus, env.label = 3.0, "mine"  # type: ignore[attr-defined]
    assert env.bonus == 3.0 and copy.deepcopy(env).bonus == 2.0


def test_a_hold_beyond_the_deadline_is_refused() -> None:
    with pytest.raises(ParameterError, match="hold: got 11, expected at most the deadline of 10"):
        make_piston(grains=4, hold=11, deadline=10)
    make_piston(grains=4, hold=10, deadline=10)
