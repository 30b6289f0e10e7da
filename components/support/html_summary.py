"""HTML summaries of objects for notebooks: title, facts and a collapsible table; all text is escaped."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping, Sequence
from pathlib import PurePath
from typing import Any

from ..errors import one_line

# Largest number of rows of a table, and of shown items of a list.
_MOST_ROWS = 200


def html_summary(title: str, facts: Mapping[str, Any], columns: Sequence[str] = (), rows: Iterable[Sequence[Any]] = ()) -> str:
    """Return an HTML element without styles or scripts.

    Args:
        title: what the object is.
        facts: name -> value, one per line; None and empty values are omitted.
        columns: names of the columns of a table.
        rows: rows of the table, of which 200 are shown; it is omitted without rows.
    """
    lines = "".join(f"<div>{_cell(name)}: {_cell(value)}</div>" for name, value in facts.items() if value not in (None, "", []))
    body = [_row(row, "td") for row in rows]
    table = f"<table><thead>{_row(columns, 'th')}</thead><tbody>{''.join(body[:_MOST_ROWS])}</tbody></table>"
    table = f"<details><summary>{len(body)} rows</summary>{table}</details>" if body else ""
    return f"<div><strong>{_cell(title)}</strong>{lines}{table}</div>"


def _row(cells: Iterable[Any], tag: str) -> str:
    return f"<tr>{''.join(f'<{tag}>{_cell(cell)}</{tag}>' for cell in cells)}</tr>"


def _cell(value: Any) -> str:
    if isinstance(value, list):
        value = "; ".join(map(str, value[:_MOST_ROWS]))
    elif value is None or isinstance(value, PurePath):
        value = str(value or "")
    return html.escape(f"{value:.6g}" if isinstance(value, float) else value if isinstance(value, str) else one_line(value))
