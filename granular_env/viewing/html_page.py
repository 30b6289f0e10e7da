"""Self-contained HTML pages: escaped text, inlined pictures, no scripts, no network.

The templates are in ``templates/``: `page.html` is the frame that every page shares, with the policy that forbids the network;
`report.html` a page of sections; `parts.html` the parts of a section. Jinja escapes whatever is not `Markup`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

_TEMPLATES = Path(__file__).with_name("templates")


@cache
def _environment() -> Environment:
    """Return an environment whose templates escape every text."""
    environment = Environment(
        loader=FileSystemLoader(_TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: value if isinstance(value, Markup) else printable(value),
    )
    environment.filters["words"] = _words
    environment.globals["is_number"] = _is_number
    return environment


@cache
def _parts() -> Any:
    return _environment().get_template("parts.html").module


def printable(value: object) -> str:
    """Return any value as text that every file can hold: bytes of a file's name that are no text become question marks."""
    return str(value).encode("utf-8", "replace").decode("utf-8")


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _words(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else printable(value)


def paragraph(words: object, style: str = "") -> Markup:
    """Return a paragraph."""
    return _parts().paragraph(words, style)


def preformatted(words: object) -> Markup:
    """Return lines as they are."""
    return _parts().preformatted(words)


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> Markup:
    """Return a table; numbers, and the heads above them, stand to the right. A row of one cell is a heading of others."""
    return _parts().table(head, [list(row) for row in rows])


def bullets(sentences: Iterable[object], style: str = "") -> Markup:
    """Return a list of sentences."""
    return _parts().bullets(sentences, style)


def picture(svg: str, description: str) -> Markup:
    """Return a drawing of `drawing.svg` with its description under it."""
    return _parts().picture(Markup(svg), description)


def film(shown: Any, description: str) -> Markup:
    """Return a `html_film.Film` with a time axis to choose its instants on."""
    return _parts().film(shown, Markup(shown.bars), description)


def page(title: str, lead: Markup, sections: Sequence[tuple[str, Markup]]) -> str:
    """Return the whole page.

    Args:
        title: plain text.
        lead: parts under the title.
        sections: heading (plain text) and parts of each.
    """
    return _environment().get_template("report.html").render(title=title, lead=lead, sections=sections)
