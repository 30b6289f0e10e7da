"""Running a study: every method with every seed, evaluated in the same episodes, with one file per trial."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Iterable
from pathlib import Path

from granular_env.code_hash import code_hash
from granular_env.components.errors import ExperimentError, Fault, GranularError, ParameterError, spelling_hint
from granular_env.components.support.validation import whole_number
from granular_env.documents import Overrides, to_toml
from granular_env.domains import gradient_domains
from granular_env.optional_packages import import_optional
from granular_env.output_files import replace_file, valid_file_name
from granular_env.progress import Bar, Progress, ProgressBars
from granular_env.run_loop import collect_warnings

from .drive import DriveShape
from .methods import MethodTable
from .problem import Problem
from .results import Score, StudyResult, Trial, read_trial
from .search import BudgetSpentError, Search
from .study import Source, Study, load_study


def run_study(
    source: Source,
    folder: str | os.PathLike[str] | None = None,
    *,
    overrides: Overrides = (),
    progress: Progress = False,
    problem: Problem | None = None,
    only: Iterable[str] = (),
) -> StudyResult:
    """Run the trials of a study that have no result.

        result = run_study("pulse-forming", "studies/pulse", overrides={"budget": 100_000})

    The folder receives the study (``study.toml``), a file per finished trial (``trials/``), a log of an episode with each
    trial's best drive or policy (``logs/``), ``table.csv`` and ``figure.png``. After Ctrl-C or a kill the same call continues:
    finished trials are read, and an unfinished trial is restarted.

    Args:
        source: a shipped study's name, the path of a TOML file, the content of one, or a loaded study.
        folder: folder of the results; default: ``studies/`` and the study's name.
        overrides: keys to set, as in `load_study`.
        progress: whether to show a bar for every trial, or a function to call with the completed fraction.
        problem: the task, if it is not the environment of the study.
        only: names of the methods to run and to report; empty for all.

    Raises:
        ExperimentError: the study is invalid, or a return was not finite (after the other trials have run).
        MissingExtraError: a method or the figure needs a package that is not installed.
    """
    study = load_study(source, overrides)
    import_optional("matplotlib", "the figure of a study")  # a missing package must raise before hours of searching, not after
    labels = [method.label for method in study.method]
    wanted = list(only) or labels
    for name in wanted:
        if name not in labels:
            raise ExperimentError(f"the study has no method {name!r}", hint=spelling_hint(name, labels), at="only")
    methods = [method for method in study.method if method.label in wanted]
    for method in methods:
        method.refuse_unless_installed()
    problem, shape = prepare_study(study, problem)
    where = Path(folder) if folder is not None else Path("studies") / valid_file_name(study.name, "study")
    with replace_file(where / "study.toml", ExperimentError) as part:
        part.write_text(to_toml(study.to_dict()), encoding="utf-8")
    pairs = [(method, seed) for method in methods for seed in study.seeds]
    trials, faults, interrupted = list[Trial](), list[Fault](), False
    with collect_warnings() as warned, ProgressBars(progress, study.budget * len(pairs), keep=True) as bars:
        for method, seed in pairs:
            bar = bars.add_bar(f"{method.label}-{seed}", study.budget)
            try:
                trials.append(_run_trial(study, method, seed, problem, shape, where, bar))
            except GranularError as error:
                faults += [fault.with_source(f"{method.label}-{seed}") for fault in error.faults]
            except KeyboardInterrupt:
                interrupted = True
                break
        baselines = {name: Score.from_episodes(actor, problem, study) for name, actor in problem.baselines().items()}
    result = StudyResult(study, where, trials, baselines, interrupted, warned)
    result.write_files()
    if faults:
        raise ExperimentError(*faults)
    return result


def _run_trial(
    study: Study, method: MethodTable, seed: int, problem: Problem, shape: DriveShape, folder: Path, bar: Bar
) -> Trial:
    """Return a trial: read from its file if that belongs to this study and program version, otherwise computed."""
    name = f"{method.label}-{seed}"
    path, log = folder / "trials" / f"{name}.json", folder / "logs" / f"{name}.mcap"
    identity = study.trial_identity(method, seed, f"{code_hash()} {problem.task_source}")
    known = read_trial(path, identity)
    if known is not None and log.exists():
        bar.update(study.budget, f"best {known.search_return:.6g}")
        return known

    def show_search(search: Search) -> None:
        if bar.is_due():
            bar.update(search.spent, f"best {search.best_return:.6g}" if search.curve else "")

    shape = dataclasses.replace(shape, knots=method.knots or shape.knots)
    search = Search(problem, shape, seed, study.search_seeds, study.budget, show_search)
    try:
        method.run(search)
    except BudgetSpentError:
        pass
    finally:
        problem.stage = None
    log.parent.mkdir(parents=True, exist_ok=True)
    trial = Trial(
        identity=identity, method=method.label, seed=seed, spent=search.spent, search_return=search.best_return,
        curve=search.curve, score=Score.from_episodes(method.actor(search), method.adapt_problem(problem), study, log),
    )  # fmt: skip
    with replace_file(path, ExperimentError) as part:
        part.write_text(trial.model_dump_json())
    return trial


def prepare_study(study: Study, problem: Problem | None = None) -> tuple[Problem, DriveShape]:
    """Return the task of a study, and the map from points to drives.

    Raises:
        ExperimentError: the task is invalid, or the study does not fit the task.
    """
    if problem is None:
        with study.locate_errors("task"):
            for key in {"hold", "clock"} & set(study.task.arguments):
                raise ParameterError("not a key of a study's task", hint="set it in the table of a ppo or sac method", at=key)
            path = Path(study.origin)
            problem = Problem(study.task.name, study.task.arguments, path.resolve().parent if path.is_file() else None)
    table = study.drive
    with study.locate_errors("drive"):
        driven = whole_number("driven", table.driven or problem.steps, 1, problem.steps)
        whole_number("knots", table.knots, 1, driven)
    for place, method in enumerate(study.method):
        with study.locate_errors("method", place):
            if method.needs_gradient and not problem.gradient_runs:
                received = f"got {method.type!r}, but task {study.task.name!r} has no objective with a gradient"
                hint = f"use cma, random, ppo or sac; components with gradients: {gradient_domains()}"
                raise ParameterError(received, expected="a method without gradients", hint=hint, at="type")
            whole_number("knots", method.knots or 1, 1, driven)
        with study.locate_errors():  # the budget must allow the first result of every method
            whole_number("budget", study.budget, math.ceil(method.first_result_cost(problem) * problem.steps * study.episodes))
    return problem, DriveShape(problem.steps, problem.entries, **table.model_dump(), rate=problem.rate)
