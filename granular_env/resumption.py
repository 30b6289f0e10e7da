"""An experiment whose run ended too early, run on from its log to its end."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

from granular_env.components.component import Component
from granular_env.components.errors import GranularError, LogError, caution
from granular_env.documents import Overrides
from granular_env.experiments.experiment import Experiment, Source, load_experiment
from granular_env.experiments.stop_rules import StopWatch
from granular_env.progress import Progress
from granular_env.recording.log import Log
from granular_env.run_loop import RunResult, advance, collect_warnings, memory_errors, refuse_unrecordable, run


def resume(
    path: str | os.PathLike[str],
    *,
    log: str | os.PathLike[str] | None = None,
    experiment: Source | None = None,
    overrides: Overrides = (),
    progress: Progress = False,
    overwrite: bool = False,
    allow_large: bool = False,
    components: Mapping[str, type[Component]] | None = None,
) -> RunResult:
    """Run an experiment on to its end, from a log whose process was killed or interrupted.

        result = ge.resume("logs/piston.mcap")

    The intact part of the log is kept, and the run continues from there with the log's own inputs and the experiment's stop
    rules. State and log are those of a run that was never interrupted, bit for bit; the log says that it was resumed. A log
    without a step is recorded from the start.

    Args:
        path: the log; it holds the experiment.
        log: the new log. By default it replaces the old one, once it holds a further step.
        experiment: refuse the log if it is of another experiment than this one.
        overrides: of `experiment`.
        progress: show a bar, or call this with the part that is done.
        overwrite: whether an existing log at `log` may be replaced.
        allow_large: lift the limits on sizes.
        components: classes of components that are not ours, by name.

    Raises:
        LogError: it is no log, or not of an experiment; it is of another one, or of another version of its component; it is
            complete already, or ended with an error; it gives other bits now. Nothing has been written.
        ParameterError: `log` exists.
        ExperimentError: `experiment` is not valid.
        StepError: the physics would break down; the log is complete up to the last good state.
    """
    from granular_env.recording import open_log
    from granular_env.recording.recovery import continuation_of

    wanted = None if experiment is None else load_experiment(experiment, overrides)
    where = f"log {str(path)!r}"
    with memory_errors(where, LogError), collect_warnings() as issued, ExitStack() as stack:
        opened = stack.enter_context(open_log(path, allow_large=allow_large, components=components))
        program = _experiment_of(opened, where)
        if wanted is not None:
            _refuse_other(program, wanted, where)
        _refuse_ended(opened, where)
        _tell_of_versions(opened, where)
        if not opened.calls:
            # The process was killed before its first step reached the disk.
            target, replace = (path, True) if log is None else (log, overwrite)
            return run(wanted or program, log=target, progress=progress, overwrite=replace)
        found = continuation_of(opened)
        component, end = found.component, found.component.ticks_in(program.duration)
        stops = StopWatch(program.stop, component, program.record.every)
        stopped_by = stops.stop_reason(component) if component.tick else None
        if found.closed and (component.tick >= end or stopped_by is not None):
            why = "its experiment was run to its end" if stopped_by is None else f"its run was stopped by {stopped_by}"
            if not opened.complete:
                hint = "nothing is left to resume; `granular-env recover` makes the file whole"
                raise LogError(f"{why}, only the end of the file is missing", hint=hint, source=where)
            raise LogError(f"it is complete: {why}", hint="nothing is left to resume", source=where)
        refuse_unrecordable(component)
        stack.enter_context(found.recorder(path, True) if log is None else found.recorder(log, overwrite))
        return advance(
            component,
            end,
            {},
            changes=found.changes,
            stops=stops,
            title=program.name,
            progress=progress,
            log=Path(path if log is None else log),
            issued=issued,
            closing=stack,
        )


def _experiment_of(log: Log, where: str) -> Experiment:
    """Return the experiment that a log is of."""
    header = log.header
    if header.get("parent") is not None:
        raise LogError("it is a branch of another log", hint="branch off it anew: granular-env branch", source=where)
    content = header.get("experiment")
    if not isinstance(content, dict):
        hint = "the script that made it knows how it goes on: ge.open_log(LOG).branch(at) gives the component"
        raise LogError("it is not of an experiment", hint=hint, source=where)
    try:
        return Experiment.parse(content, f"the experiment in {where}")
    except GranularError as error:
        hint = "another version of the program recorded it; run the experiment anew"
        raise LogError(f"it holds no experiment that this program knows: {error}", hint=hint, source=where) from error


def _refuse_other(program: Experiment, wanted: Experiment, where: str) -> None:
    if program.name != wanted.name:
        raise LogError(f"it is of the experiment {program.name!r}", expected=f"this one, {wanted.name!r}", source=where)
    mine, other = program.to_dict(), wanted.to_dict()
    keys = [key for key in {**mine, **other} if mine.get(key) != other.get(key)]
    if keys:
        came = f"it is of the experiment {program.name!r} with other keys than this one: {', '.join(keys)}"
        raise LogError(came, hint="resume the log alone, or run the experiment anew", source=where)


def _refuse_ended(log: Log, where: str) -> None:
    """Refuse a run that ended with an error: it would do so again."""
    incidents = log.incidents
    failed = next((one for one in incidents if one.get("incident") == "failed"), None)
    if failed is not None and log.complete:
        raise LogError(
            f"it is complete: its run ended with {failed.get('kind')}: {failed.get('message')}",
            hint="it would do so again; change the experiment, and run it anew",
            source=where,
        )


def _tell_of_versions(log: Log, where: str) -> None:
    from granular_env.recording.header import versions

    recorded = log.header.get("versions")
    for name, version in versions().items():
        if isinstance(recorded, dict) and recorded.get(name) != version:
            caution(f"{where} was begun with {name} {recorded.get(name)}, and goes on with {version}")


__all__ = ["resume"]
