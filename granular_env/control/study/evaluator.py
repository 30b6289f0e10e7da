"""Evaluations for methods: counted, kept, answered again after a kill, ended by the budget."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from granular_env.components.errors import ExperimentError, StepError, nearest
from granular_env.components.support.float_arrays import FloatArray

from ..drive import DriveShape
from ..problem import Policies, Problem
from .trial_record import PLAYED, RETURN, SLOPES, TrialRecord

# Objective of a drive that breaks the physics; a line search steps back from it.
_BROKEN = 1e6


class BudgetSpentError(Exception):
    """The budget does not hold the next evaluation: the method has ended, as it should."""


class InterruptedByUserError(Exception):
    """Ctrl-C: the trial is left as it is, and goes on when the study is run again."""


class BudgetedEvaluator:
    """A trial in the eyes of its method.

    A method that depends only on its seed and on these answers walks the same path every time. So nothing of a method itself
    is kept: after a kill it runs again from its beginning, gets the answers that the record holds, in their order, at no cost,
    and walks on from where it was.

    Args:
        problem: what is asked.
        shape: how points become drives.
        seed: of the method's random numbers.
        seeds: of the episodes that a point is tried in.
        budget: control steps that may be simulated.
        record: what was kept so far.
        watch: called after each evaluation; it saves, shows, and raises `InterruptedByUserError`.
    """

    def __init__(
        self,
        problem: Problem,
        shape: DriveShape,
        seed: int,
        seeds: Sequence[int],
        budget: int,
        record: TrialRecord,
        watch: Callable[[TrialRecord], None],
    ) -> None:
        self.problem, self.shape, self.seed, self.seeds = problem, shape, seed, list(seeds)
        self.budget, self.record, self.watch = budget, record, watch
        self._place = 0

    def random(self, stream: int = 0) -> np.random.Generator:
        """Random numbers of this trial; `stream` tells apart the draws of one trial."""
        return np.random.default_rng([self.seed, stream])

    def baseline(self, name: str) -> FloatArray:
        """Return the point nearest to what a baseline does in the first episode, shape (size,); it counts as one evaluation.

        Raises:
            ExperimentError: the task has no such baseline.
            BudgetSpentError: the budget does not hold an episode.
        """
        known = self.problem.baselines()
        if name not in known:
            raise ExperimentError(f"got {name!r}", expected="a baseline of this task", hint=nearest(name, known), at="begin")
        if self._place == len(self.record):
            if self.remaining_steps < self.problem.steps:
                raise BudgetSpentError
            self.record.add(PLAYED, None, 0.0, self.problem.steps)
        self._place += 1
        return self.shape.fit(self.problem.play(known[name], self.seeds[0]).actions)

    @property
    def remaining_steps(self) -> int:
        """Control steps that the budget still holds."""
        return self.budget - self.record.spent

    def returns(self, points: FloatArray) -> FloatArray:
        """Return the returns of some drives, averaged over the episodes.

        Args:
            points: shape (members, size); all of them are simulated as one batch.

        Returns:
            Shape (members,).

        Raises:
            BudgetSpentError: the budget does not hold all of them; those that it holds have been evaluated.
            ExperimentError: a return is not finite; what came before it is kept.
        """
        return self._returns(points, lambda chosen: self.problem.returns(self.shape.actions(chosen), self.seeds))

    def policy_returns(self, points: FloatArray, policies: Callable[[FloatArray], Callable[[int], Policies]]) -> FloatArray:
        """Return the same for policies, which `policies` makes of the points."""
        return self._returns(points, lambda chosen: self.problem.policy_returns(policies(chosen), len(chosen), self.seeds))

    def _returns(self, points: FloatArray, ask: Callable[[FloatArray], tuple[FloatArray, npt.NDArray[np.int64]]]) -> FloatArray:
        known = min(len(points), len(self.record) - self._place)
        values = [self.record.value(self._place + one, RETURN, points[one]) for one in range(known)]
        while len(values) < len(points) and (affordable := self.remaining_steps // (self.problem.steps * len(self.seeds))) > 0:
            chosen = points[len(values) : len(values) + affordable]
            found, steps = ask(chosen)
            for point, value, spent in zip(chosen, found.tolist(), steps.tolist(), strict=True):
                refuse_unless_finite("return", value, self.record)
                self.record.add(RETURN, point, value, spent)
                values.append(value)
        self._place += len(values)
        if len(values) > known:
            self.watch(self.record)
        if len(values) < len(points):
            raise BudgetSpentError
        return np.array(values)

    def value_and_slopes(self, point: FloatArray) -> tuple[float, FloatArray]:
        """Return a drive's smooth objective, averaged over the episodes, and its slopes, shape (size,); errors of `returns`."""
        if self._place < len(self.record):
            value, slopes = self.record.value(self._place, SLOPES, point), self.record.slopes(self._place)
            self._place += 1
            return value, slopes
        cost = math.ceil(self.problem.gradient_runs * self.problem.steps * len(self.seeds))
        if self.remaining_steps < cost:
            raise BudgetSpentError
        try:
            value, adjoints = self.problem.value_and_grad(self.shape.actions(point[None])[0], self.seeds)
        except StepError:
            value, adjoints = _BROKEN, np.zeros((self.shape.steps, self.shape.entries))
        slopes = self.shape.pullback(point, adjoints)
        refuse_unless_finite("objective", value, self.record)
        refuse_unless_finite("largest slope of the objective", float(np.abs(slopes).max()), self.record)
        self.record.add(SLOPES, point, value, cost, slopes)
        self._place += 1
        self.watch(self.record)
        return value, slopes


def refuse_unless_finite(what: str, value: float, record: TrialRecord) -> None:
    """`ExperimentError` for a number that nothing can be compared with."""
    if not math.isfinite(value):
        raise ExperimentError(
            f"evaluation {len(record) + 1}: the {what} is {value}",
            expected="a finite number",
            hint="look at the task's parameters",
        )
