"""The page: one HTML file that needs nothing else, runs no script, and is forbidden the network (``templates/atlas.html``)."""

from __future__ import annotations

import re
import shlex
from collections import Counter
from functools import cache
from pathlib import Path

from jinja2 import Template
from markupsafe import Markup

from granular_env.colours import PALETTE
from granular_env.viewing.html_page import template_environment

from .computation import Atlas
from .verdicts import Kind, Value

# Kind -> class, sign, what the summary calls it. The sign tells them apart without colour.
KINDS: dict[Kind, tuple[str, str, str]] = {
    "reproduced": ("good", "✓", "reproduced"),
    "bound kept": ("kept", "≤", "bound kept"),
    "in part": ("part", "◐", "in part"),
    "as bands": ("band", "≈", "as bands over seeds"),
    "not reproduced": ("bad", "✗", "not reproduced"),
    "no figure": ("none", "·", "not in the paper"),
}
HEAD = ("Item", "Value", "Paper", "Computed", "Tolerance", "Verdict", "Remark")
_UNIT = re.compile(r"(\d) (?=[^\W\d]|%)")


def html(atlas: Atlas, command: str) -> str:
    """Return the whole page.

    Args:
        atlas: what was computed.
        command: how it was made, for who wants to make it again.
    """
    return _template().render(
        title=f"{atlas.paper.title}: paper and computation",
        paper=atlas.paper,
        done=atlas.done,
        failed=atlas.failed,
        counts=_counts(atlas),
        changed=_constant_changes(atlas, False, "the paper"),
        chosen=_constant_changes(atlas, True, "by default"),
        unmet=[(done.entry, item) for done in atlas.done for item in done.findings.items if item.unmet],
        command=command,
        kinds=KINDS,
        head=HEAD,
        drawings={name: Markup(svg) for done in atlas.done for name, svg in done.drawings.items()},
        colours=len(PALETTE),
    )


@cache
def _template() -> Template:
    environment = template_environment(Path(__file__).with_name("templates"))
    environment.filters |= {"columns": _columns, "unbroken": _unbroken, "quoted": shlex.quote}
    return environment.get_template("atlas.html")


def _counts(atlas: Atlas) -> list[tuple[str, str, str, int]]:
    """Return class, sign, words and number of each kind of verdict that there is."""
    counted = Counter(item.verdict.kind for done in atlas.done for item in done.findings.items)
    counts = [(*shown, counted[kind]) for kind, shown in KINDS.items() if counted[kind]]
    return counts + [("bad", "!", "failed", len(atlas.failed))] if atlas.failed else counts


def _constant_changes(atlas: Atlas, of_page: bool, whose: str) -> list[str]:
    """Return what was changed of the page's own choices, or of the paper's numbers."""
    return [
        f"{name} = {atlas.constants[name]:g}{constant.unit and ' '}{constant.unit} "
        f"({whose}: {constant.value:g}; {constant.description})"
        for name, constant in atlas.paper.constants.items()
        if constant.of_page == of_page and atlas.constants[name] != constant.value
    ]


def _columns(value: Value) -> list[tuple[str, str]]:
    """Return head and words of a value's own cells."""
    return list(zip(HEAD[1:5], (value.label, _format_printed(value), _format_computed(value), _tolerance(value)), strict=True))


def _unbroken(words: str) -> str:
    """Keep signs and units on the line of their number."""
    return _UNIT.sub("\\1\u00a0", words).replace("± ", "±\u00a0")


def _format_printed(value: Value) -> str:
    if value.printed is None:
        return "—"
    # Words have no unit.
    return f"{value.printed} {value.unit}".strip().replace("-", "−") if value.printed[-1:].isdigit() else value.printed


def _format_computed(value: Value) -> str:
    if isinstance(value.computed, str):
        return value.computed
    number = str(value.band) if value.band is not None else f"{value.display_value:.{max(value.digits, 6)}g}"
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
        words = f"± {value.largest_difference:g}{unit}: {value.source}"
    sign = "not more than" if value.at_most else "±"
    ours = f"in part: {sign} {value.loose:g}{unit}, our reading" if value.loose is not None else ""
    return "; ".join(filter(None, (words, ours)))
