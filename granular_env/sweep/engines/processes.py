"""Local processes: fresh interpreters that stay warm, get bundles of tasks, and may be killed.

A process tells of what it has done every few hundredths of a second. One that ends, whoever killed it, is replaced; what it
had not told of is run again.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection, wait
from pathlib import Path
from time import perf_counter
from typing import Any

from granular_env.components.errors import SweepError

from ..bundles import Bundles
from ..computing import Computer, Job, Order, Result

_BUNDLE_SECONDS, _TELL_SECONDS = 0.2, 0.05
# A process that ends before it begins was not killed by a task.
_MOST_STILLBORN = 3
# One thread each: as many processes as cores are at work.
THREADS = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")}


def in_processes(job: Job, orders: Sequence[Order], folder: Path, workers: int | None) -> Iterator[list[Result]]:
    """The results, as they come."""
    count = max(1, min(workers or available_cores(), len(orders)))
    bundles, stillborn = Bundles(orders, count, _BUNDLE_SECONDS), 0
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
                    found, seconds = worker.told()
                except (EOFError, OSError):
                    reason, left = worker.ended(), list(worker.given.values())
                    crew[place] = _Worker(job, folder)
                    if worker.begun:
                        yield bundles.lost(left, reason)
                        continue
                    bundles.back(left)
                    stillborn += 1
                    if stillborn >= _MOST_STILLBORN:
                        raise SweepError(f"the processes end before they begin ({reason}); try engine 'serial'") from None
                    continue
                stillborn = 0
                if found:
                    bundles.timed(len(found), seconds)
                    yield found
    finally:
        for worker in crew:
            worker.stop()


def available_cores() -> int:
    """The cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:
        return os.cpu_count() or 1


class _Worker:
    """One process, and the tasks that it was given and has not told of."""

    def __init__(self, job: Job, folder: Path) -> None:
        context = get_context("spawn")  # a fork of a process that has run kernels may hang
        self.connection, theirs = context.Pipe()
        self._process: Any = context.Process(target=_serve, args=(theirs, job, folder), daemon=True)
        with _environment(THREADS), _no_interrupt():
            self._process.start()
        theirs.close()
        self.begun = False
        self.given: dict[str, Order] = {}

    def give(self, bundle: Sequence[Order]) -> None:
        """Hand a bundle over; a process that has ended is found out when it is listened to."""
        self.given = {order.hash: order for order in bundle}
        with suppress(OSError):
            self.connection.send(bundle)

    def told(self) -> tuple[list[Result], float]:
        """Results, and how long they took [s]; `EOFError` where the process has ended."""
        found, seconds = self.connection.recv()
        self.begun = True
        for result in found:
            del self.given[result.hash]
        return found, seconds

    def ended(self) -> str:
        """How the process ended, in words."""
        self.connection.close()
        self._process.join(5.0)
        code = self._process.exitcode
        if code is not None and code < 0:
            name = signal.Signals(-code).name if -code in set(signal.Signals) else "?"
            return f"its process was ended by signal {-code} ({name}), perhaps for lack of memory"
        return f"its process ended with status {code}"

    def stop(self) -> None:
        """End it, in the middle of a task if need be."""
        with suppress(OSError):
            self.connection.close()
        if self._process.is_alive():
            self._process.terminate()
        self._process.join(2.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


@contextmanager
def _environment(values: dict[str, str]) -> Iterator[None]:
    """Environment variables that a process is started with."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


@contextmanager
def _no_interrupt() -> Iterator[None]:
    """A process that is started within does not see Ctrl-C; this one sees it afterwards."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _serve(connection: Connection, job: Job, folder: Path) -> None:
    """What a process does: bundles in, results out, until nobody is there any more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the one who started it
    threading.Thread(target=_end_with_parent, daemon=True).start()
    computer = Computer(job, folder)
    with suppress(EOFError, OSError):
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


def _end_with_parent() -> None:
    """A task of hours shall not go on for nobody."""
    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)
