"""The formats of exports, and the export of a log to one of them."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING

from ...components.drawables import Drawable
from ...components.errors import LogError, ParameterError, one_line, spelling_hint
from ...output_files import replace_file, require_writable, write_error_hint
from ...progress import Progress, progress_bar
from ..element_arrays import cell_arrays, point_arrays
from .frames import Frames, Selection
from .netcdf_files import write_netcdf
from .text_files import points_of, write_csv, write_xyz
from .vtk_files import drawn_once, write_vtk

if TYPE_CHECKING:
    from ..log import Log

# Largest number of values of a variable that is a history, not a field.
_HISTORY = 16


@dataclass(frozen=True, slots=True)
class Export:
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


@dataclass(frozen=True, slots=True)
class _Format:
    """A format.

    Attributes:
        suffix: suffix of the file.
        write: function that writes frames to a file or into an empty folder.
        is_default: returns whether a variable of this shape is exported if no variables are requested.
        drawables: returns the drawables whose outputs the format contains; None if it contains any variable.
        elements: the elements of these drawables.
        is_folder: returns whether the export of a log is a folder.
    """

    suffix: str
    write: Callable[[Frames, Path], None]
    is_default: Callable[[tuple[int, ...]], bool] = lambda shape: True
    drawables: Callable[[Log], Sequence[Drawable]] | None = None
    elements: str = ""
    is_folder: Callable[[Log], bool] = lambda log: False

    def available(self, log: Log) -> list[str]:
        """Return the names of the recorded variables that the format can contain."""
        if self.drawables is None:
            return list(log.variables)
        drawables, finders = self.drawables(log), (point_arrays, cell_arrays)
        return list(dict.fromkeys(name for one in drawables for find in finders for name in find(one, log.variables)))

    def moving(self, log: Log) -> set[str]:
        """Return the outputs that place the elements in each frame, which are exported in any case."""
        drawables = self.drawables(log) if self.drawables else ()
        return {getattr(one, role, "") for one in drawables for role in ("displacement", "rotation")}


FORMATS = {
    "vtk": _Format("", write_vtk, drawables=drawn_once, elements="points, cells, links or curves", is_folder=lambda log: True),
    "xyz": _Format(".xyz", write_xyz, drawables=points_of, elements="points", is_folder=lambda log: len(points_of(log)) > 1),
    "csv": _Format(".csv", write_csv, is_default=lambda shape: prod(shape) <= _HISTORY),
    "netcdf": _Format(".nc", write_netcdf),
    "hdf5": _Format(".h5", write_netcdf),
}


def export_log(
    log: Log,
    path: str | os.PathLike[str] | None,
    to: str | None,
    selection: Selection,
    variables: Sequence[str] | None,
    overwrite: bool,
    progress: Progress,
) -> Export:
    """Export a log; see `Log.export`."""
    name = _format_name(path, to)
    one = FORMATS[name]
    names = _choose_variables(log, one, name, variables)
    is_folder = one.is_folder(log)
    default = log.path.with_name(f"{log.path.stem}-{name}") if is_folder else log.path.with_suffix(one.suffix)
    target = Path(default if path is None else path)
    with progress_bar(f"export of {log.path.name}", show=progress) as bar:
        frames = Frames(log, names, selection, bar)
        _refuse_target(target, is_folder, overwrite, log)
        with _replace_folder(target) if is_folder else replace_file(target, LogError) as part:
            one.write(frames, part)
    fields = [name for name, variable in log.variables.items() if prod(variable.shape) > _HISTORY and name not in names]
    return Export(target, frames.count, frames.names, () if variables else tuple(fields), frames.missing)


def _format_name(path: str | os.PathLike[str] | None, to: str | None) -> str:
    """Return the name of the format: the requested one, or the one whose suffix the path has."""
    if to is not None:
        if to not in FORMATS:
            raise ParameterError(f"got {to!r}", expected=", ".join(FORMATS), hint=spelling_hint(str(to), FORMATS), at="to")
        return to
    suffix = Path("" if path is None else path).suffix
    found = next((name for name, one in FORMATS.items() if one.suffix and one.suffix == suffix), None)
    if found is None:
        raise ParameterError("the format is not known", hint=f"give one of {', '.join(FORMATS)}", at="to")
    return found


def _choose_variables(log: Log, one: _Format, name: str, requested: Sequence[str] | None) -> list[str]:
    """Return the variables to export: those requested and, in formats with geometry, displacements and rotations."""
    available, others = one.available(log), "the formats csv, netcdf and hdf5 contain every variable"
    needed = f"recorded output of {one.elements}" if one.elements else "recorded variable"
    if not available:
        raise LogError(f"it has no {needed}, which the format {name} needs", hint=others, source=log.source)
    if not requested:
        return [own for own in available if one.is_default(log.variables[own].shape)] or available
    requested = [requested] if isinstance(requested, str) else requested
    for own in requested:
        if own not in available:
            hint = others if own in log.variables else spelling_hint(str(own), available)
            raise ParameterError(f"got {one_line(own)}", expected=f"a {needed}", hint=hint, at="variables")
    return [own for own in available if own in requested or own in one.moving(log)]


def _refuse_target(target: Path, is_folder: bool, overwrite: bool, log: Log) -> None:
    """Raise an error for a target that cannot or must not be written, before the log is read."""
    if not is_folder or not os.path.isdir(target):
        require_writable(target, LogError)
    if not os.path.lexists(target):
        return
    if is_folder and not os.path.isdir(target):
        raise ParameterError(
            f"{str(target)!r} is a file", expected="a folder, which holds a file per frame or set of points", at="path"
        )
    if os.path.exists(target) and os.path.samefile(target, log.path):
        raise ParameterError("this file is the log", hint="choose another name", at="path")
    if not overwrite:
        hint = "choose another name, or pass overwrite=True (--overwrite)"
        raise ParameterError(f"{str(target)!r} exists already", hint=hint, at="path")
    if is_folder and not all(os.path.isdir(one) or one.suffix in (".vtu", ".pvd", ".xyz") for one in target.rglob("*")):
        received = f"{str(target)!r} is not a folder of exported files alone"
        raise ParameterError(received, hint="nothing is replaced; choose another name", at="path")


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
