"""What the command line says while an atlas is computed, and after it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from .building import Atlas
from .model import Entry, Paper


@contextmanager
def telling(paper: Paper, quiet: bool) -> Iterator[Callable[[Entry, float], None]]:
    """A bar on standard error that goes on with each entry that is done."""
    if quiet:
        yield lambda entry, share: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    if not console.is_interactive:  # where no bar can be drawn, an empty line would be all that is left of it
        yield lambda entry, share: None
        return
    columns = (TextColumn("{task.description}"), BarColumn(bar_width=24), TaskProgressColumn(), TimeElapsedColumn())
    with Progress(*columns, TextColumn("{task.fields[last]}"), console=console, transient=True) as bar:
        task = bar.add_task(paper.name, total=1.0, last="")
        yield lambda entry, share: bar.update(task, advance=share, last=f"{entry.section} {entry.title}")


def closing(atlas: Atlas, page: Path) -> str:
    """How it went: how many items came out how, what failed, where the page is."""
    counted = Counter(item.verdict.kind for done in atlas.done for item in done.findings.items)
    figures = sum(len(done.findings.figures) for done in atlas.done)
    lines = [f"{sum(counted.values())} items, {figures} figures: " + ", ".join(f"{n} {kind}" for kind, n in counted.items())]
    lines += [f"failed: {done.entry.name}: {done.error}" for done in atlas.failed]
    return "\n".join([*lines, f"page: {page}", f"data: {page.with_name('atlas.json')}"])
