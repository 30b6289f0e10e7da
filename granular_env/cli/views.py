"""Commands that show a log: `view` and `report`."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import click

from granular_env.cli.command import Status, command, print_json
from granular_env.cli.logs import log_argument
from granular_env.cli.options import FILE, FOLDER, TIME, allow_large_option, exclusive_options, format_option, json_option
from granular_env.components.errors import ParameterError


class PictureSize(click.ParamType):
    """The type of a size in pixels, such as 1280x720."""

    name = "size"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, int]:
        """Return width and height."""
        if (found := re.fullmatch(r"(\d{1,5})[xX](\d{1,5})", str(value))) is None:
            self.fail(f"got {value!r}, expected width and height, such as 1280x720", param, ctx)
        return int(found[1]), int(found[2])


@command("view")
@log_argument
@click.option("--web", is_flag=True, help="Show the log in the browser, served on this machine only.")
@click.option("--save", metavar="RRD", type=FILE, help="Write a file for rerun instead.")
@click.option("--screenshot", metavar="PNG", type=FILE, help="Write a picture instead, without a screen.")
@click.option("--video", metavar="MP4|GIF", type=FILE, help="Write a film instead, without a screen.")
@click.option("--foxglove-layout", metavar="JSON", type=FILE, help="Write a layout for Foxglove instead, to import there.")
@click.option("--exaggerate", metavar="F", type=float, help="Draw displacements F times larger (default: visibly large).")
@click.option(
    "--at",
    metavar="T",
    type=TIME,
    help="Time of the screenshot, such as 100us (default: the end if a body broke, else two thirds).",
)
@click.option("--colour", metavar="NAME", help="Colour by this recorded output, such as surface_plastic_strain.")
@click.option("--show", metavar="NAME", multiple=True, help="Draw arrows, stresses or link forces over a film, repeatable.")
@click.option("--frame-rate", metavar="R", type=float, help="Pictures per second of a film (default: 20).")
@click.option("--duration", metavar="S", type=TIME, help="Duration of a film [s] (default: 10).")
@click.option(
    "--size", metavar="WxH", type=PictureSize(), help="Width and height of a film [pixels] (default: up to 1080 wide)."
)
@allow_large_option()
@json_option()
@exclusive_options("web", "save", "screenshot", "video", "foxglove_layout")
def view(
    log: str,
    web: bool,
    save: str | None,
    screenshot: str | None,
    video: str | None,
    foxglove_layout: str | None,
    exaggerate: float | None,
    at: float | None,
    colour: str | None,
    allow_large: bool,
    as_json: bool,
    **film: Any,
) -> int:
    """Show a log in rerun, or write a picture, a film, or a file for rerun or Foxglove."""
    from granular_env import viewing
    from granular_env.recording import open_log

    if at is not None and not screenshot:
        raise ParameterError("applies to screenshots only", hint="give --screenshot PNG too", at="at")
    outputs = {"save": save, "screenshot": screenshot, "video": video, "foxglove_layout": foxglove_layout}
    film = {name: value for name, value in film.items() if value not in (None, ())}
    if film and not video:
        raise ParameterError("applies to films only", hint="give --video FILE too", at=next(iter(film)))
    opened = open_log(log, allow_large=allow_large)
    try:
        if video:
            written = viewing.video(opened, video, exaggerate=exaggerate, colour=colour, progress=not as_json, **film)
        elif save:
            written = viewing.save_rrd(opened, save, exaggerate=exaggerate, progress=not as_json, colour=colour)
        elif screenshot:
            written = viewing.screenshot(opened, screenshot, at=at, exaggerate=exaggerate, colour=colour)
        elif foxglove_layout:
            written = viewing.save_foxglove_layout(opened, foxglove_layout)
        else:
            viewing.view(opened, web=web, exaggerate=exaggerate, colour=colour)
            return Status.DONE
    except ParameterError as error:
        raise error.with_argument("path", next((name for name in outputs if outputs[name]), "path")) from None
    print_json({"written": written}) if as_json else print(f"written: {written}")
    return Status.DONE


@command("report")
@log_argument
@click.option("-o", "--out", metavar="FOLDER", type=FOLDER, help="Folder of the report (default: next to the log).")
@click.option("--variables", metavar="NAME", multiple=True, help="Recorded output to show, repeatable (default: all).")
@click.option("--indices", metavar="I", type=int, multiple=True, help="Element of the histories, repeatable (default: five).")
@click.option(
    "--times", metavar="T", type=TIME, multiple=True, help="Time of the profiles, such as 100us, repeatable (default: four)."
)
@format_option()
@allow_large_option()
@json_option()
def report(
    log: str,
    out: str | None,
    variables: tuple[str, ...],
    indices: tuple[int, ...],
    times: tuple[float, ...],
    file_format: str,
    allow_large: bool,
    as_json: bool,
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
        page = viewing.report(opened, folder, **chosen, progress=not as_json, file_format=file_format)
    if as_json:
        print_json({"written": page, "folder": folder})
    else:
        print(f"written: {page}, with its figures in {folder}{os.sep}")
    return Status.DONE


def _report_folder(log: Path) -> Path:
    """Return the folder next to the log, named after it; never the log itself, whose name may have no suffix."""
    return log.with_suffix("") if log.suffix else log.with_name(f"{log.name}-report")
