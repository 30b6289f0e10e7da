"""The table of a sweep: one row per task, in the order of the plan, with the results so far."""

from __future__ import annotations

import csv
import os
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from granular_env.components.errors import SweepError
from granular_env.components.support.html_summary import html_summary
from granular_env.optional_packages import import_optional
from granular_env.output_files import replace_file

from .store import TABLE, Description, read_description, read_results
from .worker import Result, log_path

_NOTHING = Result("", "lost")


class Sweep:
    """The results of a sweep, as a pandas `table` or as lists (`columns`).

    Attributes:
        folder: folder of the results.
        description: the plan's name, keys, measures and tasks.
        size: number of tasks.
        outcomes: outcome of each task: done, failed or pending. A task that lost its process or node several times has failed.
        done: number of tasks that were computed without an error.
        failed: number of failed tasks.
        errors: number of a failed task -> its error as text.
        units: column of a varying key or a measure -> SI unit; "1" for dimensionless numbers.
        interrupted: whether Ctrl-C ended the computation in this process.
    """

    def __init__(self, folder: Path, description: Description, results: Mapping[str, Result]) -> None:
        self.folder, self.description, self.interrupted = folder, description, False
        self._results = [results.get(one) for one in description.hashes]
        self.outcomes = ["pending" if one is None else one.outcome.replace("lost", "failed") for one in self._results]
        self.size, self.units = len(self.outcomes), dict(description.units)
        self.done, self.failed = self.outcomes.count("done"), self.outcomes.count("failed")
        self.errors = {place: one.error for place, one in enumerate(self._results) if one and one.outcome != "done"}

    def __repr__(self) -> str:
        pending = self.size - self.done - self.failed
        counts = f"{self.done} done, {self.failed} failed, {pending} pending"
        return f"<Sweep {self.description.name!r}: {self.size} tasks, {counts}>"

    def _repr_html_(self) -> str:
        columns = self.columns()
        rows = zip(*columns.values(), strict=True)
        return html_summary(repr(self).strip("<>"), {"folder": str(self.folder)}, [*map(self.heading, columns)], rows)

    def log(self, task: int) -> Path:
        """Return the path of a task's log, for `open_log`; the plan's `log_every` selects the tasks with a log."""
        return log_path(self.folder, self.description.hashes[task])

    def columns(self) -> dict[str, list[Any]]:
        """Return name of a column -> its value for each task, in the order of the plan; wall times are left out."""
        about, results = self.description, [one or _NOTHING for one in self._results]
        found: dict[str, list[Any]] = {"task": list(range(self.size)), **about.keys}
        for place, name in enumerate(about.measures):
            found[name] = [one.values[place] if place < len(one.values) else float("nan") for one in results]
        found["outcome"] = self.outcomes
        found["error"] = [one.error or None for one in results]
        found["notes"] = [one.notes or None for one in results]
        found["hash"] = about.hashes
        logs = {path.stem for path in log_path(self.folder, "").parent.glob("*.mcap")}
        found["log"] = [f"logs/{one}.mcap" if one in logs else None for one in about.hashes]
        return found

    @cached_property
    def table(self) -> Any:
        """The table as a `pandas.DataFrame`; its index is the number of the task."""
        return import_optional("pandas", "the table of a sweep").DataFrame(self.columns())

    def write_csv(self) -> Path:
        """Write the table as CSV; return its path.

        The first line has the names with units. Numbers are exact; cells without a value are empty.
        """
        columns, path = self.columns(), self.folder / TABLE
        with replace_file(path, SweepError) as part, part.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(self.heading(name) for name in columns)
            for row in zip(*columns.values(), strict=True):
                writer.writerow("" if cell is None or cell != cell else cell for cell in row)
        return path

    def heading(self, column: str) -> str:
        """Return the name of a column with its unit."""
        unit = self.units.get(column, "1")
        return f"{column} [{unit}]" if unit != "1" else column


def open_sweep(folder: str | os.PathLike[str]) -> Sweep:
    """Return the results in a folder so far, also during a sweep or after a kill.

    Raises:
        SweepError: there is no sweep, or a sweep of another version.
    """
    path = Path(folder)
    return Sweep(path, read_description(path), read_results(path))
