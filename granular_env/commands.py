"""What each command of the command line does: call, print, return the exit status. The parser is in `cli`."""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import re
import shlex
import tomllib
import warnings
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import Any

from granular_env.components.errors import (
    ExperimentError,
    GranularWarning,
    LogError,
    MissingExtraError,
    ParameterError,
    shortened,
)
from granular_env.output_files import advice_for, count_of, readable_bytes, with_article
from granular_env.terminal import columns, printable, wrap_text

_INTERRUPTED = 130
# Exit status of a verification.
_VERIFIED = {"identical": 0, "different": 1, "incomplete": 3, "nothing was compared": 3}


# -- experiments ----------------------------------------------------------------------------------------------------


def show_list(args: argparse.Namespace) -> int:
    """Components, shipped experiments and plans of sweeps, one line each."""
    from granular_env.package_contents import overview

    known = overview()
    if args.json:
        print(json.dumps(known, indent=2))
        return 0
    for kind, entries in known.items():
        print(f"{kind}\n{columns(entries.items())}\n")
    print(wrap_text("granular-env describe NAME tells more; granular-env run EXPERIMENT, sweep PLAN and study STUDY run one."))
    return 0


def show_description(args: argparse.Namespace) -> int:
    """Print a component's variables, or the file of an experiment, a plan or a study."""
    from granular_env import descriptions
    from granular_env.components import catalogue
    from granular_env.documents import parse_assignments
    from granular_env.experiments.templates import template

    if args.name in catalogue.names():
        parameters = {override.key[-1]: override.value for override in parse_assignments(args.overrides)}
        if args.json:
            print(json.dumps(descriptions.component_facts(args.name, parameters), indent=2))
        else:
            print(descriptions.describe_component(args.name, parameters))
        return 0
    text, _ = _shipped_text(args.name)
    text = text or template(args.name)
    print(json.dumps(tomllib.loads(text), indent=2, default=str) if args.json else "\n".join(map(printable, text.splitlines())))
    return 0


def write_new(args: argparse.Namespace) -> int:
    """Write a file to start from, and the data files that it names."""
    from granular_env.experiments import templates

    text, command = _shipped_text(args.template)
    if templates.is_log(args.template):
        text, command = templates.of_log(args.template, args.out and Path(args.out).stem), "run"
    if args.out is None:
        print(text or templates.template(args.template), end="")
        return 0
    if text:
        templates.write_text(text, Path(args.out), args.force)
        print(f"written: {args.out}\nrun it with: granular-env {command} {shlex.quote(args.out)}")
        return 0
    written = templates.write(args.template, Path(args.out), args.force)
    print("\n".join(f"written: {path}" for path in written))
    print(f"run it with: granular-env run {shlex.quote(args.out)}")
    return 0


def run_experiment(args: argparse.Namespace) -> int:
    """Run an experiment, record it, tell where the log is and how far the model held."""
    from granular_env.documents import parse_assignments
    from granular_env.experiments import load_experiment
    from granular_env.run_loop import run

    _refuse_what_another_command_runs(args.experiment, "run")
    hashes = [] if args.hash_every is None else [f"record.hash_every={args.hash_every}"]
    experiment = load_experiment(args.experiment, parse_assignments([*args.overrides, *hashes]))
    show = not args.quiet and not args.json
    with _silence_own_warnings(), _log_target(args, args.log, experiment.name) as (log, overwrite):
        result = run(experiment, log=log, progress=show, live=args.live, pace=args.pace, overwrite=overwrite)
    if args.json:
        print(json.dumps(_result_facts(result), indent=2))
    else:
        _print_result(result, args.quiet)
    return _INTERRUPTED if result.interrupted else 0


def check_file(args: argparse.Namespace) -> int:
    """Validate a file of an experiment, a plan or a study, or a log, without running it."""
    if Path(args.file).suffix == ".mcap":
        return _check_log_for_programs(args.file, args.allow_large) if args.json else _check_log(args.file, args.allow_large)
    if _is_plan(args.file):
        return _check_plan(args.file, args.overrides, args.allow_large, args.json)
    if _is_study(args.file):
        return _check_study(args.file, args.overrides, args.json)
    from granular_env.documents import parse_assignments
    from granular_env.experiments import load_experiment
    from granular_env.experiments.cost import cost_note
    from granular_env.experiments.preparation import prepare

    experiment = load_experiment(args.file, parse_assignments(args.overrides))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GranularWarning)
        ready = prepare(experiment)
    notes = [str(warning.message) for warning in caught]
    if note := cost_note(ready):
        notes.append(note)
    component = ready.component
    if args.json:
        facts = {"duration": experiment.duration, "ticks": ready.ticks, "step_size": component.step_size, "notes": notes}
        return _valid("experiment", experiment.name, component=component.name, **facts)
    for note in notes:
        print(wrap_text(f"note: {printable(note)}"))
    print(
        f"valid: {printable(experiment.name)}, {with_article(component.name)} for {experiment.duration:g} s "
        f"in {ready.ticks} ticks of {component.step_size:g} s"
    )
    return 0


def _valid(kind: str, name: str, **facts: Any) -> int:
    print(json.dumps({"valid": True, "kind": kind, "name": name, **facts}, indent=2))
    return 0


# -- logs -----------------------------------------------------------------------------------------------------------


def replay_log(args: argparse.Namespace) -> int:
    """Run a log again; with --verify compare it bit for bit: 0 identical, 1 different, 3 incomplete or nothing to compare."""
    if not args.verify:
        from granular_env.run_loop import replay

        with _silence_own_warnings():
            result = replay(args.log, progress=not args.json, allow_large=args.allow_large)
        if args.json:
            print(json.dumps(_result_facts(result), indent=2))
        else:
            _print_result(result, quiet=False)
        return _INTERRUPTED if result.interrupted else 0
    from granular_env.recording import verify
    from granular_env.run_loop import collect_warnings

    with _silence_own_warnings(), collect_warnings() as told:
        found = verify(args.log, progress=not args.json, allow_large=args.allow_large)
    if args.json:
        print(json.dumps({"outcome": found.outcome, **dataclasses.asdict(found), "warnings": told}, indent=2))
        return _VERIFIED[found.outcome]
    print("\n".join(map(printable, [*found.message.splitlines(), *(f"note: {text}" for text in told)])))
    return _VERIFIED[found.outcome]


def branch_off(args: argparse.Namespace) -> int:
    """Go on from an instant of a log."""
    from granular_env.branch_run import run_branch
    from granular_env.documents import parse_assignments
    from granular_env.experiments.preparation import branch_inputs
    from granular_env.recording import open_log

    with ExitStack() as stack:
        log = stack.enter_context(open_log(args.log, allow_large=args.allow_large))
        begun = log.branch(args.at)
        left_at = _instant(args.at, begun.component.time, log.step_size)
        inputs = branch_inputs(parse_assignments(args.overrides), begun.component)
        stack.enter_context(_silence_own_warnings())
        out, overwrite = stack.enter_context(_log_target(args, args.out, f"{Path(args.log).stem}-branch"))
        result = run_branch(begun, out, inputs, args.until, progress=not args.quiet, overwrite=overwrite)
    if not args.quiet:
        print(f"branched at {left_at}, {result.ticks * log.step_size:.9g} s long")
    _print_result(result, args.quiet)
    return _INTERRUPTED if result.interrupted else 0


def recover_log(args: argparse.Namespace) -> int:
    """Make a whole log of a broken one."""
    from granular_env.recording import recover

    log = recover(args.log, args.out, allow_large=args.allow_large, overwrite=args.overwrite)
    ticks = log.end_tick - log.start_tick
    print(f"recovered: {args.out}, {log.duration:g} s, {count_of(log.calls, 'call')} of step, {count_of(ticks, 'tick')}")
    lost = log.metadata["incidents"][-1]
    print(f"lost: {lost['lost']} ({lost['bytes_lost']} bytes)")
    if ticks:
        return 0
    print("nothing was recovered but the start: the log holds no step")
    return 1


def view_log(args: argparse.Namespace) -> int:
    """Look at a log in rerun, or write what rerun shows."""
    from granular_env import viewing
    from granular_env.recording import open_log

    log = open_log(args.log, allow_large=args.allow_large)
    if args.save:
        saved = viewing.save_rrd(log, args.save, exaggerate=args.exaggerate, progress=True)
        print(f"written: {saved}")
    elif args.screenshot:
        print(f"written: {viewing.screenshot(log, args.screenshot, exaggerate=args.exaggerate)}")
    elif args.foxglove_layout:
        print(f"written: {viewing.save_foxglove_layout(log, args.foxglove_layout)}")
    else:
        viewing.view(log, web=args.web, exaggerate=args.exaggerate)
    return 0


def report_log(args: argparse.Namespace) -> int:
    """Write a page with figures of a log."""
    from granular_env import viewing
    from granular_env.recording import open_log

    with open_log(args.log, allow_large=args.allow_large) as log:
        folder = Path(args.out) if args.out else _report_folder(Path(args.log))
        chosen = {name: getattr(args, name) for name in ("variables", "times", "grains")}
        page = viewing.report(log, folder, **chosen, progress=True)
        print(f"written: {page}")
    return 0


# -- papers ---------------------------------------------------------------------------------------------------------


def write_atlas(args: argparse.Namespace) -> int:
    """Compute a paper's figures and numbers anew; return 1 where an entry could not be computed."""
    from granular_env.atlas import run_atlas
    from granular_env.atlas.console import closing

    done = run_atlas(
        args.paper,
        args.out,
        overrides=_constants(args.overrides),
        only=args.only,
        processes=args.processes,
        progress=not args.quiet,
    )
    print(done.page if args.quiet else closing(done))
    return 1 if done.failed else 0


def compute_sweep(args: argparse.Namespace) -> int:
    """Compute those of a plan's tasks that have no result yet; return 1 where a task failed."""
    from granular_env.documents import parse_assignments
    from granular_env.sweep import run_sweep
    from granular_env.sweep.console import closing
    from granular_env.sweep.store import TABLE

    _refuse_what_another_command_runs(args.plan, "sweep")
    sweep = run_sweep(
        args.plan,
        args.out,
        engine=args.engine,
        workers=args.workers,
        address=args.address,
        overrides=parse_assignments(args.overrides),
        progress=not args.quiet and not args.json,
        allow_large=args.allow_large,
    )
    if args.json:
        print(json.dumps(_sweep_facts(sweep), indent=2))
    else:
        print(shlex.quote(str(sweep.folder / TABLE)) if args.quiet else closing(sweep))
    return _INTERRUPTED if sweep.interrupted else 1 if sweep.failed else 0


def _is_plan(name: str) -> bool:
    from granular_env.documents import read
    from granular_env.sweep.plan import is_plan, shipped_plans

    return is_plan(read(Path(name))) if Path(name).is_file() else name in shipped_plans()


def _sweep_facts(sweep: Any) -> dict[str, Any]:
    from granular_env.sweep.store import CSV, TABLE

    pending = sweep.size - sweep.done - sweep.failed
    counts = {"tasks": sweep.size, "done": sweep.done, "failed": sweep.failed, "pending": pending}
    files = {"folder": str(sweep.folder), "table": str(sweep.folder / TABLE), "csv": str(sweep.folder / CSV)}
    return {**counts, "interrupted": sweep.interrupted, "errors": sweep.errors, "units": sweep.units, **files}


def _check_plan(name: str, overrides: list[str], allow_large: bool, for_programs: bool) -> int:
    from granular_env.documents import parse_assignments
    from granular_env.sweep import check_sweep

    plan = check_sweep(name, parse_assignments(overrides), allow_large=allow_large)
    if for_programs:
        return _valid("sweep", plan.title, experiment=plan.experiment, tasks=plan.size, measures=list(plan.measure))
    print(
        f"valid: {plan.title}, {count_of(plan.size, 'task')} of the experiment {plan.experiment}, "
        f"{count_of(len(plan.measure), 'measure')}"
    )
    return 0


# -- studies --------------------------------------------------------------------------------------------------------


def run_study(args: argparse.Namespace) -> int:
    """Run a study, or go on with one; 130 where Ctrl-C ended it."""
    from granular_env.control.study import console, load_study, runner
    from granular_env.documents import parse_assignments

    if args.list:
        return _list_studies()
    if args.study is None:
        raise ExperimentError("study: no study was named; `granular-env study --list` names those that come with the package")
    _refuse_what_another_command_runs(args.study, "study")
    study = load_study(args.study, parse_assignments(args.overrides))
    with _silence_own_warnings():
        result = runner.run_study(study, args.out, overwrite=args.overwrite, progress=not args.quiet, only=args.only)
    print(result.folder / "report.html" if args.quiet else console.closing(result))
    return _INTERRUPTED if result.interrupted else 0


def _list_studies() -> int:
    from granular_env.control.task_names import task_names
    from granular_env.package_contents import overview

    print(f"studies\n{columns(overview()['studies'].items())}\n")
    print(f"tasks\n{columns(task_names().items())}\n")
    print("granular-env new STUDY -o FILE.toml writes one to start from; granular-env study FILE.toml runs it.")
    return 0


def _shipped_text(name: str) -> tuple[str, str]:
    """Return the text of a shipped plan or study, and the command that runs it; "" where there is none of that name."""
    from granular_env.package_contents import shipped_files

    if Path(name).exists():
        return "", ""
    for kind, command in (("plans of sweeps", "sweep"), ("studies", "study")):
        if name in (files := shipped_files(kind)):
            return files[name].read_text(encoding="utf-8"), command
    return "", ""


def _is_study(name: str) -> bool:
    from granular_env.control.study.study import is_study, shipped_studies
    from granular_env.documents import read

    if Path(name).is_file():
        return is_study(read(Path(name)))
    return name in shipped_studies()


def _check_study(name: str, overrides: list[str], for_programs: bool) -> int:
    from granular_env.control.study import load_study
    from granular_env.control.study.runner import prepare
    from granular_env.control.task_names import names_own_code
    from granular_env.documents import parse_assignments

    study = load_study(name, parse_assignments(overrides))
    if names_own_code(study.task.name):
        print(
            f"valid as far as a file can be: {study.name}; its task {study.task.name!r} is code that is not of this package, "
            "which check does not import; `granular-env study` does"
        )
        return 0
    problem, shape = prepare(study)
    methods = ", ".join(method.label for method in study.method)
    if for_programs:
        facts = {"task": study.task.name, "control_steps": problem.steps, "numbers": shape.size, "budget": study.budget}
        return _valid("study", study.name, **facts, methods=[method.label for method in study.method])
    print(
        f"valid: {study.name}, task {study.task.name} of {problem.steps} control steps, "
        f"{count_of(shape.size, 'number')} to choose, {study.budget} control steps for each of {methods}"
    )
    for method in study.method:
        try:
            method.refuse_unless_installed()
        except MissingExtraError as error:
            print(f"not here: {error}; `granular-env study {shlex.quote(name)} --only METHOD` runs chosen methods")
    return 0


def _refuse_what_another_command_runs(name: str, command: str) -> None:
    """`ExperimentError` that names the command for a file, or a shipped name, of another kind."""
    from granular_env.documents import read
    from granular_env.experiments import shipped_experiments

    if Path(name).is_file() and Path(name).suffix != ".toml":
        return  # whoever loads it says what it is

    def is_experiment(name: str) -> bool:
        return "component" in read(Path(name)) if Path(name).is_file() else name in shipped_experiments()

    kinds = {"run": ("an experiment", is_experiment), "sweep": ("a sweep's plan", _is_plan), "study": ("a study", _is_study)}
    for other, (kind, holds) in kinds.items():
        if other != command and holds(name):
            raise ExperimentError(f"{name}: it is {kind}; run it with: granular-env {other} {shlex.quote(name)}")


# -- details --------------------------------------------------------------------------------------------------------


@contextmanager
def _log_target(args: argparse.Namespace, given: str | None, name: str) -> Iterator[tuple[Any, bool]]:
    """Where to record, and whether what stands there may be replaced: at the path given, or in a new file in logs/."""
    if getattr(args, "no_log", False) or given:
        yield (Path(given) if given else None), args.overwrite
        return
    with reserve_log(name) as path:
        yield path, True


@contextmanager
def reserve_log(name: str, folder: Path = Path("logs")) -> Iterator[Path]:
    """Give the first of logs/<name>-1.mcap, -2, ... that does not exist, as an empty file that nobody else gets.

    It may be overwritten; where nothing was written to it, it is removed again.
    """
    stem, new_folder = re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip("-.")[:100] or "run", not folder.exists()
    path = _empty_file(folder, stem)
    try:
        yield path
    finally:
        with suppress(OSError):
            if path.stat().st_size == 0:
                path.unlink()
                if new_folder:
                    folder.rmdir()


def _empty_file(folder: Path, stem: str) -> Path:
    for number in count(1):
        path = folder / f"{stem}-{number}.mcap"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            path.touch(exist_ok=False)
            return path
        except FileExistsError:
            continue
        except OSError as error:
            raise LogError(f"log {str(path)!r} cannot be written: {error.strerror}; {advice_for(error)}") from error
    raise AssertionError


def _constants(overrides: list[str]) -> dict[str, Any]:
    """Return the constants of a paper that --set gives, name -> value, each once."""
    from granular_env.documents import parse_assignments

    constants: dict[str, Any] = {}
    for override in parse_assignments(overrides):
        name, value = ".".join(override.key), override.value
        if name in constants:
            raise ParameterError(
                f"constant {name!r}: given twice, as {shortened(constants[name])} and {shortened(value)}; give it once"
            )
        constants[name] = value
    return constants


def _report_folder(log: Path) -> Path:
    """Beside the log, by its name; never the log itself, whose name may have no suffix."""
    return log.with_suffix("") if log.suffix else log.with_name(f"{log.name}-report")


def _instant(asked: float, found: float, step_size: float) -> str:
    """When a log was left, in words; an instant between two steps was moved to the nearest, which is said."""
    between = abs(asked / step_size - round(asked / step_size)) > 1e-6
    return f"{found:.9g} s" + (f" (the step nearest to {asked:.9g} s)" if between else "")


def _silence_own_warnings() -> warnings.catch_warnings:
    """Silence the run's warnings, which the command prints with its result."""
    return warnings.catch_warnings(action="ignore", category=GranularWarning)


def _check_log(path: str, allow_large: bool) -> int:
    from granular_env.recording import open_log

    log = open_log(path, allow_large=allow_large)
    facts = log.metadata
    state = "complete" if log.complete else "incomplete: `granular-env recover` makes it whole"
    size = (
        f"{log.duration:g} s, {count_of(log.calls, 'call')} of step, {count_of(log.end_tick - log.start_tick, 'tick')}, "
        f"{count_of(len(log.variables), 'variable')}, {readable_bytes(log.size)}"
    )
    # The verdict comes after all of it has been read: a damaged log is not called complete first.
    for name in log.variables:
        log.series(name)
    print(f"{path}: {with_article(facts['component'])}, {size}; {state}")
    return 0 if log.complete else 1


def _check_log_for_programs(path: str, allow_large: bool) -> int:
    from granular_env.recording import open_log

    with open_log(path, allow_large=allow_large) as log:
        for name in log.variables:
            log.series(name)
        facts = {"duration": log.duration, "ticks": log.end_tick - log.start_tick, "variables": list(log.variables)}
        _valid("log", path, component=log.metadata["component"], complete=log.complete, **facts)
        return 0 if log.complete else 1


def _result_facts(result: Any) -> dict[str, Any]:
    """Return what a run came to as JSON values; figures that nothing gave rise to are null."""
    component = result.component
    return {
        "log": None if result.log is None else str(result.log),
        "log_bytes": None if result.log is None else result.log.stat().st_size,
        "tick": component.tick,
        "time": component.time,
        "wall_seconds": result.seconds,
        "stopped_by": result.stopped_by,
        "interrupted": result.interrupted,
        "notes": [*result.warnings, *result.cautions],
        "report": _finite(result.report),
        "balances": {b.quantity: _finite(b.entries) for b in component.balances()},
    }


def _finite(values: Mapping[str, Any]) -> dict[str, Any]:
    return {name: _finite_number(value) for name, value in values.items()}


def _finite_number(value: Any) -> Any:
    """Return a number, or a list of those of a vector, with null in the place of what is not finite."""
    if hasattr(value, "tolist"):
        return [_finite_number(part) for part in value.tolist()]
    return value if math.isfinite(value) else None


def _print_result(result, quiet: bool) -> None:  # noqa: ANN001
    from granular_env.run_loop import energy_residual

    if quiet:
        if result.log is not None:
            _print_log(True, result.log)
        return
    component = result.component
    wall = f"{result.seconds:.2f} s of wall time"
    print(f"{count_of(result.ticks, 'tick')}, to {component.time:.9g} s, in {wall}; {energy_residual(component)}")
    if result.stopped_by is not None:
        print(f"stopped: {result.stopped_by}")
    if result.interrupted:
        print("interrupted: the log is complete up to there" if result.log else "interrupted")
    for text in (*result.warnings, *result.cautions):
        print(wrap_text(f"note: {printable(text)}"))
    for name, value in result.report.items():
        # What nothing in the run gave rise to, such as the pressure where no grains touched, has no figure.
        if not math.isnan(value):
            print(f"  {name}: {value:.4g}")
    if result.log is not None:
        _print_log(False, result.log)


def _print_log(quiet: bool, path: Path) -> None:
    log = shlex.quote(str(path))
    if quiet:
        print(log)
        return
    print(f"log: {log} ({readable_bytes(path.stat().st_size)})")
    print(f"  granular-env view {log}              (or --web, or --screenshot FILE.png)")
    print(f"  granular-env replay {log} --verify")


COMMANDS = {
    "list": show_list,
    "describe": show_description,
    "new": write_new,
    "run": run_experiment,
    "check": check_file,
    "replay": replay_log,
    "branch": branch_off,
    "recover": recover_log,
    "view": view_log,
    "report": report_log,
    "atlas": write_atlas,
    "sweep": compute_sweep,
    "study": run_study,
}
