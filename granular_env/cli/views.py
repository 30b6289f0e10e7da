"""Commands that show a log: `view` and `report`."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import click

from granular_env.cli.command import Status, command, print_json
from granular_env.cli.logs import log_argument
from granular_env.cli.options import FILE, FOLDER, TIME, allow_large_option, exclusive_options, format_option, json_option
from granular_env.components.errors import ParameterError

# For each output of `view`: the function of `granular_env.viewing` that writes it, and the options that apply to it.
_DRAWN = ("exaggerate", "colour")
_OUTPUTS: dict[str, tuple[str, tuple[str, ...]]] = {
    "": ("view", (*_DRAWN, "web")),
    "save": ("save_rrd", _DRAWN),
    "screenshot": ("screenshot", (*_DRAWN, "at")),
    "video": ("video", (*_DRAWN, "show", "frame_rate", "duration", "size")),
    "foxglove_layout": ("save_foxglove_layout", ()),
}


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
@click.option("--size", metavar="W H", type=(int, int), help="Width and height of a film [pixels] (default: up to 1080 wide).")
@allow_large_option()
@json_option()
@exclusive_options("web", "save", "screenshot", "video", "foxglove_layout")
def view(log: str, allow_large: bool, as_json: bool, **options: Any) -> int:
    """Show a log in rerun, or write a picture, a film, or a file for rerun or Foxglove."""
    from granular_env import viewing
    from granular_env.recording import open_log

    given = {name: value for name, value in options.items() if value is not None and value is not False and value != ()}
    output = next((name for name in _OUTPUTS if name in given), "")
    paths = [given.pop(output)] if output else []
    function, known = _OUTPUTS[output]
    if wrong := [name for name in given if name not in known]:
        places = (_flag(name) for name, (_, names) in _OUTPUTS.items() if wrong[0] in names)
        raise ParameterError(f"does not apply to {_flag(output)}", hint=f"it applies to {', '.join(places)}", at=wrong[0])
    if output in ("save", "video"):
        given["progress"] = not as_json
    with open_log(log, allow_large=allow_large) as opened:
        try:
            written = getattr(viewing, function)(opened, *paths, **given)
        except ParameterError as error:
            raise error.with_argument("path", output or "path") from None
    if output:
        print_json({"written": written}) if as_json else print(f"written: {written}")
    return Status.DONE


def _flag(output: str) -> str:
    return f"--{output.replace('_', '-')}" if output else "the viewer"


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
def report(log: str, out: str | None, file_format: str, allow_large: bool, as_json: bool, **chosen: Any) -> int:
    """Write a page with figures of a log."""
    from granular_env import viewing
    from granular_env.recording import open_log

    folder = Path(out) if out else _report_folder(Path(log))
    if folder.suffix == ".html" and not folder.is_dir():
        hint = f"the page will be {folder.with_suffix('') / 'report.html'}"
        raise ParameterError(f"got {out!r}", expected=f"a folder, such as {str(folder.with_suffix(''))!r}", hint=hint, at="out")
    with open_log(log, allow_large=allow_large) as opened:
        chosen = {name: values or None for name, values in chosen.items()}
        page = viewing.report(opened, folder, **chosen, progress=not as_json, file_format=file_format)
    if as_json:
        print_json({"written": page, "folder": folder})
    else:
        print(f"written: {page}, with its figures in {folder}{os.sep}")
    return Status.DONE


def _report_folder(log: Path) -> Path:
    """Return the folder next to the log, named after it; never the log itself, whose name may have no suffix."""
    return log.with_suffix("") if log.suffix else log.with_name(f"{log.name}-report")
