"""Computing an atlas: its entries, in several processes, a failed one not stopping the others."""

from __future__ import annotations

import dataclasses
import os
import traceback
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import closing
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

from granular_env.components.errors import GranularError, ParameterError, nearest
from granular_env.components.support.validation import whole_number
from granular_env.optional_packages import import_optional
from granular_env.workers import Worker, stop_all

from .constant_overrides import constant_values
from .context import Context
from .drawing import draw
from .finished_runs import FinishedRuns
from .folder import open_folder
from .model import Entry, Findings, Paper

# Called with an entry, and how much of it is done, when it begins (0), after each of its runs, and at its end (1).
Notify = Callable[[Entry, float], None]


@dataclasses.dataclass(frozen=True)
class Done:
    """An entry, computed.

    Attributes:
        entry: which one.
        findings: empty where it failed.
        logs: file names of the logs it used, in the atlas's folder logs/.
        error: what went wrong, in a sentence; None: nothing.
        trace: where, for errors that this package did not raise on purpose.
        drawings: its figures as parts of the page, by name.
    """

    entry: Entry
    findings: Findings
    logs: Sequence[str]
    error: str | None = None
    trace: str = ""
    drawings: Mapping[str, str] = dataclasses.field(default_factory=dict)


@dataclasses.dataclass(frozen=True)
class Atlas:
    """A paper, computed.

    Attributes:
        paper: which one.
        constants: the values that were used.
        done: its entries, in the page's order.
        page: where it was written; None where it was not.
    """

    paper: Paper
    constants: Mapping[str, float]
    done: Sequence[Done]
    page: Path | None = None

    @property
    def failed(self) -> list[Done]:
        """The entries that could not be computed."""
        return [one for one in self.done if one.error is not None]


def compute(
    paper: Paper,
    folder: str | os.PathLike[str],
    constants: Mapping[str, Any] | None = None,
    *,
    only: Iterable[str] = (),
    processes: int = 1,
    refinement: int = 1,
    notify: Notify = lambda entry, share: None,
) -> Atlas:
    """Compute the entries of a paper; their logs go into ``folder/logs``.

    Runs that the same program has finished there are not done again: an atlas that was ended goes on.

    Args:
        paper: which one.
        folder: made if it is not there; one process computes there at a time.
        constants: those that are to differ from the paper's.
        only: names of the entries to compute; default: all.
        processes: how many entries are computed at a time. A script that defines entries of its own then needs
            ``if __name__ == "__main__":`` around what it does.
        refinement: by how much steps and sampling intervals are divided; digits that hold at 2 have converged.
        notify: called with an entry, and how much of it is done, from 0 to 1.

    Raises:
        ParameterError: no such constant or entry, or a value out of its range.
        MissingExtraError: matplotlib, which draws the figures, is not installed.
        GranularError: the folder cannot be written, another process computes there, or its `atlas.json` is not an atlas's.
    """
    import_optional("matplotlib", "the atlas")
    values, entries = constant_values(paper, constants or {}), chosen(paper, only)
    for name, number in (("processes", processes), ("refinement", refinement)):
        whole_number(name, number)
    # The long ones first: the last process to end then ends sooner.
    order, found = sorted(entries, key=lambda entry: -entry.weight), {}
    with open_folder(folder) as logs:
        arguments = logs, values, refinement, FinishedRuns(Path(folder))
        stream = _serial(order, Context(*arguments), notify)
        if min(processes, len(entries)) > 1:
            stream = _parallel(order, arguments, min(processes, len(entries)), notify)
        with closing(stream):
            for one in stream:
                found[one.entry.name] = one
                notify(one.entry, 1.0)
    return Atlas(paper, values, [found[entry.name] for entry in entries])


def chosen(paper: Paper, only: Iterable[str]) -> list[Entry]:
    """Return the entries of these names, in the page's order; all where none is named; `ParameterError` for others."""
    known, wanted = {entry.name: entry for entry in paper.entries}, list(only)
    for name in wanted:
        if wanted.count(name) > 1:
            raise ParameterError(f"{name!r} is named {wanted.count(name)} times", hint="name it once", at="entries")
        if name not in known:
            raise ParameterError(f"{paper.name} has no {name!r}", hint=nearest(name, known), at="entries")
    return [entry for entry in paper.entries if not wanted or entry.name in wanted]


def _serial(entries: Sequence[Entry], context: Context, notify: Notify) -> Generator[Done, None, None]:
    for entry in entries:
        yield _attempt(entry, context, notify)


def _parallel(
    entries: Sequence[Entry], arguments: tuple[Any, ...], processes: int, notify: Notify
) -> Generator[Done, None, None]:
    """Give each process an entry at a time; what it sends is a share of that entry, or the entry done."""
    waiting, running = list(entries), {}
    of_script = any(entry.compute.__module__ == "__main__" for entry in entries)
    crew = [Worker(_serve, *arguments, with_script=of_script) for _ in range(processes)]
    try:
        for worker in crew:
            running[worker.connection] = worker, _give(worker, waiting)
        while running:
            for ready in wait(list(running)):
                worker, entry = running[ready]
                try:
                    message = worker.connection.recv()
                except (EOFError, OSError):
                    raise GranularError(
                        f"entry {entry.name!r}: {worker.exit_reason()}", hint="try one process at a time (processes = 1)"
                    ) from None
                if isinstance(message, Done):
                    yield message
                    del running[ready]
                    if waiting:
                        running[ready] = worker, _give(worker, waiting)
                else:
                    notify(entry, message)
    finally:
        stop_all(crew)


def _give(worker: Worker, waiting: list[Entry]) -> Entry:
    entry = waiting.pop(0)
    try:
        worker.connection.send(entry)
    except OSError:
        pass  # It has ended, which is found out when it is listened to.
    return entry


def _serve(connection: Connection, *arguments: Any) -> None:
    """Compute the entries that come, one after the other; what a process keeps between them is its context."""
    context = Context(*arguments)
    while True:
        connection.send(_attempt(connection.recv(), context, lambda entry, share: connection.send(share)))


def _attempt(entry: Entry, context: Context, notify: Notify) -> Done:
    """Return the entry's findings, or what went wrong: whatever it is, the other entries go on."""
    notify(entry, 0.0)
    expected = entry.expected_runs(context.constants)
    context.begin(lambda runs: notify(entry, min(runs / (expected + 1), 0.99)))
    try:
        findings = entry.compute(context)
        drawings = {figure.name: draw(figure) for figure in findings.figures}
    except GranularError as error:
        return Done(entry, Findings(), context.log_names(), f"{type(error).__name__}: {error}")
    except Exception as error:
        return Done(entry, Findings(), context.log_names(), f"{type(error).__name__}: {error}", traceback.format_exc())
    return Done(entry, findings, context.log_names(), drawings=drawings)
