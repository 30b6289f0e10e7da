"""Batches of tasks for workers: small ones together, those whose worker was lost alone and a few times only."""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Iterable, Sequence

from .worker import Order, Result

# How often a task may lose its process or its node before it is given up.
ATTEMPTS = 3
_LARGEST = 1000


class TaskBatches:
    """The tasks that wait, and how long the ones before them took.

    Args:
        orders: all of them.
        workers: how many work at a time; towards the end bundles become smaller, so that all end together.
        seconds: how long a bundle should take.
    """

    def __init__(self, orders: Iterable[Order], workers: int, seconds: float) -> None:
        self._waiting, self.workers, self._seconds = deque(orders), workers, seconds
        self._each: float | None = None

    def __len__(self) -> int:
        return len(self._waiting)

    def take(self) -> list[Order]:
        """Return the next bundle; empty where no tasks remain."""
        if not self._waiting:
            return []
        if self._waiting[0].attempts:
            return [self._waiting.popleft()]
        wanted = 1 if self._each is None else int(self._seconds / self._each)
        size = max(1, min(wanted, len(self._waiting) // (2 * self.workers), _LARGEST))
        bundle: list[Order] = []
        while self._waiting and len(bundle) < size and not self._waiting[0].attempts:
            bundle.append(self._waiting.popleft())
        return bundle

    def note_time(self, tasks: int, seconds: float) -> None:
        """Note how long so many tasks took."""
        each = max(seconds / max(tasks, 1), 1e-6)
        self._each = each if self._each is None else 0.5 * (self._each + each)

    def back(self, orders: Sequence[Order]) -> None:
        """Tasks that nobody has begun wait again."""
        self._waiting.extendleft(reversed(orders))

    def requeue(self, orders: Sequence[Order], reason: str) -> list[Result]:
        """Tasks whose worker ended before it told of them wait again, alone; the results of those that are given up."""
        again = [dataclasses.replace(order, attempts=order.attempts + 1) for order in orders]
        self._waiting.extendleft(order for order in reversed(again) if order.attempts < ATTEMPTS)
        error = f"lost {ATTEMPTS} times: {reason}"
        return [Result(order.hash, "lost", error=error) for order in again if order.attempts >= ATTEMPTS]
