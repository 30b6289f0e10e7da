"""Commands that run or repair a log: `replay`, `branch`, `recover`."""

from __future__ import annotations

import dataclasses
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import click

from granular_env.cli.command import Status, command, print_json
from granular_env.cli.options import (
    FILE,
    TIME,
    Overrides,
    allow_large_option,
    component_option,
    json_option,
    output_options,
    overwrite_option,
    set_option,
)
from granular_env.cli.run_summary import print_result, silence_own_warnings
from granular_env.cli.runs import log_target
from granular_env.output_files import count_text
from granular_env.terminal_text import printable_text

_VERIFIED = {
    "identical": Status.DONE,
    "different": Status.DIFFERENT,
    "incomplete": Status.INCOMPLETE,
    "nothing was compared": Status.INCOMPLETE,
}
log_argument = click.argument("log", help="A log.", type=FILE)


@command(
    "replay",
    epilog="Exit status with --verify: 0 identical; 1 different; 2 not a log, or not reproducible; 3 incomplete, "
    "because the log was not closed (its contents agree), or nothing was compared, because it contains no step.",
)
@log_argument
@click.option("--verify", is_flag=True, help="Compare every hash, frame and snapshot bit for bit.")
@json_option()
@allow_large_option()
@component_option()
def replay(log: str, verify: bool, as_json: bool, allow_large: bool, components: dict[str, Any]) -> int:
    """Run the simulation of a log again, from its recorded parameters, start and inputs."""
    if verify:
        return _verify_log(log, as_json, allow_large, components)
    from granular_env.log_runs import replay

    with silence_own_warnings():
        result = replay(log, progress=not as_json, allow_large=allow_large, components=components)
    return print_result(result, as_json=as_json)


def _verify_log(log: str, as_json: bool, allow_large: bool, components: dict[str, Any]) -> int:
    from granular_env.recording import verify
    from granular_env.run_loop import collect_warnings

    with silence_own_warnings(), collect_warnings() as warned:
        found = verify(log, progress=not as_json, allow_large=allow_large, components=components)
    if as_json:
        print_json({"outcome": found.outcome, **dataclasses.asdict(found), "warnings": warned})
    else:
        print("\n".join(map(printable_text, [*found.message.splitlines(), *(f"note: {text}" for text in warned)])))
    return _VERIFIED[found.outcome]


@command("branch")
@log_argument
@click.option("--at", metavar="T", type=TIME, required=True, help="Start time of the branch, such as 100us.")
@set_option(help="An input from this time on, such as input.left_force=100; other inputs continue as in the log.")
@click.option("--until", metavar="T", type=TIME, help="End time (default: the end of the log).")
@click.option("--log", "-o", "out", metavar="PATH", type=FILE, help="The log to write (default: a new file in logs/).")
@overwrite_option(help="Replace the branch's log if it exists.")
@allow_large_option()
@component_option()
@output_options
def branch(
    log: str,
    at: float,
    overrides: Overrides,
    until: float | None,
    out: str | None,
    overwrite: bool,
    allow_large: bool,
    components: dict[str, Any],
    quiet: bool,
    as_json: bool,
) -> int:
    """Continue from any instant of a log, with the same or other inputs."""
    from granular_env.experiments.preparation import branch_inputs
    from granular_env.log_runs import run_branch
    from granular_env.recording import open_log

    with ExitStack() as stack:
        parent = stack.enter_context(open_log(log, allow_large=allow_large, components=components))
        begun = parent.branch(at)
        left_at = _branch_time_text(at, begun.component.time, parent.step_size)
        inputs = branch_inputs(overrides, begun.component)
        stack.enter_context(silence_own_warnings())
        path, replace = stack.enter_context(log_target(out, f"{Path(log).stem}-branch", overwrite))
        result = run_branch(begun, path, inputs, until, progress=not quiet and not as_json, overwrite=replace)
    if not quiet and not as_json:
        print(f"branched at {left_at}, {result.ticks * parent.step_size:.9g} s long")
    return print_result(result, quiet, as_json)


def _branch_time_text(requested: float, actual: float, step_size: float) -> str:
    """Return the start time of a branch as text, with a note if the requested time was rounded to the nearest tick."""
    between = abs(requested / step_size - round(requested / step_size)) > 1e-6
    return f"{actual:.9g} s" + (f" (the step nearest to {requested:.9g} s)" if between else "")


@command("recover")
@log_argument
@click.option("-o", "--out", metavar="OUT", required=True, type=FILE, help="The log to write.")
@overwrite_option(help="Replace OUT if it exists.")
@allow_large_option()
@json_option()
def recover(log: str, out: str, overwrite: bool, allow_large: bool, as_json: bool) -> int:
    """Write a new, complete log from the intact part of a log whose program was killed."""
    from granular_env.recording import recover

    whole = recover(log, out, allow_large=allow_large, overwrite=overwrite)
    ticks, lost = whole.end_tick - whole.start_tick, whole.incidents[-1]
    if as_json:
        facts = {"duration": whole.duration, "calls": whole.calls, "ticks": ticks}
        print_json({"written": out, **facts, "lost": lost["lost"], "bytes_lost": lost["bytes_lost"]})
        return Status.DONE if ticks else Status.DIFFERENT
    print(f"recovered: {out}, {whole.duration:g} s, {count_text(whole.calls, 'call')} of step, {count_text(ticks, 'tick')}")
    print(f"lost: {lost['lost']} ({lost['bytes_lost']} bytes)")
    if ticks:
        return Status.DONE
    print("only the start was recovered: the log contains no step")
    return Status.DIFFERENT
