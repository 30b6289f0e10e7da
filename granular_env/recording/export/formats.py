"""The formats of exports, and the export of a log to one of them."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from ...components.drawables import Drawable
from ...components.errors import LogError, ParameterError, one_line, spelling_hint
from ...output_files import replace_file, require_writable, write_error_hint
from ...progress import Progress, progress_bar
from ..element_arrays import cell_arrays, point_arrays
from .frames import Frames
from .netcdf_files import write_netcdf
from .text_files import points_of, write_csv, write_xyz
from .vtk_files import drawn_once, write_vtk

if TYPE_CHECKING:
    from ..log import Log

# Largest number of values of a variable that is a history, not a field.
_HISTORY = 16


class Export(NamedTuple):
    """An exported file or folder.

    Attributes:
        path: the file or folder.
        frames: number of frames.
        variables: the exported variables.
        left_out: the recorded arrays that it does not contain, if no variables were requested.
        missing: a sentence on the frames that a damaged or unclosed log lacks; empty if there are none.
    """

    path: Path
    frames: int
    variables: tuple[str, ...]
    left_out: tuple[str, ...]
    missing: str


class _Format(NamedTuple):
    """The suffix of files, the function that writes one or fills a folder, and the drawables whose outputs it contains.

    Without `drawables`, a format contains any variable.
    """

    suffix: str
    write: Callable[[Frames, Path], None]
    drawables: Callable[[Log], Sequence[Drawable]] | None = None
    needs: str = "recorded variable"


FORMATS = {
    "vtk": _Format("", write_vtk, drawn_once, "recorded output of points, cells, links or curves"),
    "xyz": _Format(".xyz", write_xyz, points_of, "recorded output of points"),
    "csv": _Format(".csv", write_csv),
    "netcdf": _Format(".nc", write_netcdf),
    "hdf5": _Format(".h5", write_netcdf),
}


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
    one, names = FORMATS[to], _choose_variables(log, to, [variables] if isinstance(variables, str) else variables or ())
    is_folder = to == "vtk" or (to == "xyz" and len(points_of(log)) > 1)
    default = log.path.with_name(f"{log.path.stem}-{to}") if is_folder else log.path.with_suffix(one.suffix)
    target = default if path is None else Path(path)
    with progress_bar(f"export of {log.path.name}", show=progress) as bar:
        frames = Frames(log, names, *times, bar)
        _refuse_target(target, is_folder, overwrite, log)
        with _replace_folder(target) if is_folder else replace_file(target, LogError) as part:
            one.write(frames, part)
    arrays = () if variables else (name for name, field in log.variables.items() if prod(field.shape) > _HISTORY)
    return Export(target, frames.count, frames.names, tuple(name for name in arrays if name not in names), frames.missing)


def _choose_variables(log: Log, to: str, requested: Sequence[str]) -> list[str]:
    """Return the variables to export: those requested and, in formats with geometry, displacements and rotations."""
    one, others = FORMATS[to], "the formats csv, netcdf and hdf5 contain every variable"
    drawables = one.drawables(log) if one.drawables else ()
    drawn = {name: None for one in drawables for find in (point_arrays, cell_arrays) for name in find(one, log.variables)}
    available = list(drawn if one.drawables else log.variables)
    if not available:
        raise LogError(f"it has no {one.needs}, which the format {to} needs", hint=others, source=log.source)
    for name in requested:
        if name not in available:
            hint = others if name in log.variables else spelling_hint(str(name), available)
            raise ParameterError(f"got {one_line(name)}", expected=f"a {one.needs}", hint=hint, at="variables")
    if not requested:
        histories = [name for name in available if to != "csv" or prod(log.variables[name].shape) <= _HISTORY]
        return histories or available
    moving = {getattr(drawable, role, "") for drawable in drawables for role in ("displacement", "rotation")}
    return [name for name in available if name in requested or name in moving]


def _refuse_target(target: Path, is_folder: bool, overwrite: bool, log: Log) -> None:
    """Raise an error for a target that cannot or must not be written."""
    if not is_folder or not target.is_dir():
        require_writable(target, LogError)
    if not os.path.lexists(target):
        return
    if target.exists() and target.samefile(log.path):
        raise ParameterError("this file is the log", hint="choose another name", at="path")
    if not overwrite:
        hint = "choose another name, or pass overwrite=True (--overwrite)"
        raise ParameterError(f"{str(target)!r} exists already", hint=hint, at="path")
    exported = target.is_dir() and all(one.is_dir() or one.suffix in (".vtu", ".pvd", ".xyz") for one in target.rglob("*"))
    if is_folder and not exported:
        raise ParameterError(f"{str(target)!r} is not a folder of exported files alone", hint="choose another name", at="path")


@contextmanager
def _replace_folder(target: Path) -> Iterator[Path]:
    """Make a hidden folder next to `target`, which replaces `target` if the block succeeds and is deleted if it fails."""
    part = target.absolute().with_name(f".{secrets.token_hex(8)}.part")
    try:
        part.mkdir(parents=True)
        yield part
        if target.exists():
            shutil.rmtree(target)
        os.replace(part, target)
    except OSError as error:
        reason = f"{str(target)!r} cannot be written: {error.strerror or error}"
        raise LogError(reason, hint=write_error_hint(error)) from error
    finally:
        shutil.rmtree(part, ignore_errors=True)
