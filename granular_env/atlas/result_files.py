"""The files of an atlas: the page, the data, and no logs of an earlier one."""

from __future__ import annotations

import json
import math
import os
import shlex
from pathlib import Path
from typing import Any

import numpy as np

from granular_env.output_files import write_files

from .computation import Atlas, Done
from .finished_runs import FinishedRuns
from .folder import DATA, PAGE, logs_of_data, remove_logs
from .model import Arrows, Curve, Figure, Item, Shading, Table
from .page import html
from .verdicts import Value


def write(atlas: Atlas, folder: str | os.PathLike[str]) -> Path:
    """Write ``index.html`` and ``atlas.json``, and remove logs that only an earlier atlas in this folder names.

    Returns:
        The page's path.

    Raises:
        GranularError: the files cannot be written, or an `atlas.json` stands there that is not an atlas's; what stood there
            is kept.
    """
    target = Path(folder)
    data = document(atlas)
    numbers = json.dumps(data, indent=1, allow_nan=False, ensure_ascii=False) + "\n"
    finished = FinishedRuns(target)
    old = logs_of_data(target / DATA) | finished.names()
    write_files({target / DATA: numbers.encode(), target / PAGE: html(atlas, command(atlas)).encode()})
    remove_logs(target, old - set(data["logs"]))
    finished.keep(data["logs"])
    return target / PAGE


def command(atlas: Atlas) -> str:
    """Return the command line that makes this atlas."""
    changed = [
        f" --set {shlex.quote(f'{name}={atlas.constants[name]!r}')}"
        for name, constant in atlas.paper.constants.items()
        if atlas.constants[name] != constant.value
    ]
    return f"granular-env atlas {atlas.paper.name} --out FOLDER{''.join(changed)}"


def document(atlas: Atlas) -> dict[str, Any]:
    """Everything that was computed, as plain values; the same run gives the same document."""
    paper = atlas.paper
    return {
        "paper": paper.name,
        "title": paper.title,
        "citation": paper.citation,
        "constants": dict(atlas.constants),
        "command": command(atlas),
        "logs": sorted({name for done in atlas.done for name in done.logs}),
        "entries": [_entry(done) for done in atlas.done],
    }


def _entry(done: Done) -> dict[str, Any]:
    entry = done.entry
    return {
        "name": entry.name,
        "section": entry.section,
        "title": entry.title,
        "error": done.error,
        "items": [_item(item) for item in done.findings.items],
        "figures": [_figure(figure) for figure in done.findings.figures],
        "tables": [_table(table) for table in done.findings.tables],
        "logs": [f"logs/{name}" for name in done.logs],
    }


def _item(item: Item) -> dict[str, Any]:
    return {
        "name": item.name,
        "where": item.where,
        "verdict": item.verdict.kind,
        "words": item.verdict.words,
        "values": [_value(value) for value in item.values],
        "remark": item.remark,
        "reason": item.reason if item.unmet else "",
    }


def _value(value: Value) -> dict[str, Any]:
    found: dict[str, Any] = {
        "label": value.label,
        "unit": value.unit,
        "printed": value.printed,
        "paper": value.number,
        "computed": value.display_value if isinstance(value.display_value, str) else _number(value.display_value),
        "below_resolution": value.below_resolution,
        "tolerance": None if value.printed is None or isinstance(value.computed, str) else value.largest_difference,
        "source": value.source,
        "in_part": value.loose,
        "reading": value.reading,
        "verdict": value.verdict.kind,
    }
    if value.band is not None:
        band = value.band
        found["band"] = {
            "mean": band.mean,
            "sd": band.deviation,
            "p5": band.quantile(5),
            "p95": band.quantile(95),
            "draws": list(band.draws),
            "percentile": None if value.number is None else band.percentile(value.number),
        }
    return found


def _figure(figure: Figure) -> dict[str, Any]:
    found: dict[str, Any] = {
        "name": figure.name,
        "title": figure.title,
        "caption": figure.caption,
        "x": figure.x.label,
        "y": figure.y.label,
        "curves": [_curve(curve) for curve in figure.curves],
        "marks": [{"label": mark.label, "x": mark.x, "y": mark.y} for mark in figure.marks],
    }
    if figure.shading is not None:
        found["shading"] = {"label": figure.shading.label, **_arrays(figure.shading, "x", "y", "values")}
    if figure.arrows is not None:
        found["arrows"] = {"label": figure.arrows.label, **_arrays(figure.arrows, "x", "y", "u", "v")}
    if figure.letters:
        found["letters"] = [{"text": letter.text, "x": letter.x, "y": letter.y} for letter in figure.letters]
    return found


def _table(table: Table) -> dict[str, Any]:
    rows = [dict(zip(table.head, row, strict=True)) for row in table.rows]
    return {"name": table.name, "title": table.title, "caption": table.caption, "rows": rows}


def _arrays(part: Shading | Arrows, *names: str) -> dict[str, str]:
    """Return arrays of a plane, each in one string: numbers with blanks between, rows with line ends between.

    In lists each number would have a line of its own, and there are tens of thousands. Four digits are finer than a shade.
    """
    found: dict[str, str] = {}
    for name in names:
        rows = np.atleast_2d(np.asarray(getattr(part, name), dtype=np.float64))
        found[name] = "\n".join(" ".join(f"{value:.4g}" for value in row) for row in rows.tolist())
    return found


def _curve(curve: Curve) -> dict[str, Any]:
    x, y = ([_number(value) for value in values.tolist()] for values in curve.points())
    return {"label": curve.label, "style": curve.style, "x": x, "y": y}


def _number(value: float) -> float | None:
    """JSON has no NaN; nine digits are more than a drawing or a comparison needs. What is counted stays whole."""
    if isinstance(value, int):
        return value
    return float(f"{value:.9g}") if math.isfinite(value) else None
