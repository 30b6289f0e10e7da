"""Statistics of a result over many seeds: mean, deviation, quantiles, and where one draw stands among them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt


@dataclasses.dataclass(frozen=True)
class Band:
    """A result of many seeds.

    Attributes:
        draws: one number for each seed, in the seeds' order.
    """

    draws: Sequence[float]

    @classmethod
    def of(cls, draws: npt.ArrayLike) -> Band:
        """Make it from any array."""
        return cls(tuple(float(draw) for draw in np.asarray(draws, dtype=np.float64).ravel()))

    @property
    def count(self) -> int:
        """Return the number of seeds."""
        return len(self.draws)

    @property
    def mean(self) -> float:
        """Return the mean of all draws."""
        return float(np.mean(self.draws))

    @property
    def deviation(self) -> float:
        """Return the standard deviation of all draws, with one degree of freedom spent on the mean."""
        return float(np.std(self.draws, ddof=1)) if self.count > 1 else 0.0

    @property
    def error_of_mean(self) -> float:
        """The standard error of the mean."""
        return self.deviation / self.count**0.5

    @property
    def low(self) -> float:
        """The smallest draw."""
        return min(self.draws)

    @property
    def high(self) -> float:
        """The largest draw."""
        return max(self.draws)

    def quantile(self, percent: float) -> float:
        """Return the value below which that part of the draws lies, linear between draws."""
        return float(np.percentile(self.draws, percent))

    def percentile(self, value: float) -> float:
        """Return how many percent of the draws are smaller; equal ones count half."""
        draws = np.asarray(self.draws)
        return float(100.0 * (np.mean(draws < value) + 0.5 * np.mean(draws == value)))

    def __str__(self) -> str:
        # As many decimals as give the standard deviation two digits.
        digits = max(0, 1 - math.floor(math.log10(self.deviation))) if self.deviation > 0.0 else 3
        mean, spread, low, high = (
            f"{value:.{digits}f}" for value in (self.mean, self.deviation, self.quantile(5), self.quantile(95))
        )
        return f"{mean} ± {spread} [{low}, {high}]"
