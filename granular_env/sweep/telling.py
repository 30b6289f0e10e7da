"""What is said while a sweep is computed, and after it."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from time import perf_counter

from granular_env.progress import progress_bar
from granular_env.writing import counted

from .computing import Result
from .store import TABLE
from .table import Sweep

# So many errors are told at the end; the table has all of them.
_MOST_ERRORS = 3


@contextmanager
def bar(title: str | None, size: int, known: Sequence[Result]) -> Iterator[Callable[[Sequence[Result]], None]]:
    """Show a progress bar: tasks done and failed, their rate, the time that is left; none without a title.

    Args:
        title: what stands before it.
        size: how many tasks there are.
        known: results that there are already.
    """
    with progress_bar(title or "", size, done=len(known), show=title is not None) as shown:
        begun, first, done, failed = perf_counter(), len(known), len(known), _failures(known)

        def told(results: Sequence[Result]) -> None:
            nonlocal done, failed
            done, failed = done + len(results), failed + _failures(results)
            rate = (done - first) / max(perf_counter() - begun, 1e-9)
            shown.update(done, f"{done}/{size}", f"{failed} failed", f"{rate:,.3g} tasks/s")

        yield told


def _failures(results: Sequence[Result]) -> int:
    return sum(result.outcome != "done" for result in results)


def closing(sweep: Sweep) -> str:
    """How it went, where the table is, and the lines that open it."""
    pending = sweep.size - sweep.done - sweep.failed
    waiting = f", {pending} pending" if pending else ""
    lines = [f"{counted(sweep.size, 'task')}: {sweep.done} done, {sweep.failed} failed{waiting}"]
    errors = list(sweep.errors.items())
    lines += [f"failed: task {number}: {error}" for number, error in errors[:_MOST_ERRORS]]
    if len(errors) > _MOST_ERRORS:
        lines.append(f"failed: {len(errors) - _MOST_ERRORS} more; the column 'error' of the table tells why")
    if sweep.interrupted:
        lines.append("interrupted: what is done is kept; the same command goes on from there")
    lines += [f"table: {shlex.quote(str(sweep.folder / TABLE))}", "  import granular_env as ge"]
    return "\n".join([*lines, f"  sweep = ge.open_sweep({str(sweep.folder)!r})      # .table for pandas, .dataset for xarray"])
