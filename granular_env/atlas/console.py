"""Messages of the command line while an atlas is computed, and after it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from granular_env.progress import Progress, progress_bar

from .computation import Atlas
from .model import Entry


@contextmanager
def entry_progress(entries: Sequence[Entry], title: str, progress: Progress) -> Iterator[Callable[[Entry, float], None]]:
    """Show a progress bar by the work that is done, and which entries are being computed, each with its own share."""
    shares = {entry.name: 0.0 for entry in entries}
    weights = {entry.name: entry.weight for entry in entries}
    running: dict[str, None] = {}
    with progress_bar(title, sum(weights.values()), show=progress) as bar:

        def notify(entry: Entry, share: float) -> None:
            running[entry.name], shares[entry.name] = None, share
            if share >= 1.0:
                running.pop(entry.name, None)
            done = sum(weights[name] * shares[name] for name in weights)
            bar.update(done, *(f"{name} {100.0 * shares[name]:.0f} %" for name in running))

        yield notify


def closing(atlas: Atlas) -> str:
    """Say how it went: how many items came out how, what failed, where the page is."""
    counted = Counter(item.verdict.kind for done in atlas.done for item in done.findings.items)
    figures = sum(len(done.findings.figures) for done in atlas.done)
    lines = [f"{sum(counted.values())} items, {figures} figures: " + ", ".join(f"{n} {kind}" for kind, n in counted.items())]
    lines += [f"failed: {done.entry.name}: {done.error}" for done in atlas.failed]
    if atlas.page is not None:
        lines += [f"page: {atlas.page}", f"data: {atlas.page.with_name('atlas.json')}"]
    return "\n".join(lines)
