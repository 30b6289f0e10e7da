"""The interface of a study to its task: returns of drives and policies, the smooth objective's slopes, single episodes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from granular_env.components.support.float_arrays import FloatArray

Counts = npt.NDArray[np.int64]


class Actor(Protocol):
    """A chooser of actions in a single environment: a drive, a baseline, a trained policy."""

    def reset(self) -> None:
        """Begin an episode."""

    def __call__(self, observation: Any, info: Any) -> npt.ArrayLike:
        """Return the action of the next control step."""
        ...


class Policies(Protocol):
    """A batch of policies, one for each environment of a batch, or one for all of them."""

    def reset(self) -> None:
        """Begin an episode in every environment."""

    def __call__(self, observations: FloatArray) -> FloatArray:
        """Actions, shape (environments, entries), for observations of shape (environments, size)."""
        ...


@dataclass(frozen=True)
class Episode:
    """One episode of one actor.

    Attributes:
        value: the return.
        actions: what was done, shape (control steps, entries), in units of the actions' scales.
        duration: of a control step [s].
        final: the outputs at the end that pictures show, name with unit -> shape (n,).
        counters: the task's own numbers at the end.
    """

    value: float
    actions: FloatArray
    duration: float
    final: Mapping[str, FloatArray]
    counters: Mapping[str, float]


class Problem(Protocol):
    """A task as a study sees it. `TaskProblem` is the one for environments; a test may have one of its own.

    Attributes:
        steps: control steps of an episode.
        stage: keyword arguments of the task's smooth objective, where they are not its defaults; None for those.
        entries: numbers in an action.
        observed: numbers in an observation.
        rate: the task's own limit of the action's change per control step, or None.
        gradient_runs: what an objective with its slopes costs, in forward runs: force evaluations over those of a forward run.
    """

    stage: Mapping[str, Any] | None

    @property
    def steps(self) -> int:
        """Control steps of an episode."""
        ...

    @property
    def entries(self) -> int:
        """Numbers in an action."""
        ...

    @property
    def observed(self) -> int:
        """Numbers in an observation."""
        ...

    @property
    def rate(self) -> float | None:
        """The task's own limit of the action's change per control step, or None."""
        ...

    @property
    def gradient_runs(self) -> float:
        """Return the cost of an objective with its slopes, in forward runs."""
        ...

    def returns(self, drives: FloatArray, seeds: Sequence[int]) -> tuple[FloatArray, Counts]:
        """Return mean returns over the episodes, and control steps simulated, (members,); drives (members, steps, entries)."""
        ...

    def policy_returns(
        self, policies: Callable[[int], Policies], members: int, seeds: Sequence[int]
    ) -> tuple[FloatArray, Counts]:
        """Return the same for policies; `policies(episodes)` makes the batch for members x episodes environments."""
        ...

    def value_and_grad(self, drive: FloatArray, seeds: Sequence[int]) -> tuple[float, FloatArray]:
        """Return the smooth objective, averaged over the episodes, and its slopes by the drive, (steps, entries)."""
        ...

    def baselines(self) -> Mapping[str, Actor]:
        """Return the agents to compare with: "nothing", "theory", "best"."""
        ...

    def play(self, actor: Actor, seed: int, log: Path | None = None) -> Episode:
        """One episode in the single environment, recorded where a path is given."""
        ...

    def vector(self, count: int, hold: int = 1, clock: int = 0) -> Any:
        """Return a Gymnasium `VectorEnv` of so many environments, for reinforcement learning; it resets in the same step.

        Args:
            count: how many.
            hold: control steps for which an action is held.
            clock: readings of the time in the observation.
        """
        ...
