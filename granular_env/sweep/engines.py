"""Engines: where tasks are computed, in local processes or in this one. `ray_cluster` is the third, with the same interface."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections import Counter, deque
from collections.abc import Collection, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import replace
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from time import monotonic
from types import ModuleType
from typing import Any

from granular_env.components.support.parts import thread_count

from .worker import Computer, Job, Result, Task, compute_task

# How often a task may lose its process or its node before it is given up.
_ATTEMPTS = 3
# Longest wait for a task [s].
LOOK_SECONDS = 2.0
# The first task compiles the kernels, which the other processes then load. Longest wait for it [s].
_ALONE_SECONDS = 60.0
# One thread in each process: as many processes as cores are at work.
ONE_THREAD = {"GRANULAR_ENV_THREADS": "1", "OMP_NUM_THREADS": "1"}


class LostError(Exception):
    """The process or the node of a task ended; the text says how."""


class Engine:
    """The interface of engines, and the engine "serial": one task after the other in this process, for debugging.

    Attributes:
        capacity: how many tasks may be submitted at a time.
    """

    capacity: int = 1

    def __init__(self, job: Job, folder: Path) -> None:
        self._computer = Computer(job, folder)

    def submit(self, task: Task) -> Any:
        """Begin to compute a task; return a handle of it."""
        return task

    def wait(self, handles: Collection[Any]) -> Collection[Any]:
        """Wait until some tasks are over, at most for two seconds; return their handles."""
        return list(handles)

    def result(self, handle: Any) -> Result:
        """Return the result of a task that is over.

        Raises:
            LostError: its process or its node ended.
            SweepError: its worker refuses to compute.
        """
        return self._computer.compute(handle)

    def close(self) -> None:
        """End the processes that the engine started, in the middle of a task if need be."""


def compute_all(engine: Engine, tasks: Sequence[Task], time_limit: float | None = None) -> Iterator[Result]:
    """Yield the results of tasks as they come; a task whose process or node ended is computed again, a few times.

    Args:
        engine: computes them.
        tasks: each with another hash.
        time_limit: wall time of a task [s].
    """
    waiting, attempts, alone_until = deque(tasks), Counter[str](), monotonic() + _ALONE_SECONDS
    running: dict[Any, tuple[Task, float]] = {}
    while waiting or running:
        while waiting and len(running) < (1 if monotonic() < alone_until else engine.capacity):
            task = waiting.popleft()
            running[engine.submit(task)] = task, monotonic()
        for handle in engine.wait(running.keys()):
            (task, begun), alone_until = running.pop(handle), 0.0
            try:
                yield engine.result(handle)
            except LostError as error:
                attempts[task.hash] += 1
                if time_limit and monotonic() - begun >= time_limit:
                    yield Result(task.hash, "lost", error=f"took longer than the time limit of {time_limit:g} s")
                elif attempts[task.hash] == _ATTEMPTS:
                    yield Result(task.hash, "lost", error=f"lost {_ATTEMPTS} times: {error}")
                else:
                    waiting.appendleft(task)


class Processes(Engine):
    """Computes tasks in local processes, which are fresh interpreters and stay for the next task; one that ends is replaced.

    Each process has its own pool, because a process that ends breaks its pool. The processes watch a pipe whose other end
    is here alone: they end with this program, even if it is killed.
    """

    def __init__(self, job: Job, folder: Path, workers: int | None) -> None:
        self.capacity = workers or thread_count()
        self._job, self._folder = replace(job, files={}), folder  # the files are in the folder
        self._context = get_context("spawn")  # a fork of a process that has run kernels may hang
        self._watched, self._lifeline = self._context.Pipe(duplex=False)
        self._idle, self._busy = list[ProcessPoolExecutor](), dict[Future[Result], ProcessPoolExecutor]()

    def submit(self, task: Task) -> Future[Result]:
        """Begin to compute a task in an idle process, or in a new one."""
        pool = self._idle.pop() if self._idle else ProcessPoolExecutor(1, self._context, _begin, (self._watched,))
        try:
            with _worker_settings():
                future = pool.submit(compute_task, self._job, task, self._folder)
        except BrokenProcessPool:  # its process ended while it was idle
            return self.submit(task)
        self._busy[future] = pool
        return future

    def wait(self, handles: Collection[Future[Result]]) -> Collection[Future[Result]]:
        """Wait for a task, at most for two seconds."""
        return wait(handles, LOOK_SECONDS, FIRST_COMPLETED).done

    def result(self, handle: Future[Result]) -> Result:
        """Return the result of a task."""
        pool = self._busy.pop(handle)
        try:
            found = handle.result()
        except BrokenProcessPool:
            raise LostError("its process ended (killed, out of memory, or a crash of compiled code)") from None
        self._idle.append(pool)
        return found

    def close(self) -> None:
        """End all processes, and wait for them."""
        self._lifeline.close()
        for pool in (*self._idle, *self._busy.values()):
            pool.shutdown(cancel_futures=True)
        self._watched.close()


def _begin(lifeline: Connection) -> None:
    """Prepare a new process: it ignores Ctrl-C, which is for its parent, and ends when the parent's end of the pipe closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def end_with_parent() -> None:
        lifeline.poll(None)
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()


@contextmanager
def _worker_settings() -> Iterator[None]:
    """Start processes with one thread each, without Ctrl-C, and without the caller's script, which would run again there."""
    main, environment = sys.modules["__main__"], dict(os.environ)
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        sys.modules["__main__"] = ModuleType("__main__")
        os.environ.update(ONE_THREAD)
        yield
    finally:
        sys.modules["__main__"] = main
        for name in ONE_THREAD:
            del os.environ[name]
        os.environ.update(environment)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
