"""Validating without running: `check`, of an experiment, a plan, a study or a log."""

from __future__ import annotations

import json
import shlex
import warnings
from pathlib import Path
from typing import Any

import click

from granular_env.cli.command import Status, command
from granular_env.cli.kinds import is_plan, is_study
from granular_env.cli.options import Overrides, Shipped, json_option, large_option, set_option
from granular_env.components.errors import GranularWarning, MissingExtraError
from granular_env.output_files import count_of, readable_bytes
from granular_env.terminal_text import printable, wrap_text


@command("check")
@click.argument(
    "file",
    help="A TOML file, a name of `granular-env list`, or a log.",
    type=Shipped("experiments", "plans of sweeps", "studies"),
)
@json_option()
@set_option("As in run.")
@large_option()
def check(file: str, for_programs: bool, overrides: Overrides, allow_large: bool) -> int:
    """Validate the file of an experiment, plan or study, or a log, without running it."""
    if Path(file).suffix == ".mcap":
        return _check_log(file, allow_large, for_programs)
    if is_plan(file):
        return _check_plan(file, overrides, allow_large, for_programs)
    if is_study(file):
        return _check_study(file, overrides, for_programs)
    return _check_experiment(file, overrides, for_programs)


def _check_experiment(name: str, overrides: Overrides, for_programs: bool) -> int:
    from granular_env.experiments import load_experiment
    from granular_env.experiments.cost import cost_note
    from granular_env.experiments.preparation import prepare

    experiment = load_experiment(name, overrides)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GranularWarning)
        ready = prepare(experiment)
    notes = [str(warning.message) for warning in caught]
    if note := cost_note(ready):
        notes.append(note)
    component = ready.component
    if for_programs:
        facts = {"duration": experiment.duration, "ticks": ready.ticks, "step_size": component.step_size, "notes": notes}
        return _print_facts("experiment", experiment.name, component=component.name, **facts)
    for note in notes:
        print(wrap_text(f"note: {printable(note)}"))
    print(
        f"valid: {printable(experiment.name)}, component {printable(component.name)} for {experiment.duration:g} s "
        f"in {ready.ticks} ticks of {component.step_size:g} s"
    )
    return Status.DONE


def _check_plan(name: str, overrides: Overrides, allow_large: bool, for_programs: bool) -> int:
    from granular_env.sweep import check_sweep

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GranularWarning)
        plan = check_sweep(name, overrides, allow_large=allow_large)
    notes = [str(warning.message) for warning in caught]
    if for_programs:
        facts = {"experiment": plan.experiment, "tasks": plan.size, "measures": list(plan.measure), "notes": notes}
        return _print_facts("sweep", plan.title, **facts)
    for note in notes:
        print(wrap_text(f"note: {printable(note)}"))
    print(
        f"valid: {plan.title}, {count_of(plan.size, 'task')} of the experiment {plan.experiment}, "
        f"{count_of(len(plan.measure), 'measure')}"
    )
    return Status.DONE


def _check_study(name: str, overrides: Overrides, for_programs: bool) -> int:
    from granular_env.control.runner import prepare
    from granular_env.control.study import load_study

    study = load_study(name, overrides)
    if ":" in study.task.name:
        print(
            f"valid as far as a file can be: {study.name}; its task {study.task.name!r} is code that is not of this package, "
            "which check does not import; `granular-env study` does"
        )
        return Status.DONE
    problem, shape = prepare(study)
    methods = [method.label for method in study.method]
    if for_programs:
        facts = {"task": study.task.name, "control_steps": problem.steps, "numbers": shape.size, "budget": study.budget}
        return _print_facts("study", study.name, **facts, methods=methods)
    print(
        f"valid: {study.name}, task {study.task.name} of {problem.steps} control steps, "
        f"{count_of(shape.size, 'number')} to choose, {study.budget} control steps for each of {', '.join(methods)}"
    )
    for method in study.method:
        try:
            method.refuse_unless_installed()
        except MissingExtraError as error:
            print(f"not here: {error}; `granular-env study {shlex.quote(name)} --only METHOD` runs chosen methods")
    return Status.DONE


def _check_log(path: str, allow_large: bool, for_programs: bool) -> int:
    from granular_env.recording import open_log

    with open_log(path, allow_large=allow_large) as log:
        # The verdict comes after all of it has been read: a damaged log is not called complete first.
        for name in log.variables:
            log.series(name)
        component, ticks = log.metadata["component"], log.end_tick - log.start_tick
        if for_programs:
            facts = {"duration": log.duration, "ticks": ticks, "variables": list(log.variables)}
            _print_facts("log", path, component=component, complete=log.complete, **facts)
        else:
            size = (
                f"{log.duration:g} s, {count_of(log.calls, 'call')} of step, {count_of(ticks, 'tick')}, "
                f"{count_of(len(log.variables), 'variable')}, {readable_bytes(log.size)}"
            )
            state = "complete" if log.complete else "incomplete: `granular-env recover` makes it whole"
            print(f"{path}: component {printable(component)}, {size}; {state}")
        return Status.DONE if log.complete else Status.DIFFERENT


def _print_facts(kind: str, name: str, **facts: Any) -> int:
    print(json.dumps({"valid": True, "kind": kind, "name": name, **facts}, indent=2))
    return Status.DONE
