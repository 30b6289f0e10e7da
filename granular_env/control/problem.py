"""The task of a study: a batch of environments for the search, a single one for the test, and an objective for gradients."""

from __future__ import annotations

import inspect
import math
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.components.errors import ParameterError, one_line, spelling_hint
from granular_env.components.support.float_arrays import FloatArray
from granular_env.domains import find_domain, import_object, load_environments
from granular_env.envs.environment import ComponentEnv
from granular_env.envs.factory import refuse_unknown_arguments
from granular_env.envs.policies import OpenLoop, Policy
from granular_env.envs.task import RowTask


class Problem:
    """A task in the form used by studies.

    Args:
        name: name of the environment: ``pulse-forming``, ``granular_env/PulseForming-v1``, or ``module:name`` of a factory.
        arguments: arguments of the environment.
        folder: folder in which modules are searched first.

    Attributes:
        stage: keyword arguments of the task's smooth objective, which `Gradient` sets in stages; None for the defaults.
        steps: number of control steps of an episode.
        duration: duration of a control step [s].
        entries: number of entries of an action.
        rate: largest change of an action per control step that the environment allows; None for no limit.
        gradient_runs: cost of an objective with its gradient, in units of one simulated episode; 0 without gradients.

    Raises:
        ParameterError: unknown environment or argument, or episodes without an end.
    """

    stage: Mapping[str, Any] | None = None

    def __init__(self, name: str, arguments: Mapping[str, Any], folder: Path | None = None) -> None:
        self.name, self._folder, self._arguments = name, folder, {"clock": 0, **arguments}
        self._make = load_environment_factory(name, folder)
        self.env = self._make_env(**self._arguments)
        if math.isinf(self.env.deadline):
            raise ParameterError("got none", expected="a number of control steps (episodes must end)", at="deadline")
        self.steps, self.duration = int(self.env.deadline), self.env.duration
        self.entries = self.env.actuator.size
        rate = self.env.actuator.rate
        self.rate = None if math.isinf(rate) else float(rate)
        is_smooth = isinstance(self.env.task, RowTask)
        self._gradients: Any = find_domain(self.env.component.name).load_attribute("gradients") if is_smooth else None
        self.gradient_runs = float(self._gradients.RUNS) if self._gradients is not None else 0.0
        self._batch: Any = None

    def _make_env(self, **arguments: Any) -> ComponentEnv:
        refuse_unknown_arguments(self._make, arguments)
        env = getattr(made := self._make(**arguments), "unwrapped", made)
        if not isinstance(env, ComponentEnv):
            hint = "name a function that returns ComponentEnv(component, task)"
            raise ParameterError(f"it returns {one_line(made)}", expected="a ComponentEnv", hint=hint, at="name")
        return env

    def with_options(self, **options: Any) -> Problem:
        """Return the same task with other options of its environment."""
        return Problem(self.name, {**self._arguments, **options}, self._folder)

    @property
    def task_source(self) -> str:
        """The source text of the module that defines the task, on which results depend if it is the user's; "" if unknown."""
        try:
            return inspect.getsource(sys.modules[type(self.env.task).__module__])
        except (OSError, TypeError):
            return ""

    def returns(self, drives: FloatArray, seeds: Sequence[int]) -> tuple[FloatArray, npt.NDArray[np.int64]]:
        """Return for each drive, (members, steps, entries), its mean return over the seeds and its simulated control steps."""
        actions = np.repeat(drives, len(seeds), axis=0)
        return self._simulate_episodes(len(drives), seeds, lambda step, observations: actions[:, step])

    def policy_return(self, policy: Callable[[npt.NDArray[Any]], npt.NDArray[Any]], seeds: Sequence[int]) -> tuple[float, int]:
        """Return a policy's mean return over the seeds and its simulated steps; its observations are (environments, size)."""
        values, steps = self._simulate_episodes(1, seeds, lambda step, observations: policy(observations))
        return float(values[0]), int(steps[0])

    def _simulate_episodes(
        self, members: int, seeds: Sequence[int], act: Callable[[int, npt.NDArray[Any]], npt.NDArray[Any]]
    ) -> tuple[FloatArray, npt.NDArray[np.int64]]:
        count = members * len(seeds)
        if self._batch is None or self._batch.num_envs != count:
            self._batch = self.make_vector_env(count)
        observations, _ = self._batch.reset(seed=list(seeds) * members)
        totals, steps = np.zeros(count), np.zeros(count, dtype=np.int64)
        running = np.ones(count, dtype=bool)
        for step in range(-(-self.steps // self.env.hold)):
            actions = np.where(running[:, None], act(step, observations), 0.0)
            observations, rewards, terminated, truncated, _ = self._batch.step(actions)
            totals[running] += rewards[running]
            steps += running * self.env.hold
            running &= ~(terminated | truncated)
            if not running.any():
                break
        shape = (members, len(seeds))
        return totals.reshape(shape).mean(axis=1), np.minimum(steps, self.steps).reshape(shape).sum(axis=1)

    def make_vector_env(self, count: int) -> Any:
        """Return `count` environments as a Gymnasium `VectorEnv` with `AutoresetMode.SAME_STEP`."""
        from granular_env.envs import make_batch

        return make_batch(self._make_env, count, autoreset_mode="SameStep", **self._arguments)

    def baselines(self) -> Mapping[str, Policy]:
        """Return the reference policies, which always include "nothing"."""
        return {"nothing": OpenLoop(np.zeros((self.steps, self.entries))), **self.env.task.baselines()}

    def play_episode(self, actor: Policy, seed: int, log: Path | None = None) -> tuple[float, FloatArray]:
        """Play one episode in the single environment, and record it if the path of a log is given.

        Returns:
            The return, and the actions, shape (control steps, entries), in units of their scales.
        """
        from granular_env.recording import record

        env, actions, total, over = self.env, [], 0.0, False
        with ExitStack() as stack:
            if log is not None:
                # Record only now: the reset may replace the component, if its parameters are sampled for each episode.
                env.reset(seed=seed)
                stack.enter_context(record(env.component, log, overwrite=True))
            observation, info = env.reset(seed=seed)
            actor.reset()
            while not over:
                action = np.asarray(actor(observation, info), dtype=np.float64)
                observation, reward, terminated, truncated, info = env.step(action)
                actions += [np.clip(action, -1.0, 1.0)] * env.hold
                total += float(reward)
                over = terminated or truncated
        return total, np.array(actions[: self.steps])

    def value_and_grad(self, drive: FloatArray, seeds: Sequence[int]) -> tuple[float, FloatArray]:
        """Return the smooth objective averaged over the episodes, and its gradient with respect to the drive, (steps, entries).

        Available only if `gradient_runs` is not 0. Raise `StepError` if the state leaves the range of the physics.
        """
        return self._gradients.value_and_grad(self.env, drive, seeds, self.stage)


def environment_names() -> dict[str, str]:
    """Return a mapping from short to registered names, such as ``pulse-forming`` to ``granular_env/PulseForming-v1``."""
    plain = {name: name.rpartition("/")[2].partition("-v")[0] for name in load_environments()}
    return {re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", short).lower(): name for name, short in plain.items()}


def load_environment_factory(name: str, folder: Path | None = None) -> Callable[..., Any]:
    """Return the function that makes the environment with this name; the name may be ``module:name`` of user code.

    Raises:
        ParameterError: unknown name; the message suggests the nearest name.
    """
    if (registered := environment_names().get(name, name)) in load_environments():
        return import_object(load_environments()[registered].entry_point)
    if ":" not in name:
        hint = spelling_hint(
            name, list(environment_names()), "for your own task, give 'module:name' of a function that returns its environment"
        )
        raise ParameterError(f"got {name!r}", expected="the name of a task", hint=hint, at="name")
    if folder is not None and str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
    try:
        return import_object(name)
    except (ImportError, AttributeError) as error:
        raise ParameterError(f"got {name!r}: {error}", expected="'module:name' of a function", at="name") from error
