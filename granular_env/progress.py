"""Progress bars on standard error with rich, for all work that may last longer than a second.

    with progress_bar("verification of a.mcap") as bar:
        verify(log, progress=bar.update)        # called with the completed fraction, 0 to 1

Without a terminal nothing is written; in a notebook the bar needs the package ipywidgets.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import Any, Self

from granular_env.components.errors import ParameterError, one_line
from granular_env.terminal_text import printable_text

_REFRESH_SECONDS = 0.1

Progress = bool | Callable[[float], None]
"""Display of progress: True shows a bar; a function is called with the completed fraction, from 0 to 1."""


class Bar:
    """A progress bar, followed by short texts with numbers on the run; texts at the end are cut off first."""

    def __init__(self, show: Callable[[float, tuple[str, ...]], None] | None, refresh: float = 0.0) -> None:
        self._show, self._refresh, self._next = show, refresh, 0.0

    def is_due(self) -> bool:
        """Return whether an update would be displayed now; ask this before computing costly texts for the bar."""
        return self._show is not None and perf_counter() >= self._next

    def update(self, done: float, *figures: str) -> None:
        """Show that `done` of the bar's total is completed."""
        self._next = perf_counter() + self._refresh
        if self._show is not None:
            self._show(done, figures)


@contextmanager
def progress_bar(title: str, total: float | None = 1.0, *, done: float = 0.0, show: Progress = True) -> Iterator[Bar]:
    """Show a bar while the block runs.

    Args:
        title: text before the bar.
        total: value of `done` at the end; None if unknown.
        done: amount already completed.
        show: False for a bar that draws nothing, so that callers need no second path; a function is called with the
            completed fraction.
    """
    with ProgressBars(show, total) as bars:
        yield bars.add_bar(title, total, done)


class ProgressBars:
    """Several bars below each other; use it as a context manager.

    Args:
        show: whether to draw, or a function to call instead with the completed fraction of all bars.
        total: value of `done` at the end, summed over all bars; None if unknown.
        keep: whether the bars stay on the terminal when the block ends.

    Raises:
        ParameterError: `show` is neither a truth value nor a function.
    """

    def __init__(self, show: Progress = True, total: float | None = None, *, keep: bool = False) -> None:
        if not isinstance(show, bool) and not callable(show):
            raise ParameterError(f"got {one_line(show)}", expected="True, False, or a function of the fraction", at="progress")
        self._call = show if callable(show) else None
        self._total, self._shares = total, list[float]()
        self._drawn: Any = _rich_progress(keep) if show is True else None

    def __enter__(self) -> Self:
        if self._drawn is not None:
            self._drawn.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._drawn is not None:
            self._drawn.stop()

    def add_bar(self, title: str, total: float | None = 1.0, done: float = 0.0) -> Bar:
        """Add a bar and return it; arguments as in `progress_bar`."""
        if self._call is not None:
            place = len(self._shares)
            self._shares.append(done)
            return Bar(lambda done, figures: self._report_share(place, done))
        if self._drawn is None:
            return Bar(None)
        task = self._drawn.add_task(printable_text(title), total=total, completed=done, figures="")

        def draw(done: float, figures: tuple[str, ...]) -> None:
            self._drawn.update(task, completed=done, **({"figures": "  ".join(filter(None, figures))} if figures else {}))

        return Bar(draw, _REFRESH_SECONDS)

    def _report_share(self, place: int, done: float) -> None:
        self._shares[place] = done
        if self._call is not None and self._total:
            self._call(min(sum(self._shares) / self._total, 1.0))


def _rich_progress(keep: bool) -> Any:
    """Return rich's display, or None if standard error is neither a terminal nor a notebook that can draw it."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, ProgressColumn, TaskProgressColumn, TimeRemainingColumn
    from rich.text import Text

    console = Console(stderr=True, force_jupyter=None if importlib.util.find_spec("ipywidgets") else False)
    if not (console.is_interactive or console.is_jupyter):
        return None

    class WordsColumn(ProgressColumn):
        """Text that is truncated, not wrapped, at the end of the line; brackets are not markup."""

        def __init__(self, words: Callable[[Any], str]) -> None:
            super().__init__()
            self._words = words

        def render(self, task: Any) -> Text:
            return Text(self._words(task), no_wrap=True, overflow="ellipsis")

    columns = (
        WordsColumn(lambda task: task.description),
        BarColumn(16),
        TaskProgressColumn("{task.percentage:>3.0f} %"),
        TimeRemainingColumn(),
        WordsColumn(lambda task: task.fields["figures"]),
    )
    return Progress(*columns, console=console, transient=not keep)
