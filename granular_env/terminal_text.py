"""Text for a terminal: untrusted text with escaped control characters, and tables and sentences wrapped at words."""

from __future__ import annotations

import shutil
import sys
import textwrap
from collections.abc import Iterable, Sequence

_NARROWEST = 30  # least width of a table's last column; below it, the column gets a separate line
_GAP = 2


def printable_text(text: object) -> str:
    """Return a text with control characters written as escapes, so that terminals do not execute them.

    Names from files may contain escape sequences, changes of the writing direction, or undecodable bytes.
    """
    return "".join(letter if letter.isprintable() else repr(letter)[1:-1] for letter in str(text))


def output_width() -> int | None:
    """Return the width of the terminal on standard output, or None if it is not a terminal (no wrapping)."""
    return shutil.get_terminal_size().columns if sys.stdout is not None and sys.stdout.isatty() else None


def wrap_text(text: str, indent: int = 2) -> str:
    """Return a sentence wrapped at words, with further lines indented by `indent`; unchanged without a terminal."""
    width = output_width()
    return text if width is None else "\n".join(_wrap_lines(text, width, " " * indent))


def align_columns(rows: Iterable[Sequence[str]], indent: str = "  ") -> str:
    """Return rows of cells as text in aligned columns; the last cell of a row wraps at words if the terminal is too narrow."""
    table = [tuple(row) for row in rows]
    if not table:
        return ""
    widths = _column_widths(table)
    width = output_width()
    begin = len(indent) + sum(widths[:-1]) + _GAP * (len(widths) - 1)
    if width is None or begin + widths[-1] <= width:
        return "\n".join(_align_row(row, widths, indent) for row in table)
    lines: list[str] = []
    for row in table:
        head = _align_row(row[:-1], widths[:-1], indent)
        if width - begin >= _NARROWEST:
            first, *rest = _wrap_lines(row[-1], width - begin, "") or [""]
            lines += [f"{head.ljust(begin - _GAP)}{' ' * _GAP}{first}".rstrip(), *(" " * begin + line for line in rest)]
        else:
            own = " " * (len(indent) + 4)
            lines += [*_wrap_lines(head, width, own), *(own + line for line in _wrap_lines(row[-1], width - len(own), ""))]
    return "\n".join(lines)


def align_table(rows: Iterable[Sequence[str]]) -> str:
    """Return a table as text, headings first; if it is too wide, it is split into blocks that all repeat the first column."""
    cells = [tuple(row) for row in rows]
    if not cells:
        return ""
    widths, width = _column_widths(cells), output_width()
    blocks: list[list[int]] = [[]]
    for place in range(1, len(widths)):
        wanted = widths[0] + sum(_GAP + widths[one] for one in (*blocks[-1], place))
        if width is not None and wanted > width and blocks[-1]:
            blocks.append([])
        blocks[-1].append(place)
    drawn = []
    for block in blocks:
        own = [0, *block]
        drawn.append("\n".join(_align_row([row[one] for one in own], [widths[one] for one in own], "") for row in cells))
    return "\n\n".join(drawn)


def _column_widths(rows: Sequence[Sequence[str]]) -> list[int]:
    return [max(len(row[place]) for row in rows) for place in range(len(rows[0]))]


def _align_row(row: Sequence[str], widths: Sequence[int], indent: str) -> str:
    return indent + (" " * _GAP).join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()


def _wrap_lines(text: str, width: int, indent: str) -> list[str]:
    return textwrap.wrap(
        text, max(width, 10), subsequent_indent=indent, break_long_words=False, break_on_hyphens=False, drop_whitespace=True
    )
