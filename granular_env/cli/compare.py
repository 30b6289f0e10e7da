"""Command `compare`: the differences between two logs, and a page with figures of both."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from granular_env.cli.command import Status, command
from granular_env.cli.options import FILE, FOLDER, allow_large_option, format_option, json_option
from granular_env.output_files import require_writable
from granular_env.terminal_text import align_columns, printable_text, wrap_text

if TYPE_CHECKING:
    from granular_env.recording.comparison import LogComparison

_STATUS = {"identical": Status.DONE, "different": Status.DIFFERENT, "nothing was compared": Status.INCOMPLETE}
# Settings with longer values are not printed; the page and the JSON have them.
_LONGEST = 60


@command(
    "compare",
    epilog="Exit status: 0 identical; 1 different; 2 an error, such as logs of different components; 3 nothing was compared, "
    "because the logs have no common output with a common time.",
)
@click.argument("first", metavar="A", type=FILE)
@click.argument("second", metavar="B", type=FILE)
@click.option("-o", "--out", metavar="FOLDER", type=FOLDER, help="Folder of the page (default: A-B, next to A).")
@format_option()
@json_option("Print the result as JSON; write the page only if --out is given.")
@allow_large_option()
def compare(first: str, second: str, out: str | None, file_format: str, as_json: bool, allow_large: bool) -> int:
    """Compare two logs of one component: the first difference, settings, and a page with figures of both."""
    from granular_env.recording import open_log
    from granular_env.recording.comparison import compare_logs

    folder = Path(out) if out else Path(first).with_name(f"{Path(first).stem}-{Path(second).stem}")
    page = folder / "compare.html" if out or not as_json else None
    if page is not None:
        require_writable(page)
    with open_log(first, allow_large=allow_large) as log, open_log(second, allow_large=allow_large) as other:
        found = compare_logs(log, other)
        if not as_json:
            print(_comparison_text(found))
        if page is not None:
            from granular_env.viewing.reports.comparison_page import write_comparison

            write_comparison((log, other), found, page, not as_json, file_format)
    if not as_json:
        print(f"written: {page}")
    else:
        facts = {"outcome": found.outcome, **dataclasses.asdict(found), "written": None if page is None else str(page)}
        print(json.dumps(facts, indent=2))
    return _STATUS[found.outcome]


def _comparison_text(found: LogComparison) -> str:
    lines = [wrap_text(printable_text(text)) for text in (found.relation, found.message) if text]
    rows = [(f"{one.group}: {one.name}", *map(str, one.values)) for one in found.settings]
    shown = [row for row in rows if max(map(len, row)) <= _LONGEST]
    if shown:
        lines += ["settings that differ:", align_columns([tuple(map(printable_text, row)) for row in shown], "  ")]
    if len(shown) < len(rows):
        lines.append(f"{len(rows) - len(shown)} longer settings differ, too; the page lists them")
    return "\n".join(lines)
