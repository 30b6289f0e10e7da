"""The folder of a sweep's results, and the files in it.

    sweep.json            the tasks of the plan: their values and hashes
    results.jsonl         a line per finished task, appended immediately, so that results survive the end of the program
    results-I-of-N.jsonl  the same for part I of N
    table.csv             the table, made from these files at the end
    logs/HASH.mcap        the logs requested by the plan
    inputs/               the CSV files named by the experiment, identified by their content

Results are found by the hash of their task, so an edited plan reuses results that are still valid.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, ValidationError

from granular_env.components.errors import SweepError
from granular_env.output_files import lock_file, replace_file

from .worker import Result

DESCRIPTION, JOURNALS, TABLE = "sweep.json", "results*.jsonl", "table.csv"


class Description(BaseModel):
    """The content of `sweep.json`.

    Attributes:
        keys: column -> its value in each task; the columns are the varying keys, then the number of the sample.
        measures: names of the measures, which are columns, too.
        units: column -> SI unit.
        hashes: hashes of the tasks.
    """

    model_config = ConfigDict(strict=True, frozen=True)

    version: Literal[3] = 3
    name: str
    keys: dict[str, list[Any]]
    measures: list[str]
    units: dict[str, str]
    hashes: list[str]


class Store:
    """Stores the results of a sweep, or of a part of it, while they are computed; a context manager.

    Args:
        folder: folder of the results; it is created if necessary.
        description: content of the folder's `sweep.json`.
        part: (I, N) of the argument `part` of `run_sweep`.

    Raises:
        SweepError: another process uses the folder, it has other content, or it cannot be written.
    """

    def __init__(self, folder: Path, description: Description, part: tuple[int, int] = (0, 1)) -> None:
        self.folder, self.description = folder, description
        self._name = "results.jsonl" if part == (0, 1) else f"results-{part[0]}-of-{part[1]}.jsonl"

    def __enter__(self) -> Self:
        folder, named = self.folder, f"{str(self.folder)!r}"
        if (folder / DESCRIPTION).exists():
            if (other := read_description(folder).name) != self.description.name:
                received = f"{named} contains results of the plan {other!r}, not of {self.description.name!r}"
                raise SweepError(received, hint="choose another folder")
        elif folder.is_dir() and any(path.suffix not in (".jsonl", ".part") for path in folder.iterdir()):
            raise SweepError(f"{named} is not empty and contains no sweep", hint="choose another folder for the results")
        busy = "another process is computing this sweep, or this part of it, in the folder"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._journal = (folder / self._name).open("a+b")
            lock_file(self._journal, SweepError(busy, hint="wait until it ends, or choose another folder", source=named))
            if self._journal.seek(0, os.SEEK_END):
                self._journal.seek(-1, os.SEEK_END)
                if self._journal.read() != b"\n":  # the last line is incomplete, because the program was killed
                    self._journal.write(b"\n")
            with replace_file(folder / DESCRIPTION, SweepError) as part:
                part.write_text(self.description.model_dump_json(), encoding="utf-8")
        except OSError as error:
            raise self._unwritable_error(error) from error
        return self

    def __exit__(self, *_: object) -> None:
        self._journal.close()

    def add_result(self, result: Result) -> None:
        """Append a result to the file `results.jsonl` (or `results-I-of-N.jsonl`)."""
        row = [result.hash, result.outcome, result.values, result.error, result.notes]
        try:
            self._journal.write(json.dumps(row, separators=(",", ":")).encode() + b"\n")
            self._journal.flush()
        except OSError as error:
            raise self._unwritable_error(error) from error

    def _unwritable_error(self, error: OSError) -> SweepError:
        return SweepError(
            f"the results cannot be written to {str(self.folder)!r}: {error.strerror or error}",
            hint="earlier results are kept; free some space or choose another folder",
        )


def read_description(folder: Path) -> Description:
    """Return the description of the sweep in a folder.

    Raises:
        SweepError: there is no sweep, or this version cannot read it.
    """
    path = folder / DESCRIPTION
    try:
        return Description.model_validate_json(path.read_bytes())
    except FileNotFoundError:
        expected = "a folder written by `granular-env sweep`"
        raise SweepError("the folder contains no sweep", expected=expected, source=f"{str(folder)!r}") from None
    except ValidationError as error:
        first = error.errors()[0]
        hint = "compute the sweep again, in another folder"
        raise SweepError(first["msg"], hint=hint, at=tuple(first["loc"]), source=f"{str(path)!r}") from None


def read_results(folder: Path) -> dict[str, Result]:
    """Return hash of the task -> result, from all files `results*.jsonl` in a folder.

    Of several results of a task, the last counts, unless an earlier one has the outcome "done". Incomplete lines are ignored.
    """
    found: dict[str, Result] = {}
    for path in sorted(folder.glob(JOURNALS)):
        for line in path.read_bytes().split(b"\n"):
            try:
                task_hash, outcome, values, error, notes = json.loads(line)
                result = Result(task_hash, outcome, tuple(map(float, values)), error, notes)
            except (ValueError, TypeError):
                continue
            if task_hash not in found or found[task_hash].outcome != "done":
                found[task_hash] = result
    return found
