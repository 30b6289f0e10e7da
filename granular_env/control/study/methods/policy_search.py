"""CMA-ES over the numbers of a feedback policy, which sees the task's observations and acts on them in every control step."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field

from granular_env.components.support.float_arrays import FloatArray

from .evolution import evolve
from .method import MethodTable

if TYPE_CHECKING:
    from ...problem import Policies, Problem
    from ..evaluator import BudgetedEvaluator


class PolicySearch(MethodTable):
    """Searches the weights of a policy that is linear in the observation."""

    packages: ClassVar[tuple[str, ...]] = ("cma",)
    extra: ClassVar[str] = "control"

    type: Literal["policy"] = "policy"
    policy: Literal["linear"] = Field(default="linear", description="what the numbers are of")
    population: int = Field(default=16, ge=4, le=100_000, description="policies of a generation")
    spread: float = Field(default=0.1, gt=0.0, description="standard deviation of the weights at the start")

    def run(self, search: BudgetedEvaluator) -> None:
        """Search generation after generation, each policy in all episodes."""
        entries, size = search.problem.entries, search.problem.observed

        def returns(points: FloatArray) -> FloatArray:
            return search.policy_returns(points, lambda chosen: _batches(chosen, entries))

        start = np.zeros(entries * (size + 1))
        evolve(search, start, self.spread, self.population, [None, None], returns)

    def actor(self, best: dict[str, npt.NDArray[np.generic]], search: BudgetedEvaluator, problem: Problem) -> Any:
        """Return the best policy as an agent."""
        return Single(_batches(best["point"][None].astype(float), problem.entries)(1))


class LinearPolicies:
    """action = clip(weights . observation + offset, -1, 1), with weights of its own for every environment.

    Args:
        points: shape (environments, entries x (size + 1)); the offset is the last of each entry's numbers.
        entries: numbers in an action.
    """

    def __init__(self, points: FloatArray, entries: int) -> None:
        self._weights = points.reshape(len(points), entries, -1)

    def reset(self) -> None:
        """Do nothing: the agent has no memory."""

    def __call__(self, observations: FloatArray) -> FloatArray:
        """Actions, shape (environments, entries)."""
        # Products and sums in numpy's own order, not BLAS's: the same bits in any batch.
        weighted = (self._weights[:, :, :-1] * np.asarray(observations, dtype=np.float64)[:, None, :]).sum(axis=2)
        return np.clip(weighted + self._weights[:, :, -1], -1.0, 1.0)


def _batches(points: FloatArray, entries: int) -> Callable[[int], Policies]:
    """For every policy so many environments, one after the other."""
    return lambda episodes: LinearPolicies(np.repeat(points, episodes, axis=0), entries)


class Single:
    """The only policy of a batch, in a single environment."""

    def __init__(self, policies: Policies) -> None:
        self._policies = policies

    def reset(self) -> None:
        """Begin an episode."""
        self._policies.reset()

    def __call__(self, observation: Any, info: Any) -> FloatArray:
        """Return the action of the next control step, shape (entries,)."""
        return self._policies(np.asarray(observation)[None])[0]
