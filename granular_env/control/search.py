"""Evaluations for methods, counted and limited by the budget."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from granular_env.components.errors import ExperimentError, StepError, spelling_hint
from granular_env.components.support.float_arrays import FloatArray

from .drive import DriveShape
from .problem import Problem

# Objective of a drive that raises `StepError`; so large that the line search shortens its step.
_BROKEN = 1e6


class BudgetSpentError(Exception):
    """The rest of the budget is too small for the next evaluation: the regular end of a search."""


class Search:
    """The evaluations of one method with one seed.

    Args:
        problem: the task.
        shape: map from points to drives.
        seed: seed of the method's random numbers.
        seeds: seeds of the episodes in which points (see `DriveShape`) are evaluated.
        budget: largest number of simulated control steps.
        watch: function called with this `Search` after each evaluation.

    Attributes:
        spent: number of simulated control steps.
        best: the point or the policy with the largest return.
        best_return: return of `best`; -inf before the first evaluation.
        curve: (control steps, best return) at each improvement.
    """

    def __init__(
        self,
        problem: Problem,
        shape: DriveShape,
        seed: int,
        seeds: Sequence[int],
        budget: int,
        on_evaluation: Callable[[Search], None] = lambda search: None,
    ) -> None:
        self.problem, self.shape, self.seed, self.seeds = problem, shape, seed, list(seeds)
        self.budget, self._watch = budget, on_evaluation
        self.spent = 0
        self.best: Any = None
        self.best_return, self.curve = -math.inf, list[tuple[int, float]]()

    @property
    def remaining_steps(self) -> int:
        """Return the number of control steps left in the budget."""
        return self.budget - self.spent

    def random_generator(self, stream: int = 0) -> np.random.Generator:
        """Return a random generator of this trial; `stream` distinguishes several generators of a trial."""
        return np.random.default_rng([self.seed, stream])

    def count_steps(self, steps: int) -> None:
        """Add simulated control steps to `spent`."""
        self.spent += steps
        self._watch(self)

    def count_return(self, candidate: Any, value: float, steps: int) -> None:
        """Add `steps` to `spent`, and store the point or the policy if its return `value` is the best so far.

        Raises:
            ExperimentError: the return is not finite.
        """
        self._refuse_unless_finite("return", value)
        if value > self.best_return:
            self.best, self.best_return = candidate, value
            self.curve.append((self.spent + steps, value))
        self.count_steps(steps)

    def baseline_point(self, name: str) -> FloatArray:
        """Play a baseline in the first search episode, spending budget; return the point (size,) that fits its actions best.

        Raises:
            ExperimentError: the task has no such baseline.
            BudgetSpentError: the budget is too small for an episode.
        """
        known = self.problem.baselines()
        if name not in known:
            hint = spelling_hint(name, known)
            raise ExperimentError(f"got {name!r}", expected="a baseline of this task", hint=hint, at="begin")
        if self.remaining_steps < self.problem.steps:
            raise BudgetSpentError
        self.count_steps(self.problem.steps)
        return self.shape.fit_point(self.problem.play_episode(known[name], self.seeds[0])[1])

    def returns(self, points: FloatArray) -> FloatArray:
        """Return for each point the return of its drive, averaged over the search episodes.

        Args:
            points: shape (members, size), simulated as one batch.

        Returns:
            Shape (members,).

        Raises:
            BudgetSpentError: the budget is too small for all points; points within the budget have been evaluated.
        """
        affordable = max(self.remaining_steps // (self.problem.steps * len(self.seeds)), 0)
        chosen = points[:affordable]
        if not len(chosen):
            raise BudgetSpentError
        values, steps = self.problem.returns(self.shape.actions(chosen), self.seeds)
        for point, value, spent in zip(chosen, values.tolist(), steps.tolist(), strict=True):
            self.count_return(np.array(point), value, spent)
        if len(chosen) < len(points):
            return np.concatenate([values, self.returns(points[len(chosen) :])])  # budget left by episodes that ended early
        return values

    def value_and_slopes(self, point: FloatArray) -> tuple[float, FloatArray]:
        """Return the smooth objective at a point, averaged over the episodes, and its gradient (size,); errors as `returns`."""
        cost = math.ceil(self.problem.gradient_runs * self.problem.steps * len(self.seeds))
        if self.remaining_steps < cost:
            raise BudgetSpentError
        try:
            value, adjoints = self.problem.value_and_grad(self.shape.actions(point[None])[0], self.seeds)
        except StepError:
            value, adjoints = _BROKEN, np.zeros((self.shape.steps, self.shape.entries))
        slopes = self.shape.pullback(point, adjoints)
        self._refuse_unless_finite("objective", value + float(np.abs(slopes).max()))
        self.count_steps(cost)
        return value, slopes

    def _refuse_unless_finite(self, what: str, value: float) -> None:
        if not math.isfinite(value):
            received = f"the {what} is {value} after {self.spent} control steps"
            raise ExperimentError(received, expected="a finite number", hint="check the task's parameters")
