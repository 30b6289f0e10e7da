"""CMA-ES (Hansen & Ostermeier 2001) from the package cma: samples populations from a normal distribution and adapts it."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from ..search import Search
from .method import MethodTable


class Evolution(MethodTable):
    """CMA-ES over the knots of the drive (see `DriveShape`); each population is simulated as one batch."""

    packages: ClassVar[tuple[str, ...]] = ("cma",)

    type: Literal["cma"] = "cma"
    population: int = Field(default=16, ge=4, le=100_000, description="drives per generation")
    begin: str = Field(default="", description="name of the baseline used as mean of the first generation; default: none")
    start: float = Field(default=0.0, ge=-1.0, le=1.0, description="mean of all knots at the start (unless begin is set)")
    spread: float = Field(default=0.3, gt=0.0, description="initial standard deviation, as a fraction of highest - lowest")

    def run(self, search: Search) -> None:
        """Search one generation after another; restart at another point after convergence."""
        import cma

        lowest, highest = search.shape.lowest, search.shape.highest
        middle = search.baseline_point(self.begin) if self.begin else np.full(search.shape.size, self.start)
        sigma, round_number = self.spread * (highest - lowest), 0
        while True:
            random = search.random_generator(round_number)
            here = middle if round_number == 0 else middle + sigma * random.standard_normal(len(middle))
            options = {
                "popsize": self.population, "bounds": [lowest, highest], "verbose": -9, "verb_log": 0, "verb_disp": 0,
                # A separate generator instead of NumPy's global one, so that the path depends only on the study's seed.
                "seed": np.nan, "randn": lambda *shape, draw=random: draw.standard_normal(shape),
            }  # fmt: skip
            strategy = cma.CMAEvolutionStrategy(np.clip(here, lowest, highest), sigma, options)
            # Wall time must not end a search; otherwise the same study would find different drives.
            while not set(strategy.stop() or {}) - {"timeout", "maxfevals", "maxiter"}:
                points = np.array(strategy.ask())
                strategy.tell(list(points), (-search.returns(points)).tolist())
            round_number += 1
