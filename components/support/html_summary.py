"""HTML of objects in a notebook: a title, facts, and tables that unfold; all text is escaped."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..errors import one_line

# Largest number of rows of a table.
_MOST_ROWS = 200


def html_summary(title: str, facts: Mapping[str, Any], tables: Mapping[str, Sequence[Sequence[Any]]]) -> str:
    """Return an HTML element without styles or scripts.

    Args:
        title: what the object is.
        facts: name -> value, shown in lines; None and empty values are omitted.
        tables: what the rows are -> rows, of which the first has the names of the columns; a table without others is omitted.
    """
    lines = "".join(f"<div>{_cell(name)}: {_cell(value)}</div>" for name, value in facts.items() if value not in (None, "", []))
    found = (_table(heading, rows) for heading, rows in tables.items() if len(rows) > 1)
    return f"<div><strong>{_cell(title)}</strong>{lines}{''.join(found)}</div>"


def _table(heading: str, rows: Sequence[Sequence[Any]]) -> str:
    head, *body = rows
    more = f" (the first {_MOST_ROWS})" if len(body) > _MOST_ROWS else ""
    text = f"<thead>{_row(head, 'th')}</thead><tbody>{''.join(_row(row, 'td') for row in body[:_MOST_ROWS])}</tbody>"
    return f"<details><summary>{len(body)} {_cell(heading)}{more}</summary><table>{text}</table></details>"


def _row(cells: Iterable[Any], tag: str) -> str:
    return f"<tr>{''.join(f'<{tag}>{_cell(cell)}</{tag}>' for cell in cells)}</tr>"


def _cell(value: Any) -> str:
    if isinstance(value, list):
        value = "; ".join(map(str, value[:_MOST_ROWS]))
    return html.escape(f"{value:.6g}" if isinstance(value, float) else value if isinstance(value, str) else one_line(value))
