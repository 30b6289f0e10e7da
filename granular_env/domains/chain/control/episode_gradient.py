"""A task's objective and its gradient with respect to the actions of an episode, averaged over seeds: for studies."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from granular_env.components.chain.adjoint import value_and_adjoint
from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray

# What one gradient counts as, in forward runs: a run forward, one again from the checkpoints, and the sweep back, which
# differentiates every force of a run and transposes it: counted as two.
RUNS = 4.0


def value_and_grad(
    env: Any, drive: FloatArray, seeds: Sequence[int], stage: Mapping[str, Any] | None = None
) -> tuple[float, FloatArray]:
    """Return the objective, averaged over the episodes, and its derivatives with respect to the drive, (steps, entries).

    Args:
        env: the environment of a chain.
        drive: an action for every control step, shape (steps, entries).
        seeds: one for each episode.
        stage: keyword arguments of the task's `objective`, where they are not its defaults.

    Raises:
        ParameterError: the task has no objective with a gradient, or its chain has none.
        StepError: the drive breaks the physics.
    """
    steps = len(drive)
    value, slopes, actuator = 0.0, np.zeros_like(drive), env.actuator
    sides = [int(element.name.startswith("right")) for element, *_ in actuator.driven]
    late = max(steps - actuator.delay, 0)
    for seed in seeds:
        _, info = env.reset(seed=seed)
        settings = dict(stage or {})
        if names := env.task.counter_names[: len(env.task.goal_scales)]:
            # The objective of a task that draws its goals is that of the present one.
            settings["goal"] = np.array([info[name] for name in names])
        inputs = np.zeros((steps, 2))
        inputs[actuator.delay :, sides] = actuator.scales * drive[:late]
        adjoints = value_and_adjoint(env.component, inputs, env.internal_steps, _objective(env, steps, settings))
        value += adjoints.value / len(seeds)
        slopes[:late] += actuator.scales * adjoints.inputs[actuator.delay :, sides] / len(seeds)
    return value, slopes


def _objective(env: Any, steps: int, settings: Mapping[str, Any]) -> Any:
    """Return the task's objective; `ParameterError` for a setting that it does not take, or that has another shape."""
    known = inspect.signature(env.task.objective).parameters
    for name, value in settings.items():
        default = known[name].default if name in known else None
        if name not in known or (default is not None and np.shape(default) != np.shape(value)):
            came = f"takes no {name!r}" if name not in known else f"takes {name} = {default}"
            raise ParameterError(f"got {value}, but the objective of the task {env.task.name!r} {came}", at=name)
    return env.task.objective(env.component, steps, **settings)
