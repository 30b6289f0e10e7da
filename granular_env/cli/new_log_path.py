"""The path where a run is recorded: the one that was given, or a new file in logs/."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path

from granular_env.components.errors import LogError
from granular_env.output_files import advice_for, file_name


@contextmanager
def log_target(given: str | None, name: str, overwrite: bool) -> Iterator[tuple[Path, bool]]:
    """Give where to record, and whether what stands there may be replaced."""
    if given:
        yield Path(given), overwrite
    else:
        with reserve_log(name) as path:
            yield path, True


@contextmanager
def reserve_log(name: str, folder: Path = Path("logs")) -> Iterator[Path]:
    """Give the first of logs/<name>-1.mcap, -2, ... that does not exist, as an empty file that nobody else gets.

    It may be overwritten; where nothing was written to it, it is removed again.
    """
    new_folder = not folder.exists()
    path = _empty_file(folder, file_name(name, "run"))
    try:
        yield path
    finally:
        with suppress(OSError):
            if path.stat().st_size == 0:
                path.unlink()
                if new_folder:
                    folder.rmdir()


def _empty_file(folder: Path, stem: str) -> Path:
    for number in count(1):
        path = folder / f"{stem}-{number}.mcap"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            path.touch(exist_ok=False)
            return path
        except FileExistsError:
            continue
        except OSError as error:
            raise LogError(f"log {str(path)!r} cannot be written: {error.strerror}", hint=advice_for(error)) from error
    raise AssertionError
