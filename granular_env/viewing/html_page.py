"""Self-contained HTML pages: escaped text, inlined pictures, no scripts, no network.

The templates are in ``templates/``: `page.html` is the common frame of all pages, with the policy that forbids network access;
`report.html` is a page of sections; `parts.html` defines the parts of a section, which are functions of `parts`. Jinja escapes
all text that is not `Markup`.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

_ENVIRONMENT = Environment(
    loader=FileSystemLoader(Path(__file__).with_name("templates")),
    autoescape=True,
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)
_ENVIRONMENT.filters["words"] = lambda value: f"{value:.6g}" if isinstance(value, float) else str(value)

parts: Any = _ENVIRONMENT.get_template("parts.html").module


class Page(NamedTuple):
    """A page: its title, the paragraphs at its top, and its sections (heading, content); title and headings are plain text."""

    title: str
    lead: Markup
    sections: Sequence[tuple[str, Markup]]


def render_page(page: Page, files: Sequence[str]) -> str:
    """Return the whole page as HTML; a meta element lists the names of the `files` next to it."""
    return _ENVIRONMENT.get_template("report.html").render(page._asdict(), files=files)
