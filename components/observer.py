"""Observers: what looks at a component while it steps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from .inputs import Held


class Observer(Protocol):
    """Looks at a component while it steps (a recorder, a viewer, a progress bar); never changes it."""

    next_tick: int
    """The next tick at which `on_sample` wants to be called; a step that goes past is cut there, invisibly."""

    def on_reset(self, component: Any) -> None:
        """After a reset or a restore: a new history starts here."""

    def on_sample(self, component: Any) -> None:
        """At `next_tick`, perhaps inside a step; sets `next_tick` anew."""

    def on_step(self, component: Any, ticks: int, inputs: Mapping[str, Held]) -> None:
        """After a whole step, with the inputs that were set by it (compiled).

        What is raised here, an interrupt too, reaches the caller once all observers have been told; the step stands. Whoever
        raises it is told once more, as it may have been cut short: `component.tick` says whether it has that step.
        """

    def on_failure(self, component: Any, error: BaseException) -> None:
        """After a step that failed or was interrupted: the component is back where that step began."""
