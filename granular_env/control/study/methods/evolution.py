"""CMA-ES (Hansen & Ostermeier 2001), by the package cma: a population adapts the normal distribution that it is drawn from."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from granular_env.components.support.float_arrays import FloatArray

from .method import MethodTable

if TYPE_CHECKING:
    from ..evaluator import BudgetedEvaluator


class Evolution(MethodTable):
    """CMA-ES over the knots of the drive; each population is simulated as one batch."""

    packages: ClassVar[tuple[str, ...]] = ("cma",)
    extra: ClassVar[str] = "control"

    type: Literal["cma"] = "cma"
    population: int = Field(default=16, ge=4, le=100_000, description="drives of a generation")
    begin: str = Field(default="", description="a baseline that the first generation lies about; default: none")
    start: float = Field(default=0.0, ge=-1.0, le=1.0, description="value of all knots that the first generation lies about")
    spread: float = Field(default=0.3, gt=0.0, description="standard deviation at the start, in units of the bounds' distance")

    def run(self, search: BudgetedEvaluator) -> None:
        """Search generation after generation; start again elsewhere where it has converged."""
        lowest, highest = search.shape.lowest, search.shape.highest
        middle = np.full(search.shape.size, np.clip(self.start, lowest, highest))
        if self.begin:
            middle = search.baseline(self.begin)
        sigma, bounds = self.spread * (highest - lowest), [lowest, highest]
        evolve(search, middle, sigma, self.population, bounds, search.returns)


def evolve(
    search: BudgetedEvaluator,
    start: FloatArray,
    sigma: float,
    population: int,
    bounds: list[Any],
    returns: Callable[[FloatArray], FloatArray],
) -> None:
    """Search with CMA-ES until the budget is spent.

    Args:
        search: gives the random numbers.
        start: where the first run starts; the next ones start from a draw around it.
        sigma: standard deviation at the start.
        population: points of a generation.
        bounds: least and greatest coordinate, or [None, None].
        returns: what is to become large, of points of shape (population, size).
    """
    import cma

    round_number = 0
    while True:
        random = search.random(round_number)
        here = start if round_number == 0 else start + sigma * random.standard_normal(len(start))
        if bounds[0] is not None:
            here = np.clip(here, bounds[0], bounds[1])
        options = {
            "popsize": population, "bounds": bounds, "verbose": -9, "verb_log": 0, "verb_disp": 0, "seed": np.nan,
            # Its own generator, not numpy's global one: the path depends on the study's seed alone.
            "randn": lambda *shape, draw=random: draw.standard_normal(shape),
        }  # fmt: skip
        strategy = cma.CMAEvolutionStrategy(here, sigma, options)
        # Wall time must end no search: a resumed one would end elsewhere.
        while not _stuck(strategy.stop() or {}):
            points = np.array(strategy.ask())
            strategy.tell(list(points), (-returns(points)).tolist())
        round_number += 1


def _stuck(reasons: Any) -> bool:
    return any(reason not in ("timeout", "maxfevals", "maxiter") for reason in reasons)
