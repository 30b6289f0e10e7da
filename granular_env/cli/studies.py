"""Searching for the best drive of a task: `study`."""

from __future__ import annotations

import click

from granular_env.cli.command import Status, command
from granular_env.cli.kinds import refuse_other_kinds
from granular_env.cli.options import FOLDER, Overrides, Shipped, overwrite_option, quiet_option, set_option
from granular_env.cli.run_summary import silence_own_warnings
from granular_env.components.errors import ExperimentError
from granular_env.terminal_text import columns


@command("study")
@click.argument("study", required=False, help="A name of `granular-env study --list`, or a TOML file.", type=Shipped("studies"))
@click.option("--list", "listing", is_flag=True, help="The studies that come with the package, and the tasks.")
@click.option("-o", "--out", metavar="FOLDER", type=FOLDER, help="Where its results go (default: studies/NAME).")
@set_option("Override any key, such as budget=100000, task.grains=30 or method.0.population=8.")
@click.option("--only", metavar="METHOD", multiple=True, help="Run only this method (may be repeated).")
@overwrite_option("Start anew where the folder has results already.")
@quiet_option("page")
def study(
    study: str | None, listing: bool, out: str | None, overrides: Overrides, only: tuple[str, ...], overwrite: bool, quiet: bool
) -> int:
    """Let methods search for the best drive of a task, and compare them; a study that was interrupted goes on."""
    if listing:
        return _list_studies()
    from granular_env.control.study import console, load_study, runner

    if study is None:
        raise ExperimentError(
            "no study was named", hint="`granular-env study --list` names those that come with the package", at="study"
        )
    refuse_other_kinds(study, "study")
    loaded = load_study(study, overrides)
    with silence_own_warnings():
        result = runner.run_study(loaded, out, overwrite=overwrite, progress=not quiet, only=only)
    print(result.folder / "report.html" if quiet else console.closing(result))
    return Status.INTERRUPTED if result.interrupted else Status.DONE


def _list_studies() -> int:
    from granular_env.control.named_environments import task_names
    from granular_env.package_contents import overview

    print(f"studies\n{columns(overview()['studies'].items())}\n")
    print(f"tasks\n{columns(task_names().items())}\n")
    print("granular-env new STUDY -o FILE.toml writes one to start from; granular-env study FILE.toml runs it.")
    return Status.DONE
