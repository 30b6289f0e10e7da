"""The page: one HTML file that needs nothing else, runs no script, and is forbidden the network."""

from __future__ import annotations

import re
import shlex
from collections import Counter
from collections.abc import Sequence
from html import escape

from .building import Atlas, Done
from .drawing import legend, svg
from .model import Figure, Item
from .style import STYLE
from .verdicts import Kind, Value

_POLICY = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"
# Kind -> class, sign, what the summary calls it. The sign tells them apart without colour.
KINDS: dict[Kind, tuple[str, str, str]] = {
    "reproduced": ("good", "✓", "reproduced"),
    "bound kept": ("kept", "≤", "bound kept"),
    "in part": ("part", "◐", "in part"),
    "as bands": ("band", "≈", "as bands over seeds"),
    "not reproduced": ("bad", "✗", "not reproduced"),
    "no figure": ("none", "·", "not in the paper"),
}
_UNIT = re.compile(r"(\d) (?=[^\W\d]|%)")
HEAD = ("Item", "Value", "Paper", "Computed", "Tolerance", "Verdict", "Remark")


def html(atlas: Atlas, command: str) -> str:
    """The whole page.

    Args:
        atlas: what was computed.
        command: how it was made, for who wants to make it again.
    """
    title = escape(f"{atlas.paper.title}: paper and computation")
    sections = "".join(_section(done) for done in atlas.done)
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{title}</title><style>{STYLE}</style></head>\n"
        f"<body>{_head(atlas, command)}{sections}</body></html>\n"
    )


def _head(atlas: Atlas, command: str) -> str:
    paper = atlas.paper
    parts = [f"<h1>{escape(paper.title)}</h1>", f'<p class="dim">{escape(paper.citation)}</p>']
    parts += [f"<p>{escape(paragraph)}</p>" for paragraph in paper.summary]
    parts += [_counts(atlas), _changed(atlas), _failures(atlas), _not_reproduced(atlas), _menu(atlas)]
    parts.append(
        f"<details><summary>Make this page again</summary><pre>{escape(command)}</pre>"
        '<p class="dim">Beside it stand <a href="atlas.json">atlas.json</a>, with every item and the data of every figure, and '
        "the folder logs: the record of every run, which replays bit for bit.</p></details>"
    )
    return "".join(parts)


def _counts(atlas: Atlas) -> str:
    counted = Counter(item.verdict.kind for done in atlas.done for item in done.findings.items)
    entries = [
        f'<li class="{style}"><b>{sign} {counted[kind]}</b>{words}</li>'
        for kind, (style, sign, words) in KINDS.items()
        if counted[kind]
    ]
    if atlas.failed:
        entries.append(f'<li class="bad"><b>! {len(atlas.failed)}</b>failed</li>')
    return f'<ul class="counts">{"".join(entries)}</ul>'


def _changed(atlas: Atlas) -> str:
    changed = [
        f"{name} = {atlas.constants[name]:g} {constant.unit} (the paper: {constant.value:g}; {constant.description})"
        for name, constant in atlas.paper.constants.items()
        if atlas.constants[name] != constant.value
    ]
    if not changed:
        return ""
    words = escape("; ".join(changed))
    return f'<p class="changed"><b>Not the paper’s constants:</b> {words}. What the paper printed does not hold for them.</p>'


def _failures(atlas: Atlas) -> str:
    links = "".join(f"<li>{_link(done)}: {escape(done.error or '')}</li>" for done in atlas.failed)
    return f'<div class="failed"><strong>These entries could not be computed</strong><ul>{links}</ul></div>' if links else ""


def _not_reproduced(atlas: Atlas) -> str:
    rows = [
        f"<li>{_link(done)}: {escape(item.name)}. <b>{escape(item.verdict.words)}.</b> {escape(item.reason)}</li>"
        for done in atlas.done
        for item in done.findings.items
        if item.unmet
    ]
    if not rows:
        return ""
    return f"<h3>What does not come out as printed, or only in part</h3><ul>{''.join(rows)}</ul>"


def _menu(atlas: Atlas) -> str:
    rows = []
    for done in atlas.done:
        signs = "".join(
            f'<span class="{KINDS[item.verdict.kind][0]}">{KINDS[item.verdict.kind][1]}</span>' for item in done.findings.items
        )
        signs = '<span class="bad">failed</span>' if done.error is not None else signs
        rows.append(f'<li>{_link(done)}<span class="dots">{signs}</span></li>')
    return f"<nav><h3>Contents</h3><ol>{''.join(rows)}</ol></nav>"


def _link(done: Done) -> str:
    entry = done.entry
    words = f'<span class="number">{escape(entry.section)}</span>{escape(entry.title)}'
    return f'<a href="#{escape(entry.name, quote=True)}">{words}</a>'


def _section(done: Done) -> str:
    entry = done.entry
    parts = [
        f'<section id="{escape(entry.name, quote=True)}">',
        f'<h2><span class="number">{escape(entry.section)}</span>{escape(entry.title)}</h2><p>{escape(entry.text)}</p>',
    ]
    if done.error is not None:
        trace = f"<details><summary>Where</summary><pre>{escape(done.trace)}</pre></details>" if done.trace else ""
        parts.append(f'<div class="failed"><strong>Failed.</strong> {escape(done.error)}{trace}</div>')
    if done.findings.figures:
        parts.append(f'<div class="figures">{"".join(_figure(figure) for figure in done.findings.figures)}</div>')
    if done.findings.items:
        parts.append(_table(done.findings.items))
    parts.append(_logs(done.logs))
    return "".join(parts) + "</section>\n"


def _figure(figure: Figure) -> str:
    return (
        f'<figure id="{escape(figure.name, quote=True)}"><p class="figtitle">{escape(figure.title)}</p>{svg(figure)}'
        f"{legend(figure)}<figcaption>{escape(figure.caption)}</figcaption></figure>"
    )


def _table(items: Sequence[Item]) -> str:
    head = "".join(f"<th>{name}</th>" for name in HEAD)
    return f"<table><thead><tr>{head}</tr></thead>{''.join(map(_rows, items))}</table>"


def _rows(item: Item) -> str:
    """A body of its own for each item: a row for each value, the item's own cells reaching over all of them."""
    verdict, span = item.verdict, f' rowspan="{len(item.values)}"'
    style, sign, _ = KINDS[verdict.kind]
    remark = f"<p>{escape(item.remark)}</p>" if item.remark else ""
    remark += f'<p class="reason">{escape(item.reason)}</p>' if item.reason and item.unmet else ""
    first = f'<td class="item"{span}>{escape(item.name)}<small>{escape(item.where)}</small></td>'
    last = (
        f'<td class="verdict {style}"{span} data-label="{HEAD[5]}" data-sign="{sign}">{escape(_kept(verdict.words))}</td>'
        f'<td class="remark"{span} data-label="{HEAD[6]}">{remark}</td>'
    )
    rows = [_cells(value) for value in item.values]
    return f"<tbody><tr>{first}{rows[0]}{last}</tr>{''.join(f'<tr>{row}</tr>' for row in rows[1:])}</tbody>"


def _cells(value: Value) -> str:
    words = ((HEAD[1], value.label), (HEAD[2], _printed(value)), (HEAD[3], _computed(value)), (HEAD[4], _tolerance(value)))
    alone = " alone" if value.printed is None else ""
    return "".join(
        f'<td class="cell {name.lower()}{alone}" data-label="{name}">{escape(_kept(word))}</td>' for name, word in words
    )


def _kept(words: str) -> str:
    """Signs and units stay on the line of their number."""
    return _UNIT.sub("\\1\u00a0", words).replace("± ", "±\u00a0")


def _printed(value: Value) -> str:
    if value.printed is None:
        return "—"
    # Words have no unit.
    return f"{value.printed} {value.unit}".strip().replace("-", "−") if value.printed[-1:].isdigit() else value.printed


def _computed(value: Value) -> str:
    if isinstance(value.computed, str):
        return value.computed
    number = str(value.band) if value.band is not None else f"{value.shown:.{max(value.digits, 6)}g}"
    less = "less than " if value.below_resolution else ""
    return f"{less}{number} {value.unit}".strip().replace("-", "−")


def _tolerance(value: Value) -> str:
    """Say how near ours has to be, and where that comes from."""
    if value.printed is None:
        return "—"
    if value.band is not None:
        return "within the draws"
    if isinstance(value.computed, str):
        return f"in part: {value.reading}, our reading" if value.reading else "as printed"
    if value.at_most and value.loose is None:
        return "not more"
    unit = f" {value.unit}" if value.unit else ""
    counted = isinstance(value.computed, int) and not value.at_most
    words = "by rounding" if value.rounding else "exact" if counted else ""
    if value.relative is not None:
        words = f"± {100.0 * value.relative:g} %: {value.source}"
    elif value.tolerance is not None:
        words = f"± {value.allowed:g}{unit}: {value.source}"
    sign = "not more than" if value.at_most else "±"
    ours = f"in part: {sign} {value.loose:g}{unit}, our reading" if value.loose is not None else ""
    return "; ".join(filter(None, (words, ours)))


def _logs(names: Sequence[str]) -> str:
    if not names:
        return '<p class="dim">Computed from formulas; no run was needed.</p>'
    rows = "".join(
        f'<li><a href="logs/{escape(name, quote=True)}">{escape(name)}</a><br>'
        f"<code>granular-env replay {escape(shlex.quote(f'logs/{name}'))} --verify</code></li>"
        for name in names
    )
    words = "The log behind it, replayable" if len(names) == 1 else f"The logs of the {len(names)} runs behind it, replayable"
    return f'<details><summary>{words}</summary><ul class="logs">{rows}</ul></details>'
