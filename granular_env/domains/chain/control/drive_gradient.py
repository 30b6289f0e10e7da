"""The smooth objective of a task on a chain, and its derivatives with respect to the actions of an episode: for studies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from granular_env.components.chain.adjoint import value_and_adjoint
from granular_env.components.errors import ParameterError
from granular_env.components.support.arrays import FloatArray

# What one gradient counts as, in forward runs: a run forward, one again from the checkpoints, and the sweep back, which
# differentiates every force of a run and transposes it: counted as two.
RUNS = 4.0


def value_and_grad(
    env: Any, drive: FloatArray, seeds: Sequence[int], stage: Mapping[str, Any] | None = None
) -> tuple[float, FloatArray]:
    """Return the objective, averaged over the episodes, and its derivatives with respect to the drive, (steps, entries).

    Args:
        env: a `ChainEnv`.
        drive: an action for every control step, shape (steps, entries).
        seeds: one for each episode.
        stage: attributes of the task that its objective is built with, where they are not its own.

    Raises:
        ParameterError: the task has no objective with a gradient, or its chain has none.
        StepError: the drive breaks the physics.
    """
    steps = len(drive)
    value, slopes, actuator = 0.0, np.zeros_like(drive), env.actuator
    late = max(steps - actuator.delay, 0)
    for seed in seeds:
        _, info = env.reset(seed=seed)
        if goal := env.task.counter_names[: len(env.task.goal_scales)]:
            # The objective of a task that draws its goals is that of its present demand.
            env.task.demand = np.array([info[name] for name in goal])
        inputs = np.zeros((steps, 2))
        inputs[actuator.delay :, actuator.sides] = env.actuator.scales * drive[:late]
        adjoints = value_and_adjoint(env.component, inputs, env.internal_steps, _objective(env, steps, stage or {}))
        value += adjoints.value / len(seeds)
        slopes[:late] += env.actuator.scales * adjoints.inputs[actuator.delay :, actuator.sides] / len(seeds)
    return value, slopes


def _objective(env: Any, steps: int, stage: Mapping[str, Any]) -> Any:
    task = env.task
    own: dict[str, Any] = {name: getattr(task, name, None) for name in stage}
    for name, value in stage.items():
        if own[name] is None or np.shape(own[name]) != np.shape(value):
            came = f"no attribute {name!r}" if own[name] is None else f"{name} = {own[name]}"
            raise ParameterError(f"{name}: got {value}, but the task {task.name!r}, whose objective it is for, has {came}")
    try:
        for name, value in stage.items():
            setattr(task, name, value)
        return task.objective(env.component, steps)
    finally:
        for name, value in own.items():
            setattr(task, name, value)
