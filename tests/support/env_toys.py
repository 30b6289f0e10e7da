"""Small environments for tests: registered tasks and a toy task."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from granular_env.components.component import Component
from granular_env.components.oscillator import Oscillator
from granular_env.domains.chain.tasks.piston import make_piston
from granular_env.domains.chain.tasks.protection import make_protection
from granular_env.envs import ComponentEnv, EnvState, Task

SMALL = {"grains": 8, "deadline": 200}


class Swing(Task):
    """A toy: push a mass on a spring to one metre."""

    name = "swing"

    def __init__(self) -> None:
        super().__init__()
        self.actions = {"force": 2.0}
        self.observations = {"position": 0.5, "velocity": 1.0}
        self.observation_limit = 3.0

    def start(self, random: np.random.Generator) -> dict[str, float]:
        return {"position": random.uniform(-0.1, 0.1)}

    def begin_episode(self, component: Component, outputs: dict) -> None:
        self.counters = {"farthest": outputs["position"]}

    def evaluate_step(self, component: Component, outputs: dict, duration: float) -> tuple[float, bool]:
        self.counters = {"farthest": max(self.counters["farthest"], outputs["position"])}
        return outputs["position"], outputs["position"] > 1.0


MAKERS: dict[str, Callable[..., ComponentEnv]] = {
    "piston": lambda **options: make_piston(**{**SMALL, **options}),
    "force": lambda **options: make_protection(**{**SMALL, "impulse": 0.02, "clock": 0, **options}),
    "swing": lambda **options: ComponentEnv(
        Oscillator(step_size=0.01), Swing(), **{"internal_steps": 5, "deadline": 200, **options}
    ),
}


def random_actions(count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (count, 1)).astype(np.float32)


def transcript(env: ComponentEnv, chosen: np.ndarray) -> list[bytes]:
    """Return everything that an agent receives, as bytes."""
    told = []
    for action in chosen:
        observation, reward, terminated, truncated, info = env.step(action)
        told.append(observation.tobytes() + np.float64(reward).tobytes() + bytes([terminated, truncated]))
        told.extend(np.asarray(value).tobytes() for value in info.values())
        if terminated or truncated:
            break
    return told


def state_parts(state: EnvState) -> tuple:
    """Return the parts of a state for comparison."""
    return state.snapshot.to_bytes(), state.memory, dict(state.counters), state.origin
