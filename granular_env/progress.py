"""Progress bars on standard error: the one helper for all work that may last longer than a second.

    with progress_bar("verification of a.mcap") as bar:
        verify(log, progress=bar.update)        # called with the part that is done, 0 to 1

The bar, the percentage and the time left are shown at every width of the terminal; figures that do not fit are left out, the
last ones first. Without a terminal nothing is written. A notebook shows one line of text, which needs no further package.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from types import TracebackType
from typing import Any, Protocol, Self

from granular_env.components.errors import ParameterError, one_line
from granular_env.terminal_text import printable

_REFRESH_SECONDS = 0.1
_NOTEBOOK_SECONDS = 0.5
_NOTEBOOK_WIDTH = 100
_WIDE = 100  # from this width on, the bar is long
_PERCENTAGE, _LEFT = 5, 12  # widths of "100 %" and "0:00:00 left"
_FIRST_FIGURE = 16  # width of a figure such as "t = 0.005567 s"; titles leave so much room


Progress = bool | Callable[[float], None]
"""How far work is: True shows a bar; a function is called with the part that is done, from 0 to 1."""


class Bar(Protocol):
    """One bar.

    Figures are short texts behind the bar, the most important first.
    """

    def is_due(self) -> bool:
        """Return whether an update would be seen now; ask before figures that take time to compute."""
        ...

    def update(self, done: float, *figures: str) -> None:
        """Show how much is done, in units of the bar's total."""
        ...

    def advance(self, more: float, *figures: str) -> None:
        """Show that this much more is done."""
        ...


@contextmanager
def progress_bar(title: str, total: float | None = 1.0, *, done: float = 0.0, show: Progress = True) -> Iterator[Bar]:
    """Show one bar while the block runs.

    Args:
        title: what stands before the bar.
        total: the value of `done` at the end; None where it is unknown.
        done: what is done already.
        show: False for a bar that draws nothing, so that callers need no second path; a function is called with the part that
            is done.
    """
    with ProgressBars(show, total) as bars:
        yield bars.add(title, total, done)


class ProgressBars:
    """Several bars under each other; use it as a context manager.

    Args:
        show: whether to draw at all, or what is called instead with the part of all that is done.
        total: the value of `done` at the end, of all bars together; None where it is unknown.
        keep: whether the bars stay on the terminal when the block ends.

    Raises:
        ParameterError: `show` is neither a truth value nor a function.
    """

    def __init__(self, show: Progress = True, total: float | None = None, *, keep: bool = False) -> None:
        if not isinstance(show, bool) and not callable(show):
            raise ParameterError(f"got {one_line(show)}", expected="True, False, or a function of the part done", at="progress")
        self._call = show if callable(show) else None
        self._total, self._shares = total, list[float]()
        self._show, self._keep = show is True, keep
        self._terminal: Any = None
        self._notebook = False

    def __enter__(self) -> Self:
        if self._show:
            self._notebook = _is_notebook()
            if not self._notebook:
                self._terminal = _start_terminal(self._keep)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._terminal is not None:
            self._terminal.stop()
        elif self._notebook:
            sys.stderr.write("\r" + " " * _NOTEBOOK_WIDTH + "\r")
            sys.stderr.flush()

    def add(self, title: str, total: float | None = 1.0, done: float = 0.0) -> Bar:
        """Add a bar and return it; arguments as in `progress_bar`."""
        title = printable(title)
        if self._call is not None:
            self._shares.append(done)
            return _Callback(self._tell, len(self._shares) - 1, done)
        if self._terminal is not None:
            return _TerminalBar(self._terminal, title, total, done)
        if self._notebook:
            return _NotebookBar(title, total, done)
        return _NoBar()

    def _tell(self, place: int, done: float) -> None:
        self._shares[place] = done
        if self._call is not None and self._total:
            self._call(min(sum(self._shares) / self._total, 1.0))


class _Callback:
    """A bar that a function of the caller's stands for."""

    def __init__(self, tell: Callable[[int, float], None], place: int, done: float) -> None:
        self._tell, self._place, self._done = tell, place, done

    def is_due(self) -> bool:
        return True

    def update(self, done: float, *figures: str) -> None:
        self._done = done
        self._tell(self._place, done)

    def advance(self, more: float, *figures: str) -> None:
        self.update(self._done + more)


class _NoBar:
    def is_due(self) -> bool:
        return False

    def update(self, done: float, *figures: str) -> None:
        pass

    def advance(self, more: float, *figures: str) -> None:
        pass


class _TerminalBar:
    """A bar that rich draws."""

    def __init__(self, drawn: Any, title: str, total: float | None, done: float) -> None:
        self._drawn, self._done = drawn, done
        self._next = 0.0
        self._task = drawn.add_task(title, total=total, completed=done, figures=())

    def is_due(self) -> bool:
        return perf_counter() >= self._next

    def update(self, done: float, *figures: str) -> None:
        self._next = perf_counter() + _REFRESH_SECONDS
        self._done = done
        self._drawn.update(self._task, completed=done, **({"figures": figures} if figures else {}))

    def advance(self, more: float, *figures: str) -> None:
        self.update(self._done + more, *figures)


class _NotebookBar:
    """One line of text, written over itself: what every notebook shows."""

    def __init__(self, title: str, total: float | None, done: float) -> None:
        self._title, self._total, self._done = title, total, done
        self._begun, self._first, self._next = perf_counter(), done, 0.0
        self.update(done)

    def is_due(self) -> bool:
        return perf_counter() >= self._next

    def update(self, done: float, *figures: str) -> None:
        self._done = done
        if not self.is_due():
            return
        self._next = perf_counter() + _NOTEBOOK_SECONDS
        parts = [shorten_front(self._title, _NOTEBOOK_WIDTH // 3)]
        if self._total:
            parts += [f"{100 * done / self._total:3.0f} %", self._time_left()]
        room = _NOTEBOOK_WIDTH - len("  ".join(parts)) - 2
        line = "  ".join([*parts, fit_figures(figures, room)])
        sys.stderr.write("\r" + line.ljust(_NOTEBOOK_WIDTH))
        sys.stderr.flush()

    def advance(self, more: float, *figures: str) -> None:
        self.update(self._done + more, *figures)

    def _time_left(self) -> str:
        advanced = self._done - self._first
        if advanced <= 0.0 or self._total is None:
            return _duration_left(None)
        return _duration_left((perf_counter() - self._begun) * (self._total - self._done) / advanced)


def fit_figures(figures: tuple[str, ...], room: int) -> str:
    """Join as many figures, from the first on, as there is room for."""
    text = ""
    for figure in filter(None, figures):
        longer = f"{text}  {figure}" if text else figure
        if len(longer) > room:
            break
        text = longer
    return text


def shorten_front(text: str, width: int) -> str:
    """Cut a text at its front to a width in terminal cells; the end of a path or a name is what tells it apart."""
    from rich.cells import cell_len

    if cell_len(text) <= width:
        return text
    while text and cell_len(text) > width - 1:
        text = text[1:]
    return f"…{text}"


def _duration_left(seconds: float | None) -> str:
    if seconds is None:
        return "-:--:-- left"
    whole = max(0, round(seconds))
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d} left"


def _is_notebook() -> bool:
    """Return whether this is a kernel of Jupyter, whose standard error is no terminal but is seen by a person."""
    shell = sys.modules.get("IPython")
    if shell is None:
        return False
    running = shell.get_ipython()
    return running is not None and type(running).__name__ == "ZMQInteractiveShell"


def _start_terminal(keep: bool) -> Any:
    """Return rich's progress display, started; None where standard error is no terminal that can draw one."""
    from rich.console import Console

    console = Console(stderr=True, force_jupyter=False)
    if not console.is_interactive:
        return None
    from rich.cells import cell_len
    from rich.progress import BarColumn, Progress, ProgressColumn
    from rich.text import Text

    def title(task: Any) -> str:
        return shorten_front(task.description, _title_width(console.width))

    class Title(ProgressColumn):
        def render(self, task: Any) -> Text:
            return Text(title(task), no_wrap=True)

    class Width(BarColumn):
        def render(self, task: Any) -> Any:
            self.bar_width = _bar_width(console.width)
            return super().render(task)

    class Part(ProgressColumn):
        def render(self, task: Any) -> Text:
            return Text(f"{int(task.percentage):3d} %" if task.total else "", style="progress.percentage")

    class Left(ProgressColumn):
        max_refresh = 0.5

        def render(self, task: Any) -> Text:
            return Text(_duration_left(task.time_remaining) if task.total else "", style="progress.remaining", no_wrap=True)

    class Figures(ProgressColumn):
        def render(self, task: Any) -> Text:
            # One space stands between two columns, and the last place of the line stays free.
            titles = max(cell_len(title(one)) for one in drawn.tasks)
            room = console.width - titles - _bar_width(console.width) - _PERCENTAGE - _LEFT - 5
            return Text(fit_figures(task.fields["figures"], room), no_wrap=True)

    drawn = Progress(Title(), Width(), Part(), Left(), Figures(), console=console, transient=not keep)
    drawn.start()
    return drawn


def _bar_width(width: int) -> int:
    return 24 if width >= _WIDE else max(4, min(16, width - _PERCENTAGE - _LEFT - 12))


def _title_width(width: int) -> int:
    room = width - _bar_width(width) - _PERCENTAGE - _LEFT - 5
    return max(6, min(40, room if width < 50 else max(room // 2, room - _FIRST_FIGURE)))
