"""Local processes: fresh interpreters that stay warm, and end with the program that started them."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Collection, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import replace
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path

from ..worker import Job, Result, Task, compute_task
from .engine import LOOK_SECONDS, Engine, LostError

# One thread each: as many processes as cores are at work.
_THREADS: dict[str, str] = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
)


class Processes(Engine):
    """Computes tasks in local processes; one that ends is replaced.

    Each process has a pool of its own, because a process that ends breaks its pool. The processes watch a pipe whose other end
    is here alone: they end with this program, even if it is killed.
    """

    def __init__(self, job: Job, folder: Path, workers: int | None) -> None:
        self.capacity = workers or available_cores()
        self._job, self._folder = replace(job, files={}), folder  # the files are in the folder
        self._context = get_context("spawn")  # a fork of a process that has run kernels may hang
        self._watched, self._lifeline = self._context.Pipe(duplex=False)
        self._idle, self._busy = list[ProcessPoolExecutor](), dict[Future[Result], ProcessPoolExecutor]()

    def submit(self, task: Task) -> Future[Result]:
        """Begin to compute a task in an idle process, or in a new one."""
        pool = self._idle.pop() if self._idle else ProcessPoolExecutor(1, self._context, _begin, (self._watched,))
        with _worker_settings():
            future = pool.submit(compute_task, self._job, task, self._folder)
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


def available_cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


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
    main, environment = vars(sys.modules["__main__"]), dict(os.environ)
    script = {name: main[name] for name in ("__spec__", "__file__") if name in main}
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        main["__spec__"] = None
        main.pop("__file__", None)
        os.environ.update(_THREADS)
        yield
    finally:
        main.update(script)
        for name in _THREADS:
            del os.environ[name]
        os.environ.update(environment)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
