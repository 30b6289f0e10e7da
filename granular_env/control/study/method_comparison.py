"""The methods of a study compared, a row each: returns, and which baselines it beats."""

from __future__ import annotations

import statistics

from .results import StudyResult


def verdicts(result: StudyResult) -> list[list[object]]:
    """Return a row for every method: its lower median, least and best return over the seeds, control steps, what it beats.

    The lower median is the return of one of the trials, of two the worse one; "beats" is said of it.
    """
    rows: list[list[object]] = []
    for label in result.labels():
        trials = result.of(label)
        if not trials:
            rows.append([label, "none", "none", "none", "", *("" for _ in result.baselines)])
            continue
        values = [trial.score.value for trial in trials if trial.score is not None]
        middle = statistics.median_low(values)
        beaten = ["yes" if middle > score.value else "no" for score in result.baselines.values()]
        rows.append([label, middle, min(values), max(values), max(trial.record.spent for trial in trials), *beaten])
    return rows


def headings(result: StudyResult) -> list[str]:
    """Return the headings of the columns of `verdicts`."""
    numbers = ["return (lower median)", "worst seed", "best seed", "control steps"]
    return ["method", *numbers, *(f"beats {name}" for name in result.baselines)]
