"""Computing a sweep: the tasks of a plan that have no result yet, by an engine, stored as they come."""

from __future__ import annotations

import json
import os
import tempfile
import warnings
from collections.abc import Collection, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any, Literal

from granular_env.components.errors import (
    ExperimentError,
    Fault,
    GranularError,
    GranularWarning,
    ParameterError,
    one_line,
)
from granular_env.documents import Overrides
from granular_env.experiments.preparation import Prepared
from granular_env.output_files import file_name
from granular_env.progress import Progress

from .console import sweep_progress
from .engines import Engine, compute_all, open_engine
from .plan import Plan, load_plan
from .store import Description, Store, read_results
from .table import Sweep
from .tasks import Workload, make_workload, units_of
from .worker import Computer, Result, Task, log_path, write_inputs

# `check` prepares this many tasks from all over the plan. A prime number: they seldom share the value of a key.
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
    retry: Literal["lost", "failed"] = "lost",
    part: tuple[int, int] = (0, 1),
) -> Sweep:
    """Compute the tasks of a plan that have no result yet, and write the table.

        sweep = ge.run_sweep("plan.toml", "sweeps/mine")
        sweep.table

    Ctrl-C keeps the results so far; the same call computes the rest.

    Args:
        plan: a shipped plan's name, the path of a TOML file, or the content of one.
        folder: of the results; default ``sweeps/`` and the plan's name.
        engine: "processes", "serial" or "ray".
        workers: how many tasks at a time; default: as many as there are cores.
        address: HOST:PORT of a Ray cluster; default: the one of RAY_ADDRESS, or one of our own on this machine.
        overrides: keys of the experiment to set in every task, such as ``{"component.grains": 500}``.
        progress: show a bar, or call this with the part that is done.
        allow_large: lift the limit on the number of tasks.
        time_limit: wall time after which a task is ended [s], and counts as failed; not for the engine "serial".
        retry: compute again the tasks that failed because of the machine (memory, disk, a lost worker, the time limit):
            "lost"; or all that failed: "failed".
        part: (i, n): compute the tasks i, i + n, i + 2n, ... alone, for job arrays; ``open_sweep(folder).write()`` writes the
            table of all parts.

    Raises:
        ExperimentError: the plan or its experiment is not valid.
        ParameterError: an unknown engine, or an option that does not fit it.
        SweepError: the results cannot be kept, or the cluster cannot be used; earlier results are kept.
        MissingExtraError: Ray is not installed.
    """
    loaded = load_plan(plan, overrides)
    _check_options(retry, part)
    workload = make_workload(loaded, time_limit, allow_large)
    units, tasks, where = _validate_plan(loaded, workload), workload.distinct(part), results_folder(loaded, folder)
    with (
        closing(open_engine(engine, workload.job, where, workers, address)) as opened,
        Store(where, _describe(loaded, workload, units), part) as store,
    ):
        write_inputs(workload.job, where)
        results = read_results(where)
        waiting = [task for task in tasks.values() if not _is_kept(results.get(task.hash), task, where, retry)]
        for task in waiting:
            results.pop(task.hash, None)
        try:
            interrupted = _compute(opened, waiting, store, results, tasks.keys(), progress, time_limit)
        finally:
            sweep = Sweep(where, store.description, results)
            if part == (0, 1):
                sweep.write()
    sweep.interrupted = interrupted
    return sweep


def check_sweep(
    plan: str | os.PathLike[str] | Mapping[str, Any], overrides: Overrides = (), *, allow_large: bool = False
) -> Plan:
    """Validate a plan against its experiment, as `run_sweep` does first; run and write nothing.

    Raises:
        ExperimentError: the plan or its experiment is not valid.
    """
    loaded = load_plan(plan, overrides)
    _validate_plan(loaded, make_workload(loaded, None, allow_large), thorough=True)
    return loaded


def results_folder(plan: Plan, folder: str | os.PathLike[str] | None = None) -> Path:
    """Return the folder of a plan's results: the one that is given, or ``sweeps/`` and the plan's name."""
    try:
        return Path("sweeps") / file_name(plan.title, "sweep") if folder is None else Path(folder)
    except TypeError:
        raise ParameterError(f"got {one_line(folder)}", expected="the path of a folder for the results", at="folder") from None


def _compute(
    engine: Engine,
    tasks: Sequence[Task],
    store: Store,
    results: dict[str, Result],
    wanted: Collection[str],
    progress: Progress,
    time_limit: float | None,
) -> bool:
    """Compute tasks, and keep their results as they come; return whether Ctrl-C ended it."""
    before = [results[one] for one in wanted if one in results]
    try:
        with sweep_progress(store.description.name, len(wanted), before, progress) as report:
            for result in compute_all(engine, tasks, time_limit):
                results[result.hash] = result
                store.add(result)
                report(result)
    except KeyboardInterrupt:
        return True
    return False


def _check_options(retry: str, part: tuple[int, int]) -> None:
    if retry not in ("lost", "failed"):
        raise ParameterError(f"got {one_line(retry)}", expected="'lost' or 'failed'", at="retry")
    try:
        index, count = part
        valid = 0 <= index < count and int(index) == index and int(count) == count
    except (TypeError, ValueError):
        valid = False
    if not valid:
        expected, hint = "(i, n) with 0 <= i < n", "of 3 parts the first is 0 and the last is 2"
        raise ParameterError(f"got {one_line(part)}", expected=expected, hint=hint, at="part")


def _is_kept(result: Result | None, task: Task, folder: Path, retry: str) -> bool:
    """Return whether an earlier result is kept: it is not to be tried again, and it has its log if it needs one."""
    if result is None or result.outcome in ("lost", retry):
        return False
    return task.log != "always" or result.outcome == "failed" or log_path(folder, task.hash).exists()


def _describe(plan: Plan, workload: Workload, units: dict[str, str]) -> Description:
    measures = plan.text["measure"].items()
    return Description(
        name=plan.title,
        program=workload.job.program,
        experiment=str(workload.job.document.get("name", "")),
        keys=workload.keys,
        measures={name: words if isinstance(words, str) else json.dumps(words) for name, words in measures},
        units=units,
        hashes=[task.hash for task in workload.tasks],
    )


# -- validation -----------------------------------------------------------------------------------------------------------


def _validate_plan(plan: Plan, workload: Workload, thorough: bool = False) -> dict[str, str]:
    """Prepare tasks from all over the plan until one can begin; return the units of the columns.

    Args:
        plan: which one.
        workload: its tasks.
        thorough: prepare more tasks, and warn of those that cannot begin.

    Raises:
        ExperimentError: none of the tasks that were tried can begin, or repetitions do not differ.
    """
    units: dict[str, str] | None = None
    faults: list[GranularError] = []
    tasks = list(workload.distinct().values())
    count = min(len(tasks), _MOST_TRIED)
    ignored = warnings.catch_warnings(action="ignore", category=GranularWarning)
    with tempfile.TemporaryDirectory(prefix="granular-env-sweep-") as folder, ignored:
        write_inputs(workload.job, Path(folder))
        computer = Computer(workload.job, Path(folder))
        for task in (tasks[number * len(tasks) // count] for number in range(count)):
            try:
                ready = computer.prepare_task(task)
            except GranularError as error:
                faults.append(error)
                continue
            if units is None:
                _refuse_idle_seeds(plan, computer, task, ready)
                units = units_of(plan, ready.component)
            if not thorough:
                break
    if units is None:
        raise plan.error_of(faults[0])
    if thorough and faults:
        said = f"{len(faults)} of {count} tasks that were tried cannot begin, such as: {faults[0]}"
        warnings.warn(said, GranularWarning, stacklevel=3)
    return units


def _refuse_idle_seeds(plan: Plan, computer: Computer, task: Task, ready: Prepared) -> None:
    """Refuse repetitions whose seed changes nothing: they would all be the same."""
    seeds = plan.seeds
    if seeds is None or seeds.count == 1:
        return
    others = {key: value ^ 1 if key in seeds.keys else value for key, value in task.overrides}
    other = computer.prepare_task(Task("", tuple(others.items()))).component
    if other.identity == ready.component.identity and other.save().to_bytes() == ready.component.save().to_bytes():
        received = f"{', '.join(seeds.keys)} changes nothing in component {ready.component.name!r}"
        hint = 'all repetitions would be the same; name the key that is a seed, such as keys = ["component.arrangement.seed"]'
        raise ExperimentError(plan.locate_fault(Fault(("seeds", "keys"), received, hint=hint)))
