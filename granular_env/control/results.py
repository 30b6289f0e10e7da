"""The results of a study: trials, one file each, and one table of them."""

from __future__ import annotations

import csv
import dataclasses
import io
import statistics
from pathlib import Path
from typing import Self

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError

from granular_env.components.errors import ExperimentError
from granular_env.envs.policies import Policy
from granular_env.output_files import replacing

from .problem import Problem
from .study import Study

TABLE, FIGURE = "table.csv", "figure.png"


class Score(BaseModel):
    """The returns of an actor in the test episodes.

    Attributes:
        value: the return, averaged over the test episodes.
        spread: standard deviation over them; 0 for one.
        actions: of the first of them, shape (control steps, entries).
        duration: of a control step [s].
    """

    value: float
    spread: float
    actions: list[list[float]]
    duration: float

    @classmethod
    def of(cls, actor: Policy, problem: Problem, study: Study, log: Path | None = None) -> Self:
        """Play an actor in the test episodes; the first is recorded where a path is given."""
        episodes = [problem.play(actor, seed, None if place else log) for place, seed in enumerate(study.test_seeds)]
        values, actions = np.array([value for value, _ in episodes]), episodes[0][1].tolist()
        return cls(value=float(values.mean()), spread=float(values.std()), actions=actions, duration=problem.duration)


class Trial(BaseModel):
    """One method with one seed, finished: the content of ``trials/METHOD-SEED.json``.

    Attributes:
        identity: hash of everything that decides it.
        spent: control steps simulated.
        search_return: of its best, in the episodes of the search.
        curve: (control steps, best return) at each improvement.
        score: of its best.
    """

    model_config = ConfigDict(frozen=True)

    identity: str
    method: str
    seed: int
    spent: int
    search_return: float
    curve: list[tuple[int, float]]
    score: Score

    @property
    def name(self) -> str:
        """Return the name of its files."""
        return f"{self.method}-{self.seed}"


def read_trial(path: Path, identity: str) -> Trial | None:
    """Return the trial of a file; None where there is none, or that of another study or program."""
    try:
        found = Trial.model_validate_json(path.read_bytes())
    except (OSError, ValidationError):
        return None
    return found if found.identity == identity else None


@dataclasses.dataclass
class StudyResult:
    """The result of a study.

    Attributes:
        study: the study.
        folder: of its files.
        trials: one for each method and seed, in the file's order; without those that failed or were interrupted.
        baselines: agents to compare with, by name.
        interrupted: whether Ctrl-C ended it; the same command continues.
        notes: the warnings of the runs.
    """

    study: Study
    folder: Path
    trials: list[Trial]
    baselines: dict[str, Score]
    interrupted: bool
    notes: list[str]

    def of(self, method: str) -> list[Trial]:
        """Return the trials of a method, the best first."""
        return sorted((trial for trial in self.trials if trial.method == method), key=lambda trial: -trial.score.value)

    def comparison(self) -> list[list[object]]:
        """Return headings, and a row for every method: its returns over the seeds, and the baselines that it beats.

        The lower median, of two seeds the worse one, decides what a method beats.
        """
        heads = ["method", "return (lower median)", "worst seed", "best seed", "control steps"]
        rows: list[list[object]] = [[*heads, *(f"beats {name}" for name in self.baselines)]]
        for method in dict.fromkeys(trial.method for trial in self.trials):
            trials = self.of(method)
            values = [trial.score.value for trial in trials]
            middle = statistics.median_low(values)
            beaten = ["yes" if middle > score.value else "no" for score in self.baselines.values()]
            rows.append([method, middle, values[-1], values[0], max(trial.spent for trial in trials), *beaten])
        return rows

    def write(self) -> None:
        """Write the table, a row for each trial and each baseline, and the figure."""
        from .figure import draw_study

        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["method", "seed", "return", "spread", "search_return", "control_steps"])
        for one in self.trials:
            score = one.score
            writer.writerow([one.method, one.seed, score.value, score.spread, one.search_return, one.spent])
        for name, score in self.baselines.items():
            writer.writerow([f"baseline {name}", "", score.value, score.spread, "", ""])
        with replacing(self.folder / TABLE, ExperimentError) as part:
            part.write_text(text.getvalue())
        if self.trials:
            with replacing(self.folder / FIGURE, ExperimentError) as part:
                part.write_bytes(draw_study(self))
