"""The formats of exports, and the export of a log to one of them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from ...components.errors import LogError, ParameterError, one_line, spelling_hint
from ...output_files import replace_file
from ...progress import Progress, progress_bar
from ..element_arrays import element_arrays
from .frames import Frames
from .netcdf_files import write_netcdf
from .text_files import particles, write_csv, write_xyz
from .vtk_files import solid_drawables, write_vtk

if TYPE_CHECKING:
    from ..log import Log

# Largest number of values of a variable that is a history, not a field.
_HISTORY = 16
# The end of the name of a file (of a folder for VTK) in each format, and the function that writes it.
FORMATS = {
    "vtk": ("-vtk", write_vtk),
    "xyz": (".xyz", write_xyz),
    "csv": (".csv", write_csv),
    "netcdf": (".nc", write_netcdf),
    "hdf5": (".h5", write_netcdf),
}


class Export(NamedTuple):
    """An exported file or folder.

    Attributes:
        path: the file or folder.
        frames: number of frames.
        variables: the exported variables.
        missing: a sentence on the frames that a damaged or unclosed log lacks; empty if there are none.
    """

    path: Path
    frames: int
    variables: tuple[str, ...]
    missing: str


def export_log(
    log: Log,
    to: str,
    path: str | os.PathLike[str] | None,
    times: tuple[float | None, float | None, float | None],
    variables: Sequence[str] | None,
    overwrite: bool,
    progress: Progress,
) -> Export:
    """Export a log; see `Log.export`. The times are `start`, `end` and `every`."""
    if to not in FORMATS:
        raise ParameterError(f"got {one_line(to)}", expected=", ".join(FORMATS), at="to")
    suffix, write = FORMATS[to]
    names = _choose_variables(log, to, [variables] if isinstance(variables, str) else variables or ())
    target = log.path.with_name(log.path.stem + suffix) if path is None else Path(path)
    with progress_bar(f"export of {log.path.name}", show=progress) as bar:
        frames = Frames(log, names, times, bar)
        with replace_file(target, LogError, folder=to == "vtk") as part:
            _check_target(target, overwrite, log)
            write(frames, part)
    return Export(target, frames.count, frames.names, frames.missing)


def _choose_variables(log: Log, to: str, requested: Sequence[str]) -> list[str]:
    """Return the variables to export: those requested and, in formats with geometry, the displacements."""
    names, moving, others = list(log.variables), set[str](), "the formats csv, netcdf and hdf5 contain every variable"
    if to in ("vtk", "xyz"):
        drawables = solid_drawables(log) if to == "vtk" else particles(log)
        drawn = {name for one in drawables for found in element_arrays(one, log.variables) for name in found}
        names, moving = [name for name in names if name in drawn], {getattr(one, "displacement", "") for one in drawables}
    if not names:
        raise LogError(f"it has no recorded variable that the format {to} contains", hint=others, source=log.source)
    for name in requested:
        if name not in names:
            hint = others if name in log.variables else spelling_hint(str(name), names)
            expected = f"a recorded variable that the format {to} contains"
            raise ParameterError(f"got {one_line(name)}", expected=expected, hint=hint, at="variables")
    if requested:
        return [name for name in names if name in requested or name in moving]
    return [name for name in names if to != "csv" or prod(log.variables[name].shape) <= _HISTORY] or names


def _check_target(target: Path, overwrite: bool, log: Log) -> None:
    """Raise `ParameterError` for a target that must not be replaced."""
    if not os.path.lexists(target):
        return
    if not overwrite:
        hint = "choose another name, or pass overwrite=True (--overwrite)"
        raise ParameterError(f"{str(target)!r} exists already", hint=hint, at="path")
    if target.exists() and target.samefile(log.path):
        raise ParameterError("this file is the log", hint="choose another name", at="path")
    if target.is_dir() and not all(one.is_dir() or one.suffix in (".vtu", ".pvd") for one in target.rglob("*")):
        raise ParameterError(f"{str(target)!r} is not a folder of exported files alone", hint="choose another name", at="path")
