"""Hooks of mkdocs: pictures with a twin for dark pages, and generated tables."""

import re
import sys
from pathlib import Path
from typing import Any

from mkdocs.exceptions import PluginError

sys.path.insert(0, str(Path(__file__).resolve().parent))

import site_tables  # noqa: E402

PICTURE = re.compile(r"!\[(?P<text>[^\]]*)\]\((?P<stem>[^)#\s]+)(?P<suffix>\.(?:png|gif|svg))\)")
ENTRY = re.compile(r"^::: (?P<path>granular_env\.components\.\S+)\n(?:    .*\n)*", re.MULTILINE)
TABLES = re.compile(r"^<!-- tables: (?P<kind>\w+) ?(?P<name>\S*) -->$", re.MULTILINE)


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Show each picture as the one that fits the page, and the tables that a line or an entry of the reference asks for."""
    markdown = _pair_pictures(markdown, Path(page.file.abs_src_path).parent)
    markdown = ENTRY.sub(lambda found: found[0] + _tables("entry", found["path"]), markdown)
    return TABLES.sub(lambda found: _tables(found["kind"], found["name"]), markdown)


def _tables(kind: str, name: str) -> str:
    try:
        return site_tables.text_of(kind, name)
    except ValueError as error:
        raise PluginError(str(error)) from error


def _pair_pictures(markdown: str, folder: Path) -> str:
    """Write each picture that has a twin (``NAME-dark.png``) twice, once for each colour scheme."""

    def both(found: re.Match[str]) -> str:
        text, stem, suffix = found["text"], found["stem"], found["suffix"]
        if not (folder / f"{stem}-dark{suffix}").exists():
            return found[0]
        return f"![{text}]({stem}{suffix}#only-light)\n![{text}]({stem}-dark{suffix}#only-dark)"

    return PICTURE.sub(both, markdown)
