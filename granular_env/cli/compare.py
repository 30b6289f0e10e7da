"""Command `compare`: the differences between two logs, and a page with figures of both."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import click

from granular_env.cli.command import Status, command, print_json
from granular_env.cli.options import FILE, FOLDER, allow_large_option, format_option, json_option
from granular_env.terminal_text import align_columns, printable_text, wrap_text

_STATUS = {"identical": Status.DONE, "different": Status.DIFFERENT, "nothing was compared": Status.INCOMPLETE}


@command(
    "compare",
    epilog="Exit status: 0 identical; 1 different; 2 an error, such as logs of different components; 3 nothing was compared, "
    "because no output was recorded in both logs at a common time.",
)
@click.argument("a", type=FILE)
@click.argument("b", type=FILE)
@click.option("-o", "--out", metavar="FOLDER", type=FOLDER, help="Folder of the page (default: A-B, next to A).")
@format_option()
@json_option(help="Print the result as JSON; write the page only if --out is given.")
@allow_large_option()
def compare(a: str, b: str, out: str | None, file_format: str, as_json: bool, allow_large: bool) -> int:
    """Compare two logs of one component: print the first difference, and write a page with figures of both logs."""
    from granular_env.recording import open_log
    from granular_env.recording.comparison import compare_logs

    folder = Path(out or Path(a).with_name(f"{Path(a).stem}-{Path(b).stem}"))
    page = None if as_json and not out else folder / "compare.html"
    with open_log(a, allow_large=allow_large) as log, open_log(b, allow_large=allow_large) as other:
        if page is None:
            found = compare_logs(log, other)
        else:
            from granular_env import viewing

            found = viewing.compare(log, other, folder, progress=not as_json, file_format=file_format)
    if as_json:
        print_json({"outcome": found.outcome, **dataclasses.asdict(found), "written": page})
        return _STATUS[found.outcome]
    for text in filter(None, (found.relation, found.message, found.omission)):
        print(wrap_text(printable_text(text)))
    settings = [tuple(map(printable_text, row)) for row in found.settings]
    print(align_columns([("settings that differ", "A", "B"), *settings], "") if settings else "settings: equal")
    print(f"written: {page}")
    return _STATUS[found.outcome]
