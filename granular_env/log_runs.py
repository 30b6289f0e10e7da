"""Runs that start from a log: replay, branch, and resumption of an experiment that ended early."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from granular_env.components.component import Component
from granular_env.components.errors import GranularError, LogError
from granular_env.documents import Overrides
from granular_env.experiments.experiment import Experiment, Source, load_experiment
from granular_env.experiments.stop_rules import StopWatch
from granular_env.progress import Progress
from granular_env.recording.log import Log
from granular_env.run_loop import (
    Inputs,
    RunResult,
    advance_component,
    collect_warnings,
    refuse_unrecordable,
    run,
    translate_memory_errors,
)

if TYPE_CHECKING:
    from granular_env.recording.branch import Branch


def replay(
    log: str | os.PathLike[str],
    *,
    progress: Progress = False,
    allow_large: bool = False,
    components: Mapping[str, type[Component]] | None = None,
) -> RunResult:
    """Run the simulation of a log again from start to end, without comparing the results; arguments as for `verify`.

    Raises:
        LogError: not a log, or the log cannot be run again.
    """
    from granular_env.recording import open_log
    from granular_env.recording.replay import check_work

    where = f"log {str(log)!r}"
    with (
        translate_memory_errors(where, LogError),
        collect_warnings() as issued,
        open_log(log, allow_large=allow_large, components=components) as opened,
    ):
        component, results = opened.component(), []
        check_work(opened.end_tick - opened.start_tick, component, opened.limits)
        for segment in opened.segments:
            start = opened.snapshot(segment, segment.start)
            component.restore(start)
            changes = dict(opened.step_history(segment).input_changes(start.inputs))
            results.append(
                advance_component(
                    component, segment.end, {}, changes=changes, title=str(log), progress=progress, issued_warnings=issued
                )
            )
            if results[-1].interrupted:
                break
        if not results:
            raise LogError("the log contains no step", at="steps", source=f"log {str(log)!r}")
        total, seconds = sum(one.ticks for one in results), sum(one.seconds for one in results)
        return dataclasses.replace(results[-1], ticks=total, seconds=seconds, start=opened.start_tick)


def run_branch(
    branch: Branch,
    log: str | os.PathLike[str],
    inputs: Inputs,
    until: float | None = None,
    *,
    progress: Progress = False,
    overwrite: bool = False,
) -> RunResult:
    """Run a branch of a log and record it, with a progress bar; the result is bitwise identical to that of `Branch.run`.

    Args:
        branch: the branch, not yet stepped.
        log: path of the new log.
        inputs: values or profiles of inputs from the branch's start on, instead of those in the log.
        until: end time on the component's clock [s]; default: the end of the log or, before it, the next reset in it.
        progress: show a bar, or call this with the completed fraction.
        overwrite: whether an existing file may be replaced.

    Raises:
        ParameterError: an argument is invalid; nothing has been written.
        StepError: the physics would break down; the log up to that time is complete, a note of the error names its path.
        LogError: the log cannot be written.
    """
    where, end = f"log {os.fspath(log)!r}", branch.end_tick(until)
    with translate_memory_errors(where, LogError), collect_warnings() as issued, ExitStack() as stack:
        stack.enter_context(branch.make_recorder(log, inputs, overwrite=overwrite))
        result = advance_component(
            branch.component,
            end,
            {},
            changes=branch.input_changes(inputs),
            title=Path(log).name,
            progress=progress,
            log=Path(log),
            issued_warnings=issued,
            closing_stack=stack,
        )
        return dataclasses.replace(result, start=branch.tick)


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
    """Continue an experiment to its end from a log whose process was killed or interrupted.

        result = ge.resume("logs/piston.mcap")

    The intact part of the log is kept, and the run continues from there with the log's inputs and the experiment's stop rules.
    State and log are bitwise identical to those of an uninterrupted run, except that the log notes the resumption. A log
    without a step is recorded from the start.

    Args:
        path: the log, which contains the experiment.
        log: the new log. By default it replaces the old log once it contains a further step.
        experiment: refuse the log if it belongs to a different experiment.
        overrides: keys of `experiment` to set.
        progress: show a bar, or call this with the completed fraction.
        overwrite: whether an existing log at `log` may be replaced.
        allow_large: lift the limits on sizes.
        components: component classes outside this package, by name.

    Raises:
        LogError: not a log of an experiment, another experiment or component version, a complete log, a run that ended with
            an error, or different bits in the replay. Nothing has been written.
        ParameterError: `log` exists.
        ExperimentError: `experiment` is not valid.
        StepError: the physics would break down; the log is complete up to the last good state.
    """
    from granular_env.recording import open_log
    from granular_env.recording.recovery import make_continuation

    wanted = None if experiment is None else load_experiment(experiment, overrides)
    where, (target, replace) = f"log {str(path)!r}", (path, True) if log is None else (log, overwrite)
    with translate_memory_errors(where, LogError), collect_warnings() as issued, ExitStack() as stack:
        opened = stack.enter_context(open_log(path, allow_large=allow_large, components=components))
        program = _logged_experiment(opened, where)
        if wanted is not None:
            _refuse_other_program(program, wanted, where)
        _refuse_failed_run(opened, where)
        if not opened.calls:
            # The process was killed before its first step was written: record the experiment from the start.
            return run(wanted or program, log=target, progress=progress, overwrite=replace)
        found = make_continuation(opened)
        component, end = found.component, found.component.duration_ticks(program.duration)
        stops = StopWatch(program.stop, component, program.record.every)
        stopped_by = stops.stop_reason(component) if component.tick else None
        if found.closed and (component.tick >= end or stopped_by is not None):
            why = "its experiment has run to its end" if stopped_by is None else f"its run was stopped by {stopped_by}"
            if not opened.complete:
                hint = "nothing is left to resume; `granular-env recover` completes the file"
                raise LogError(f"{why}, and only the end of the file is missing", hint=hint, source=where)
            raise LogError(f"the log is complete: {why}", hint="nothing is left to resume", source=where)
        refuse_unrecordable(component)
        stack.enter_context(found.make_recorder(target, replace))
        return advance_component(
            component,
            end,
            {},
            changes=found.changes,
            stops=stops,
            title=program.name,
            progress=progress,
            log=Path(target),
            issued_warnings=issued,
            closing_stack=stack,
        )


def _logged_experiment(log: Log, where: str) -> Experiment:
    """Return the experiment stored in a log; `where` names the log in errors."""
    header = log.header
    if header.get("parent") is not None:
        raise LogError("the log is a branch", hint="start a new branch from it: granular-env branch", source=where)
    content = header.get("experiment")
    if not isinstance(content, dict):
        hint = "a script recorded it and must continue it: ge.open_log(LOG).branch(at) returns the component"
        raise LogError("the log does not belong to an experiment", hint=hint, source=where)
    try:
        return Experiment.parse(content, f"the experiment in {where}")
    except GranularError as error:
        hint = "another version of the program recorded the log; run the experiment again"
        raise LogError(f"this version cannot read the experiment in the log: {error}", hint=hint, source=where) from error


def _refuse_other_program(program: Experiment, expected: Experiment, where: str) -> None:
    if program.name != expected.name:
        raise LogError(f"the log is of experiment {program.name!r}", expected=f"experiment {expected.name!r}", source=where)
    mine, other = program.to_dict(), expected.to_dict()
    keys = [key for key in {**mine, **other} if mine.get(key) != other.get(key)]
    if keys:
        came = f"the experiment {program.name!r} in the log has different values of the keys {', '.join(keys)}"
        raise LogError(came, hint="resume the log without an experiment, or run the experiment again", source=where)


def _refuse_failed_run(log: Log, where: str) -> None:
    """Raise an error for a log whose run ended with an error, because the error would occur again."""
    incidents = log.incidents
    failed = next((one for one in incidents if one.get("incident") == "failed"), None)
    if failed is not None and log.complete:
        raise LogError(
            f"the log is complete: its run ended with {failed.get('kind')}: {failed.get('message')}",
            hint="the error would recur; change the experiment and run it again",
            source=where,
        )
