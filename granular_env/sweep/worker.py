"""The computation of a task, which is the same in all engines, so that their results are bitwise identical."""

from __future__ import annotations

import faulthandler
import os
import socket
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from granular_env.code_hash import code_hash
from granular_env.components.errors import GranularWarning, SweepError
from granular_env.experiments import Experiment, load_experiment
from granular_env.experiments.preparation import Prepared, prepare_experiment
from granular_env.output_files import replace_file

from .measures import Measure, RunObserver


@dataclass(frozen=True)
class Job:
    """The data that all tasks of a sweep have in common.

    Attributes:
        document: the experiment.
        files: name of a CSV file in the folder ``inputs/`` -> its content.
        measures: name of a column -> its measure.
        every: sampling interval of the measures [s].
        program: hash of the code; a worker with other code refuses the job.
        time_limit: wall time after which a task is ended [s]; None for no limit.
    """

    document: Mapping[str, Any]
    files: Mapping[str, bytes]
    measures: Mapping[str, Measure]
    every: float | None
    program: str
    time_limit: float | None = None


@dataclass(frozen=True, slots=True)
class Task:
    """One run of a plan's experiment.

    Attributes:
        hash: hash of the experiment, the overrides, the measures and the program.
        overrides: the keys of the experiment set by the task, with their values.
        is_logged: whether the task's log is kept.
    """

    hash: str
    overrides: tuple[tuple[str, Any], ...]
    is_logged: bool = False


@dataclass(frozen=True, slots=True)
class Result:
    """The outcome of a task.

    Attributes:
        hash: hash of the task.
        outcome: done; failed: physics or input fail in every run of the task; lost: the machine failed (a worker ended,
            memory or disk ran out, the time limit passed), so that the next sweep repeats the task.
        values: the numbers of the measures, in order.
        error: the error as a sentence.
        notes: warnings of the run, violated assumptions, and the measures that have no value.
    """

    hash: str
    outcome: Literal["done", "failed", "lost"]
    values: tuple[float, ...] = ()
    error: str = ""
    notes: str = ""


class TaskComputer:
    """Computes tasks of a job in this process; `folder` has the CSV files in ``inputs/`` and gets the logs in ``logs/``.

    Raises:
        SweepError: the code of this process differs from that of the process that started the sweep.
    """

    def __init__(self, job: Job, folder: Path) -> None:
        if job.program != code_hash():
            raise SweepError(
                f"{socket.gethostname()} has a different version of granular-env, of a plug-in or of a package that it uses",
                hint="install the same versions on every node; after editing a package, start the sweep from a new process",
            )
        self._job, self._folder = job, folder

    def prepare_task(self, task: Task) -> Prepared:
        """Return the experiment of a task, ready to run, before its first step.

        Raises:
            GranularError: the experiment or its measures are invalid.
        """
        experiment, observer = self._load_task(task)
        ready = prepare_experiment(experiment, has_trial_step=False)
        observer.on_reset(ready.component)
        return ready

    def compute(self, task: Task) -> Result:
        """Compute a task and return its result; an error gives a result with the outcome "failed" or "lost"."""
        try:
            return self._run_task(task)
        except Exception as error:  # of any type, so that an error in a third-party component does not end the sweep
            outcome = "lost" if _is_machine_error(error) else "failed"
            return Result(task.hash, outcome, error=f"{type(error).__name__}: {str(error) or 'no message'}")

    def _run_task(self, task: Task) -> Result:
        from granular_env.run_loop import run

        experiment, observer = self._load_task(task)
        log = log_path(self._folder, task.hash) if task.is_logged else None
        if log is not None:
            log.parent.mkdir(parents=True, exist_ok=True)
        with warnings.catch_warnings(action="ignore", category=GranularWarning):
            done = run(experiment, log=log, overwrite=True, observers=[observer])
        if done.interrupted:
            raise KeyboardInterrupt
        values, notes = observer.values(done.component, done.report)
        said = dict.fromkeys((*done.warnings, *done.cautions, *notes))
        return Result(task.hash, "done", tuple(values), notes="; ".join(said))

    def _load_task(self, task: Task) -> tuple[Experiment, RunObserver]:
        """Return the experiment of a task, and the observer that takes its measures."""
        experiment = load_experiment(self._job.document, dict(task.overrides), self._folder / "inputs")
        every = self._job.every or experiment.record.every
        return experiment, RunObserver(self._job.measures, every, experiment.duration)


def log_path(folder: Path, task_hash: str) -> Path:
    """Return the path of a task's log in the results' folder."""
    return folder / "logs" / f"{task_hash}.mcap"


def write_inputs(job: Job, folder: Path) -> None:
    """Write the CSV files of a job to ``inputs/`` in the given folder, where its tasks look for them."""
    for name, data in job.files.items():
        # Replace the file in one operation, because other parts of the sweep may be reading it.
        with replace_file(folder / "inputs" / name, SweepError) as part:
            part.write_bytes(data)


def compute_task(job: Job, task: Task, folder: Path) -> Result:
    """Compute a task in a worker process; after the time limit the process ends, even within a compiled kernel."""
    computer = TaskComputer(job, folder)
    if job.time_limit is None:
        return computer.compute(task)
    with open(os.devnull, "w") as nowhere:
        faulthandler.dump_traceback_later(job.time_limit, exit=True, file=nowhere)
        try:
            return computer.compute(task)
        finally:
            faulthandler.cancel_dump_traceback_later()


def _is_machine_error(error: BaseException) -> bool:
    """Return whether memory, disk or the operating system failed instead of the task."""
    cause = error.__cause__ or error.__context__
    return isinstance(error, MemoryError | OSError) or (cause is not None and _is_machine_error(cause))
