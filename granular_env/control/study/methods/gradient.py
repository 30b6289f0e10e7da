"""L-BFGS-B (Byrd et al. 1995), by scipy, on the task's smooth objective, with the slopes of the discrete adjoint."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from pydantic import Field

from .method import MethodTable

if TYPE_CHECKING:
    from ..search import Search

FloatArray = npt.NDArray[np.float64]


class Gradient(MethodTable):
    """L-BFGS-B over the knots, from several starts; whatever is better than the start's best so far is judged by its return."""

    type: str = "gradient"
    spread: float = Field(default=0.3, ge=0.0, description="how far the starts lie from rest, in units of the bounds' distance")
    memory: int = Field(default=10, ge=1, le=1000, description="steps that the estimate of the curvature rests on")
    iterations: int = Field(default=200, ge=1, description="most iterations from one start")
    starts: int | None = Field(default=None, ge=1, description="how many starts; default: until the budget is spent")

    def run(self, search: Search) -> None:
        """Start after start."""
        from scipy.optimize import minimize

        shape, start = search.shape, 0
        while self.starts is None or start < self.starts:
            lowest_yet = [math.inf]

            def judged(point: FloatArray, lowest_yet: list[float] = lowest_yet) -> tuple[float, FloatArray]:
                value, slopes = search.value_and_slopes(point)
                if value < lowest_yet[0]:
                    lowest_yet[0] = value
                    search.returns(point[None])
                return value, slopes

            random = search.random(start)
            drawn = random.uniform(-1.0, 1.0, shape.size) * self.spread * (shape.highest - shape.lowest)
            first = np.clip(drawn, shape.lowest, shape.highest)
            options = {"maxiter": self.iterations, "maxcor": self.memory, "maxfun": 10**9, "ftol": 1e-15, "gtol": 0.0}
            bounds = [(shape.lowest, shape.highest)] * shape.size
            minimize(judged, first, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
            start += 1
