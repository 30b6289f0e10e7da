"""For studies: a task's objective and its gradient with respect to the actions of an episode, averaged over episodes."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from granular_env.components.chain.adjoint import value_and_adjoint
from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray

# Cost of one gradient, in units of a forward run: 1 for the run, 1 for its repetition from the checkpoints, and 2 for the
# backward sweep, which computes every force with its derivative.
RUNS = 4.0


def value_and_grad(
    env: Any, drive: FloatArray, seeds: Sequence[int], stage: Mapping[str, Any] | None = None
) -> tuple[float, FloatArray]:
    """Return the objective averaged over the episodes, and its derivatives with respect to the drive, shape (steps, entries).

    Args:
        env: the environment of a chain.
        drive: an action for every control step, shape (steps, entries).
        seeds: the seed of each episode.
        stage: keyword arguments of the task's `objective` that differ from their defaults.

    Raises:
        ParameterError: the task has no objective, or its chain has no gradient.
        StepError: the drive takes the state outside the range of the physics.
    """
    steps = len(drive)
    value, slopes, actuator = 0.0, np.zeros_like(drive), env.actuator
    sides = [int(element.name.startswith("right")) for element, *_ in actuator.driven]
    late = max(steps - actuator.delay, 0)
    for seed in seeds:
        _, info = env.reset(seed=seed)
        settings = dict(stage or {})
        if names := env.task.counter_names[: len(env.task.goal_scales)]:
            # A task that samples its goals needs the goal of each episode.
            settings["goal"] = np.array([info[name] for name in names])
        inputs = np.zeros((steps, 2))
        inputs[actuator.delay :, sides] = actuator.scales * drive[:late]
        adjoints = value_and_adjoint(env.component, inputs, env.internal_steps, _task_objective(env, steps, settings))
        value += adjoints.value / len(seeds)
        slopes[:late] += actuator.scales * adjoints.inputs[actuator.delay :, sides] / len(seeds)
    return value, slopes


def _task_objective(env: Any, steps: int, settings: Mapping[str, Any]) -> Any:
    """Return the task's objective for the keyword arguments `settings`; `ParameterError` if one is unknown or malformed."""
    known = inspect.signature(env.task.objective).parameters
    for name, value in settings.items():
        default = known[name].default if name in known else None
        if name not in known or (default is not None and np.shape(default) != np.shape(value)):
            came = f"has no argument {name!r}" if name not in known else f"requires the shape of {name} = {default}"
            raise ParameterError(f"got {value}, but the objective of the task {env.task.name!r} {came}", at=name)
    return env.task.objective(env.component, steps, **settings)
