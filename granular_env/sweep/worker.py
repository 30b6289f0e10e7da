"""One task, computed: the same function in every engine, so that all of them give the same bits."""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Literal

from granular_env.components.errors import GranularError, GranularWarning
from granular_env.components.support.compilation.cache_folder import cache_folder
from granular_env.components.support.jit import source_hash
from granular_env.experiments import load_experiment
from granular_env.experiments.preparation import Prepared, prepare
from granular_env.output_files import one_at_a_time

from .csv_files import write_files
from .measures import Measure
from .observer import RunObserver

# A few frames are enough for every kernel to be there.
_WARMING_FRAMES = 12
Outcome = Literal["done", "failed", "lost"]


@dataclass(frozen=True)
class Job:
    """The part that all tasks of a sweep share.

    Attributes:
        document: the experiment.
        files: CSV files, name -> content.
        measures: column -> what stands in it.
        every: time between two looks [s].
        program: hash of the code; a worker with another one refuses.
    """

    document: Mapping[str, Any]
    files: Mapping[str, bytes]
    measures: Mapping[str, Measure]
    every: float | None
    program: str


@dataclass(frozen=True, slots=True)
class Order:
    """The message that gives a worker a task.

    Attributes:
        hash: the task's.
        overrides: the keys of the experiment that it sets, with their values.
        log: when its log is kept.
        attempts: how often a process or node was lost over it.
    """

    hash: str
    overrides: tuple[tuple[str, Any], ...]
    log: Literal["never", "failed", "always"] = "never"
    attempts: int = 0


@dataclass(frozen=True, slots=True)
class Result:
    """The outcome of a task.

    Attributes:
        hash: the task's.
        outcome: done; failed: it fails whenever it is run; lost: its process or node ended again and again.
        values: the measures.
        error: what went wrong, in a sentence.
        notes: assumptions that the run left behind, and measures that have no value.
        log: its log, where the worker has no access to the results' folder.
    """

    hash: str
    outcome: Outcome
    values: tuple[float, ...] = ()
    error: str = ""
    notes: str = ""
    log: bytes | None = field(default=None, repr=False)


class Computer:
    """Computes tasks of a job in this process.

    Args:
        job: what they share.
        folder: where the job's CSV files are put, and logs in ``logs/``.
    """

    def __init__(self, job: Job, folder: Path) -> None:
        self._job, self._inputs, self._logs = job, folder / "inputs", folder / "logs"
        if not all((self._inputs / name).exists() for name in job.files):
            write_files(job.files, self._inputs)

    def prepare_task(self, order: Order) -> Prepared:
        """Return a task's experiment, ready to run, and its measures; raise `GranularError` where they do not fit."""
        experiment = load_experiment(self._job.document, dict(order.overrides), self._inputs)
        ready = prepare(experiment)
        self._looks(experiment.duration, experiment.record.every).on_reset(ready.component)
        return ready

    def warm(self, order: Order) -> None:
        """Compile, or load, every kernel that such a task needs; one process of a machine compiles, the others wait for it."""
        with _one_compiles():
            try:
                with warnings.catch_warnings(action="ignore", category=GranularWarning):
                    self._briefly(order)
            except GranularError:
                pass  # The task itself will tell.

    def _briefly(self, order: Order) -> None:
        ready = self.prepare_task(order)
        component, experiment = ready.component, ready.experiment
        every = self._job.every or experiment.record.every
        ticks = min(ready.ticks, _WARMING_FRAMES * (component.ticks_in(every) if every else 1))
        looks = self._looks(ticks * component.step_size, experiment.record.every)
        component.observe(looks)
        component.step(ticks * component.step_size, **ready.inputs)
        looks.values(component, component.report())

    def compute(self, order: Order) -> Result:
        """Return the result of a task; an error is a result too."""
        try:
            with warnings.catch_warnings(action="ignore", category=GranularWarning):
                return self._run(order, self.log_path(order) if order.log == "always" else None)
        except GranularError as error:
            message = f"{type(error).__name__}: {error}"
        except MemoryError:
            message = "MemoryError: it asks for more memory than there is"
        except Exception as error:  # a component of somebody else's: the sweep goes on
            message = f"{type(error).__name__}: {error}"
        if order.log == "failed":
            self._log_again(order)
        return Result(order.hash, "failed", (float("nan"),) * len(self._job.measures), message)

    def log_path(self, order: Order) -> Path:
        """Return where a task's log is."""
        return self._logs / f"{order.hash}.mcap"

    def _run(self, order: Order, log: Path | None) -> Result:
        from granular_env.run_loop import run

        experiment = load_experiment(self._job.document, dict(order.overrides), self._inputs)
        looks = self._looks(experiment.duration, experiment.record.every)
        if log is not None:
            log.parent.mkdir(parents=True, exist_ok=True)
        done = run(experiment, log=log, overwrite=True, observers=[looks])
        if done.interrupted:
            raise KeyboardInterrupt
        values, notes = looks.values(done.component, done.report)
        said = dict.fromkeys((*done.warnings, *done.cautions, *notes))
        return Result(order.hash, "done", tuple(values), notes="; ".join(said))

    def _log_again(self, order: Order) -> None:
        """Record a task that failed: it fails at the same step again. Where nothing can be recorded there is no log."""
        try:
            with warnings.catch_warnings(action="ignore", category=GranularWarning):
                self._run(order, self.log_path(order))
        except (GranularError, MemoryError):
            pass

    def _looks(self, duration: float, recorded: float | None) -> RunObserver:
        return RunObserver(self._job.measures, self._job.every or recorded, duration)


def _one_compiles() -> AbstractContextManager[None]:
    """Hold a lock that the processes of one user on one machine share, while kernels are compiled."""
    folder = cache_folder()
    return nullcontext() if folder is None else one_at_a_time(folder / "warming.lock")


@cache
def program() -> str:
    """Hash of all code that decides a result: the components', the experiments', the measurements' and the sweep's own."""
    state = hashlib.sha256(source_hash().encode())
    root = Path(__file__).resolve().parent
    own = [root / name for name in ("worker.py", "observer.py", "measures.py")]
    package = root.parent
    for path in (
        *own,
        package / "run_loop.py",
        package / "crests_and_crossings.py",
        *sorted((package / "experiments").glob("*.py")),
        *sorted((package / "domains").glob("*/measurement/*.py")),
    ):
        state.update(path.read_bytes())
    for name in ("scipy", "pydantic"):
        try:
            state.update(f"{name} {version(name)}".encode())
        except PackageNotFoundError:
            pass
    return state.hexdigest()[:16]
