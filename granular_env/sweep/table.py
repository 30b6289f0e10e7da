"""The table of a sweep: a row for each task in the plan's order, whatever is known so far."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any, TextIO

from granular_env.components.errors import SweepError
from granular_env.optional_packages import import_optional
from granular_env.output_files import replacing

from .store import CSV, TABLE, read_description, read_results
from .worker import Result

_NOTHING = Result("", "lost")


class Sweep:
    """A sweep's results: `table` for pandas, `dataset` for xarray.

    Attributes:
        folder: where they are.
        description: the plan's name, keys, measures and tasks.
        interrupted: whether Ctrl-C ended the computing of it, in this process.
    """

    def __init__(self, folder: Path, description: Mapping[str, Any], results: Mapping[str, Result]) -> None:
        self.folder, self.description = folder, description
        self._results = results
        self.interrupted = False

    def __repr__(self) -> str:
        pending = self.size - self.done - self.failed
        counts = f"{self.size} tasks, {self.done} done, {self.failed} failed, {pending} pending"
        return f"<Sweep {self.description['name']!r}: {counts}>"

    @property
    def size(self) -> int:
        """Return the number of tasks."""
        return len(self.description["tasks"])

    @property
    def units(self) -> dict[str, str]:
        """Column -> SI unit, of the keys that vary and of the measures; "1" for plain numbers."""
        return dict(self.description.get("units", {}))

    @cached_property
    def outcomes(self) -> list[str]:
        """For each task done, failed or pending; a task whose process or node was lost again and again has failed."""
        words = {"done": "done", "failed": "failed", "lost": "failed"}
        found = (self._results.get(task[-1]) for task in self.description["tasks"])
        return ["pending" if result is None else words[result.outcome] for result in found]

    @property
    def done(self) -> int:
        """Return the number of tasks that have their measures."""
        return self.outcomes.count("done")

    @property
    def failed(self) -> int:
        """Return the number of tasks that failed."""
        return self.outcomes.count("failed")

    @property
    def errors(self) -> dict[int, str]:
        """Number of each task that failed -> why."""
        tasks = self.description["tasks"]
        return {number: self._results[tasks[number][-1]].error for number, one in enumerate(self.outcomes) if one == "failed"}

    def log(self, task: int) -> Path:
        """Return where a task's log is, for `open_log`.

        Raises:
            SweepError: there is no such task, or it left no log.
        """
        if isinstance(task, bool) or not isinstance(task, int) or not 0 <= task < self.size:
            raise SweepError(f"got {task}, the sweep has 0 to {self.size - 1}", at="task")
        path = self.folder / "logs" / f"{self.description['tasks'][task][-1]}.mcap"
        if not path.exists():
            raise SweepError(f"task {task} left no log", hint="say in the plan's [logs] which are kept")
        return path

    def columns(self) -> dict[str, list[Any]]:
        """Column -> a value for each task, in the plan's order. There are no wall times: they hold in no other run."""
        about, tasks = self.description, self.description["tasks"]
        results = [self._results.get(task[-1], _NOTHING) for task in tasks]
        found: dict[str, list[Any]] = {"task": list(range(len(tasks)))}
        for place, key in enumerate([*about["grid"], *about["samples"]]):
            found[key] = [_plain(task[0][place]) for task in tasks]
        for place, key in enumerate(("sample", "repetition", "seed"), start=1):
            if about["samples"] if key == "sample" else about["repetitions"]:
                found[key] = [task[place] for task in tasks]
        for place, name in enumerate(about["measures"]):
            found[name] = [one.values[place] if place < len(one.values) else float("nan") for one in results]
        found["outcome"] = self.outcomes
        found["error"] = [one.error or None for one in results]
        found["notes"] = [one.notes or None for one in results]
        found["hash"] = [task[-1] for task in tasks]
        logs = {path.name for path in (self.folder / "logs").glob("*.mcap")}
        found["log"] = [f"logs/{task[-1]}.mcap" if f"{task[-1]}.mcap" in logs else None for task in tasks]
        return found

    @cached_property
    def arrow(self) -> Any:
        """The table as a `pyarrow.Table`: what the Parquet file holds."""
        pyarrow = import_optional("pyarrow", "the table of a sweep")
        floats, texts = set(self.description["measures"]), {"outcome", "error", "notes", "hash", "log"}
        kinds = dict.fromkeys(floats, pyarrow.float64()) | dict.fromkeys(texts, pyarrow.string())
        with _unusable(self.folder):
            columns = {name: pyarrow.array(_alike(values), kinds.get(name)) for name, values in self.columns().items()}
        facts = {key: self.description[key] for key in ("name", "plan", "program", "experiment")} | {"units": self.units}
        return pyarrow.table(columns).replace_schema_metadata({"granular-env": json.dumps(facts)})

    @cached_property
    def table(self) -> Any:
        """The table as a `pandas.DataFrame`; `columns` gives the same without pandas."""
        import_optional("pandas", "the table of a sweep")
        return self.arrow.to_pandas()

    @cached_property
    def dataset(self) -> Any:
        """The measures as an `xarray.Dataset`: a dimension for each key of the grid, for samples and for repetitions.

        Drawn values are coordinates along ``sample``; ``outcome`` says where a task failed or is pending.
        """
        xarray = import_optional("xarray", "the dataset of a sweep")
        about, columns = self.description, self.columns()
        dims = {key: _alike([_plain(value) for value in values]) for key, values in about["grid"].items()}
        if about["samples"]:
            dims["sample"] = list(range(about["sample_count"]))
        if about["repetitions"]:
            dims["repetition"] = list(range(about["repetitions"]))
        shape = [len(values) for values in dims.values()]
        data = {name: (list(dims), _array(columns[name], shape)) for name in (*about["measures"], "outcome")}
        drawn = {key: ("sample", _alike(self._of_samples(columns[key]))) for key in about["samples"]}
        with _unusable(self.folder):
            found = xarray.Dataset(data, coords={**dims, **drawn}, attrs={"sweep": about["name"]})
        for name, words in about["measures"].items():
            found[name].attrs["measure"] = words
        for name, unit in self.units.items():
            if name in found.variables:
                found[name].attrs["units"] = unit
        return found

    def _of_samples(self, values: Sequence[Any]) -> list[Any]:
        step = self.description["repetitions"] or 1
        return list(values[: self.description["sample_count"] * step : step])

    def write(self) -> Path:
        """Write the table as Parquet and as CSV, each whole or not at all; return the path of the first."""
        import_optional("pyarrow", "the table of a sweep")
        import pyarrow.parquet as parquet

        path = self.folder / TABLE
        with replacing(path, SweepError) as part:
            parquet.write_table(self.arrow, part)
        with replacing(self.folder / CSV, SweepError) as part, part.open("w", newline="", encoding="utf-8") as file:
            self._write_csv(file)
        return path

    def _write_csv(self, file: TextIO) -> None:
        """Write a line of names with units, and a line for each task; numbers are exact, what is not known is empty."""
        columns, units = self.columns(), self.units
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([f"{name} [{units[name]}]" if units.get(name, "1") != "1" else name for name in columns])
        for row in zip(*columns.values(), strict=True):
            writer.writerow(["" if cell is None or cell != cell else cell for cell in row])


def open_sweep(folder: str | os.PathLike[str]) -> Sweep:
    """Return the results in a folder so far; also while the sweep is running, or after it was killed.

    Raises:
        SweepError: no sweep is there, or one of another version.
    """
    try:
        path = Path(folder)
    except TypeError:
        raise SweepError(f"got {folder!r}", expected="the path of a sweep's folder", at="folder") from None
    return Sweep(path, read_description(path), read_results(path))


@contextmanager
def _unusable(folder: Path) -> Iterator[None]:
    """Values that no table can hold, as an error of the family: a description that somebody edited."""
    try:
        yield
    except (ValueError, TypeError, ArithmeticError) as error:  # pyarrow's errors are ValueErrors
        raise SweepError(f"the results in {str(folder)!r} make no table: {error}", hint="compute the sweep anew") from None


def _plain(value: Any) -> Any:
    """Return a value as a cell: tables and lists as JSON."""
    return json.dumps(value) if isinstance(value, list | dict) else value


def _alike(values: list[Any]) -> list[Any]:
    """Values of one kind: whole numbers among others as floats, anything among text as text."""
    kinds = {type(value) for value in values if value is not None}
    if len(kinds) <= 1:
        return values
    if kinds == {int, float}:
        return [float(value) for value in values]
    return [value if isinstance(value, str) or value is None else json.dumps(value) for value in values]


def _array(values: list[Any], shape: list[int]) -> Any:
    import numpy as np

    return np.array(values).reshape(shape)
