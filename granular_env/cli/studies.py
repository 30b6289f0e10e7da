"""Command `study`: search for the best drive of a task."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING, Any

import click

from granular_env.cli.command import Status, command, print_json, print_lists
from granular_env.cli.kinds import refuse_other_kinds
from granular_env.cli.options import FOLDER, Overrides, ShippedName, output_options, set_option
from granular_env.cli.run_summary import silence_own_warnings
from granular_env.components.errors import ExperimentError
from granular_env.terminal_text import align_table

if TYPE_CHECKING:
    from granular_env.control.results import StudyResult

# Largest number of notes printed after a study.
_MOST_NOTES = 3


@command("study")
@click.argument(
    "study", required=False, help="A name from `granular-env study --list`, or a TOML file.", type=ShippedName("studies")
)
@click.option("--list", "listing", is_flag=True, help="List the shipped studies and the tasks.")
@click.option("-o", "--out", metavar="FOLDER", type=FOLDER, help="Folder of the results (default: studies/NAME).")
@set_option(help="Override any key, such as budget=100000, task.grains=30 or method.0.population=8.")
@click.option("--only", metavar="METHOD", multiple=True, help="Run only this method (may be repeated).")
@output_options
def study(
    study: str | None, listing: bool, out: str | None, overrides: Overrides, only: tuple[str, ...], quiet: bool, as_json: bool
) -> int:
    """Optimise the drive (inputs over time) of a task by several methods, and compare them; an interrupted study continues."""
    if listing:
        return _list_studies(as_json)
    from granular_env.control.results import FIGURE, TABLE
    from granular_env.control.runner import run_study
    from granular_env.control.study import load_study

    if study is None:
        hint = "`granular-env study --list` lists the shipped studies"
        raise ExperimentError("no study was named", hint=hint, at="study")
    refuse_other_kinds(study, "study")
    with silence_own_warnings():
        result = run_study(load_study(study, overrides), out, progress=not quiet and not as_json, only=only)
    files = {"table": result.folder / TABLE, "figure": result.folder / FIGURE, "logs": result.folder / "logs"}
    if as_json:
        print_json({"written": result.folder, **files, **_study_facts(result)})
    elif quiet:
        print(files["table"])
    else:
        _print_study(result)
        for name, path in files.items():
            print(f"{name}: {shlex.quote(str(path))}")
    return Status.INTERRUPTED if result.interrupted else Status.DONE


def _print_study(result: StudyResult) -> None:
    """Print the comparison of the methods."""
    rows = ([f"{cell:.6g}" if isinstance(cell, float) else str(cell) for cell in row] for row in result.comparison())
    print(align_table(rows))
    print("baselines: " + ", ".join(f"{name} {score.value:.6g}" for name, score in result.baselines.items()))
    for text in result.notes[:_MOST_NOTES]:
        print(f"note: {text}")
    if result.interrupted:
        print("interrupted: the finished trials are kept; repeat the command to continue")


def _study_facts(result: StudyResult) -> dict[str, Any]:
    """Return the result of a study as data for JSON."""
    heads, *rows = result.comparison()
    return {
        "methods": [dict(zip(map(str, heads), row, strict=True)) for row in rows],
        "baselines": {name: score.value for name, score in result.baselines.items()},
        "interrupted": result.interrupted,
        "notes": result.notes,
    }


def _list_studies(as_json: bool) -> int:
    from granular_env.control.problem import environment_names
    from granular_env.package_contents import shipped_overview

    closing = "granular-env new STUDY -o FILE.toml writes a copy to edit; granular-env study FILE.toml runs it."
    print_lists({"studies": shipped_overview()["studies"], "tasks": environment_names()}, as_json, closing)
    return Status.DONE
