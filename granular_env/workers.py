"""Worker processes: fresh interpreters that answer over a pipe, ignore Ctrl-C, and end with the process that started them."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection, wait
from typing import Any

# One thread each: as many processes as cores are at work.
THREADS = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")}
_PATIENCE = 2.0


class Worker:
    """A process that runs ``serve(connection, *arguments)``.

    It ends with this process, however this one ends (SIGTERM, SIGHUP and SIGKILL included), and when `stop` is called.

    Args:
        serve: what it runs; a function of a module, so that the new interpreter finds it.
        arguments: of `serve`, after its end of the pipe.
    """

    def __init__(self, serve: Callable[..., None], *arguments: Any) -> None:
        context = get_context("spawn")  # a fork of a process that has run kernels may hang
        self.connection, theirs = context.Pipe()
        self._process: Any = context.Process(target=_serve, args=(serve, theirs, arguments), daemon=True)
        with _environment(THREADS), _no_interrupt(), _no_script():
            self._process.start()
        theirs.close()

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    def exit_reason(self) -> str:
        """Say how the process ended, once its end of the pipe is closed."""
        self.connection.close()
        self._process.join(5.0)
        code = self._process.exitcode
        if code is not None and code < 0:
            name = signal.Signals(-code).name if -code in set(signal.Signals) else "?"
            return f"its process was ended by signal {-code} ({name}), perhaps for lack of memory"
        return f"its process ended with status {code}"

    def terminate(self) -> None:
        """Ask the process to end, in the middle of its work if need be; does not wait for it."""
        with suppress(OSError):
            self.connection.close()
        if self._process.is_alive():
            self._process.terminate()

    def stop(self) -> None:
        """End the process, in the middle of its work if need be, and wait until it is gone."""
        self.terminate()
        self._process.join(_PATIENCE)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


def stop_all(workers: Iterable[Worker]) -> None:
    """Stop several workers, all at the same time."""
    workers = list(workers)
    for worker in workers:
        worker.terminate()
    for worker in workers:
        worker.stop()


def end_with_parent() -> None:
    """End this process as soon as the one that started it has ended; returns at once."""
    threading.Thread(target=_wait_for_parent, daemon=True).start()


def _wait_for_parent() -> None:
    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)


def _serve(serve: Callable[..., None], connection: Connection, arguments: tuple[Any, ...]) -> None:
    """Run `serve` in the new process, until nobody listens any more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the one who started it
    end_with_parent()
    with suppress(EOFError, BrokenPipeError, ConnectionResetError):
        serve(connection, *arguments)


@contextmanager
def _environment(values: Mapping[str, str]) -> Iterator[None]:
    """Set environment variables for a process that is started within."""
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
def _no_script() -> Iterator[None]:
    """Keep a process that is started within from importing the caller's script, which would run a second time there."""
    main = vars(sys.modules["__main__"])
    before = {name: main[name] for name in ("__spec__", "__file__") if name in main}
    main["__spec__"] = None
    main.pop("__file__", None)
    try:
        yield
    finally:
        main.update(before)


@contextmanager
def _no_interrupt() -> Iterator[None]:
    """Keep Ctrl-C from a process that is started within; this one sees it afterwards."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
