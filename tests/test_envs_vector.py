"""The native batch against Gymnasium's SyncVectorEnv of the single environment: equal in every bit."""

from __future__ import annotations

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from granular_env.components.errors import GranularWarning, ParameterError
from granular_env.domains.chain import ChainEnv, ChainVectorEnv
from granular_env.domains.chain.tasks.piston import PistonTask, make_piston
from granular_env.domains.chain.tasks.protection import ProtectionTask, make_protection
from granular_env.domains.chain.tasks.pulse_forming import make_pulse_forming
from granular_env.envs.registration import register_all
from granular_env.recording import record, verify

register_all()
COUNT = 4
MODES = list(AutoresetMode)

# What is tried: the environment, and arguments that differ from one to the other or not.
CASES: dict[str, tuple[type[ChainEnv], dict[str, Any]]] = {
    "force": (make_protection, {"grains": 6, "deadline": 8, "internal_steps": 40, "impulse": 1e-3, "clock": 0}),
    "clock": (make_protection, {"grains": 6, "deadline": 8, "internal_steps": 40, "impulse": 1e-3, "clock": 3}),
    "held": (make_piston, {"grains": 5, "deadline": 20, "internal_steps": 13, "hold": 3, "control_delay": 2, "noise": 0.1}),
    "held with a clock": (
        make_pulse_forming,
        {"grains": 9, "amplitude": 3.0, "place": 3, "deadline": 40, "hold": 7, "randomise": {"radius": (2.9e-3, 3e-3)}},
    ),
    "piston": (make_piston, {"grains": 5, "deadline": 8, "internal_steps": 30}),
    "sensors": (
        make_protection,
        {
            "clock": 0,
            "grains": 5,
            "deadline": 8,
            "internal_steps": 40,
            "impulse": 1e-3,
            "observe": {"velocity": [0, -1, 3], "force": [2, 3], "contact_force": [-1], "wall_force": ["right"]},
            "noise": 0.02,
        },
    ),
    "slow actuator": (
        make_piston,
        {"grains": 4, "deadline": 14, "internal_steps": 20, "action_rate": 0.3, "control_delay": 3, "noise": 0.1},
    ),
    "drawn": (
        make_protection,
        {
            "clock": 0,
            "grains": 6,
            "deadline": 7,
            "internal_steps": 30,
            "chain": {"law": {"name": "viscous", "dissipation": 0.5}},
            "randomise": {"radius": (2e-3, 3e-3), "contact_stiffness": (1e9, 2e9), "velocity": (0.0, 3.0)},
            "impulse": 1e-3,
        },
    ),
    "each grain drawn": (
        make_piston,
        {
            "grains": 6,
            "deadline": 9,
            "internal_steps": 30,
            "randomise": {"radius": {"low": 2e-3, "high": 3e-3}, "velocity": {1: (0.0, 2.0)}},
        },
    ),
    "plastic": (
        make_protection,
        {
            "clock": 0,
            "grains": 5,
            "deadline": 8,
            "internal_steps": 40,
            "impulse": 1e-3,
            "chain": {"law": {"name": "elastic_plastic", "yield_pressure": 1e9}, "integrator": "leapfrog"},
        },
    ),
    "refused": (
        make_protection,
        {
            "grains": 3,
            "deadline": 5,
            "impulse": 10.0,
            "clock": 0,
            "hold": 2,
            "action_scale": 2e5,
            "chain": {"overlap_limit": 0.005},
        },
    ),
}
EPISODES = -(-1000 // (len(CASES) * len(MODES)))


def pair(case: str, mode: AutoresetMode, info: str) -> tuple[ChainVectorEnv, SyncVectorEnv]:
    maker, arguments = CASES[case]
    arguments = {**arguments, "info": info}
    native = ChainVectorEnv(maker, COUNT, autoreset_mode=mode, **arguments)
    makers = [lambda: maker(**arguments) for _ in range(COUNT)]
    return native, SyncVectorEnv(makers, autoreset_mode=mode)


def same(found: Any, expected: Any, where: str = "") -> None:
    """Equal in value, type, shape and bits."""
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


def play(native: ChainVectorEnv, sync: SyncVectorEnv, episodes: int, seed: int) -> int:
    """Random actions to both until so many episodes are over; returns how many there were."""
    shape = (native.num_envs, 1)
    generator, over, disabled = np.random.default_rng(seed), 0, native.autoreset_mode == AutoresetMode.DISABLED
    same(native.reset(seed=seed), sync.reset(seed=seed))
    bias = generator.uniform(-0.3, 0.8, shape)
    while over < episodes:
        actions = (bias + generator.normal(0.0, 0.5, shape)).astype(np.float32)
        found, expected = native.step(actions), sync.step(actions)
        same(found, expected)
        ended = expected[2] | expected[3]
        over += int(ended.sum())
        if disabled and ended.any():
            same(native.reset(options={"reset_mask": ended.copy()}), sync.reset(options={"reset_mask": ended.copy()}))
    return over


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("case", sorted(CASES))
@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
def test_a_batch_gives_what_single_environments_give(case: str, mode: AutoresetMode) -> None:
    seed = sorted(CASES).index(case)
    native, sync = pair(case, mode, "full" if seed % 2 else "brief")
    assert play(native, sync, EPISODES, seed) >= EPISODES
    native.close()
    sync.close()


def test_the_cases_reach_every_end() -> None:
    """Else the comparison above would say little."""
    ends = {}
    for case, (maker, arguments) in CASES.items():
        env, generator, found = ChainVectorEnv(maker, COUNT, **arguments), np.random.default_rng(1), [0, 0, 0]
        env.reset(seed=1)
        bias = generator.uniform(-0.3, 0.8, (COUNT, 1))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", GranularWarning)
            for _ in range(100):
                _, _, terminated, truncated, infos = env.step(bias + generator.normal(0.0, 0.5, (COUNT, 1)))
                found = [
                    found[0] + terminated.sum(),
                    found[1] + truncated.sum(),
                    found[2] + infos.get("_step_error", bias * 0).sum(),
                ]
        ends[case] = found
    timed = {"clock", "held with a clock"}
    assert all(terminated > 0 and (truncated > 0) != (case in timed) for case, (terminated, truncated, _) in ends.items()), ends
    assert [case for case, found in ends.items() if found[2] > 0] == ["refused"]


def test_make_vec_picks_the_batch() -> None:
    for name, task in (("granular_env/Protection-v1", ProtectionTask), ("granular_env/Piston-v1", PistonTask)):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            env = gymnasium.make_vec(name, num_envs=3, grains=5)
        assert isinstance(env.unwrapped, ChainVectorEnv) and env.num_envs == 3
        assert isinstance(env.unwrapped.single(0), ChainEnv) and isinstance(env.unwrapped.single(0).task, task)
        assert env.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
        observations, _ = env.reset(seed=1)
        assert env.observation_space.contains(observations) and observations.shape[1] in (10, 18)
        assert env.observation_space.contains(env.step(env.action_space.sample())[0])
        assert env.single_observation_space == env.unwrapped.single(0).observation_space
        env.close()


def test_parameters_may_differ_from_one_to_the_other() -> None:
    own = [
        {"radius": 2e-3},
        {"impulse": 1e-3, "chain": {"precompression": 3.0}},
        {"deadline": 3, "internal_steps": 40, "noise": 0.1},
    ]
    common: dict[str, Any] = {"grains": 5, "chain": {"contact_stiffness": 1e9}}
    batch = ChainVectorEnv(make_protection, 3, parameters=own, **common)
    chains = [{**common["chain"], **each.get("chain", {})} for each in own]
    singles = [
        lambda each=each, chain=chain: make_protection(**{**common, **each, "chain": chain, "info": "brief"})
        for each, chain in zip(own, chains, strict=True)
    ]
    play(batch, SyncVectorEnv(singles), 12, seed=3)
    assert [single.component.get("precompression") for single in map(batch.single, range(3))] == [0.0, 3.0, 0.0]


def test_laws_may_differ_from_one_to_the_other() -> None:
    own = [{"chain": {"law": {"name": "viscous", "dissipation": 0.3}}}, {"chain": {"gravity": 9.81}}]
    batch = ChainVectorEnv(make_piston, 2, parameters=own, grains=4, deadline=20, chain={"right": "plane"})
    singles = [
        lambda each=each: make_piston(grains=4, deadline=20, chain={"right": "plane", **each["chain"]}, info="brief")
        for each in own
    ]
    play(batch, SyncVectorEnv(singles), 6, seed=5)


def test_goals_of_other_sizes_may_differ_from_one_to_the_other() -> None:
    # The wanted waves' tables are as long as their number and the precompression want them.
    own = [
        {},
        {"amplitude": [3.0, 2.0], "place": [9, 3]},
        {"chain": {"precompression": 9.0}, "randomise": {"radius": (2e-3, 3e-3)}},
    ]
    common: dict[str, Any] = {"grains": 12, "amplitude": 3.0, "place": 9, "deadline": 60, "info": "brief"}
    batch = ChainVectorEnv(make_pulse_forming, 3, parameters=own, **common)
    assert len({len(batch.single(k).constants) for k in range(3)}) == 3
    fresh = ChainVectorEnv(make_pulse_forming, 3, parameters=own, **common)
    singles = [lambda k=k, each=each: make_pulse_forming(**{**common, **each}) for k, each in enumerate(own)]
    play(fresh, SyncVectorEnv(singles), 30, seed=2)


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_what_environments_do_by_themselves_counts_in_the_batch(mode: AutoresetMode) -> None:
    env = ChainVectorEnv(make_protection, 2, grains=4, deadline=3, internal_steps=15, autoreset_mode=mode)
    env.reset(seed=1)
    for _ in range(3):
        env.single(1).step([1.0])
    if mode == AutoresetMode.DISABLED:
        with pytest.raises(ParameterError, match=r"\[1\] are over"):
            env.step(np.zeros((2, 1)))
        env.single(1).reset()
    times = env.step(np.ones((2, 1)))[4]["time"]
    step = env.single(0).duration
    assert times.tolist() == [step, step if mode == AutoresetMode.DISABLED else 0.0], "what is over is reset, not stepped"
    if mode == AutoresetMode.NEXT_STEP:
        for _ in range(2):
            env.step(np.zeros((2, 1)))  # environment 0 is over then
        env.single(0).reset(options={"velocity": {2: 1.0}})
        assert env.step(np.zeros((2, 1)))[4]["time"][0] == step, "what was reset by hand is not reset again"


def test_observations_and_infos_are_fresh() -> None:
    env = ChainVectorEnv(make_protection, 2, grains=4, info="full")
    observations, infos = env.reset(seed=1)
    kept = observations.copy(), {name: value.copy() for name, value in infos.items()}
    for _ in range(5):
        env.step(np.ones((2, 1), np.float32))
    same(observations, kept[0])
    same(infos, kept[1])


def test_a_mask_resets_some() -> None:
    env = ChainVectorEnv(make_protection, 3, grains=4, clock=0, autoreset_mode="Disabled")
    env.reset(seed=1)
    before, *_ = env.step(np.ones((3, 1)))
    mask = np.array([False, True, False])
    observations, infos = env.reset(seed=[1, 2, 3], options={"reset_mask": mask})
    same(observations[~mask], before[~mask])
    assert not observations[1].any() and infos["_time"].tolist() == mask.tolist()
    for wrong in (mask.tolist(), np.zeros(3, bool), np.ones(2, bool), np.ones(3)):
        with pytest.raises(ParameterError, match="reset_mask"):
            env.reset(options={"reset_mask": wrong})


def test_with_autoreset_disabled_what_is_over_stays_over() -> None:
    env = ChainVectorEnv(make_protection, 2, grains=4, deadline=2, internal_steps=25, autoreset_mode=AutoresetMode.DISABLED)
    env.reset(seed=1)
    for _ in range(2):
        env.step(np.zeros((2, 1)))
    with pytest.raises(ParameterError, match="reset_mask"):
        env.step(np.zeros((2, 1)))


def test_a_recorded_environment_is_recorded_whole(tmp_path: Any) -> None:
    env, path = ChainVectorEnv(make_protection, 3, grains=5), tmp_path / "one.mcap"
    env.reset(seed=1)
    for _ in range(4):
        env.step(np.full((3, 1), 0.3))
    with record(env.single(1).component, path):
        for _ in range(6):
            env.step(np.full((3, 1), 0.5))
    env.step(np.full((3, 1), 0.5))
    found = verify(path)
    assert found.identical and found.calls == 6
    assert env.save([1])[0].snapshot.data == env.save([0])[0].snapshot.data


@pytest.mark.parametrize(
    ("actions", "words"),
    [
        (np.array([[0.0], [np.nan], [0.0]]), r"actions\[1,0\]: got nan"),
        (np.array([[0.0], [0.0], [-np.inf]]), r"actions\[2,0\]"),
        (np.zeros((2, 1)), r"shape \(2, 1\), expected numbers of shape \(3, 1\)"),
        (np.zeros(3), r"shape \(3,\)"),
        ([[0.0], [0.0, 1.0], [0.0]], "actions"),
        ([["a"], ["b"], ["c"]], "actions"),
        (None, "actions"),
    ],
)
def test_what_are_no_actions_is_refused_and_nothing_moves(actions: Any, words: str) -> None:
    env = ChainVectorEnv(make_protection, 3, grains=4)
    with pytest.raises(ParameterError):
        env.step(np.zeros((3, 1)))  # before the first reset
    env.reset(seed=1)
    env.step(np.ones((3, 1)))
    before = [state.to_bytes() for state in env.save()]
    with pytest.raises(ParameterError, match=words):
        env.step(actions)
    assert [state.to_bytes() for state in env.save()] == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"num_envs": 0}, "num_envs"),
        ({"num_envs": 2.0}, "num_envs"),
        ({"autoreset_mode": "sometimes"}, "autoreset_mode"),
        ({"parameters": [{}]}, "list of 3 mappings"),
        ({"parameters": {"radius": 1.0}}, "list of 3 mappings"),
        ({"parameters": [{}, {"radius": -1.0}, {}]}, r"parameters\[1\].radius"),
        ({"parameters": [{}, {"grains": 5}, {}]}, r"parameters\[1\]: observation space"),
        ({"parameters": [{}, {}, {"control_delay": 2}]}, r"parameters\[2\]: control_delay"),
        ({"parameters": [{}, 3, {}]}, r"parameters\[1\]"),
        ({"parameters": [{}, {"impuls": 1.0}, {}]}, r"parameters\[1\].impuls: unknown"),
        ({"randomise": {"radus": (1.0, 2.0)}}, "did you mean 'radius'"),
        ({"randomise": 3}, "randomise"),
    ],
)
def test_batches_that_cannot_be_are_refused(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        ChainVectorEnv(make_protection, **{"num_envs": 3, "grains": 4, **arguments})


def test_seeds_are_given_to_each() -> None:
    env = ChainVectorEnv(make_protection, 2, grains=4, randomise={"velocity": (0.0, 1.0)}, info="full")
    first = env.reset(seed=5)[1]["velocity"][:, 0].tolist()
    assert env.reset(seed=[6, 5])[1]["velocity"][:, 0].tolist()[::-1] == [first[0], first[1]]
    assert env.np_random_seed == (6, 5) and len(env.np_random) == 2
    before = [state.to_bytes() for state in env.save()]
    for wrong in ([1], "one", True, -1, [1, "two"], [3, -3]):
        with pytest.raises(ParameterError, match="seed"):
            env.reset(seed=wrong)  # type: ignore[arg-type]
    assert [state.to_bytes() for state in env.save()] == before
    for wrong in (-1, 1.5, "one"):
        with pytest.raises(ParameterError, match="seed: got"):
            env.single(0).reset(seed=wrong)  # type: ignore[arg-type]


def test_pictures_of_all() -> None:
    env = ChainVectorEnv(make_protection, 2, grains=4, render_mode="rgb_array")
    env.reset(seed=1)
    env.step(np.array([[1.0], [0.0]]))
    first, second = env.render()
    assert first.shape == (360, 960, 3) and (first != second).any()
