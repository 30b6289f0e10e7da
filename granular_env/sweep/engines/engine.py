"""The interface of engines, the engine "serial", and the loop over any engine."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from time import monotonic
from typing import Any

from ..worker import Computer, Job, Result, Task

# How often a task may lose its process or its node before it is given up.
_ATTEMPTS = 3
# Longest wait for a task [s].
LOOK_SECONDS = 2.0
# The first task compiles the kernels, which the other processes then load. Longest wait for it [s].
_ALONE_SECONDS = 60.0


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
