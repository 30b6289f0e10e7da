"""The command `export`, which writes the frames of a log for other programs."""

from __future__ import annotations

import sys
from typing import Any

import click

from granular_env.cli.command import Status, command, print_json
from granular_env.cli.logs import log_argument
from granular_env.cli.options import FILE, TIME, allow_large_option, json_option, overwrite_option
from granular_env.output_files import count_text
from granular_env.terminal_text import printable_text, wrap_text


@command("export", epilog="Exit status: 0 done; 1 the log is damaged or was not closed, and its intact frames are exported.")
@log_argument
@click.option("--to", type=click.Choice(["vtk", "xyz", "csv", "netcdf", "hdf5"]), required=True, help="Format.")
@click.option(
    "-o", "--out", "path", metavar="PATH", type=FILE, help="File to write, folder for vtk (default: next to the log)."
)
@click.option("--every", metavar="T", type=TIME, help="At most one frame per interval T [s] (default: all frames).")
@click.option("--from", "start", metavar="T", type=TIME, help="Time of the first frame [s].")
@click.option("--to-time", "end", metavar="T", type=TIME, help="Time of the last frame [s].")
@click.option("--variables", metavar="NAME", multiple=True, help="Recorded variable, repeatable.")
@overwrite_option(help="Replace PATH if it exists.")
@json_option()
@allow_large_option()
def export(log: str, to: str, as_json: bool, allow_large: bool, variables: tuple[str, ...], **options: Any) -> int:
    """Write a log for ParaView, OVITO, pandas, xarray, MATLAB or Julia."""
    from granular_env.recording import open_log

    with open_log(log, allow_large=allow_large) as opened:
        done = opened.export(to, variables=variables, progress=not as_json, **options)
    left_out = [name for name, one in opened.variables.items() if one.shape and name not in done.variables]
    if as_json:
        facts = done._asdict()
        print_json({"written": facts.pop("path"), **facts, "left_out": left_out})
    else:
        size = f"{count_text(done.frames, 'frame')} of {count_text(len(done.variables), 'variable')}"
        print(printable_text(f"written: {done.path}, {size}"))
        if left_out and not variables:
            where = "request them with --variables" if to == "csv" else "csv, netcdf and hdf5 contain them and the scalars"
            print(wrap_text(printable_text(f"left out: {', '.join(left_out)}; {where}")))
    if done.missing:
        print(printable_text(f"granular-env export: {done.missing}"), file=sys.stderr)
    return Status.DIFFERENT if done.missing else Status.DONE
