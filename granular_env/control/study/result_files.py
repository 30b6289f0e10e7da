"""The files of a study's results: results.json, curves.csv, the figures and report.html."""

from __future__ import annotations

import csv
import io
import json
from typing import Any

from granular_env.components.errors import ExperimentError
from granular_env.output_files import write_files

from .results import StudyResult, Trial
from .study import VERSION


def write_results(result: StudyResult) -> None:
    """Write ``results.json``, ``curves.csv``, the figures and ``report.html``; all of them, or none."""
    from . import figures, report

    pictures = figures.pictures(result)
    contents = {
        "results.json": json.dumps(as_json(result), indent=2, allow_nan=False).encode("utf-8"),
        "curves.csv": curves(result).encode("utf-8"),
        "report.html": report.page_of(result, pictures).encode("utf-8"),
        **{f"{name}.png": picture.png for name, picture in pictures.items()},
    }
    write_files({result.folder / name: data for name, data in contents.items()}, ExperimentError)


def as_json(result: StudyResult) -> dict[str, Any]:
    """Return the results in plain values; the same study gives the same."""
    return {
        "version": VERSION,
        "study": result.study.to_dict(),
        "identity": result.study.identity,
        "gradient_runs": result.gradient_runs,
        "interrupted": result.interrupted,
        "baselines": {name: {"return": score.value, "spread": score.spread} for name, score in result.baselines.items()},
        "trials": [_trial(trial, result) for trial in result.trials],
    }


def _trial(trial: Trial, result: StudyResult) -> dict[str, Any]:
    score = trial.score
    return {
        "method": trial.label,
        "seed": trial.seed,
        "return": None if score is None else score.value,
        "spread": None if score is None else score.spread,
        "search_return": trial.record.best_return if trial.record.best else None,
        "control_steps": trial.record.spent,
        "evaluations": len(trial.record),
        "finished": trial.record.finished,
        "failure": trial.failure,
        "beats": {} if score is None else {name: score.value > other.value for name, other in result.baselines.items()},
        "counters": {} if score is None else dict(score.episode.counters),
        "log": None if trial.log is None else str(trial.log.relative_to(result.folder)),
    }


def curves(result: StudyResult) -> str:
    """CSV: of every trial, the best return against the control steps simulated; a line for each improvement and the end."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["method", "seed", "control_steps", "best_return"])
    for trial in result.trials:
        spent, best = trial.record.curve()
        for place in range(len(best)):
            if place == 0 or place == len(best) - 1 or best[place] > best[place - 1]:
                writer.writerow([trial.label, trial.seed, int(spent[place]), repr(float(best[place]))])
    return text.getvalue()
