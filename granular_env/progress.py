"""The progress bar of a run: simulated time, speed, and the ledger's residual. Looks at the component, never changes it."""

from __future__ import annotations

from time import perf_counter
from types import TracebackType
from typing import Any, Self

from granular_env.components.contract import Component

_REFRESH_SECONDS = 0.1


class Progress:
    """A bar on standard error while a run advances; use it as a context manager.

    Args:
        title: what stands before the bar.
        end: the tick at which the run ends.
    """

    def __init__(self, title: str, end: int) -> None:
        self._title, self._end = title, end
        self._next = 0.0

    def __enter__(self) -> Self:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

        self._bar: Any = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=24),
            TaskProgressColumn(),
            TextColumn("{task.fields[figures]}"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        self._task = self._bar.add_task(self._title, total=self._end, figures="")
        self._bar.start()
        self._began = perf_counter()
        self._first: int | None = None
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._bar.stop()

    def update(self, component: Component) -> None:
        """Show where the component is now; cheap where it was shown a moment ago."""
        now = perf_counter()
        if now < self._next:
            return
        self._next = now + _REFRESH_SECONDS
        if self._first is None:
            self._first = component.tick
        self._bar.update(self._task, completed=component.tick, figures=self._figures(component, now))

    def _figures(self, component: Component, now: float) -> str:
        speed = (component.tick - (self._first or 0)) / max(now - self._began, 1e-9)
        return f"t = {component.time:.4g} s  {speed:,.0f} steps/s  {residual(component)}"


def residual(component: Component) -> str:
    """The energy that the numerics made or lost, beside the energy that was there."""
    ledger = component.ledger()
    scale = max(ledger.kinetic_energy + ledger.potential_energy, abs(ledger.input_work))
    share = f" ({ledger.energy_residual / scale:+.1e})" if scale > 0.0 else ""
    return f"energy residual {ledger.energy_residual:+.2e} J{share}"
