"""One task, computed: the same function in every engine, so that all of them give the same bits."""

from __future__ import annotations

import hashlib
import socket
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import dataclass, field
from functools import cache
from importlib.machinery import all_suffixes
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

from granular_env.components.catalogue import foreign_package
from granular_env.components.errors import GranularWarning, SweepError
from granular_env.components.support.jit import cache_folder, source_hash
from granular_env.experiments import load_experiment
from granular_env.experiments.preparation import Prepared, prepare
from granular_env.output_files import one_at_a_time

from .csv_files import write_files
from .measures import Measure
from .observer import RunObserver

# A few frames compile every kernel.
_WARMING_FRAMES = 12
# Kinds of tasks that this process has compiled kernels for, and the largest number that it compiles for in advance.
_WARM: set[str] = set()
_MOST_KINDS = 32
Outcome = Literal["done", "failed", "lost"]


@dataclass(frozen=True)
class Job:
    """The part that all tasks of a sweep share.

    Attributes:
        document: the experiment.
        files: CSV files, name -> content.
        measures: column -> what stands in it.
        every: time between two looks [s].
        program: hash of the code; a worker with other code refuses the job.
        time_limit: wall time of a task [s]; None for no limit.
    """

    document: Mapping[str, Any]
    files: Mapping[str, bytes]
    measures: Mapping[str, Measure]
    every: float | None
    program: str
    time_limit: float | None = None

    @property
    def component(self) -> str:
        """Catalogue name of the component."""
        return self.document["component"]["type"]


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
        outcome: done; failed: the physics or the input fails, whenever the task is run; lost: the machine failed (a worker
            ended, memory or disk ran out, the time limit passed), so that the next sweep computes the task again.
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

    Raises:
        SweepError: this process has other code than the one that began the sweep.
    """

    def __init__(self, job: Job, folder: Path) -> None:
        if job.program != program(job.component):
            package = foreign_package(job.component)
            raise SweepError(
                f"{socket.gethostname()} has another version of granular-env{f', of {package}' if package else ''} or of a "
                "package it computes with",
                hint="install the same versions on every node; after editing a package, start the sweep from a new process",
            )
        self._job, self._inputs, self._logs = job, folder / "inputs", folder / "logs"
        if not all((self._inputs / name).exists() for name in job.files):
            write_files(job.files, self._inputs)

    def prepare_task(self, order: Order) -> Prepared:
        """Return a task's experiment, ready to run; no step is made.

        Raises:
            GranularError: the experiment or its measures are not valid.
        """
        experiment = load_experiment(self._job.document, dict(order.overrides), self._inputs)
        ready = prepare(experiment, trial=False)
        self._looks(experiment.duration, experiment.record.every).on_reset(ready.component)
        return ready

    def warm(self, order: Order, begin: Callable[[], None] = lambda: None) -> None:
        """Compile or load the kernels of a new kind of task.

        One process of a machine compiles, and the others wait for it.

        Args:
            order: a task.
            begin: called after waiting.
        """
        kind = repr(_without_numbers([self._job.document, order.overrides]))
        if kind in _WARM or len(_WARM) >= _MOST_KINDS:
            return
        _WARM.add(kind)
        with _one_compiles():
            begin()
            # The task itself reports its errors, also those of a third party's component.
            with suppress(Exception), warnings.catch_warnings(action="ignore", category=GranularWarning):
                self._briefly(order)

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
        except Exception as caught:  # also from a third party's component: the sweep continues
            error = caught
        outcome: Outcome = "lost" if _is_of_machine(error) else "failed"
        if order.log == "failed" and outcome == "failed":
            self._log_again(order)
        message = f"{type(error).__name__}: {str(error) or 'no message'}"
        return Result(order.hash, outcome, (float("nan"),) * len(self._job.measures), message)

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
        with suppress(Exception), warnings.catch_warnings(action="ignore", category=GranularWarning):
            self._run(order, self.log_path(order))

    def _looks(self, duration: float, recorded: float | None) -> RunObserver:
        return RunObserver(self._job.measures, self._job.every or recorded, duration)


def _one_compiles() -> AbstractContextManager[None]:
    """Hold a lock that the processes of one user on one machine share, while kernels are compiled."""
    folder = cache_folder()
    return nullcontext() if folder is None else one_at_a_time(folder / "warming.lock")


def _is_of_machine(error: BaseException) -> bool:
    """Return whether memory, disk or the operating system failed, not the task."""
    cause = error.__cause__ or error.__context__
    return isinstance(error, MemoryError | OSError) or (cause is not None and _is_of_machine(cause))


def _without_numbers(value: Any) -> Any:
    """Return a value with its numbers left out: they do not change machine code; names of laws and integrators do."""
    if isinstance(value, Mapping):
        return {key: _without_numbers(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_without_numbers(one) for one in value]
    return None if isinstance(value, int | float) else value


@cache
def program(component: str) -> str:
    """Hash of all code that decides a result.

    That is the code of the components, the experiments, the measurements and the sweep, and, for a component of another
    package, the code of that package.
    """
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
    package = foreign_package(component)
    for path in _code_of(package) if package else ():
        state.update(path.read_bytes())
    return state.hexdigest()[:16]


def _code_of(package: str) -> Iterator[Path]:
    """Yield the modules of a package, or of a top-level module, without importing it."""
    spec = find_spec(package)
    if spec is not None and spec.submodule_search_locations is None and spec.origin:
        yield Path(spec.origin)
    for folder in (spec.submodule_search_locations if spec is not None else None) or ():
        yield from (path for path in sorted(Path(folder).rglob("*")) if path.name.endswith(tuple(all_suffixes())))
