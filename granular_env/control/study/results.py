"""The results of a study as data: its trials, their scores, and those of the baselines."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path

from granular_env.components.errors import Fault

from ..problem import Episode
from .study import Study
from .trial_record import TrialRecord


@dataclasses.dataclass(frozen=True)
class Score:
    """The returns of an actor in the test episodes.

    Attributes:
        value: the return, averaged over the test episodes.
        spread: standard deviation over them; 0 for one.
        episode: the first of them.
    """

    value: float
    spread: float
    episode: Episode


@dataclasses.dataclass(frozen=True)
class Trial:
    """One method with one seed.

    Attributes:
        label: the method's name.
        seed: its seed.
        record: everything that it evaluated.
        score: of its best; None where it found none.
        log: the recorded episode of its best, or None.
        faults: why it ended early; none where it did not.
    """

    label: str
    seed: int
    record: TrialRecord
    score: Score | None
    log: Path | None
    faults: tuple[Fault, ...] = ()

    @property
    def failure(self) -> str:
        """Why it ended early, in words, or ""."""
        return "\n".join(map(str, self.faults))

    @property
    def name(self) -> str:
        """Return the name that files of it have."""
        return f"{self.label}-{self.seed}"


@dataclasses.dataclass(frozen=True)
class StudyResult:
    """The result of a study.

    Attributes:
        study: what was run.
        folder: where its files are.
        trials: one for each method and seed, in the file's order.
        baselines: what they are compared with, by name.
        gradient_runs: what slopes cost, in forward runs.
        interrupted: whether Ctrl-C ended it; the same command goes on from there.
        warnings: trials whose slopes are all 0, then what the runs warned of, each sentence once.
    """

    study: Study
    folder: Path
    trials: list[Trial]
    baselines: Mapping[str, Score]
    gradient_runs: float
    interrupted: bool
    warnings: list[str]

    def baseline(self, name: str) -> float | None:
        """Return a baseline's return, or None where the task has no such baseline."""
        return self.baselines[name].value if name in self.baselines else None

    def labels(self) -> list[str]:
        """Return the methods' names, in the file's order."""
        return list(dict.fromkeys(trial.label for trial in self.trials))

    def of(self, label: str) -> list[Trial]:
        """Return the trials of a method that found something, the best first."""
        found = [trial for trial in self.trials if trial.label == label and trial.score is not None]
        return sorted(found, key=lambda trial: -trial.score.value if trial.score else 0.0)
