"""The means of an entry: runs that are recorded once, and the paper's constants."""

from __future__ import annotations

import hashlib
import json
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext, suppress
from pathlib import Path
from time import perf_counter
from typing import Any

from granular_env.components.catalogue import component_class
from granular_env.components.component import Component
from granular_env.components.errors import GranularWarning, LogError, ParameterError
from granular_env.components.stepping import Observer
from granular_env.domains import domain_of
from granular_env.experiments import Experiment
from granular_env.experiments.experiment import Source, load_experiment
from granular_env.output_files import file_name, one_at_a_time
from granular_env.recording import open_log
from granular_env.recording.replay.log import Log
from granular_env.run_loop import run

from .finished_runs import FinishedRuns
from .folder import LOCK, PART

# Of a run that goes on, so often is told how far it is [s].
_TELL_SECONDS = 2.0


class Context:
    """Runs experiments for the entries of one atlas; each is run once in a process, however many entries ask for it.

    Args:
        logs: the folder that the logs are written into.
        constants: the paper's constants, with the changes that were asked for.
        refinement: by how much entries divide their steps and sampling intervals.
        finished: runs that need not be done again; None: all are done here.
    """

    def __init__(
        self, logs: Path, constants: Mapping[str, float], refinement: int = 1, finished: FinishedRuns | None = None
    ) -> None:
        self.constants, self.refinement = dict(constants), refinement
        self._logs, self._finished = logs, finished
        self._paths: dict[str, Path] = {}
        self.begin(lambda runs: None)

    def begin(self, on_run: Callable[[float], None]) -> None:
        """Begin an entry: `on_run` is called with the number of its runs so far, after each, and with parts of a long one."""
        self._used: list[str] = []
        self._runs, self._on_run, self._last_told, self._start = 0, on_run, perf_counter(), (0.0, 0.0)

    def run(self, experiment: Source, *, start: tuple[float, float] = (0.0, 0.0), **overrides: Any) -> Log:
        """Open the log of an experiment.

            log = context.run("nesterenko-1983/3.4-piston", **{"component.grains": 50})

        Args:
            experiment: a shipped experiment's name, or the content of one.
            start: for the progress bar, where a run begins faster than it goes on: a part of its simulated time, and the part
                of the computing time that it takes.
            overrides: key = value, the value a number, a string, or a list of them.

        Raises:
            GranularError: it is not valid, or its physics broke down.
        """
        self._start = start
        loaded = load_experiment(experiment, overrides)
        content = json.dumps(loaded.to_dict(), sort_keys=True)
        if content not in self._paths:
            self._paths[content] = self._find_run(loaded, content) or self._record_alone(loaded, content)
        path = self._paths[content]
        if path.name not in self._used:
            self._used.append(path.name)
        self._count()
        return open_log(path)

    def watch(self, experiment: Source, every: float, *, recorded: bool = True) -> Any:
        """Return the motion in an experiment, sampled at even intervals [s] while it runs; its log may be much thinner.

        For ensembles: what is measured is never written, and the logs still replay. It is run anew at each call. What keeps the
        motion is the `watch` of the component's domain, and its history is returned.

        Args:
            experiment: a shipped experiment's name, or the content of one.
            every: a whole number of the experiment's steps [s].
            recorded: False for no log at all, in ensembles so large that nobody would look at them.
        """
        loaded = load_experiment(experiment)
        watch = _watch(loaded.component.type, every)
        if recorded:
            path = self._record_run(loaded, json.dumps(loaded.to_dict(), sort_keys=True), [watch])
            self._used.append(path.name)
        else:
            self._run(loaded, None, [watch])
        self._count()
        return watch.history

    def state(self, experiment: Source) -> Component:
        """Return the component at the end of an experiment, of which nothing is kept; for very large ensembles."""
        component = self._run(load_experiment(experiment), None, [])
        self._count()
        return component

    def log_names(self) -> list[str]:
        """Return the file names of the logs that the entry asked for."""
        return self._used

    def _count(self) -> None:
        self._start = (0.0, 0.0)
        self._runs += 1
        self._on_run(self._runs)

    def _find_run(self, experiment: Experiment, content: str) -> Path | None:
        """Return the log of a run that is finished already; only where all that computed it is code of this package."""
        path = self._path(experiment, content)
        of_package = component_class(experiment.component.type).__module__.startswith("granular_env.")
        if self._finished is None or not of_package or not self._finished.has(path.name):
            return None
        with suppress(LogError):
            open_log(path)
            return path
        return None

    def _path(self, experiment: Experiment, content: str) -> Path:
        short = file_name(experiment.name.rpartition("/")[2], "run")
        return self._logs / f"{short}-{hashlib.sha256(content.encode()).hexdigest()[:6]}.mcap"

    def _record_alone(self, experiment: Experiment, content: str) -> Path:
        """Run it, or wait for the process that is at the same run."""
        path = self._path(experiment, content)
        with nullcontext() if self._finished is None else one_at_a_time(path.with_name(f".{path.name}{LOCK}")):
            return self._find_run(experiment, content) or self._record_run(experiment, content)

    def _record_run(self, experiment: Experiment, content: str, observers: Sequence[Observer] = ()) -> Path:
        """Run it. Where two processes do, each writes its own file, and the last one, which is equal, stays."""
        path = self._path(experiment, content)
        own = path.with_name(f".{path.name}.{os.getpid()}{PART}")
        try:
            self._run(experiment, own, observers)
            own.replace(path)
            if self._finished is not None:
                self._finished.add(path.name)
        finally:
            own.unlink(missing_ok=True)
        return path

    def _part_done(self, part: float) -> None:
        """Tell how far a run is, where it is a long one."""
        if perf_counter() - self._last_told > _TELL_SECONDS:
            self._last_told = perf_counter()
            self._on_run(self._runs + work_done(part, self._start))

    def _run(self, experiment: Experiment, log: Path | None, observers: Sequence[Observer]) -> Component:
        self._last_told = perf_counter()
        with warnings.catch_warnings(action="ignore", category=GranularWarning):
            result = run(experiment, log=log, overwrite=True, observers=observers, progress=self._part_done)
        if result.interrupted:
            raise KeyboardInterrupt
        return result.component


def work_done(part: float, start: tuple[float, float]) -> float:
    """Return the part of a run's computing time after a part of its simulated time, linear before and after the start's end."""
    simulated, computed = start
    if part < simulated:
        return computed * part / simulated
    return computed + (1.0 - computed) * (part - simulated) / max(1.0 - simulated, 1e-9)


def _watch(component: str, every: float) -> Any:
    """Return an observer that keeps the motion of such a component."""
    watch = domain_of(component).load("watch")
    if watch is None:
        raise ParameterError(
            f"it runs a {component!r}, of which no history is kept", hint="read its log instead", at="experiment"
        )
    return watch(every)
