"""Random search: the knots of the drive are sampled uniformly between their bounds; the reference for all other methods."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from ..search import Search
from .method import MethodTable


class RandomSearch(MethodTable):
    """A search that samples knots uniformly between the drive's bounds and keeps the best."""

    type: Literal["random"] = "random"
    batch: int = Field(default=32, ge=1, le=100_000, description="drives simulated at a time")

    def run(self, search: Search) -> None:
        """Sample and evaluate one batch of points after another until the budget is spent."""
        random, shape = search.random_generator(), search.shape
        while True:
            search.returns(random.uniform(shape.lowest, shape.highest, (self.batch, shape.size)))
