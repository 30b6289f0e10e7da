"""Messages of the command line while a study runs, and after it."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from granular_env.progress import Bar, Progress, ProgressBars
from granular_env.terminal_text import table

from .method_comparison import headings, verdicts
from .results import StudyResult
from .study import Study

_MOST_NOTES = 3

Notify = Callable[[str, int, float], None]
"""Called with a trial's name, the control steps it has simulated, and the best return so far."""


@contextmanager
def trial_progress(study: Study, trials_of_all: int, progress: Progress) -> Iterator[Notify]:
    """Show a progress bar for every trial: control steps simulated, and the best return so far."""
    with ProgressBars(progress, study.budget * trials_of_all, keep=True) as bars:
        trials: dict[str, Bar] = {}

        def notify(trial: str, spent: int, best: float) -> None:
            if trial not in trials:
                trials[trial] = bars.add(trial, study.budget)
            trials[trial].update(spent, f"best {best:.6g}" if best > float("-inf") else "")

        yield notify


def closing(result: StudyResult) -> str:
    """Say how it went: the comparison as a table, and where everything is."""
    rows = [headings(result), *verdicts(result)]
    lines = [table([[f"{cell:.6g}" if isinstance(cell, float) else str(cell) for cell in row] for row in rows])]
    if result.baselines:
        lines.append("baselines: " + ", ".join(f"{name} {score.value:.6g}" for name, score in result.baselines.items()))
    lines += [f"note: {text}" for text in result.warnings[:_MOST_NOTES]]
    if result.interrupted:
        lines.append("interrupted: these are the results so far; the same command goes on from there")
    lines.append(f"page: {shlex.quote(str(result.folder / 'report.html'))}")
    lines.append(f"logs: {shlex.quote(str(result.folder / 'logs'))}")
    return "\n".join(lines)
