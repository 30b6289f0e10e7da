"""Random search: points drawn evenly between the bounds. What every other method has to beat."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from pydantic import Field

from .method import MethodTable

if TYPE_CHECKING:
    from ..evaluator import BudgetedEvaluator


class RandomSearch(MethodTable):
    """Draws knots evenly between the drive's bounds, and keeps the best."""

    type: Literal["random"] = "random"
    batch: int = Field(default=32, ge=1, le=100_000, description="drives that are simulated at a time")

    def run(self, search: BudgetedEvaluator) -> None:
        """Draw batch after batch."""
        random, shape = search.random(), search.shape
        while True:
            search.returns(random.uniform(shape.lowest, shape.highest, (self.batch, shape.size)))
