"""Computing a sweep: what is not known yet of a plan, by an engine, kept from moment to moment."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import closing, suppress
from pathlib import Path
from typing import Any, Literal

from granular_env.components.errors import ParameterError, SweepError, one_line
from granular_env.documents import Overrides
from granular_env.optional_packages import import_optional
from granular_env.output_files import file_name
from granular_env.progress import Progress

from . import engines
from .plan import Plan, load_plan
from .planned_runs import Task, refuse_too_many
from .run_preparation import plan_tasks
from .store import Store
from .table import Sweep
from .validation import validate_plan
from .worker import Order, Result


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
) -> Sweep:
    """Compute the tasks of a plan that have no result yet.

        sweep = ge.run_sweep("plan.toml", "sweeps/mine")
        sweep.table

    Ctrl-C keeps the results so far; calling it again computes the rest.

    Args:
        plan: a shipped plan's name, the path of a TOML file, or the content of one.
        folder: where the results are, or will be; default ``sweeps/`` and the plan's name.
        engine: "processes", "serial" or "ray".
        workers: how many tasks at a time; default: as many as there are cores.
        address: HOST:PORT of a Ray cluster; default: the one of RAY_ADDRESS, or one of our own on this machine.
        overrides: keys of the experiment to set in every task, such as ``{"component.grains": 500}``.
        progress: show a bar: tasks done and failed, their rate, the time that is left; or call this with the part that is
            done.
        allow_large: lift the limit on the number of tasks.
        time_limit: wall time after which a task is ended [s], and counts as failed; not for the engine "serial".
        retry: compute again the tasks that failed because of the machine (memory, disk, a lost worker, the time limit):
            "lost"; or all that failed: "failed".

    Raises:
        ExperimentError: the plan or its experiment is not valid.
        ParameterError: an unknown engine, or an option that does not fit it.
        SweepError: the results cannot be kept, or the cluster cannot be used; what is done is kept.
        MissingExtraError: pyarrow, or Ray for its engine, is not installed.
    """
    import_optional("pyarrow", "the table of a sweep")
    loaded = load_plan(plan, overrides)
    refuse_too_many(loaded, allow_large)
    job, tasks, about = plan_tasks(loaded, time_limit)
    wanted = _orders(loaded, tasks)
    about["units"] = validate_plan(loaded, job, wanted)
    engines.check(engine, workers, address, time_limit)
    if retry not in ("lost", "failed"):
        raise ParameterError(f"got {one_line(retry)}", expected="'lost' or 'failed'", at="retry")
    with Store(_folder(folder) if folder is not None else _default_folder(loaded)) as store:
        known = {
            hashed: result
            for hashed, result in store.begin(about).items()
            if hashed in wanted and _holds(result, wanted[hashed], store.folder, retry)
        }
        waiting = [order for hashed, order in wanted.items() if hashed not in known]
        sweep = Sweep(store.folder, about, known)
        try:
            if waiting:
                stream = engines.results(engine, job, waiting, store.folder, workers, address)
                sweep.interrupted = _collect(stream, store, known, len(wanted), loaded.title, progress)
        except SweepError:
            with suppress(SweepError):
                sweep.write()
            raise
        sweep.write()
    return sweep


def check_sweep(
    plan: str | os.PathLike[str] | Mapping[str, Any], overrides: Overrides = (), *, allow_large: bool = False
) -> Plan:
    """Validate a plan against its experiment, as `run_sweep` does first; run and write nothing.

    Raises:
        ExperimentError: the plan or its experiment is not valid.
    """
    loaded = load_plan(plan, overrides)
    refuse_too_many(loaded, allow_large)
    job, tasks, _ = plan_tasks(loaded)
    validate_plan(loaded, job, _orders(loaded, tasks), thorough=True)
    return loaded


def _collect(stream: Any, store: Store, known: dict[str, Result], size: int, title: str, progress: Progress) -> bool:
    """Keep results as they come; whether Ctrl-C ended it."""
    from .console import bar

    try:
        with bar(title, size, list(known.values()), progress) as advance, closing(stream):
            for results in stream:
                known.update((result.hash, result) for result in results)
                store.add(results)
                advance(results)
    except KeyboardInterrupt:
        return True
    return False


def _orders(plan: Plan, tasks: Sequence[Task]) -> dict[str, Order]:
    """Return the tasks to compute, each once: hash -> order; of equal tasks one keeps its log where any has to."""
    found: dict[str, Order] = {}
    for task in tasks:
        always = plan.logs.wants(task.number)
        if task.hash not in found or always:
            log = "always" if always else "failed" if plan.logs.keep == "failed" else "never"
            found[task.hash] = Order(task.hash, task.overrides, log)
    return found


def _holds(result: Result, order: Order, folder: Path, retry: str) -> bool:
    """Return whether an earlier result is kept: it is not to be tried again, and it has its log if it needs one."""
    if result.outcome in ("lost", retry):
        return False
    return order.log != "always" or result.outcome == "failed" or (folder / "logs" / f"{order.hash}.mcap").exists()


def _folder(folder: str | os.PathLike[str]) -> Path:
    try:
        return Path(folder)
    except TypeError:
        raise ParameterError(f"got {one_line(folder)}", expected="the path of a folder for the results", at="folder") from None


def _default_folder(plan: Plan) -> Path:
    return Path("sweeps") / file_name(plan.title, "sweep")
