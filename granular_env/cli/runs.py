"""Command `run`: run an experiment and record it, or resume an interrupted run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from itertools import count
from pathlib import Path
from typing import Any

import click

from granular_env.cli.command import command
from granular_env.cli.kinds import refuse_other_kinds
from granular_env.cli.options import (
    FILE,
    TIME,
    Overrides,
    ShippedName,
    allow_large_option,
    component_option,
    exclusive_options,
    output_options,
    overwrite_option,
    set_option,
)
from granular_env.cli.run_summary import print_result, silence_own_warnings
from granular_env.output_files import valid_file_name


@command("run")
@click.argument(
    "experiment",
    required=False,
    help="A name from `granular-env list`, or a TOML file.",
    type=ShippedName("experiments"),
)
@set_option(help="Override any key, such as component.radius=3mm or start.velocity.0=3.")
@click.option("--log", "-o", metavar="PATH", type=FILE, help="The log to write (default: a new file in logs/).")
@click.option(
    "--resume",
    "resumed",
    metavar="LOG",
    type=FILE,
    help="Resume a killed or interrupted run from its log (with --log PATH, in a new log).",
)
@click.option("--no-log", is_flag=True, help="Record nothing.")
@overwrite_option(help="Replace the log if it exists.")
@click.option(
    "--hash-every",
    metavar="N",
    type=int,
    help="Hash the state every N ticks; with 1, a verification names the first different tick.",
)
@click.option("--live", is_flag=True, help="Show the run in rerun while it is computed.")
@click.option(
    "--pace",
    metavar="SECONDS",
    type=TIME,
    help="With --live: shortest wall time of the run (default: 10; 0: as fast as possible).",
)
@allow_large_option(help="With --resume: lift the limits on sizes that a log may declare.")
@component_option()
@output_options
@exclusive_options("log", "no_log")
@exclusive_options("resumed", "no_log")
@exclusive_options("resumed", "hash_every")
@exclusive_options("resumed", "live")
def run(
    *,
    experiment: str | None,
    overrides: Overrides,
    log: str | None,
    resumed: str | None,
    no_log: bool,
    overwrite: bool,
    hash_every: int | None,
    live: bool,
    pace: float | None,
    allow_large: bool,
    components: dict[str, Any],
    quiet: bool,
    as_json: bool,
) -> int:
    """Run an experiment and record it.

    --resume LOG continues the experiment of the log. If an EXPERIMENT is also given, the log must belong to it.
    """
    if resumed is not None:
        return _resume_run(
            resumed,
            experiment=experiment,
            overrides=overrides,
            log=log,
            overwrite=overwrite,
            allow_large=allow_large,
            components=components,
            quiet=quiet,
            as_json=as_json,
        )
    if experiment is None:
        raise click.UsageError("Missing argument 'EXPERIMENT'.")
    from granular_env.documents import parse_assignments
    from granular_env.experiments import load_experiment
    from granular_env.run_loop import run

    refuse_other_kinds(experiment, "run")
    hashes = () if hash_every is None else parse_assignments([f"record.hash_every={hash_every}"])
    loaded = load_experiment(experiment, (*overrides, *hashes))
    show = not quiet and not as_json
    target = nullcontext((None, False)) if no_log else log_target(log, loaded.name, overwrite)
    with silence_own_warnings(), target as (path, replace):
        result = run(loaded, log=path, progress=show, live=live, pace=pace, overwrite=replace)
    return print_result(result, quiet, as_json)


@contextmanager
def log_target(requested: str | None, name: str, overwrite: bool) -> Iterator[tuple[Path, bool]]:
    """Yield the path of the log to write, and whether an existing file may be replaced.

    The default path is the first of logs/<name>-1.mcap, -2, ... that does not exist, reserved by an empty file, which is
    removed if nothing was recorded.
    """
    if requested:
        yield Path(requested), overwrite
        return
    Path("logs").mkdir(exist_ok=True)
    path = next(
        path for number in count(1) if _reserve_file(path := Path("logs") / f"{valid_file_name(name, 'run')}-{number}.mcap")
    )
    try:
        yield path, True
    finally:
        with suppress(OSError):
            if path.stat().st_size == 0:
                path.unlink()
                path.parent.rmdir()


def _reserve_file(path: Path) -> bool:
    """Create an empty file; return False if the file exists."""
    try:
        path.touch(exist_ok=False)
    except FileExistsError:
        return False
    return True


def _resume_run(
    path: str,
    *,
    experiment: str | None,
    overrides: Overrides,
    log: str | None,
    overwrite: bool,
    allow_large: bool,
    components: dict[str, Any],
    quiet: bool,
    as_json: bool,
) -> int:
    from granular_env.log_runs import resume

    if overrides and experiment is None:
        raise click.UsageError("--set requires an EXPERIMENT; --resume alone uses the experiment of the log unchanged.")
    show = not quiet and not as_json
    with silence_own_warnings():
        result = resume(
            path,
            log=log,
            experiment=experiment,
            overrides=overrides,
            progress=show,
            overwrite=overwrite,
            allow_large=allow_large,
            components=components,
        )
    return print_result(result, quiet, as_json)
