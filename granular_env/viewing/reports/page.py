"""The report of a run: a self-contained HTML page, and its figures as files."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from granular_env.components.errors import ParameterError
from granular_env.output_files import count_text, require_writable, size_text, valid_file_name, write_files
from granular_env.progress import Progress, progress_bar
from granular_env.recording.header import header_table

from ..figures import drawing
from ..figures.html_film import make_film
from ..html_page import Page, page_template, parts
from ..scene_builder import require_log
from ..scene_data import SceneData
from . import tables
from .figures import CaptionedFigure, ReportChoice, draw_report

# Formats of figures, each with the entry of its metadata that is omitted: the date or the program.
FORMATS = {"png": "Software", "svg": "Date", "pdf": "CreationDate"}
_FILM_WORDS = "Film of the run: choose an instant on the time axis below (arrow keys step through the instants), or play."


def report(
    log: Any,
    folder: str | os.PathLike[str],
    times: Sequence[float] | None = None,
    indices: Sequence[int] | None = None,
    variables: Sequence[str] | None = None,
    progress: Progress = False,
    file_format: str = "png",
) -> Path:
    """Write ``report.html`` and its figures as files; both replace an earlier report in the folder.

        ge.viewing.report(log, "piston", variables=["contact_force"], indices=[10, 20], times=[1e-4, 2e-4])

    The page embeds its pictures and style, runs no script, forbids network access, and is light or dark with your system.

    Args:
        log: an open log, of any component.
        folder: target folder; it is created if necessary.
        times: times of the profiles [s]; default: four, evenly spaced.
        indices: elements of the histories; default: up to five that changed.
        variables: recorded outputs to show; default: all. Arrays get x-t diagrams and histories, scalars curves.
        progress: show a bar, or call this with the completed fraction.
        file_format: format of the figures' files: "png", "svg" or "pdf".

    Returns:
        The path of the page.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ParameterError: a variable, time or index that the log does not contain, another format, or `folder` is a file; nothing
            is written.
        GranularError: the files cannot be written; none is written.
    """
    require_log(log)
    target = Path(folder) / "report.html"
    require_page(target, file_format)
    choice = ReportChoice(variables, times, indices)
    with progress_bar(f"report in {target.parent.name}", show=progress) as bar:
        scene_data, drawn, omissions = draw_report(log, choice, bar.update)
        sections = _sections(log, scene_data, drawn, omissions)
        if choice.variables is None and (film := make_film(log, scene_data)) is not None:
            words = " ".join(one for one in (_FILM_WORDS, scene_data.remark) if one)
            sections = [("Film", parts.film(film, words)), *sections]
        page = Page(f"Run report: {scene_data.title}", _lead_paragraphs(log, scene_data), sections)
        write_page(target, page, drawn, file_format)
        bar.update(1.0)
    return target


def require_page(target: Path, file_format: str) -> None:
    """Raise an error if the page `target` cannot be written, or figures have no such format."""
    require_writable(target)
    if file_format not in FORMATS:
        raise ParameterError(f"got {file_format!r}", expected=f"one of {', '.join(FORMATS)}", at="file_format")


def write_page(target: Path, page: Page, drawn: Mapping[str, CaptionedFigure], file_format: str) -> None:
    """Write a page and its figures as files next to it, and delete further figures of an earlier page at the same path."""
    contents = {}
    for name, one in drawn.items():
        buffer = io.BytesIO()
        one.figure.savefig(buffer, format=file_format, dpi=130, metadata={FORMATS[file_format]: None})
        # Names of figures contain names from the log, which may contain any characters.
        contents[f"{valid_file_name(name, 'figure')}.{file_format}"] = buffer.getvalue()
    before = target.read_text("utf-8", "replace") if target.exists() else ""
    html = page_template.render(page=page, files=contents).encode("utf-8", "replace")
    write_files({**{target.parent / name: data for name, data in contents.items()}, target: html})
    for name in re.findall(r"[^ /]+", "".join(re.findall(r'<meta name="figures" content="(.*?)">', before)[:1])):
        if name not in contents and Path(name).suffix[1:] in FORMATS:
            (target.parent / name).unlink(missing_ok=True)


def figure_sections(drawn: Mapping[str, CaptionedFigure]) -> dict[str, Markup]:
    """Return the HTML of the figures by heading."""
    found: dict[str, Markup] = {}
    for name, one in drawn.items():
        picture = parts.picture(drawing.to_svg(one.figure, name), one.words.replace("`", ""))
        found[one.heading] = found.get(one.heading, Markup()) + picture
    return found


def _sections(
    log: Any, scene_data: SceneData, drawn: Mapping[str, CaptionedFigure], omissions: Sequence[str]
) -> list[tuple[str, Markup]]:
    """Return the heading and HTML of each section."""
    shown = figure_sections(drawn)
    inputs, balances, happened = (shown.pop(heading, Markup()) for heading in ("Inputs", "Balances", "Events"))
    sections = [
        *shown.items(),
        ("Outputs without a figure", Markup().join(map(parts.paragraph, omissions))),
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
    """Return the paragraphs at the top of the report: conclusions, cautions, notes, and description and length of the run."""
    metadata, lead = log.metadata, Markup()
    experiment = header_table(metadata.get("experiment"))
    notes = [*tables.incident_sentences(log), *metadata["cautions"], *scene_data.notes]
    for sentences, style in ((metadata.get("conclusions"), ""), (notes, "cautions")):
        lead += parts.bullets(sentences, style) if sentences else ""
    scale, unit = drawing.time_unit(log.duration)
    what = f"{log.duration * scale:.6g} {unit} of component {metadata['component']}, {count_text(log.calls, 'call')} of step()"
    size = f"{what}; recorded {metadata.get('created')}; {size_text(os.path.getsize(log.path))}."
    source = f"From: {experiment['source']}" if experiment.get("source") else ""
    for text, style in ((experiment.get("description"), ""), (source, "dim"), (size, "dim")):
        lead += parts.paragraph(text, style) if text else ""
    return lead
