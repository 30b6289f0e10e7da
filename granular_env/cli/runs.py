"""Running an experiment: `run`."""

from __future__ import annotations

from contextlib import nullcontext

import click

from granular_env.cli.command import Overrides, command, exclusive, output_options, overwrite_option, set_option
from granular_env.cli.completion import files, names
from granular_env.cli.kinds import refuse_other_kinds
from granular_env.cli.log_paths import log_target
from granular_env.cli.results import print_result, silence_own_warnings


@command("run")
@click.argument("experiment", help="A name of `granular-env list`, or a TOML file.", shell_complete=names("experiments"))
@set_option("Override any key, such as component.grains=500 or start.velocity.0=3.")
@click.option("--log", metavar="PATH", shell_complete=files, help="Where to record it (default: a new file in logs/).")
@click.option("--no-log", is_flag=True, help="Record nothing.")
@overwrite_option("Replace the log if it exists.")
@click.option("--hash-every", metavar="N", type=int, help="Hash the state every N ticks; 1 lets a verification name the tick.")
@click.option("--live", is_flag=True, help="Show the run in rerun while it goes on.")
@click.option(
    "--pace",
    metavar="SECONDS",
    type=float,
    help="With --live: how long the run takes to watch (default: 10; 0: no longer than needed).",
)
@output_options("log")
@exclusive("log", "no_log")
def run(
    experiment: str,
    overrides: Overrides,
    log: str | None,
    no_log: bool,
    overwrite: bool,
    hash_every: int | None,
    live: bool,
    pace: float | None,
    quiet: bool,
    for_programs: bool,
) -> int:
    """Run an experiment and record it."""
    from granular_env.documents import parse_assignments
    from granular_env.experiments import load_experiment
    from granular_env.run_loop import run

    refuse_other_kinds(experiment, "run")
    hashes = () if hash_every is None else parse_assignments([f"record.hash_every={hash_every}"])
    loaded = load_experiment(experiment, (*overrides, *hashes))
    show = not quiet and not for_programs
    target = nullcontext((None, False)) if no_log else log_target(log, loaded.name, overwrite)
    with silence_own_warnings(), target as (path, replace):
        result = run(loaded, log=path, progress=show, live=live, pace=pace, overwrite=replace)
    return print_result(result, quiet, for_programs)
