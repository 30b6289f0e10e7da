"""What the command line says while a study runs, and after it."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from .outcome import StudyResult
from .results import heads, verdicts
from .running import Told
from .schema import Study

_MOST_NOTES = 3


@contextmanager
def telling(study: Study, quiet: bool) -> Iterator[Told]:
    """A bar on standard error for every trial: control steps simulated, and the best return so far."""
    if quiet:
        yield lambda trial, spent, best: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    if not console.is_interactive:  # where no bar can be drawn, an empty line would be all that is left of it
        yield lambda trial, spent, best: None
        return
    columns = (TextColumn("{task.description}"), BarColumn(bar_width=24), TaskProgressColumn())
    with Progress(*columns, TextColumn("{task.fields[best]}"), TimeRemainingColumn(), console=console) as bar:
        tasks: dict[str, Any] = {}

        def told(trial: str, spent: int, best: float) -> None:
            if trial not in tasks:
                tasks[trial] = bar.add_task(trial, total=study.budget, best="")
            words = f"best {best:.6g}" if best > float("-inf") else ""
            bar.update(tasks[trial], completed=spent, best=words)

        yield told


def closing(result: StudyResult) -> str:
    """How it went: the comparison as a table, and where everything is."""
    from granular_env.describe import columns

    rows = [heads(result), *verdicts(result)]
    lines = [columns([[f"{cell:.6g}" if isinstance(cell, float) else str(cell) for cell in row] for row in rows], indent="")]
    if result.baselines:
        lines.append("baselines: " + ", ".join(f"{name} {score.value:.6g}" for name, score in result.baselines.items()))
    lines += [f"note: {text}" for text in result.warnings[:_MOST_NOTES]]
    if result.interrupted:
        lines.append("interrupted: these are the results so far; the same command goes on from there")
    lines.append(f"page: {shlex.quote(str(result.folder / 'report.html'))}")
    lines.append(f"logs: {shlex.quote(str(result.folder / 'logs'))}")
    return "\n".join(lines)
