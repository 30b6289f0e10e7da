"""The base of all methods of a study."""

from __future__ import annotations

from abc import abstractmethod
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import Field

from granular_env.components.errors import MissingExtraError
from granular_env.documents import Table

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from ...problem import Problem
    from ..evaluator import BudgetedEvaluator


class MethodTable(Table):
    """Base of every method: a `[[method]]` table of the study file that can search."""

    packages: ClassVar[tuple[str, ...]] = ()
    """Modules that it needs besides the package's own."""
    extra: ClassVar[str] = ""
    """The extra that installs them."""
    needs_gradient: ClassVar[bool] = False
    """True for one that can search only where the task has an objective with slopes."""

    type: Any = Field(description="which method")
    name: str = Field(
        default="", pattern=r"^([A-Za-z0-9][A-Za-z0-9_-]{0,60})?$", description="what it is called in the results"
    )

    knots: int | None = Field(default=None, ge=1, le=100_000, description="values of each entry; default: those of [drive]")

    @property
    def label(self) -> str:
        """Return the name that it has in the results."""
        return self.name or self.type

    def refuse_unless_installed(self) -> None:
        """`MissingExtraError` with the command that installs what is missing."""
        for package in self.packages:
            try:
                import_module(package)
            except ImportError as error:
                raise MissingExtraError(
                    f"method {self.label!r} needs the package {package}, which cannot be imported ({error})",
                    hint=f"run: pip install 'granular-env[{self.extra}]'",
                ) from error

    def least_runs(self, problem: Problem) -> float:
        """Forward runs of an episode that its first result takes."""
        return 1.0

    @abstractmethod
    def run(self, search: BudgetedEvaluator) -> None:
        """Search until the budget is spent (`BudgetSpentError`), or nothing more is to be found."""

    def actor(self, best: dict[str, npt.NDArray[np.generic]], search: BudgetedEvaluator, problem: Problem) -> Any:
        """Return an agent that plays the best so far in a single environment; by default the drive of the best point."""
        from ...drive import Drive

        return Drive(search.shape.actions(best["point"][None].astype(float))[0])
