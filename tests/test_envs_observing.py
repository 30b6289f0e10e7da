"""What an agent sees and what its action does: sensors, noise, rate, delay, randomisation; and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from support.env_toys import SMALL, actions, transcript

from granular_env.components.errors import ParameterError
from granular_env.components.support.counter_random import normal, stream_key
from granular_env.domains.chain.tasks.piston import make_piston
from granular_env.domains.chain.tasks.protection import make_protection

PRESSED = {"grains": 6, "deadline": 50, "chain": {"precompression": 20.0}}


def shaken(**options: Any) -> make_protection:
    env = make_protection(clock=0, **{**PRESSED, **options})
    env.reset(seed=3)
    transcript(env, actions(20, seed=2))
    return env


# -- sensors ------------------------------------------------------------------------------------------------------------


def test_sensors_read_what_the_component_says() -> None:
    places = {"velocity": [0, -1, 2], "displacement": 4, "force": [1, 2], "contact_force": [-1, 1, 2], "wall_force": "right"}
    env = shaken(observe=places)
    observation, _ = env.observe()
    chain = env.component
    velocity, force = chain.get("velocity") / 10.0, chain.get("contact_force") / 500.0
    expected = [
        *velocity[[0, 5, 2]], chain.get("displacement")[4] / 1e-3, 0.5 * (force[1] + force[2]), 0.5 * (force[2] + force[3]),
        *force[[6, 1, 2]], -chain.get("right_wall_force") / 500.0,
    ]  # fmt: skip
    # A factor 1 / scale and a rounding to float32.
    np.testing.assert_allclose(observation, expected, rtol=2e-7)
    assert env.observation_space.shape == (len(expected),) and np.count_nonzero(observation) > 5


@pytest.mark.parametrize("law", [{"name": "viscous", "dissipation": 1.0}, {"name": "elastic_plastic", "yield_pressure": 1e9}])
def test_forces_include_dissipation_and_history(law: dict[str, Any]) -> None:
    env = make_protection(
        clock=0, grains=5, chain={"law": law}, observe={"contact_force": range(1, 6), "wall_force": ["right"]}, deadline=None
    )
    env.reset(seed=1)
    transcript(env, np.full((60, 1), 0.5, np.float32))
    observation, _ = env.observe()
    np.testing.assert_allclose(observation[:5], env.component.get("contact_force")[1:] / 500.0, rtol=2e-7)
    assert observation[5] == observation[4] > 0.0


def test_the_full_state_is_every_grains_displacement_and_velocity() -> None:
    full, chosen = shaken(), shaken(observe={"displacement": range(6), "velocity": list(range(6))})
    np.testing.assert_array_equal(full.observe()[0], chosen.observe()[0])


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        ({"velocty": [0]}, "did you mean 'velocity'"),
        ({"velocity": [8]}, "-8 to 7"),
        ({"velocity": [-9]}, "-8 to 7"),
        ({"velocity": [1.5]}, "whole numbers"),
        ({"velocity": [True]}, "whole numbers"),
        ({"velocity": [0, -8]}, "once"),
        ({"velocity": None}, "list of places"),
        ({"contact_force": [9]}, "-9 to 8"),
        ({"contact_force": [0]}, "left is .*so there is no contact left of grain 0"),
        ({"wall_force": ["left"]}, "has no wall"),
        ({"wall_force": ["top"]}, '"left" or "right"'),
        ({"velocity": []}, "at least one"),
        ({}, "at least one"),
        ("everything", '"full"'),
        (3, '"full"'),
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
    transcript(twin, actions(21, seed=2))
    assert (env.observe()[0] != blurred).all() and (twin.observe()[0] != env.observe()[0]).all()


def test_noise_has_the_moments_of_a_normal_distribution() -> None:
    env = make_protection(clock=0, grains=64, noise=0.5, deadline=None)
    seen = [env.reset(seed=seed)[0] for seed in range(200)]
    drawn = np.concatenate(seen).astype(float) / 0.5
    count = len(drawn)
    assert count == 25600
    # Four standard errors of mean, variance, third and fourth moment; twelve uniform numbers have the fourth moment 2.9.
    assert abs(drawn.mean()) < 4.0 / math.sqrt(count)
    assert abs(drawn.var() - 1.0) < 4.0 * math.sqrt(2.0 / count)
    assert abs((drawn**3).mean()) < 4.0 * math.sqrt(15.0 / count)
    assert abs((drawn**4).mean() - 2.9) < 4.0 * math.sqrt(96.0 / count)
    assert abs(drawn).max() <= 6.0
    # Neighbours in place and in time know nothing of each other.
    for one, other in ((np.array(seen)[:, 1:], np.array(seen)[:, :-1]), (np.array(seen)[1:], np.array(seen)[:-1])):
        assert abs(np.corrcoef(one.ravel(), other.ravel())[0, 1]) < 4.0 / math.sqrt(count)


def test_the_noise_is_what_whole_numbers_say() -> None:
    """The same sums in Python's own integers: nothing is rounded, so every machine has these bits."""
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


def test_noise_is_clipped_with_the_observation() -> None:
    env = make_protection(clock=0, **SMALL, noise=100.0)
    assert np.abs(env.reset(seed=1)[0]).max() == env.task.observation_limit


@pytest.mark.parametrize("noise", [-1.0, math.nan, "much"])
def test_noise_that_is_none_is_refused(noise: Any) -> None:
    with pytest.raises(ParameterError, match="noise"):
        make_protection(clock=0, **SMALL, noise=noise)


# -- the actuator -------------------------------------------------------------------------------------------------------


def applied(env: make_protection | make_piston, commands: list[float]) -> list[float]:
    (name,) = env.task.actions
    return [env.step([command])[4][name] / env.task.actions[name] for command in commands]


def test_info_tells_what_was_applied() -> None:
    env = make_protection(clock=0, **SMALL)
    assert env.reset(seed=1)[1]["left_force"] == 0.0
    assert applied(env, [0.5, 7.0, -7.0]) == [0.5, 1.0, -1.0]
    assert env.component.get("left_force") == -500.0


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


def test_rate_and_delay_begin_where_the_piston_is() -> None:
    env = make_piston(**SMALL, control_delay=1, action_rate=0.1)
    info = env.reset(options={"velocity": {0: 5.0}})[1]
    assert info["left_velocity"] == 5.0
    assert applied(env, [0.0, 0.0, 0.0]) == [0.5, 0.4, 0.30000000000000004]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"action_rate": 0.0}, "action_rate"),
        ({"action_rate": -1.0}, "action_rate"),
        ({"action_rate": math.nan}, "action_rate"),
        ({"control_delay": -1}, "control_delay"),
        ({"control_delay": 1.5}, "control_delay"),
        ({"control_delay": 10**9}, "control_delay"),
        ({"info": "all"}, "info"),
    ],
)
def test_actuators_that_are_none_are_refused(options: dict[str, Any], words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        make_protection(clock=0, **SMALL, **options)


def test_a_wrong_shape_is_told_with_both_shapes() -> None:
    env = make_protection(clock=0, **SMALL)
    env.reset(seed=1)
    with pytest.raises(ParameterError, match=r"got shape \(2,\), expected shape \(1,\)"):
        env.step([0.0, 0.0])


def test_a_refused_step_leaves_the_actuator_as_it_was() -> None:
    env = make_protection(clock=0, grains=3, action_scale=1e6, control_delay=1)
    env.reset(seed=1)
    terminated, before = False, env.save()
    while not terminated:
        before = env.save()
        _, reward, terminated, _, info = env.step([1.0])
    assert reward == -10.0 and "limit" in info["step_error"]
    assert env.save().snapshot.data == before.snapshot.data
    changed = np.flatnonzero(np.frombuffer(env.save().episode) != np.frombuffer(before.episode))
    assert changed.tolist() == [1], "only that the episode is over"


# -- info ---------------------------------------------------------------------------------------------------------------


def test_brief_infos_leave_out_the_grains() -> None:
    full, brief = shaken().observe()[1], shaken(info="brief").observe()[1]
    assert full.keys() - brief.keys() == {"displacement", "velocity"}
    assert all(full[name] == value for name, value in brief.items())


# -- randomisation --------------------------------------------------------------------------------------------------------


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


def test_draws_fill_their_range_evenly() -> None:
    env = make_protection(clock=0, grains=2, randomise={"precompression": (10.0, 20.0)})
    drawn = [env.reset(seed=seed)[1]["drawn_precompression"] for seed in range(300)]
    # The mean of 300 even draws has a standard error of 10 / sqrt(12 * 300) = 0.17.
    assert abs(np.mean(drawn) - 15.0) < 0.7 and min(drawn) < 10.5 and max(drawn) > 19.5


def test_each_grain_may_have_its_own_radius() -> None:
    env = make_protection(clock=0, grains=5, randomise={"radius": {"low": 2e-3, "high": 3e-3}})
    radii = []
    for seed in (0, 1):
        told = env.reset(seed=seed)[1]["drawn_radius"]
        assert told.tolist() == env.component.geometry.radius.tolist()
        radii += told.tolist()
    assert len(set(radii)) == 10 and min(radii) >= 2e-3 and max(radii) <= 3e-3


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
        ({"grains": (3, 5)}, "nothing that can be drawn"),
        ({"law": ("hertz", "power")}, "nothing that can be drawn"),
        ({"radius": 1.0}, r"\(low, high\)"),
        ({"radius": (2.0, 1.0)}, "low <= high"),
        ({"radius": (-2.0, -1.0)}, "radius"),
        ({"radius": (math.nan, 1.0)}, "radius"),
        ({"velocity": {9: (0.0, 1.0)}}, "-8 to 7"),
        ({"velocity": {0: (0.0, 1.0), -8: (0.0, 1.0)}}, "once"),
        ({"seed": 3}, "nothing that can be drawn"),
        ({"radius": {"low": 1e-3}}, "keys low, high"),
        (3, "randomise"),
    ],
)
def test_draws_that_are_none_are_refused(randomise: Any, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        make_protection(clock=0, **SMALL, randomise=randomise)
