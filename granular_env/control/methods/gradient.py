"""L-BFGS-B (Byrd et al. 1995) from SciPy, on the task's smooth objective, with gradients of the discrete adjoint."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from granular_env.components.support.float_arrays import FloatArray

from ..search import Search
from .method import MethodTable


class Gradient(MethodTable):
    """L-BFGS-B over the knots of the drive: a few iterations from each of several points, then a descent from the best.

    There are many local optima, which differ in the number of waves that the drive sends. The return is also evaluated for
    each drive that lowers the objective.
    """

    needs_gradient: ClassVar[bool] = True

    type: Literal["gradient"] = "gradient"
    begin: str = Field(default="", description="baseline used as first start and centre of the others; default: none")
    start: float = Field(
        default=0.0, ge=-1.0, le=1.0, description="value of all knots at the centre of the starts (unless begin is set)"
    )
    spread: float = Field(default=0.3, ge=0.0, description="half-width of the random starts, as a fraction of highest - lowest")
    draws: int | None = Field(
        default=None, ge=2, description="number of random values per entry, interpolated to the knots; default: one per knot"
    )
    starts: int = Field(default=4, ge=1, description="number of start points per round")
    trial: int = Field(default=20, ge=1, description="number of iterations from each start point of a round")
    iterations: int = Field(default=1000, ge=1, description="maximum number of iterations from the best point of a round")
    rounds: int | None = Field(
        default=None, ge=1, description="number of rounds; default: until the budget is spent", examples=[3]
    )
    stages: list[dict[str, Any]] = Field(
        default=[{}],
        min_length=1,
        description="arguments of the task's objective, one table per stage; each stage starts from the previous stage's best",
    )
    memory: int = Field(default=20, ge=1, le=1000, description="number of previous steps in the approximation of the Hessian")

    def run(self, search: Search) -> None:
        """Search in rounds: a few iterations from each of new start points, then one descent per stage from the best point."""
        shape, number = search.shape, 0
        as_tuples = [{key: tuple(one) if isinstance(one, list) else one for key, one in stage.items()} for stage in self.stages]
        middle = search.baseline_point(self.begin) if self.begin else np.full(shape.size, self.start)
        while self.rounds is None or number < self.rounds:
            starts = [self._start_point(search, middle, number * self.starts + place) for place in range(self.starts)]
            search.problem.stage = as_tuples[0]
            found = [self._run_lbfgs(search, start, self.trial) for start in starts]
            _, best = min(found, key=lambda pair: pair[0])  # of equal values, take the first
            for stage in as_tuples:
                search.problem.stage = stage
                _, best = self._run_lbfgs(search, best, self.iterations)
            number += 1

    def _start_point(self, search: Search, middle: FloatArray, number: int) -> FloatArray:
        """Return start point `number`, sampled around `middle`; point 0 is `middle` itself if `begin` names a baseline."""
        shape = search.shape
        if self.begin and number == 0:
            return middle
        drawn = search.random_generator(number).uniform(-1.0, 1.0, (shape.entries, self.draws or shape.knots))
        if self.draws is not None:
            along = np.linspace(0.0, self.draws - 1.0, shape.knots)
            drawn = np.array([np.interp(along, np.arange(self.draws), row) for row in drawn])
        reach = self.spread * (shape.highest - shape.lowest)
        return np.clip(middle + reach * drawn.reshape(-1), shape.lowest, shape.highest)

    def _run_lbfgs(self, search: Search, start: FloatArray, iterations: int) -> tuple[float, FloatArray]:
        """Return the smallest value of the objective found by L-BFGS-B, and the point where it was found."""
        from scipy.optimize import minimize

        least = [math.inf]

        def objective(point: FloatArray) -> tuple[float, FloatArray]:
            value, slopes = search.value_and_slopes(point)
            if value < least[0]:
                least[0] = value
                search.returns(point[None])
            return value, slopes

        # No tolerances: the search ends after `iterations`, or when rounding errors stop the line search.
        options = {"maxiter": iterations, "maxcor": self.memory, "maxfun": 10**9, "ftol": 0.0, "gtol": 0.0}
        bounds = [(search.shape.lowest, search.shape.highest)] * search.shape.size
        ended = minimize(objective, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
        return float(ended.fun), np.asarray(ended.x, dtype=np.float64)
