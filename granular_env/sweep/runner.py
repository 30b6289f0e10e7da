"""Runs a sweep: an engine computes the tasks that have no result yet, and results are stored as they arrive."""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

from granular_env.components.errors import GranularError, GranularWarning, ParameterError, one_line, spelling_hint
from granular_env.components.support.validation import positive_number, whole_number
from granular_env.documents import Overrides
from granular_env.output_files import valid_file_name
from granular_env.progress import Progress

from .console import sweep_progress
from .engines import Engine, ProcessPool, compute_tasks
from .plan import Plan, load_plan
from .ray_cluster import RayCluster
from .store import Description, Store, read_results
from .table import Sweep
from .tasks import Workload, column_units, make_workload
from .worker import Job, Result, Task, TaskComputer, log_path, write_inputs

# Largest number of tasks that `_validate_plan` tries. A prime, so that tasks at equal distances rarely share a key's value.
_MOST_TRIED = 7


def run_sweep(
    plan: str | os.PathLike[str] | Mapping[str, Any],
    folder: str | os.PathLike[str] | None = None,
    *,
    engine: str = "processes",
    workers: int | None = None,
    address: str | None = None,
    overrides: Overrides = (),
    progress: Progress = False,
    allow_large: bool = False,
    time_limit: float | None = None,
    part: str = "0/1",
) -> Sweep:
    """Compute the tasks of a plan that have no result, and write the table.

        sweep = ge.run_sweep("plan.toml", "sweeps/mine")
        sweep.table

    Ctrl-C keeps the finished results, and the same call computes the rest. The next call also repeats tasks that
    failed because of the machine (memory, disk, a lost worker, the time limit).

    Args:
        plan: a shipped plan's name, the path of a TOML file, or the content of one.
        folder: folder of the results; default ``sweeps/`` and the plan's name.
        engine: "processes", "serial" or "ray".
        workers: number of concurrent tasks; default: the number of cores.
        address: HOST:PORT of a Ray cluster; default: RAY_ADDRESS, or a temporary cluster on this machine.
        overrides: keys of the experiment to set in every task, such as ``{"component.grains": 500}``.
        progress: whether to show a bar, or a function to call with the completed fraction.
        allow_large: lift the limit on the number of tasks.
        time_limit: wall time after which a task is ended and counts as failed [s]; not for the engine "serial".
        part: "I/N": compute only the tasks I, I + N, I + 2N, ..., for instance in a job array of a cluster; afterwards,
            ``open_sweep(folder).write_csv()`` writes the table of all parts.

    Raises:
        ExperimentError: the plan or its experiment is not valid.
        ParameterError: an unknown engine, or an option that does not fit it.
        SweepError: the results cannot be stored, or the cluster cannot be used; earlier results are kept.
        MissingExtraError: Ray is not installed.
    """
    loaded = load_plan(plan, overrides)
    share = _parse_part(part)
    workload = make_workload(loaded, time_limit, allow_large)
    units, tasks, where = _validate_plan(loaded, workload), workload.distinct_tasks(share), results_folder(loaded, folder)
    about = Description(
        name=loaded.title,
        keys=workload.keys,
        measures=list(loaded.measure),
        units=units,
        hashes=[task.hash for task in workload.tasks],
    )
    with closing(_open_engine(engine, workload.job, where, workers, address)) as opened, Store(where, about, share) as store:
        write_inputs(workload.job, where)
        results = {key: one for key, one in read_results(where).items() if one.outcome != "lost"}
        waiting = [task for task in tasks.values() if not _has_result(results.get(task.hash), task, where)]
        interrupted = False
        try:
            with sweep_progress(about.name, len(tasks), len(tasks) - len(waiting), progress) as report:
                for result in compute_tasks(opened, waiting, time_limit):
                    results[result.hash] = result
                    store.add_result(result)
                    report(result)
        except KeyboardInterrupt:
            interrupted = True
        finally:
            sweep = Sweep(where, about, results)
            if share == (0, 1):
                sweep.write_csv()
    sweep.interrupted = interrupted
    return sweep


def check_sweep(
    plan: str | os.PathLike[str] | Mapping[str, Any], overrides: Overrides = (), *, allow_large: bool = False
) -> Plan:
    """Validate a plan like `run_sweep`, and return it; run and write nothing.

    Raises:
        ExperimentError: the plan or its experiment is not valid.
    """
    loaded = load_plan(plan, overrides)
    _validate_plan(loaded, make_workload(loaded, None, allow_large))
    return loaded


def results_folder(plan: Plan, folder: str | os.PathLike[str] | None = None) -> Path:
    """Return the folder of a plan's results: the given folder, or ``sweeps/`` and the plan's name."""
    return Path("sweeps") / valid_file_name(plan.title, "sweep") if folder is None else Path(folder)


def _open_engine(name: str, job: Job, folder: Path, workers: int | None, address: str | None) -> Engine:
    """Return the engine with this name; `ParameterError` if it is unknown or does not have one of the options."""
    if name not in (names := ("processes", "serial", "ray")):
        raise ParameterError(f"got {one_line(name)}", hint=spelling_hint(str(name), names), at="engine")
    if job.time_limit is not None:
        positive_number("time_limit", job.time_limit)
    if workers is not None:
        whole_number("workers", workers, 1, 4096)
    for option, given, fitting in (("time_limit", job.time_limit, "processes"), ("address", address, "ray")):
        if given is not None and name not in (fitting, "ray"):
            hint = f"use engine={fitting!r} (--engine {fitting})"
            raise ParameterError(f"the engine {name!r} does not support this option", at=option, hint=hint)
    if name == "ray":
        return RayCluster(job, folder, workers, address)
    return ProcessPool(job, folder, workers) if name == "processes" else Engine(job, folder)


def _parse_part(text: str) -> tuple[int, int]:
    index, _, count = str(text).partition("/")
    if index.isdecimal() and count.isdecimal() and int(index) < int(count):
        return int(index), int(count)
    expected, hint = "I/N with 0 <= I < N", "number three parts 0/3, 1/3 and 2/3"
    raise ParameterError(f"got {one_line(text)}", expected=expected, hint=hint, at="part")


def _has_result(result: Result | None, task: Task, folder: Path) -> bool:
    """Return whether a task has a result and, if its log is to be kept, the log exists."""
    return result is not None and not (task.is_logged and result.outcome == "done" and not log_path(folder, task.hash).exists())


def _validate_plan(plan: Plan, workload: Workload) -> dict[str, str]:
    """Try to prepare tasks, evenly spread over the plan, until one can start; return the units of the table's columns.

    Raises:
        ExperimentError: none of the tried tasks can start.
    """
    tasks, faults = list(workload.distinct_tasks().values()), list[GranularError]()
    ignored = warnings.catch_warnings(action="ignore", category=GranularWarning)
    with tempfile.TemporaryDirectory(prefix="granular-env-sweep-") as folder, ignored:
        write_inputs(workload.job, Path(folder))
        computer = TaskComputer(workload.job, Path(folder))
        for task in tasks[:: 1 + len(tasks) // _MOST_TRIED]:
            try:
                return column_units(plan, computer.prepare_task(task).component)
            except GranularError as error:
                faults.append(error)
    raise plan.plan_error(faults[0])
