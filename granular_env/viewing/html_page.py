"""Self-contained HTML pages: escaped text, inlined pictures, no scripts, no network.

In ``templates/``, `page.html` is a page of sections, and `parts.html` defines the parts of a section, which are functions of
`parts`. Jinja escapes all text that is not `Markup`.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

_TEMPLATES = FileSystemLoader(Path(__file__).with_name("templates"))
_ENVIRONMENT = Environment(loader=_TEMPLATES, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
_ENVIRONMENT.filters["words"] = lambda value: f"{value:.6g}" if isinstance(value, float) else str(value)

# The page has the arguments `page`, a `Page`, and `files`, the names of the figures next to it, which a meta element lists.
page_template = _ENVIRONMENT.get_template("page.html")
parts: Any = _ENVIRONMENT.get_template("parts.html").module


class Page(NamedTuple):
    """A page: its title, the paragraphs at its top, and its sections (heading, content); title and headings are plain text."""

    title: str
    lead: Markup
    sections: Sequence[tuple[str, Markup]]
