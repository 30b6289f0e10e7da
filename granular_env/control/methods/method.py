"""The base of all methods of a study."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar

from pydantic import Field

from granular_env.documents import Table
from granular_env.envs.policies import OpenLoop, Policy
from granular_env.optional_packages import import_optional

from ..problem import Problem
from ..search import Search


class MethodTable(Table):
    """The keys that every [[method]] table of a study's file has.

    Attributes:
        packages: optional modules that the method needs.
        needs_gradient: whether the method needs an objective with gradients.
    """

    packages: ClassVar[tuple[str, ...]] = ()
    needs_gradient: ClassVar[bool] = False

    type: Any = Field(description="type of the method: gradient, cma, random, ppo or sac")
    name: str = Field(
        default="", pattern=r"^([A-Za-z0-9][A-Za-z0-9_-]{0,60})?$", description="name in the results; default: the type"
    )
    knots: int | None = Field(default=None, ge=1, le=100_000, description="knots per entry; default: those of [drive]")

    @property
    def label(self) -> str:
        """Return the name of the method in the results."""
        return self.name or self.type

    def refuse_unless_installed(self) -> None:
        """Raise `MissingExtraError` with the install command for a missing package."""
        for package in self.packages:
            import_optional(package, f"method {self.label!r}")

    def first_result_cost(self, problem: Problem) -> float:
        """Return the cost of the method's first result, in units of one simulated episode."""
        return problem.gradient_runs + 1.0 if self.needs_gradient else 1.0

    def adapt_problem(self, problem: Problem) -> Problem:
        """Return the task with the environment options that the method uses, in training and in the test of its best policy."""
        return problem

    @abstractmethod
    def run(self, search: Search) -> None:
        """Search until the budget is spent (`BudgetSpentError`) or the search is complete."""

    def actor(self, search: Search) -> Policy:
        """Return the best drive or policy of a search as a policy for a single environment."""
        return OpenLoop(search.shape.actions(search.best[None])[0])
