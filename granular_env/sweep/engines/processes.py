"""Local processes: fresh interpreters that stay warm, get bundles of tasks, and may be killed.

A process reports its results every few hundredths of a second. A process that ends is replaced, and the tasks that it had not
reported are run again. With a time limit each bundle is one task.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from pathlib import Path
from time import monotonic, perf_counter

from granular_env.components.errors import Fault, Option, SweepError
from granular_env.workers import Worker, stop_all

from ..batches import TaskBatches
from ..worker import Computer, Job, Order, Result

_BUNDLE_SECONDS, _TELL_SECONDS = 0.2, 0.05
# Wall time between two looks at the time limit [s].
_LOOK_SECONDS = 0.2
# A process that ends before it begins was not killed by a task.
_MOST_STILLBORN = 3


def in_processes(job: Job, orders: Sequence[Order], folder: Path, workers: int | None) -> Iterator[list[Result]]:
    """Yield the results as they come."""
    count, limit = max(1, min(workers or available_cores(), len(orders))), job.time_limit
    bundles, stillborn = TaskBatches(orders, count, 0.0 if limit else _BUNDLE_SECONDS), 0
    crew = [_Worker(job, folder) for _ in range(count)]
    try:
        while len(bundles) or any(worker.given for worker in crew):
            for worker in crew:
                if not worker.given and (bundle := bundles.take()):
                    worker.give(bundle)
            for place, worker in enumerate(crew):
                if limit and monotonic() > worker.begun_task + limit:
                    worker.stop()
                    crew[place] = _Worker(job, folder)
                    yield [Result(order.hash, "lost", error=over_time(limit)) for order in worker.given.values()]
            for ready in wait([worker.connection for worker in crew], _LOOK_SECONDS if limit else None):
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


def over_time(limit: float) -> str:
    """Return the error of a task that took longer than the time limit."""
    return f"took longer than the time limit of {limit:g} s"


def available_cores() -> int:
    """Return the cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:
        return os.cpu_count() or 1


class _Worker(Worker):
    """One process, and the tasks that it was given and has not reported.

    Attributes:
        begun: whether the process has answered.
        begun_task: when it began its present task; infinity before that.
        given: hash -> task.
    """

    def __init__(self, job: Job, folder: Path) -> None:
        super().__init__(_serve, job, folder)
        self.begun, self.begun_task = False, math.inf
        self.given: dict[str, Order] = {}

    def give(self, bundle: Sequence[Order]) -> None:
        """Hand a bundle over; a process that has ended is found out when it is listened to."""
        self.given, self.begun_task = {order.hash: order for order in bundle}, math.inf
        with suppress(OSError):
            self.connection.send(bundle)

    def receive(self) -> tuple[list[Result], float]:
        """Return results, and how long they took [s].

        Raises:
            EOFError: the process has ended.
            SweepError: the process cannot compute this job.
        """
        answer = self.connection.recv()
        if isinstance(answer, SweepError):
            raise answer
        found, seconds = answer
        for result in found:
            del self.given[result.hash]
        self.begun_task = monotonic() if self.begun and self.given else math.inf
        self.begun = True
        return found, seconds


def _serve(connection: Connection, job: Job, folder: Path) -> None:
    """Compute bundles in a worker process until its parent closes the pipe or exits."""

    def tell() -> None:
        connection.send(([], 0.0))

    try:
        computer = Computer(job, folder)
    except SweepError as error:
        connection.send(error)
        return
    tell()
    while True:
        bundle = connection.recv()
        for order in bundle:
            computer.warm(order, tell)
        tell()
        _work(connection, computer, bundle)


def _work(connection: Connection, computer: Computer, bundle: Sequence[Order]) -> None:
    found: list[Result] = []
    began = perf_counter()
    for place, order in enumerate(bundle, start=1):
        found.append(computer.compute(order))
        spent = perf_counter() - began
        if place == len(bundle) or spent > _TELL_SECONDS:
            connection.send((found, spent))
            found, began = [], perf_counter()
