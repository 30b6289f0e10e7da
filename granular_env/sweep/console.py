"""Messages of the command line during and after a sweep."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter

from granular_env.output_files import count_text
from granular_env.progress import Progress, progress_bar
from granular_env.terminal_text import align_table, printable_text

from .store import TABLE
from .table import Sweep
from .worker import Result

# Largest number of rows of a table that is printed.
_MOST_ROWS = 24
# Largest number of errors that are printed; the table contains all errors.
_MOST_ERRORS = 3


@contextmanager
def sweep_progress(title: str, size: int, known_count: int, progress: Progress) -> Iterator[Callable[[Result], None]]:
    """Show a progress bar of `size` tasks, `known_count` of them with a result: done, failed, rate, remaining time."""
    with progress_bar(title, size, done=known_count, show=progress) as shown:
        begun, done, failed = perf_counter(), 0, 0

        def show_result(result: Result) -> None:
            nonlocal done, failed
            done, failed = done + 1, failed + (result.outcome != "done")
            rate = done / max(perf_counter() - begun, 1e-9)
            shown.update(known_count + done, f"{known_count + done}/{size}", f"{failed} failed", f"{rate:,.3g} tasks/s")

        yield show_result


def closing_text(sweep: Sweep, part: str = "") -> str:
    """Return a text: numbers of tasks, errors, and code that opens the table or, for a part, what to do after all parts."""
    pending = sweep.outcomes.count("pending")
    counts = f"{sweep.done} done, {sweep.failed} failed" + (f", {pending} pending" if pending else "")
    lines = [f"{count_text(sweep.size, 'task')}: {counts}"]
    errors = list(sweep.errors.items())
    lines += [f"failed: task {number}: {error}" for number, error in errors[:_MOST_ERRORS]]
    if len(errors) > _MOST_ERRORS:
        lines.append(f"failed: {len(errors) - _MOST_ERRORS} more tasks; see the column 'error' of the table")
    if sweep.interrupted:
        lines.append("interrupted: finished results are kept; run the same command to continue")
    if part:
        return "\n".join([*lines, f"part {part}: when all parts are done, run the command with --merge to write the table"])
    if 0 < sweep.done and sweep.size <= _MOST_ROWS:
        lines += ["", align_table(_table_rows(sweep)), ""]
    path = shlex.quote(str(sweep.folder / TABLE))
    return "\n".join([*lines, f"table: {path}", f"  in Python: ge.open_sweep({str(sweep.folder)!r}).table"])


def _table_rows(sweep: Sweep) -> list[list[str]]:
    """Return the rows of the printed table: headings with units, then each task's varying keys, measures and outcome."""
    columns, about = sweep.columns(), sweep.description
    shown = ["task", *about.keys, *about.measures, *(["outcome"] if sweep.done < sweep.size else [])]
    rows = [[columns[name][row] for name in shown] for row in range(sweep.size)]
    cells = [[f"{cell:.6g}" if isinstance(cell, float) else printable_text(cell) for cell in row] for row in rows]
    return [[sweep.heading(name) for name in shown], *cells]
