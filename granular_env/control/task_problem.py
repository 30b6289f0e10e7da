"""An environment's task as a study sees it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from granular_env.components.errors import ParameterError
from granular_env.components.variables import parse_element
from granular_env.domains import domain_of
from granular_env.envs.task import RowTask, no_objective

from .drive import Drive
from .named_environments import find_environment, make_environment, registered_name
from .problem import Actor, Counts, Episode, FloatArray, Policies


class TaskProblem:
    """A task: its batch for searching, its single environment for judging and recording, its objective for slopes.

    Args:
        name: of the environment, see `find_environment`.
        arguments: the environment's arguments.
        folder: where modules of the user's own are looked for first.

    Attributes:
        stage: keyword arguments of the task's smooth objective, where they are not its defaults; None for those.

    Raises:
        ParameterError: there is no such environment, it does not take an argument, or its episodes have no end.
    """

    def __init__(self, name: str, arguments: Mapping[str, Any], folder: Path | None = None) -> None:
        if given := sorted({"hold", "clock"} & set(arguments)):
            raise ParameterError(
                "it is no key of a study's task",
                hint="the methods that can use it (ppo, sac) have keys of that name",
                at=given[0],
            )
        # Drives need no clock; what learns brings its own.
        self.name, self._arguments = registered_name(name), {"clock": 0, **arguments}
        self._make = find_environment(name, folder)
        self.env = make_environment(self._make, self._arguments, name)
        if math.isinf(self.env.deadline):
            raise ParameterError(
                "got none", expected="a number of control steps", hint="a study needs episodes that end", at="deadline"
            )
        self._domain = domain_of(self.env.component.name)
        self._batches: dict[int, Any] = {}
        self.stage: Mapping[str, Any] | None = None

    @property
    def steps(self) -> int:
        """Control steps of an episode."""
        return int(self.env.deadline)

    @property
    def entries(self) -> int:
        """Numbers in an action."""
        return int(self.env.action_space.shape[0])

    @property
    def observed(self) -> int:
        """Numbers in an observation."""
        return int(self.env.observation_space.shape[0])

    @property
    def rate(self) -> float | None:
        """The environment's own limit of the action's change per control step."""
        rate = self.env.actuator.rate
        return None if math.isinf(rate) else float(rate)

    @property
    def gradient_runs(self) -> float:
        """Return the cost of an objective with its slopes, in forward runs; 0 where there are no gradients."""
        gradients = self._domain.load("gradients")
        return float(gradients.RUNS) if gradients is not None and isinstance(self.env.task, RowTask) else 0.0

    # -- many at a time ---------------------------------------------------------------------------------------------

    def returns(self, drives: FloatArray, seeds: Sequence[int]) -> tuple[FloatArray, Counts]:
        """Return mean returns over the episodes, and control steps simulated, (members,); drives (members, steps, entries)."""
        actions = np.repeat(drives, len(seeds), axis=0)
        return self._roll_out(len(drives), seeds, lambda step, observations: actions[:, step])

    def policy_returns(
        self, policies: Callable[[int], Policies], members: int, seeds: Sequence[int]
    ) -> tuple[FloatArray, Counts]:
        """Return the same for policies; `policies(episodes)` makes the batch for members x episodes environments."""
        batch = policies(len(seeds))
        batch.reset()
        return self._roll_out(members, seeds, lambda step, observations: batch(observations))

    def _roll_out(
        self, members: int, seeds: Sequence[int], act: Callable[[int, npt.NDArray[Any]], npt.NDArray[Any]]
    ) -> tuple[FloatArray, Counts]:
        count = members * len(seeds)
        env = self._batch(count)
        observations, _ = env.reset(seed=list(seeds) * members)
        totals, steps = np.zeros(count), np.zeros(count, dtype=np.int64)
        running = np.ones(count, dtype=bool)
        for step in range(self.steps):
            actions = np.where(running[:, None], act(step, observations), 0.0)
            observations, rewards, terminated, truncated, _ = env.step(actions)
            totals[running] += rewards[running]
            steps += running
            running &= ~(terminated | truncated)
            if not running.any():
                break
        shape = (members, len(seeds))
        return totals.reshape(shape).mean(axis=1), steps.reshape(shape).sum(axis=1)

    def _batch(self, count: int) -> Any:
        """Return a batch of so many; the last one is kept, because a search asks for the same size repeatedly."""
        if count not in self._batches:
            self._batches = {count: self.vector(count)}
        return self._batches[count]

    def vector(self, count: int, hold: int = 1, clock: int = 0) -> Any:
        """Return a Gymnasium `VectorEnv` of so many environments, which resets in the same step.

        It is native where the task judges rows, otherwise Gymnasium's own.
        """
        from granular_env.envs import make_batch

        def make(**arguments: Any) -> Any:
            return make_environment(self._make, arguments, self.name)

        return make_batch(make, count, autoreset_mode="SameStep", **{**self._arguments, "hold": hold, "clock": clock})

    # -- one at a time ----------------------------------------------------------------------------------------------

    def baselines(self) -> Mapping[str, Actor]:
        """Return the agents to compare with; doing nothing is always among them."""
        return {"nothing": Drive(np.zeros((self.steps, self.entries))), **self.env.task.baselines()}

    def play(self, actor: Actor, seed: int, log: Path | None = None) -> Episode:
        """One episode in the single environment, recorded where a path is given."""
        from granular_env.recording import record

        env, actions, total = self.env, [], 0.0
        with ExitStack() as stack:
            if log is not None:
                # Where a component is drawn for each episode, the recorder has to look at that of this one.
                env.reset(seed=seed)
                stack.enter_context(record(env.component, log, overwrite=True))
            observation, info = env.reset(seed=seed)
            actor.reset()
            over = False
            while not over:
                action = np.asarray(actor(observation, info), dtype=np.float64)
                observation, reward, terminated, truncated, info = env.step(action)
                actions.append(np.clip(action, -1.0, 1.0))
                total += float(reward)
                over = terminated or truncated
        return Episode(total, np.array(actions), env.duration, self._final(env), _numbers(info))

    def _final(self, env: Any) -> dict[str, FloatArray]:
        """Return the arrays among the observed outputs at the end, velocities first; of vectors, each component by itself."""
        component, final = env.component, {}
        for name in sorted(env.task.observations, reverse=True):
            element = parse_element(name)
            value, unit = np.asarray(element.of(component.get(element.name))), component.variables[element.name].unit
            for place in np.ndindex(value.shape[1:]) if value.ndim else ():
                part = f"[{', '.join([':', *map(str, place)])}]" if place else ""
                final[f"{name.replace('_', ' ')}{part} [{unit}]"] = value[(slice(None), *place)]
        return final

    # -- slopes -----------------------------------------------------------------------------------------------------

    def value_and_grad(self, drive: FloatArray, seeds: Sequence[int]) -> tuple[float, FloatArray]:
        """Return the smooth objective, averaged over the episodes, and its slopes with respect to the drive, (steps, entries).

        Raises:
            ParameterError: the task has no objective with slopes, or its component has none.
            StepError: the drive breaks the physics.
        """
        gradients = self._domain.load("gradients")
        if gradients is None or not isinstance(self.env.task, RowTask):
            raise no_objective(self.env.task)
        return gradients.value_and_grad(self.env, drive, seeds, self.stage)


def _numbers(info: Mapping[str, Any]) -> dict[str, float]:
    """Return the numbers of an info."""
    return {name: float(value) for name, value in info.items() if isinstance(value, (int, float, np.number)) and name != "time"}
