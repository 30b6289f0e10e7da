"""The page of a study."""

from __future__ import annotations

import shlex
from collections.abc import Mapping

from markupsafe import Markup

from granular_env.documents import to_toml
from granular_env.output_files import count_of
from granular_env.viewing import html_page

from .figures import Picture
from .method_comparison import headings, verdicts
from .results import StudyResult


def page_of(result: StudyResult, pictures: Mapping[str, Picture]) -> str:
    """One HTML page that needs nothing else; text of the study is escaped, the network is forbidden."""
    shown = {name: html_page.picture(picture.svg, picture.words) for name, picture in pictures.items()}
    sections = [("Comparison", _comparison(result) + shown.pop("convergence", Markup()))]
    if "drives" in shown:
        sections.append(("Drives", shown.pop("drives")))
    if shown:
        sections.append(("Final state", Markup().join(shown.values())))
    sections += [("Trials", _trials(result)), ("Study", html_page.preformatted(to_toml(result.study.to_dict())))]
    return html_page.page(f"Study: {result.study.name}", _lead(result), sections)


def _lead(result: StudyResult) -> Markup:
    study = result.study
    notes = [f"{trial.name} ended early: {trial.failure}" for trial in result.trials if trial.failure]
    if result.interrupted:
        notes.append("The study was interrupted: these are the results so far. The same command goes on from there.")
    words = html_page.paragraph(study.description) if study.description else Markup()
    words += html_page.paragraph(f"Task {study.task.name}; every method may simulate {study.budget:,} control steps.", "dim")
    return words + (html_page.bullets(notes, "cautions") if notes else Markup())


def _comparison(result: StudyResult) -> Markup:
    baselines = [[name, score.value, score.spread] for name, score in result.baselines.items()]
    slopes = f"An objective with its slopes counts as {result.gradient_runs:g} forward runs, and judging a drive as one more. "
    cost = (
        "Physics is counted in control steps: one control step of one environment is 1. "
        f"{slopes if result.gradient_runs else ''}"
        f"A return is the mean over {count_of(len(result.study.test_seeds), 'test episode')}; "
        "where a method ran with several seeds, the lower median decides what it beats."
    )
    return (
        html_page.table(headings(result), verdicts(result))
        + (html_page.table(["baseline", "return", "standard deviation"], baselines) if baselines else Markup())
        + html_page.paragraph(cost, "dim")
    )


def _trials(result: StudyResult) -> Markup:
    rows: list[list[object]] = []
    for trial in result.trials:
        value: object = "none" if trial.score is None else trial.score.value
        counters = {} if trial.score is None else trial.score.episode.counters
        counts = ", ".join(f"{name} = {number:.4g}" for name, number in counters.items())
        rows.append([trial.label, str(trial.seed), value, trial.record.spent, "yes" if trial.record.finished else "no", counts])
    head = ["method", "seed", "return", "control steps", "finished", "the task's numbers at the end of the first test episode"]
    commands = [f"granular-env replay {shlex.quote(str(trial.log))} --verify" for trial in result.trials if trial.log]
    return (
        html_page.table(head, rows)
        + html_page.paragraph("Every best is a log that replays:")
        + html_page.preformatted("\n".join(commands))
    )
