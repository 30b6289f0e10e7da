"""Running an experiment: `run`."""

from __future__ import annotations

import ctypes
from contextlib import nullcontext, suppress
from typing import Any

import click

from granular_env.cli.command import command
from granular_env.cli.completion import files, names
from granular_env.cli.kinds import refuse_other_kinds
from granular_env.cli.new_log_path import log_target
from granular_env.cli.options import (
    Overrides,
    component_option,
    exclusive,
    large_option,
    output_options,
    overwrite_option,
    set_option,
)
from granular_env.cli.run_summary import print_result, silence_own_warnings

# Options of `mallopt`, and their values [bytes]: the size from which arrays are memory of their own, which goes back to the
# system with them, and the free end of the heap that stays.
_MMAP_THRESHOLD, _TRIM_THRESHOLD = -3, -1
_LARGE_ARRAY, _SPARE_HEAP = 1 << 18, 1 << 20


@command("run")
@click.argument(
    "experiment",
    required=False,
    help="A name of `granular-env list`, or a TOML file.",
    shell_complete=names("experiments"),
)
@set_option("Override any key, such as component.grains=500 or start.velocity.0=3.")
@click.option("--log", "-o", metavar="PATH", shell_complete=files, help="Where to record it (default: a new file in logs/).")
@click.option(
    "--resume",
    "resumed",
    metavar="LOG",
    shell_complete=files,
    help="Go on with a run that was killed or interrupted, from its log, to its end; --log: in a log of its own.",
)
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
@large_option("With --resume: lift the limits on sizes that a log may declare.")
@component_option()
@output_options("log")
@exclusive("log", "no_log")
@exclusive("resumed", "no_log")
@exclusive("resumed", "hash_every")
@exclusive("resumed", "live")
def run(
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
    for_programs: bool,
) -> int:
    """Run an experiment and record it.

    With --resume LOG alone the experiment is the log's; with an EXPERIMENT too, a log of another one is refused.
    """
    _return_large_arrays()
    if resumed is not None:
        return _resume(resumed, experiment, overrides, log, overwrite, allow_large, components, quiet, for_programs)
    if experiment is None:
        raise click.UsageError("Missing argument 'EXPERIMENT'.")
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


def _return_large_arrays() -> None:
    """Let the memory of large arrays go back to the system as soon as they are free.

    By itself the C library of Linux takes arrays up to the size of the largest one that has been freed, at most 32 MB, from its
    heap, which keeps the holes: a solid of 140,000 nodes that breaks takes a quarter more memory then.
    """
    with suppress(OSError, TypeError, AttributeError):  # another C library
        library = ctypes.CDLL(None)
        library.mallopt(_MMAP_THRESHOLD, _LARGE_ARRAY)
        library.mallopt(_TRIM_THRESHOLD, _SPARE_HEAP)


def _resume(
    path: str,
    experiment: str | None,
    overrides: Overrides,
    log: str | None,
    overwrite: bool,
    allow_large: bool,
    components: dict[str, Any],
    quiet: bool,
    for_programs: bool,
) -> int:
    from granular_env.resumption import resume

    if overrides and experiment is None:
        raise click.UsageError("--set goes with an EXPERIMENT; --resume alone takes the experiment of the log as it is.")
    show = not quiet and not for_programs
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
    return print_result(result, quiet, for_programs)
