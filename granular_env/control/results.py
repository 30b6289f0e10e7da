"""The results of a study: its trials (one method with one seed), each in a file, and a table of all trials."""

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
from granular_env.components.support.html_summary import html_summary
from granular_env.envs.policies import Policy
from granular_env.output_files import replace_file

from .problem import Problem
from .study import Study

TABLE, FIGURE = "table.csv", "figure.png"


class Score(BaseModel):
    """The returns of a policy in the test episodes.

    Attributes:
        value: the return, averaged over the test episodes.
        spread: standard deviation over the test episodes; 0 for a single one.
        actions: actions in the first test episode, shape (control steps, entries).
        duration: duration of a control step [s].
    """

    value: float
    spread: float
    actions: list[list[float]]
    duration: float

    @classmethod
    def from_episodes(cls, actor: Policy, problem: Problem, study: Study, log: Path | None = None) -> Self:
        """Return the score of a policy played in the test episodes; record the first episode if the path of a log is given."""
        episodes = [problem.play_episode(actor, seed, None if place else log) for place, seed in enumerate(study.test_seeds)]
        values, actions = np.array([value for value, _ in episodes]), episodes[0][1].tolist()
        return cls(value=float(values.mean()), spread=float(values.std()), actions=actions, duration=problem.duration)


class Trial(BaseModel):
    """A finished trial of one method with one seed: the content of ``trials/METHOD-SEED.json``.

    Attributes:
        identity: hash of everything that determines the trial, see `Study.trial_identity`.
        spent: number of simulated control steps.
        search_return: return of the best drive or policy in the search episodes.
        curve: (simulated control steps, best return) at each improvement of the best return.
        score: score of the best drive or policy in the test episodes.
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
        """Return the name of the trial's files without their extension."""
        return f"{self.method}-{self.seed}"


def read_trial(path: Path, identity: str) -> Trial | None:
    """Return the trial in a file, or None if there is none or it belongs to another study or program version."""
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
        folder: folder of the study's files.
        trials: one per method and seed, in the order of the study's file, without failed or interrupted trials.
        baselines: scores of the reference policies, by name.
        interrupted: whether Ctrl-C ended the study; the same command continues it.
        notes: texts of the warnings issued during the trials.
    """

    study: Study
    folder: Path
    trials: list[Trial]
    baselines: dict[str, Score]
    interrupted: bool
    notes: list[str]

    def method_trials(self, method: str) -> list[Trial]:
        """Return the trials of a method, best first."""
        return sorted((trial for trial in self.trials if trial.method == method), key=lambda trial: -trial.score.value)

    def comparison(self) -> list[list[object]]:
        """Return the headings and one row per method: its returns over the seeds, and whether it beats each baseline.

        A method beats a baseline if its median return over the seeds (the lower of two middle ones) is larger.
        """
        heads = ["method", "return (lower median)", "worst seed", "best seed", "control steps"]
        rows: list[list[object]] = [[*heads, *(f"beats {name}" for name in self.baselines)]]
        for method in dict.fromkeys(trial.method for trial in self.trials):
            trials = self.method_trials(method)
            values = [trial.score.value for trial in trials]
            middle = statistics.median_low(values)
            beaten = ["yes" if middle > score.value else "no" for score in self.baselines.values()]
            rows.append([method, middle, values[-1], values[0], max(trial.spent for trial in trials), *beaten])
        return rows

    def _repr_html_(self) -> str:
        heads, *rows = self.comparison()
        facts = {"folder": str(self.folder), "notes": self.notes}
        return html_summary(f"study {self.study.name}", facts, [*map(str, heads)], rows)

    def write_files(self) -> None:
        """Write the table (one row per trial and baseline) and the figure."""
        from .figure import draw_study

        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["method", "seed", "return", "spread", "search_return", "control_steps"])
        for one in self.trials:
            score = one.score
            writer.writerow([one.method, one.seed, score.value, score.spread, one.search_return, one.spent])
        for name, score in self.baselines.items():
            writer.writerow([f"baseline {name}", "", score.value, score.spread, "", ""])
        with replace_file(self.folder / TABLE, ExperimentError) as part:
            part.write_text(text.getvalue())
        if self.trials:
            with replace_file(self.folder / FIGURE, ExperimentError) as part:
                part.write_bytes(draw_study(self))
