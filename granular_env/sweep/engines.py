"""Engines that compute tasks in local processes or in this process; `ray_cluster` has the same interface."""

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

from granular_env.components.support.threads import thread_count

from .worker import Job, Result, Task, TaskComputer, compute_task

# Number of times a task may lose its process or node before it fails.
_ATTEMPTS = 3
# Longest time that `wait` waits for a task [s].
LOOK_SECONDS = 2.0
# Longest wait for the first task [s], which compiles the kernels that the other processes load.
_ALONE_SECONDS = 60.0
# One thread per process, because there are as many processes as cores.
ONE_THREAD = {"GRANULAR_ENV_THREADS": "1", "OMP_NUM_THREADS": "1"}


class TaskLostError(Exception):
    """The process or node that computed a task ended; the text states how."""


class Engine:
    """The interface of engines, and the engine "serial", which computes tasks sequentially in this process for debugging.

    Attributes:
        capacity: largest number of tasks that may be submitted and not finished at the same time.
    """

    capacity: int = 1

    def __init__(self, job: Job, folder: Path) -> None:
        self._computer = TaskComputer(job, folder)

    def submit(self, task: Task) -> Any:
        """Start the computation of a task; return a handle (any object) for `wait` and `result`."""
        return task

    def wait(self, handles: Collection[Any]) -> Collection[Any]:
        """Wait at most two seconds for finished tasks; return their handles."""
        return list(handles)

    def result(self, handle: Any) -> Result:
        """Return the result of a finished task.

        Raises:
            TaskLostError: the process or node that computed the task ended.
            SweepError: the worker has other code than this process.
        """
        return self._computer.compute(handle)

    def close(self) -> None:
        """End the engine's processes, even if they are computing a task."""


def compute_tasks(engine: Engine, tasks: Sequence[Task], time_limit: float | None = None) -> Iterator[Result]:
    """Yield results of tasks (distinct hashes, `time_limit` [s]) as they finish; if a process or node ends, retry its task."""
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
            except TaskLostError as error:
                attempts[task.hash] += 1
                if time_limit and monotonic() - begun >= time_limit:
                    yield Result(task.hash, "lost", error=f"took longer than the time limit of {time_limit:g} s")
                elif attempts[task.hash] == _ATTEMPTS:
                    yield Result(task.hash, "lost", error=f"its process or node ended {_ATTEMPTS} times: {error}")
                else:
                    waiting.appendleft(task)


class ProcessPool(Engine):
    """An engine with local processes (new interpreters), which are reused for further tasks and replaced when they end.

    Each process has a separate pool, because a process that ends breaks its pool. The processes watch a pipe whose other end
    exists only here, so they end with this program, even if it is killed.
    """

    def __init__(self, job: Job, folder: Path, workers: int | None) -> None:
        self.capacity = workers or thread_count()
        self._job, self._folder = replace(job, files={}), folder  # the processes read the CSV files from the folder
        self._context = get_context("spawn")  # not forked: a forked process may hang if the parent has run compiled kernels
        self._watched, self._lifeline = self._context.Pipe(duplex=False)
        self._idle, self._busy = list[ProcessPoolExecutor](), dict[Future[Result], ProcessPoolExecutor]()

    def submit(self, task: Task) -> Future[Result]:
        """Start the computation of a task in an idle or a new process."""
        pool = self._idle.pop() if self._idle else ProcessPoolExecutor(1, self._context, _prepare_process, (self._watched,))
        try:
            with _worker_settings():
                future = pool.submit(compute_task, self._job, task, self._folder)
        except BrokenProcessPool:  # the process ended while idle
            return self.submit(task)
        self._busy[future] = pool
        return future

    def wait(self, handles: Collection[Future[Result]]) -> Collection[Future[Result]]:
        """Wait at most two seconds for finished tasks; return their handles."""
        return wait(handles, LOOK_SECONDS, FIRST_COMPLETED).done

    def result(self, handle: Future[Result]) -> Result:
        """Return the result of a task."""
        pool = self._busy.pop(handle)
        try:
            found = handle.result()
        except BrokenProcessPool:
            raise TaskLostError("the process ended (killed, out of memory, or a crash of compiled code)") from None
        self._idle.append(pool)
        return found

    def close(self) -> None:
        """End all processes, and wait for them."""
        self._lifeline.close()
        for pool in (*self._idle, *self._busy.values()):
            pool.shutdown(cancel_futures=True)
        self._watched.close()


def _prepare_process(lifeline: Connection) -> None:
    """Prepare a new process: it ignores Ctrl-C, which the parent handles, and ends when the parent's end of the pipe closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def end_with_parent() -> None:
        lifeline.poll(None)
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()


@contextmanager
def _worker_settings() -> Iterator[None]:
    """Within this context, new processes have one thread, ignore Ctrl-C, and do not run the caller's script again."""
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
