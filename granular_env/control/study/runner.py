"""Running a study: every method with every seed, kept at every moment, judged in the same episodes."""

from __future__ import annotations

import contextlib
import dataclasses
import math
import os
import shutil
from collections.abc import Iterable
from pathlib import Path
from time import perf_counter

import numpy as np

from granular_env.components.errors import (
    ExperimentError,
    Fault,
    GranularError,
    Option,
    ParameterError,
    nearest,
)
from granular_env.documents import Overrides, to_toml
from granular_env.domains import gradient_domains
from granular_env.optional_packages import import_optional
from granular_env.output_files import file_name, write_files
from granular_env.progress import Progress
from granular_env.run_loop import Interrupt, collect_warnings

from ..drive import DriveShape
from ..problem import Actor, Problem
from .console import Notify, trial_progress
from .evaluator import BudgetedEvaluator, BudgetSpentError, InterruptedByUserError
from .methods import MethodTable
from .result_files import write_results
from .results import Score, StudyResult, Trial
from .study import Source, Study, load_study
from .trial_record import START_ANEW, TrialRecord, load_or_start

# Between two writes of a trial's record, and of the log of its best [s].
_SAVED_EVERY, _LOGGED_EVERY = 1.0, 30.0
_OURS = ("checkpoints", "logs")
_FLAT = (
    "the slopes of the objective were 0 at every point, so that the search could not move: no drive that it tried reaches what "
    "is judged; give a later deadline, or another start"
)


def run_study(
    source: Source,
    folder: str | os.PathLike[str] | None = None,
    *,
    overrides: Overrides = (),
    overwrite: bool = False,
    progress: Progress = False,
    problem: Problem | None = None,
    only: Iterable[str] = (),
) -> StudyResult:
    """Run a study, or go on with one that was interrupted, killed, or given a larger budget.

        result = run_study("pulse-forming", "studies/pulse", overrides={"budget": 100_000})

    The folder gets the study as it was run, a record of every trial (`checkpoints/`), a log of the best of each (`logs/`),
    ``results.json``, ``curves.csv``, the figures, and ``report.html``.

    Args:
        source: a shipped study's name, the path of a TOML file, the content of one, or a loaded study.
        folder: where to; default: ``studies/`` and the study's name.
        overrides: keys to set, as in `load_study`.
        overwrite: whether to start anew where the folder holds another study, or results of this one.
        progress: show a bar for every trial, or call this with the part that is done.
        problem: what is asked, where it is not the environment of the study's task.
        only: names of the methods to run and to report; none: all. What others have done is kept for a later run.

    Raises:
        ExperimentError: the study is not valid, the folder belongs to another one, or a return was not finite; then the other
            methods have run, and what came before it is kept.
        MissingExtraError: a method, or the figures, need a package that is not installed.
        ParameterError: the task does not take these arguments.
    """
    study = load_study(source, overrides)
    import_optional("matplotlib", "the figures of a study")  # said now, not when hours of searching are over
    methods = chosen_methods(study, only)
    for method in methods:
        method.refuse_unless_installed()
    where = Path(folder) if folder is not None else Path("studies") / file_name(study.name, "study")
    problem, shape = prepare(study, problem)
    _claim(where, study, overwrite)
    trials, interrupted = [], False
    with collect_warnings() as warned, contextlib.ExitStack() as stack:
        interrupt = stack.enter_context(Interrupt())
        notify = stack.enter_context(trial_progress(study, len(methods) * len(study.seeds), progress))
        for method in methods:
            for seed in study.seeds:
                attempt = _Attempt(study, method, seed, problem, shape, where, interrupt, notify)
                interrupted = interrupted or interrupt.pressed
                trials.append(attempt.finish() if interrupted else attempt.run())
                interrupted = interrupted or attempt.interrupted
        baselines = {name: evaluate_actor(actor, problem, study) for name, actor in problem.baselines().items()}
    notes = [*(f"{trial.name}: {_FLAT}" for trial in trials if trial.record.is_flat), *warned]
    result = StudyResult(study, where, trials, baselines, problem.gradient_runs, interrupted, notes)
    write_results(result)
    _raise_failures(result)
    return result


def chosen_methods(study: Study, only: Iterable[str]) -> list[MethodTable]:
    """Return the methods of those names, all where none is named; `ExperimentError` with the nearest for another name."""
    labels, wanted = [method.label for method in study.method], list(only)
    for name in wanted:
        if name not in labels:
            raise ExperimentError(
                Fault(("only",), f"got {name!r}, which is no method of it", hint=nearest(name, labels), source=study.origin)
            )
    return [method for method in study.method if not wanted or method.label in wanted]


def _raise_failures(result: StudyResult) -> None:
    failed = [fault.of(trial.name) for trial in result.trials for fault in trial.faults]
    if failed:
        error = ExperimentError(*failed)
        error.add_note(f"results so far: {result.folder}")
        raise error


def prepare(study: Study, problem: Problem | None = None) -> tuple[Problem, DriveShape]:
    """Return the problem that a study poses, and how its points become drives; errors as in `run_study`."""
    if problem is None:
        from ..task_problem import TaskProblem

        with study.locate("task"):
            problem = TaskProblem(study.task.name, study.task.arguments, _folder_of(study))
    _refuse_without_gradient(study, problem)
    table = study.drive
    if (driven := table.driven or problem.steps) > problem.steps:
        expected = f"at most {problem.steps}, the control steps of an episode"
        raise ExperimentError(study.locate_fault(Fault(("drive", "driven"), f"got {driven}", expected)))
    knots: dict[tuple[str | int, ...], int] = {("drive", "knots"): table.knots}
    knots |= {("method", place, "knots"): one.knots for place, one in enumerate(study.method) if one.knots}
    for where, number in knots.items():
        if number > driven:
            expected = f"at most {driven}, one for every driven control step"
            raise ExperimentError(study.locate_fault(Fault(where, f"got {number}", expected)))
    _refuse_too_little(study, problem)
    limits = [rate for rate in (table.rate, problem.rate) if rate is not None]
    return problem, DriveShape(problem.steps, problem.entries, **{**table.model_dump(), "rate": min(limits, default=None)})


def _folder_of(study: Study) -> Path | None:
    """Return the folder of the study's file, in which modules of its author's lie; None where it came from no file."""
    path = Path(study.origin)
    return path.resolve().parent if path.is_file() else None


def _refuse_without_gradient(study: Study, problem: Problem) -> None:
    """`ExperimentError` for a method that needs slopes where the task has none."""
    for place, method in enumerate(study.method):
        if method.needs_gradient and not problem.gradient_runs:
            came = f"got {method.type!r}, but task {study.task.name!r} has no objective with a gradient"
            hint = f"cma, random, policy, ppo or sac; components with gradients: {gradient_domains()}"
            fault = Fault(("method", place, "type"), came, "a method that needs none", hint)
            raise ExperimentError(study.locate_fault(fault))


def _refuse_too_little(study: Study, problem: Problem) -> None:
    """`ExperimentError` for a budget with which a method could find nothing at all."""
    for method in study.method:
        least = math.ceil(method.least_runs(problem) * problem.steps * study.episodes)
        if study.budget < least:
            expected = f"at least {least}, which the first result of {method.label!r} takes"
            raise ExperimentError(study.locate_fault(Fault(("budget",), f"got {study.budget}", expected)))


def evaluate_actor(actor: Actor, problem: Problem, study: Study, log: Path | None = None) -> Score:
    """Play an actor in the test episodes; the first is recorded where a path is given."""
    episodes = []
    for place, seed in enumerate(study.test_seeds):
        episodes.append(problem.play(actor, seed, log if place == 0 else None))
    values = np.array([episode.value for episode in episodes])
    return Score(float(values.mean()), float(values.std()), episodes[0])


# -- a trial --------------------------------------------------------------------------------------------------------------


class _Attempt:
    """A trial while it runs."""

    def __init__(
        self,
        study: Study,
        method: MethodTable,
        seed: int,
        problem: Problem,
        shape: DriveShape,
        folder: Path,
        interrupt: Interrupt,
        notify: Notify,
    ) -> None:
        self._study, self._method, self._seed, self._problem, self._folder = study, method, seed, problem, folder
        self._interrupt, self._notify = interrupt, notify
        self.interrupted, self._faults = False, tuple[Fault, ...]()
        self._name = f"{method.label}-{seed}"
        self._path = folder / "checkpoints" / f"{self._name}.trial"
        self._owner = {"study": study.identity, "method": method.label, "seed": seed}
        shape = dataclasses.replace(shape, knots=method.knots or shape.knots)
        self._record = load_or_start(self._path, self._owner)
        if self._record.spent > study.budget:
            spent = f"got {study.budget}, but {self._name} has simulated {self._record.spent} control steps already"
            hint = ("give at least that, or pass ", Option("overwrite"), " to start anew")
            raise ExperimentError(study.locate_fault(Fault(("budget",), spent, hint=hint)))
        self._search = BudgetedEvaluator(problem, shape, seed, study.search_seeds, study.budget, self._record, self._watch)
        self._saved = self._logged = perf_counter()
        self._wait, self._logged_best = _SAVED_EVERY, -np.inf

    def run(self) -> Trial:
        """Search, unless that has been done."""
        record = self._record
        if record.finished and record.notes.get("budget") == self._study.budget:
            self._notify(self._name, self._study.budget, record.best_return)
            return self.finish()
        record.finished = False
        self._notify(self._name, record.spent, record.best_return)
        try:
            with contextlib.suppress(BudgetSpentError):
                self._method.run(self._search)
            record.finished, record.notes = True, {**record.notes, "budget": self._study.budget}
        except (InterruptedByUserError, KeyboardInterrupt):
            self.interrupted = True
        except GranularError as error:
            self._faults = error.faults
        self._save()
        return self.finish()

    def finish(self) -> Trial:
        """Judge the best so far, and record it."""
        score = self._log_best() if self._record.best else None
        log = self._log if score is not None and self._log.exists() else None
        return Trial(self._method.label, self._seed, self._record, score, log, self._faults)

    @property
    def _log(self) -> Path:
        return self._folder / "logs" / f"{self._name}.mcap"

    def _watch(self, record: TrialRecord) -> None:
        self._notify(self._name, record.spent, record.best_return)
        if self._interrupt.pressed:
            raise InterruptedByUserError
        now = perf_counter()
        if now - self._saved > self._wait:
            self._save()
            # A long record is written less often: at most a fiftieth of the time goes into it.
            self._saved = perf_counter()
            self._wait = max(_SAVED_EVERY, 50.0 * (self._saved - now))
        if now - self._logged > _LOGGED_EVERY and record.best_return > self._logged_best:
            self._log_best()
            self._logged, self._logged_best = perf_counter(), record.best_return

    def _save(self) -> None:
        self._record.save(self._path, self._owner)

    def _log_best(self) -> Score:
        self._log.parent.mkdir(parents=True, exist_ok=True)
        try:
            actor = self._method.actor(self._record.best, self._search, self._problem)
            return evaluate_actor(actor, self._problem, self._study, self._log)
        except (IndexError, KeyError, TypeError, ValueError) as error:
            if isinstance(error, GranularError):
                raise
            unfit = f"the best that it holds does not fit this study ({error})"
            raise ExperimentError(Fault(received=unfit, hint=START_ANEW, source=str(self._path))) from error


# -- the folder -----------------------------------------------------------------------------------------------------------


def _claim(folder: Path, study: Study, overwrite: bool) -> None:
    """Make the folder this study's, or find that it is."""
    if os.path.lexists(folder) and not folder.is_dir():
        raise ParameterError(f"{str(folder)!r} is a file", expected="a folder", hint="the study's results go into it")
    file = folder / "study.toml"
    if not file.is_file() and folder.is_dir() and any(folder.iterdir()):
        raise ExperimentError("it holds files and no study", hint="choose another folder", source=str(folder))
    if file.is_file() and overwrite:
        _clear(folder)
    elif file.is_file() and (found := load_study(file)).identity != study.identity:
        other = f"it holds another study, {found.name!r}, or this one with other keys"
        hint = ("choose another folder, or pass ", Option("overwrite"), " to replace its results")
        raise ExperimentError(Fault(received=other, hint=hint, source=str(folder)))
    new = not folder.exists()
    _make_folder(folder)
    try:
        write_files({file: to_toml(study.to_dict()).encode("utf-8")}, ExperimentError)
        for part in _OURS:
            _make_folder(folder / part)
    except ExperimentError:
        if new:
            shutil.rmtree(folder, ignore_errors=True)
        raise


def _clear(folder: Path) -> None:
    """Remove the records of trials and their logs, and nothing else."""
    for record in (folder / "checkpoints").glob("*.trial"):
        try:
            record.unlink(missing_ok=True)
            (folder / "logs" / f"{record.stem}.mcap").unlink(missing_ok=True)
        except OSError as error:
            raise ExperimentError(f"cannot be removed: {error.strerror or error}", source=str(record)) from error


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExperimentError(
            f"cannot be made: {error.strerror or error}", hint="choose another folder", source=str(folder)
        ) from error
