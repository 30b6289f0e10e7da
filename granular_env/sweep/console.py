"""Messages of the command line while a sweep is computed, and after it."""

from __future__ import annotations

import importlib.util
import shlex
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from time import perf_counter

from granular_env.output_files import count_of
from granular_env.progress import Progress, progress_bar
from granular_env.terminal_text import printable, table

from .store import CSV, TABLE
from .table import Sweep
from .worker import Result

# A table of so many rows is printed.
_MOST_ROWS = 24
_WAYS = {"pandas": ".table for pandas", "xarray": ".dataset for xarray"}
# So many errors are told at the end; the table has all of them.
_MOST_ERRORS = 3


@contextmanager
def bar(title: str, size: int, known: Sequence[Result], progress: Progress) -> Iterator[Callable[[Sequence[Result]], None]]:
    """Show a progress bar: tasks done and failed, their rate, the time that is left.

    Args:
        title: what stands before it.
        size: how many tasks there are.
        known: results that there are already.
        progress: whether to show it, or what is called instead.
    """
    with progress_bar(title, size, done=len(known), show=progress) as shown:
        begun, first, done, failed = perf_counter(), len(known), len(known), _failures(known)

        def report(results: Sequence[Result]) -> None:
            nonlocal done, failed
            done, failed = done + len(results), failed + _failures(results)
            rate = (done - first) / max(perf_counter() - begun, 1e-9)
            shown.update(done, f"{done}/{size}", f"{failed} failed", f"{rate:,.3g} tasks/s")

        yield report


def _failures(results: Sequence[Result]) -> int:
    return sum(result.outcome != "done" for result in results)


def closing(sweep: Sweep) -> str:
    """Say how it went, where the table is, and the lines that open it."""
    pending = sweep.size - sweep.done - sweep.failed
    waiting = f", {pending} pending" if pending else ""
    lines = [f"{count_of(sweep.size, 'task')}: {sweep.done} done, {sweep.failed} failed{waiting}"]
    errors = list(sweep.errors.items())
    lines += [f"failed: task {number}: {error}" for number, error in errors[:_MOST_ERRORS]]
    if len(errors) > _MOST_ERRORS:
        lines.append(f"failed: {len(errors) - _MOST_ERRORS} more; the column 'error' of the table tells why")
    if sweep.interrupted:
        lines.append("interrupted: what is done is kept; the same command goes on from there")
    if 0 < sweep.done and sweep.size <= _MOST_ROWS:
        lines += ["", table(_rows(sweep)), ""]
    lines += [f"table: {shlex.quote(str(sweep.folder / TABLE))} (and {CSV})", "  import granular_env as ge"]
    return "\n".join([*lines, f"  sweep = ge.open_sweep({str(sweep.folder)!r})      # {_ways_in()}"])


def _rows(sweep: Sweep) -> list[list[str]]:
    """Return headings with units, and the keys that vary, the measures and what failed of each task."""
    columns, about = sweep.columns(), sweep.description
    shown = ["task", *about["grid"], *about["samples"], *(["repetition"] if about["repetitions"] else []), *about["measures"]]
    shown += ["outcome"] if sweep.done < sweep.size else []
    units = sweep.units
    heads = [f"{name} [{units[name]}]" if units.get(name, "1") != "1" else name for name in shown]
    return [heads, *([_cell(columns[name][row]) for name in shown] for row in range(sweep.size))]


def _cell(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else printable(value)


def _ways_in() -> str:
    """Return what opens the table with the packages that are here, and what installs the others."""
    ways = [way for package, way in _WAYS.items() if importlib.util.find_spec(package) is not None]
    missing = [package for package in _WAYS if importlib.util.find_spec(package) is None]
    advice = f"; pip install 'granular-env[sweep]' adds {' and '.join(missing)}" if missing else ""
    return ", ".join([*ways, ".columns() for lists"]) + advice
