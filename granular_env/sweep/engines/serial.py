"""One task after the other in this process: for looking into one, and for components that no other process knows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from ..worker import Computer, Job, Order, Result


def in_series(job: Job, orders: Sequence[Order], folder: Path) -> Iterator[list[Result]]:
    """Yield the results in the order of the tasks."""
    computer = Computer(job, folder)
    for order in orders:
        yield [computer.compute(order)]
