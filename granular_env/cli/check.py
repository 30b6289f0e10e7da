"""Command `check`: validate an experiment, a plan, a study or a log without running it."""

from __future__ import annotations

import shlex
import warnings
from pathlib import Path
from typing import Any

import click

from granular_env.cli.command import Status, command, print_json
from granular_env.cli.kinds import document_kind
from granular_env.cli.options import Overrides, ShippedName, allow_large_option, json_option, set_option
from granular_env.components.errors import GranularWarning, MissingExtraError
from granular_env.output_files import count_text, size_text
from granular_env.terminal_text import printable_text, wrap_text


@command("check")
@click.argument(
    "file",
    help="A TOML file, a name from `granular-env list`, or a log.",
    type=ShippedName("experiments", "plans of sweeps", "studies"),
)
@json_option()
@set_option(help="Override any key, as in run.")
@allow_large_option()
def check(file: str, as_json: bool, overrides: Overrides, allow_large: bool) -> int:
    """Validate the file of an experiment, plan or study, or a log, without running it."""
    if Path(file).suffix == ".mcap":
        return _check_log(file, allow_large, as_json)
    checks = {"plans of sweeps": _check_plan, "studies": _check_study}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GranularWarning)
        facts, sentence, further = checks.get(document_kind(file), _check_experiment)(file, overrides, allow_large)
    notes = [*(str(warning.message) for warning in caught), *further]
    if as_json:
        print_json({"valid": True, **facts, "notes": notes})
        return Status.DONE
    for note in notes:
        print(wrap_text(f"note: {printable_text(note)}"))
    print(f"valid: {printable_text(sentence)}")
    return Status.DONE


# The result of a check: facts for the JSON output, a sentence for the text output, and notes printed after the warnings.
Checked = tuple[dict[str, Any], str, list[str]]


def _check_experiment(name: str, overrides: Overrides, allow_large: bool) -> Checked:
    from granular_env.experiments import load_experiment
    from granular_env.experiments.cost import cost_note, refuse_oversized_log
    from granular_env.experiments.preparation import prepare_experiment

    experiment = load_experiment(name, overrides)
    ready = prepare_experiment(experiment)
    refuse_oversized_log(ready, Path("logs") / "log.mcap")
    component, ticks = ready.component, ready.ticks
    facts = {"kind": "experiment", "name": experiment.name, "component": component.name, "duration": experiment.duration}
    facts |= {"ticks": ticks, "step_size": component.step_size}
    size = f"{experiment.duration:g} s in {ticks} ticks of {component.step_size:g} s"
    note = cost_note(ready)
    return facts, f"{experiment.name}, component {component.name} for {size}", [note] if note else []


def _check_plan(name: str, overrides: Overrides, allow_large: bool) -> Checked:
    from granular_env.sweep import check_sweep

    plan = check_sweep(name, overrides, allow_large=allow_large)
    facts = {"kind": "sweep", "name": plan.title, "experiment": plan.experiment, "tasks": plan.size}
    facts["measures"] = list(plan.measure)
    counts = f"{count_text(plan.size, 'task')} of the experiment {plan.experiment}, {count_text(len(plan.measure), 'measure')}"
    return facts, f"{plan.title}, {counts}", []


def _check_study(name: str, overrides: Overrides, allow_large: bool) -> Checked:
    from granular_env.control.runner import prepare_study
    from granular_env.control.study import load_study

    study = load_study(name, overrides)
    methods, notes = [method.label for method in study.method], list[str]()
    facts = {"kind": "study", "name": study.name, "task": study.task.name, "budget": study.budget, "methods": methods}
    if ":" in study.task.name:
        note = "the task belongs to another package, whose code `check` does not import; `granular-env study` does"
        return facts, f"{study.name}, task {study.task.name}, as far as the file alone can be checked", [note]
    problem, shape = prepare_study(study)
    for method in study.method:
        try:
            method.refuse_unless_installed()
        except MissingExtraError as error:
            notes.append(f"not possible: {error}; `granular-env study {shlex.quote(name)} --only METHOD` runs one method")
    facts |= {"control_steps": problem.steps, "numbers": shape.size}
    size = f"{problem.steps} control steps, {count_text(shape.size, 'number')} to choose"
    budget = f"{study.budget} control steps for each of {', '.join(methods)}"
    return facts, f"{study.name}, task {study.task.name} of {size}, {budget}", notes


def _check_log(path: str, allow_large: bool, as_json: bool) -> int:
    from granular_env.recording import open_log

    with open_log(path, allow_large=allow_large) as log:
        # Read the frames of all variables before printing, so that a damaged log is not reported as complete.
        for name in log.variables:
            log.series(name)
        component, ticks = log.metadata["component"], log.end_tick - log.start_tick
        if as_json:
            facts = {"valid": True, "kind": "log", "name": path, "component": component, "complete": log.complete}
            facts |= {"duration": log.duration, "ticks": ticks, "variables": list(log.variables)}
            print_json(facts)
        else:
            size = (
                f"{log.duration:g} s, {count_text(log.calls, 'call')} of step, {count_text(ticks, 'tick')}, "
                f"{count_text(len(log.variables), 'variable')}, {size_text(log.size)}"
            )
            state = "complete" if log.complete else "incomplete: `granular-env recover` completes it"
            print(f"{path}: component {printable_text(component)}, {size}; {state}")
        return Status.DONE if log.complete else Status.DIFFERENT
