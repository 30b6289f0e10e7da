"""A report of a run: one HTML page that needs nothing else, and its pictures as PNG files."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from granular_env.components.errors import ParameterError
from granular_env.output_files import require_writable, write_files
from granular_env.progress import Progress, progress_bar

from .. import html_page
from ..figures import drawing
from ..figures.html_film import film_of
from ..scene_data import SceneData
from . import tables
from .figures import Choice, Shown, draw_report

_PAGE = "report.html"
_FILM_WORDS = "The run as a film: choose an instant on the time axis below (the arrow keys go through them), or play."
# Parts of the work that are done when the log is read, and when the pictures are drawn.
_READING, _DRAWING = 0.6, 0.85


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

    The page carries its pictures and its style, runs no script and is forbidden the network by its own policy; text from
    the log is escaped. It is light or dark with the reader's system.

    Args:
        log: an open log, of any component.
        folder: where to; made if it is not there.
        times: instants of the profiles [s]; default: four, evenly spaced.
        indices: of which elements the histories are drawn; default: up to five that changed.
        variables: recorded outputs to show; default: all. Arrays get x-t diagrams and histories, scalars curves.
        progress: show a bar, or call this with the part that is done.

    Returns:
        The path of the page.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ParameterError: a variable, an instant or an index that the log does not have, or `folder` is a file; nothing is
            written.
        GranularError: the files cannot be written; then none of them is.
    """
    if not hasattr(log, "metadata") or not hasattr(log, "variables"):
        raise ParameterError(f"got {type(log).__name__}", expected="an open log: open_log(path)", at="log")
    target = _target(folder)
    with progress_bar(f"report in {target.parent.name}", show=progress) as bar:
        return _write(log, target, Choice(variables, times, indices), bar.update)


def _write(log: Any, target: Path, choice: Choice, tell: Callable[[float], None]) -> Path:
    scene_data, drawn = draw_report(log, choice, lambda part: tell(_READING * part))
    files = {}
    for name, shown in drawn.items():
        files[target.parent / f"{name}.png"] = drawing.png(shown.figure)
        tell(_READING + (_DRAWING - _READING) * len(files) / len(drawn))
    sections = _sections(log, scene_data, drawn)
    if choice.variables is None and choice.times is None:
        film = film_of(log, scene_data, lambda part: tell(_DRAWING + (1.0 - _DRAWING) * part))
        if film is not None:
            stretch = f"{film.stretch.capitalize()}." if film.stretch else ""
            words = " ".join(one for one in (_FILM_WORDS, stretch, scene_data.remark) if one)
            sections = [("Film", html_page.film(film, words)), *sections]
    html = html_page.page(f"Run report: {scene_data.title}", _lead(log, scene_data), sections)
    write_files({**files, target: html.encode("utf-8", "replace")})
    tell(1.0)
    return target


def _target(folder: Any) -> Path:
    """Return the path of the page; refuse what cannot be written before there is anything to write."""
    try:
        name = os.fsdecode(folder)
    except TypeError:
        raise ParameterError(f"got {folder!r}", expected="the path of a folder", at="folder") from None
    if os.path.lexists(name) and not os.path.isdir(name):
        raise ParameterError(
            f"{name!r} is a file", expected="a folder", hint="the report's pages and pictures go into it", at="folder"
        )
    require_writable(Path(name) / _PAGE)
    return Path(name) / _PAGE


def _sections(log: Any, scene_data: SceneData, drawn: Mapping[str, Shown]) -> list[tuple[str, Markup]]:
    """Return heading and HTML of each section."""
    shown = {name: (one.heading, html_page.picture(drawing.svg(one.figure, name), one.words)) for name, one in drawn.items()}
    balances = Markup().join(shown.pop(name)[1] for name in list(shown) if name.startswith("balance-"))
    inputs = Markup().join(shown.pop(name)[1] for name in list(shown) if shown[name][0] == "Inputs")
    happened = shown.pop("events")[1] if "events" in shown else Markup()
    sections = [
        *shown.values(),
        ("Inputs", inputs),
        ("Balances", tables.balances(scene_data) + balances),
        ("Events", happened + tables.events(log)),
        ("Validity", tables.validity(log)),
        ("Parameters", tables.parameters(log)),
        ("Experiment", tables.experiment(log)),
        ("Environment", tables.environment(log)),
        ("Replay it", tables.replay(log)),
    ]
    return [(heading, content) for heading, content in sections if content]


def _lead(log: Any, scene_data: SceneData) -> Markup:
    """Return what the experiment is, how long the run was, and what its reader should know first."""
    scale, unit = drawing.time_unit(log.duration)
    metadata = log.metadata
    calls = "1 call" if log.calls == 1 else f"{log.calls} calls"
    what = f"{log.duration * scale:.6g} {unit} of component {metadata.get('component')}, in {calls} of step()"
    size = tables.file_size(os.path.getsize(log.path))
    experiment = metadata.get("experiment")
    described = experiment if isinstance(experiment, dict) else {}
    words = [html_page.paragraph(described[key]) for key in ("description",) if described.get(key)]
    words += [html_page.paragraph(f"From: {described['source']}", "dim")] if described.get("source") else []
    words.append(html_page.paragraph(f"{what}; recorded {metadata.get('created')}; {size}.", "dim"))
    if concluded := metadata.get("conclusions"):
        words.append(html_page.bullets([str(text) for text in concluded]))
    notes = [*tables.incident_sentences(log), *scene_data.notes]
    return Markup().join([*words, *([html_page.bullets(notes, "cautions")] if notes else [])])
