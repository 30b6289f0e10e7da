"""The folder of a sweep's results.

    sweep.json        the plan's tasks, their values and hashes; written anew when a plan is computed again
    results.jsonl     one line for each task that is over, appended as they come: whatever ends the program, they stay
    table.parquet     the table, made of both at the end
    table.csv         the same as text
    logs/HASH.mcap    the logs that the plan keeps
    inputs/           the CSV files that the experiment names, by their content

Results are known by their task's hash. A plan that was edited finds there what still holds.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, ValidationError, model_validator

from granular_env.components.errors import SweepError
from granular_env.output_files import lock, replacing

from .measures import OWN_COLUMNS
from .worker import Result

FORMAT, VERSION = "granular-env sweep", 1
# Wall time between two waits for the disk [s].
_SYNC_SECONDS = 5.0
DESCRIPTION, JOURNAL, TABLE, CSV = "sweep.json", "results.jsonl", "table.parquet", "table.csv"
# Files of a process that was killed while it wrote them; see `output_files.replacing`.
_PARTS = ".*.part"


_Hash = Annotated[str, StringConstraints(pattern="^[0-9a-f]{32}$")]


class Description(BaseModel):
    """The content of `sweep.json` besides its format and version."""

    model_config = ConfigDict(strict=True, frozen=True)

    name: str
    plan: str
    program: str
    experiment: str
    grid: dict[str, list[Any]]
    samples: list[str]
    sample_count: int = Field(ge=0)
    repetitions: int = Field(ge=0)
    measures: dict[str, str]
    units: dict[str, str] = {}
    tasks: list[tuple[list[Any], int, int, Annotated[int, Field(ge=0, lt=2**63)] | None, _Hash]]

    @model_validator(mode="after")
    def _of_a_piece(self) -> Self:
        names = [*self.grid, *self.samples, *self.measures]
        if len(set(names)) < len(names) or set(self.measures) & set(OWN_COLUMNS):
            raise ValueError("two columns have one name")
        if (self.sample_count > 0) != bool(self.samples):
            raise ValueError("sample_count does not fit the samples")
        size = math.prod(map(len, self.grid.values())) * (self.sample_count or 1) * (self.repetitions or 1)
        if size != len(self.tasks):
            raise ValueError(f"{len(self.tasks)} tasks, expected {size}")
        if any(len(task[0]) != len(self.grid) + len(self.samples) for task in self.tasks):
            raise ValueError("a task has another number of values than there are keys")
        return self


class Store:
    """The results of one sweep while it is computed; use it as a context manager.

    Args:
        folder: made if need be.

    Raises:
        SweepError: another process computes here, it is no folder of a sweep, or it cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._synced = perf_counter()

    def __enter__(self) -> Self:
        if self.folder.exists() and not self.folder.is_dir():
            raise SweepError(f"{str(self.folder)!r} is a file", expected="a folder", hint="the sweep's results go into it")
        try:
            if self.folder.is_dir() and not (self.folder / DESCRIPTION).exists() and _foreign(self.folder):
                raise SweepError(
                    f"{str(self.folder)!r} holds other files and no sweep", hint="choose another folder for the results"
                )
            self.folder.mkdir(parents=True, exist_ok=True)
            self._journal = (self.folder / JOURNAL).open("ab")
        except OSError as error:
            raise self._unwritable(error) from error
        busy = SweepError(
            "another process computes a sweep there",
            hint="wait for it, or choose another folder",
            source=f"{str(self.folder)!r}",
        )
        try:
            lock(self._journal, busy)
        except OSError as error:
            self._journal.close()
            raise self._unwritable(error) from error
        except SweepError:
            self._journal.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(OSError):
            os.fsync(self._journal.fileno())
        self._journal.close()

    def begin(self, description: dict[str, Any]) -> dict[str, Result]:
        """Say which tasks there are; returns what is known of them from before.

        Raises:
            SweepError: the folder has the results of another plan, or of a program that kept them otherwise.
        """
        if (self.folder / DESCRIPTION).exists():
            before = read_description(self.folder)
            if before["name"] != description["name"]:
                raise SweepError(
                    f"{str(self.folder)!r} holds the results of the plan {before['name']!r}, this one is "
                    f"{description['name']!r}",
                    hint="choose another folder",
                )
        for part in self.folder.glob(_PARTS):
            part.unlink(missing_ok=True)
        self._mend()
        with replacing(self.folder / DESCRIPTION, SweepError) as part:
            part.write_text(json.dumps({"format": FORMAT, "version": VERSION, **description}), encoding="utf-8")
        return read_results(self.folder)

    def _mend(self) -> None:
        """End a last line that was cut off in the middle, so that the next result begins a new line."""
        path = self.folder / JOURNAL
        with path.open("rb") as file:
            if file.seek(0, os.SEEK_END) and file.seek(-1, os.SEEK_END) is not None and file.read(1) != b"\n":
                self._append(b"\n")

    def add(self, results: Iterable[Result]) -> None:
        """Keep results: they are in the file when this returns, and on the disk some seconds later at the latest."""
        self._append(b"".join(_line(result) for result in results))
        if perf_counter() >= self._synced + _SYNC_SECONDS:
            self._sync()

    def _sync(self) -> None:
        """Wait until the disk has the results so far: a power cut takes what the system has not written yet."""
        try:
            os.fsync(self._journal.fileno())
        except OSError as error:
            raise self._unwritable(error) from error
        self._synced = perf_counter()

    def _append(self, data: bytes) -> None:
        try:
            self._journal.write(data)
            self._journal.flush()
        except OSError as error:
            raise self._unwritable(error) from error

    def _unwritable(self, error: OSError) -> SweepError:
        return SweepError(
            f"the results cannot be kept in {str(self.folder)!r}: {error.strerror or error}",
            hint="those so far are there; free some space or choose another folder",
        )


def _foreign(folder: Path) -> bool:
    return any(path.name != JOURNAL and not path.match(_PARTS) for path in folder.iterdir())


def _line(result: Result) -> bytes:
    row: Sequence[Any] = [result.hash, result.outcome, result.values, result.error, result.notes]
    return json.dumps(row, separators=(",", ":")).encode() + b"\n"


def read_description(folder: Path) -> dict[str, Any]:
    """Return the description that `Store.begin` wrote.

    Raises:
        SweepError: there is none, or one that this program does not read.
    """
    path = folder / DESCRIPTION
    try:
        found = json.loads(data := path.read_bytes())
    except FileNotFoundError:
        raise SweepError(
            "no sweep is there", expected="the folder that `granular-env sweep` wrote", source=f"{str(folder)!r}"
        ) from None
    except (OSError, ValueError, RecursionError) as error:
        raise SweepError(
            f"cannot be read: {getattr(error, 'strerror', None) or error}",
            hint="compute the sweep anew",
            source=f"{str(path)!r}",
        ) from None
    if not isinstance(found, dict) or found.get("format") != FORMAT:
        raise SweepError("no description of a sweep", hint="compute the sweep anew", source=f"{str(path)!r}")
    if found.get("version") != VERSION:
        raise SweepError(
            f"got {found.get('version')!r}",
            expected=f"{VERSION}, the version that this program reads",
            hint="update granular-env, or choose another folder",
            at="version",
            source=f"{str(path)!r}",
        )
    try:
        Description.model_validate_json(data)
    except (ValidationError, RecursionError) as error:
        first = error.errors()[0] if isinstance(error, ValidationError) else {"loc": (), "msg": "it is nested too deeply"}
        raise SweepError(first["msg"], hint="compute the sweep anew", at=tuple(first["loc"]), source=f"{str(path)!r}") from None
    return found


def read_results(folder: Path) -> dict[str, Result]:
    """Hash -> the last result of that task; lines that were cut off are passed over."""
    found = {}
    try:
        with (folder / JOURNAL).open("rb") as lines:
            for line in lines:
                if (result := _result(line)) is not None:
                    found[result.hash] = result
    except FileNotFoundError:
        pass
    except OSError as error:
        raise SweepError(f"cannot be read: {error.strerror or error}", source=f"{str(folder / JOURNAL)!r}") from None
    return found


def _result(line: bytes) -> Result | None:
    try:
        hashed, outcome, values, error, notes = json.loads(line)
        numbers = tuple(float(value) for value in values)
    except (ValueError, TypeError, RecursionError):
        return None
    if not line.endswith(b"\n") or outcome not in ("done", "failed", "lost"):
        return None
    return Result(str(hashed), outcome, numbers, str(error), str(notes))
