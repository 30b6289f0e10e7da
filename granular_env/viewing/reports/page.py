"""The report of a run: a self-contained HTML page, and its pictures as PNG files."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from granular_env.output_files import count_text, require_writable, size_text, write_files
from granular_env.progress import Progress, progress_bar

from ..figures import drawing
from ..figures.html_film import make_film
from ..html_page import parts, render_page
from ..scene_builder import require_log
from ..scene_data import SceneData
from . import tables
from .figures import CaptionedFigure, ReportChoice, draw_report

_FILM_WORDS = "Film of the run: choose an instant on the time axis below (arrow keys step through the instants), or play."


def report(
    log: Any,
    folder: str | os.PathLike[str],
    times: Sequence[float] | None = None,
    indices: Sequence[int] | None = None,
    variables: Sequence[str] | None = None,
    progress: Progress = False,
) -> Path:
    """Write ``report.html`` and the PNG files of its figures.

        ge.viewing.report(log, "piston", variables=["contact_force"], indices=[10, 20], times=[1e-4, 2e-4])

    The page embeds its pictures and style, runs no script, and forbids network access by a policy. Text from the log is
    escaped. The page follows the light or dark theme of the reader's system.

    Args:
        log: an open log, of any component.
        folder: target folder; it is created if necessary.
        times: times of the profiles [s]; default: four, evenly spaced.
        indices: elements of the histories; default: up to five that changed.
        variables: recorded outputs to show; default: all. Arrays get x-t diagrams and histories, scalars curves.
        progress: show a bar, or call this with the completed fraction.

    Returns:
        The path of the page.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ParameterError: a variable, time or index that the log does not contain, or `folder` is a file; nothing is written.
        GranularError: the files cannot be written; none is written.
    """
    require_log(log)
    target = Path(folder) / "report.html"
    require_writable(target)
    choice = ReportChoice(variables, times, indices)
    with progress_bar(f"report in {target.parent.name}", show=progress) as bar:
        scene_data, drawn = draw_report(log, choice, bar.update)
        sections = _sections(log, scene_data, drawn)
        if choice.variables is None and choice.times is None and (film := make_film(log, scene_data)) is not None:
            words = " ".join(one for one in (_FILM_WORDS, film.stretch, scene_data.remark) if one)
            sections = [("Film", parts.film(film, words)), *sections]
        html = render_page(f"Run report: {scene_data.title}", _lead_paragraphs(log, scene_data), sections)
        pictures = {target.parent / f"{name}.png": drawing.to_png(shown.figure) for name, shown in drawn.items()}
        write_files({**pictures, target: html.encode("utf-8", "replace")})
        bar.update(1.0)
    return target


def _sections(log: Any, scene_data: SceneData, drawn: Mapping[str, CaptionedFigure]) -> list[tuple[str, Markup]]:
    """Return the heading and HTML of each section."""
    shown = {name: (one.heading, parts.picture(drawing.to_svg(one.figure, name), one.words)) for name, one in drawn.items()}
    balances = Markup().join(shown.pop(name)[1] for name in list(shown) if name.startswith("balance-"))
    inputs = Markup().join(shown.pop(name)[1] for name in list(shown) if shown[name][0] == "Inputs")
    happened = shown.pop("events")[1] if "events" in shown else Markup()
    sections = [
        *shown.values(),
        ("Inputs", inputs),
        ("Balances", tables.balance_table(scene_data) + balances),
        ("Events", happened + tables.event_section(log)),
        ("Validity", tables.validity_section(log)),
        ("Parameters", tables.parameter_table(log)),
        ("Experiment", tables.experiment_section(log)),
        ("Environment", tables.environment_table(log)),
        ("Replay it", tables.replay_commands(log)),
    ]
    return [(heading, content) for heading, content in sections if content]


def _lead_paragraphs(log: Any, scene_data: SceneData) -> Markup:
    """Return the paragraphs at the top of the report: description of the experiment, length of the run, and notes."""
    metadata = log.metadata
    experiment = metadata.get("experiment") if isinstance(metadata.get("experiment"), dict) else {}
    scale, unit = drawing.time_unit(log.duration)
    calls = count_text(log.calls, "call")
    what = f"{log.duration * scale:.6g} {unit} of component {metadata.get('component')}, {calls} of step()"
    lead = [parts.paragraph(experiment["description"])] if experiment.get("description") else []
    lead += [parts.paragraph(f"From: {experiment['source']}", "dim")] if experiment.get("source") else []
    size = size_text(os.path.getsize(log.path))
    lead.append(parts.paragraph(f"{what}; recorded {metadata.get('created')}; {size}.", "dim"))
    if concluded := metadata.get("conclusions"):
        lead.append(parts.bullets(concluded))
    if notes := [*tables.incident_sentences(log), *scene_data.notes]:
        lead.append(parts.bullets(notes, "cautions"))
    return Markup().join(lead)
