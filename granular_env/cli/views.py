"""Commands that show a log: `view` and `report`."""

from __future__ import annotations

import os
from pathlib import Path

import click

from granular_env.cli.command import Status, command
from granular_env.cli.logs import log_argument
from granular_env.cli.options import FILE, FOLDER, TIME, allow_large_option, exclusive_options
from granular_env.components.errors import ParameterError


@command("view")
@log_argument
@click.option("--web", is_flag=True, help="Show the log in the browser, served on this machine only.")
@click.option("--save", metavar="RRD", type=FILE, help="Write a file for rerun instead.")
@click.option("--screenshot", metavar="PNG", type=FILE, help="Write a picture instead, without a screen.")
@click.option("--foxglove-layout", metavar="JSON", type=FILE, help="Write a layout for Foxglove instead, to import there.")
@click.option("--exaggerate", metavar="F", type=float, help="Draw displacements F times larger (default: visibly large).")
@click.option(
    "--at", metavar="T", type=TIME, help="Time of the screenshot [s] (default: the end of a run with events, else two thirds)."
)
@click.option("--colour", metavar="NAME", help="Colour by this recorded output, such as surface_plastic_strain.")
@allow_large_option()
@exclusive_options("web", "save", "screenshot", "foxglove_layout")
def view(
    log: str,
    web: bool,
    save: str | None,
    screenshot: str | None,
    foxglove_layout: str | None,
    exaggerate: float | None,
    at: float | None,
    colour: str | None,
    allow_large: bool,
) -> int:
    """Show a log in rerun, or write a file for rerun or Foxglove."""
    from granular_env import viewing
    from granular_env.recording import open_log

    if at is not None and not screenshot:
        raise ParameterError("applies to screenshots only", hint="give --screenshot PNG too", at="at")
    opened = open_log(log, allow_large=allow_large)
    try:
        if save:
            written = viewing.save_rrd(opened, save, exaggerate=exaggerate, progress=True, colour=colour)
        elif screenshot:
            written = viewing.screenshot(opened, screenshot, at=at, exaggerate=exaggerate, colour=colour)
        elif foxglove_layout:
            written = viewing.save_foxglove_layout(opened, foxglove_layout)
        else:
            viewing.view(opened, web=web, exaggerate=exaggerate, colour=colour)
            return Status.DONE
    except ParameterError as error:
        raise error.with_argument("path", "save" if save else "screenshot" if screenshot else "foxglove_layout") from None
    print(f"written: {written}")
    return Status.DONE


@command("report")
@log_argument
@click.option("-o", "--out", metavar="FOLDER", type=FOLDER, help="Folder of the report (default: next to the log).")
@click.option("--variables", metavar="NAME", multiple=True, help="Recorded output to show, repeatable (default: all).")
@click.option("--indices", metavar="I", type=int, multiple=True, help="Element of the histories, repeatable (default: five).")
@click.option("--times", metavar="T", type=TIME, multiple=True, help="Time of the profiles [s], repeatable (default: four).")
@allow_large_option()
def report(
    log: str,
    out: str | None,
    variables: tuple[str, ...],
    indices: tuple[int, ...],
    times: tuple[float, ...],
    allow_large: bool,
) -> int:
    """Write a page with figures of a log."""
    from granular_env import viewing
    from granular_env.recording import open_log

    folder = Path(out) if out else _report_folder(Path(log))
    if folder.suffix == ".html" and not folder.is_dir():
        hint = f"the page will be {folder.with_suffix('') / 'report.html'}"
        raise ParameterError(f"got {out!r}", expected=f"a folder, such as {str(folder.with_suffix(''))!r}", hint=hint, at="out")
    with open_log(log, allow_large=allow_large) as opened:
        chosen = {"variables": variables or None, "indices": indices or None, "times": times or None}
        page = viewing.report(opened, folder, **chosen, progress=True)
        print(f"written: {page}, with its figures in {folder}{os.sep}")
    return Status.DONE


def _report_folder(log: Path) -> Path:
    """Return the folder next to the log, named after it; never the log itself, whose name may have no suffix."""
    return log.with_suffix("") if log.suffix else log.with_name(f"{log.name}-report")
