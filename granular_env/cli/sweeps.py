"""Command `sweep`: run one experiment for many values of its keys."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING, Any

import click

from granular_env.cli.command import Status, command, print_json
from granular_env.cli.kinds import refuse_other_kinds
from granular_env.cli.options import FOLDER, TIME, Overrides, ShippedName, allow_large_option, output_options, set_option

if TYPE_CHECKING:
    from granular_env.sweep import Sweep


@command("sweep")
@click.argument("plan", help="A plan from `granular-env list`, or a TOML file.", type=ShippedName("plans of sweeps"))
@click.option(
    "-o",
    "--out",
    metavar="FOLDER",
    type=FOLDER,
    help="Folder of the results (default: sweeps/ and the plan's name).",
)
@click.option(
    "--engine",
    type=click.Choice(("processes", "serial", "ray")),
    default="processes",
    help="Engine that runs the tasks (default: processes).",
)
@click.option("--address", metavar="HOST:PORT", help="Address of a Ray cluster (default: start one on this machine).")
@click.option("--workers", metavar="N", type=int, help="Number of tasks run in parallel (default: one per core).")
@click.option(
    "--time-limit", metavar="SECONDS", type=TIME, help="End a task after this wall time; repeating the command retries it."
)
@click.option("--part", metavar="I/N", default="0/1", help="Compute only the tasks I, I + N, I + 2N, ..., for job arrays.")
@click.option("--merge", is_flag=True, help="Only write the table of the results of all parts.")
@set_option(help="Override a key of the experiment in every task, such as component.grains=500.")
@allow_large_option(help="Lift the limit on the number of tasks.")
@output_options
def sweep(
    *,
    plan: str,
    out: str | None,
    engine: str,
    address: str | None,
    workers: int | None,
    time_limit: float | None,
    part: str,
    merge: bool,
    overrides: Overrides,
    allow_large: bool,
    quiet: bool,
    as_json: bool,
) -> int:
    """Run an experiment for many values of its keys and write one table; runs that already have a result are not repeated."""
    from granular_env.sweep import load_plan, open_sweep, run_sweep
    from granular_env.sweep.console import closing_text
    from granular_env.sweep.runner import results_folder
    from granular_env.sweep.store import TABLE

    refuse_other_kinds(plan, "sweep")
    if merge:
        done = open_sweep(results_folder(load_plan(plan), out))
        done.write_csv()
    else:
        done = run_sweep(
            plan,
            out,
            engine=engine,
            workers=workers,
            address=address,
            overrides=overrides,
            progress=not quiet and not as_json,
            allow_large=allow_large,
            time_limit=time_limit,
            part=part,
        )
    if as_json:
        print_json(_sweep_facts(done))
    else:
        print(
            shlex.quote(str(done.folder / TABLE if part == "0/1" else done.folder))
            if quiet
            else closing_text(done, part if part != "0/1" else "")
        )
    return Status.INTERRUPTED if done.interrupted else Status.DIFFERENT if done.failed else Status.DONE


def _sweep_facts(sweep: Sweep) -> dict[str, Any]:
    from granular_env.sweep.store import TABLE

    pending = sweep.outcomes.count("pending")
    counts = {"tasks": sweep.size, "done": sweep.done, "failed": sweep.failed, "pending": pending}
    files = {"folder": str(sweep.folder), "table": str(sweep.folder / TABLE)}
    return {**counts, "interrupted": sweep.interrupted, "errors": sweep.errors, "units": sweep.units, **files}
