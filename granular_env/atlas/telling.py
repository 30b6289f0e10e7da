"""What the command line says while an atlas is computed, and after it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from granular_env.progress import progress_bar

from .building import Atlas
from .model import Entry, Paper


@contextmanager
def telling(paper: Paper, quiet: bool) -> Iterator[Callable[[Entry, float], None]]:
    """Show a progress bar that goes on with each entry that is done."""
    with progress_bar(paper.name, show=not quiet) as bar:
        yield lambda entry, share: bar.advance(share, f"{entry.section} {entry.title}")


def closing(atlas: Atlas, page: Path) -> str:
    """How it went: how many items came out how, what failed, where the page is."""
    counted = Counter(item.verdict.kind for done in atlas.done for item in done.findings.items)
    figures = sum(len(done.findings.figures) for done in atlas.done)
    lines = [f"{sum(counted.values())} items, {figures} figures: " + ", ".join(f"{n} {kind}" for kind, n in counted.items())]
    lines += [f"failed: {done.entry.name}: {done.error}" for done in atlas.failed]
    return "\n".join([*lines, f"page: {page}", f"data: {page.with_name('atlas.json')}"])
