"""Local processes: fresh interpreters that stay warm, get bundles of tasks, and may be killed.

A process tells of what it has done every few hundredths of a second. One that ends, whoever killed it, is replaced; what it
had not told of is run again.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from pathlib import Path
from time import perf_counter

from granular_env.components.errors import Fault, Option, SweepError
from granular_env.workers import Worker, stop_all

from ..batches import TaskBatches
from ..worker import Computer, Job, Order, Result

_BUNDLE_SECONDS, _TELL_SECONDS = 0.2, 0.05
# A process that ends before it begins was not killed by a task.
_MOST_STILLBORN = 3


def in_processes(job: Job, orders: Sequence[Order], folder: Path, workers: int | None) -> Iterator[list[Result]]:
    """Yield the results as they come."""
    count = max(1, min(workers or available_cores(), len(orders)))
    bundles, stillborn = TaskBatches(orders, count, _BUNDLE_SECONDS), 0
    crew = [_Worker(job, folder) for _ in range(count)]
    try:
        while len(bundles) or any(worker.given for worker in crew):
            for worker in crew:
                if not worker.given and (bundle := bundles.take()):
                    worker.give(bundle)
            for ready in wait([worker.connection for worker in crew]):
                place = next(place for place, worker in enumerate(crew) if worker.connection is ready)
                worker = crew[place]
                try:
                    found, seconds = worker.receive()
                except (EOFError, OSError):
                    reason, left = worker.exit_reason(), list(worker.given.values())
                    crew[place] = _Worker(job, folder)
                    if worker.begun:
                        yield bundles.requeue(left, reason)
                        continue
                    bundles.back(left)
                    stillborn += 1
                    if stillborn >= _MOST_STILLBORN:
                        begun = f"the processes end before they begin ({reason})"
                        raise SweepError(Fault(received=begun, hint=("try ", Option("engine", "serial")))) from None
                    continue
                stillborn = 0
                if found:
                    bundles.note_time(len(found), seconds)
                    yield found
    finally:
        stop_all(crew)


def available_cores() -> int:
    """Return the cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:
        return os.cpu_count() or 1


class _Worker(Worker):
    """One process, and the tasks that it was given and has not told of."""

    def __init__(self, job: Job, folder: Path) -> None:
        super().__init__(_serve, job, folder)
        self.begun = False
        self.given: dict[str, Order] = {}

    def give(self, bundle: Sequence[Order]) -> None:
        """Hand a bundle over; a process that has ended is found out when it is listened to."""
        self.given = {order.hash: order for order in bundle}
        with suppress(OSError):
            self.connection.send(bundle)

    def receive(self) -> tuple[list[Result], float]:
        """Results, and how long they took [s]; `EOFError` where the process has ended."""
        found, seconds = self.connection.recv()
        self.begun = True
        for result in found:
            del self.given[result.hash]
        return found, seconds


def _serve(connection: Connection, job: Job, folder: Path) -> None:
    """Compute bundles in a worker process until its parent closes the pipe or exits."""
    computer = Computer(job, folder)
    connection.send(([], 0.0))
    while True:
        _work(connection, computer, connection.recv())


def _work(connection: Connection, computer: Computer, bundle: Sequence[Order]) -> None:
    found: list[Result] = []
    began = perf_counter()
    for place, order in enumerate(bundle, start=1):
        found.append(computer.compute(order))
        spent = perf_counter() - began
        if place == len(bundle) or spent > _TELL_SECONDS:
            connection.send((found, spent))
            found, began = [], perf_counter()
