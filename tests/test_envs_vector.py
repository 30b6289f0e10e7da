"""The native batch against Gymnasium's SyncVectorEnv of the single environment: equal in every bit."""

from __future__ import annotations

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from granular_env.components.contract import GranularWarning, ParameterError
from granular_env.envs import ChainEnv, ChainVectorEnv, ForceEnv, PistonEnv, register_all
from granular_env.recording import record, verify

register_all()
COUNT = 4
MODES = list(AutoresetMode)

# What is tried: the environment, and arguments that differ from lane to lane or not.
CASES: dict[str, tuple[type[ChainEnv], dict[str, Any]]] = {
    "force": (ForceEnv, {"grains": 6, "deadline": 8, "internal_steps": 40, "impulse": 1e-3}),
    "piston": (PistonEnv, {"grains": 5, "deadline": 8, "internal_steps": 30}),
    "sensors": (
        ForceEnv,
        {
            "grains": 5,
            "deadline": 8,
            "internal_steps": 40,
            "impulse": 1e-3,
            "observe": {"velocity": [0, -1, 3], "force": [2, 3], "contact_force": [-1], "wall_force": ["right"]},
            "noise": 0.02,
        },
    ),
    "slow actuator": (
        PistonEnv,
        {"grains": 4, "deadline": 14, "internal_steps": 20, "action_rate": 0.3, "control_delay": 3, "noise": 0.1},
    ),
    "drawn": (
        ForceEnv,
        {
            "grains": 6,
            "deadline": 7,
            "internal_steps": 30,
            "chain": {"law": {"name": "viscous", "dissipation": 0.5}},
            "randomise": {"radius": (2e-3, 3e-3), "contact_stiffness": (1e9, 2e9), "velocity": (0.0, 3.0), "seed": 3},
            "impulse": 1e-3,
        },
    ),
    "each grain drawn": (
        PistonEnv,
        {
            "grains": 6,
            "deadline": 9,
            "internal_steps": 30,
            "randomise": {"radius": {"low": 2e-3, "high": 3e-3}, "velocity": {1: (0.0, 2.0)}},
        },
    ),
    "plastic": (
        ForceEnv,
        {
            "grains": 5,
            "deadline": 8,
            "internal_steps": 40,
            "impulse": 1e-3,
            "chain": {"law": {"name": "elastic_plastic", "yield_pressure": 1e9}, "integrator": "leapfrog"},
        },
    ),
    "refused": (
        ForceEnv,
        {"grains": 3, "deadline": 5, "impulse": 10.0, "force_scale": 2e5, "chain": {"overlap_limit": 0.005}},
    ),
}
EPISODES = -(-1000 // (len(CASES) * len(MODES)))


def pair(case: str, mode: AutoresetMode, info: str) -> tuple[ChainVectorEnv, SyncVectorEnv]:
    maker, arguments = CASES[case]
    arguments = {**arguments, "info": info}
    native = ChainVectorEnv(maker, COUNT, autoreset_mode=mode, **arguments)
    makers = [lambda index=index: maker(**arguments, index=index) for index in range(COUNT)]
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
    generator, over, disabled = np.random.default_rng(seed), 0, native.autoreset_mode == AutoresetMode.DISABLED
    same(native.reset(seed=seed), sync.reset(seed=seed))
    bias = generator.uniform(-0.3, 0.8, (COUNT, 1))
    while over < episodes:
        actions = (bias + generator.normal(0.0, 0.5, (COUNT, 1))).astype(np.float32)
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
