"""Computing an atlas: its entries, in several processes, a failed one not stopping the others."""

from __future__ import annotations

import dataclasses
import os
import signal
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from granular_env.components.errors import GranularError, ParameterError, nearest, shortened

from .constants import resolved
from .context import Context, remove_parts
from .model import Entry, Findings, Paper

# Called when an entry is done: the entry, and its share of the whole.
Told = Callable[[Entry, float], None]


@dataclasses.dataclass(frozen=True)
class Done:
    """An entry, computed.

    Attributes:
        entry: which one.
        findings: empty where it failed.
        logs: file names of the logs it used, in the atlas's folder logs/.
        error: what went wrong, in a sentence; None: nothing.
        trace: where, for errors that this package did not raise on purpose.
    """

    entry: Entry
    findings: Findings
    logs: Sequence[str]
    error: str | None = None
    trace: str = ""


@dataclasses.dataclass(frozen=True)
class Atlas:
    """A paper, computed.

    Attributes:
        paper: which one.
        constants: the values that were used.
        done: its entries, in the page's order.
    """

    paper: Paper
    constants: Mapping[str, float]
    done: Sequence[Done]

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
    told: Told = lambda entry, share: None,
) -> Atlas:
    """Compute the entries of a paper; their logs go into ``folder/logs``.

    Args:
        paper: which one.
        folder: made if it is not there.
        constants: those that are to differ from the paper's.
        only: names of the entries to compute; default: all.
        processes: how many entries are computed at a time. More than one starts Python anew, so a script then needs
            ``if __name__ == "__main__":`` around what it does.
        told: told of each entry that is done.

    Raises:
        ParameterError: no such constant or entry, or a value out of its range.
        GranularError: the folder cannot be written.
    """
    values, entries = resolved(paper, constants or {}), _chosen(paper, only)
    if isinstance(processes, bool) or not isinstance(processes, int) or processes < 1:
        raise ParameterError(f"processes: got {shortened(processes)}, expected a whole number of at least 1")
    logs = Path(folder) / "logs"
    try:
        logs.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise GranularError(f"cannot write the atlas into {str(folder)!r}: {error}") from error
    # The long ones first: the last process to end then ends sooner.
    order = sorted(entries, key=lambda entry: -entry.weight)
    total, found = sum(entry.weight for entry in entries), {}
    for one in _computed(order, logs, values, min(processes, len(entries))):
        found[one.entry.name] = one
        told(one.entry, one.entry.weight / total)
    return Atlas(paper, values, [found[entry.name] for entry in entries])


def _chosen(paper: Paper, only: Iterable[str]) -> list[Entry]:
    known, wanted = {entry.name: entry for entry in paper.entries}, list(only)
    for name in wanted:
        if wanted.count(name) > 1:
            raise ParameterError(f"entry {name!r}: named {wanted.count(name)} times; name it once")
        if name not in known:
            raise ParameterError(f"entry {name!r}: {paper.name} has none of that name; {nearest(name, known)}")
    return [entry for entry in paper.entries if not wanted or entry.name in wanted]


def _computed(entries: Sequence[Entry], logs: Path, values: Mapping[str, float], processes: int) -> Iterator[Done]:
    if processes <= 1:
        context = Context(logs, values)
        yield from (_attempt(entry, context) for entry in entries)
        return
    from concurrent.futures import ProcessPoolExecutor, as_completed
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import get_context

    # A fresh interpreter each: a fork of one that has run kernels may hang.
    with ProcessPoolExecutor(
        processes, mp_context=get_context("spawn"), initializer=_begin, initargs=(logs, dict(values))
    ) as pool:
        futures = [pool.submit(_work, entry) for entry in entries]
        try:
            yield from (future.result() for future in as_completed(futures))
        except BrokenProcessPool as error:
            raise GranularError("a process ended within an entry, perhaps for lack of memory; try processes = 1") from error
        finally:
            pool.shutdown(cancel_futures=True)
            remove_parts(logs)


_CONTEXT: list[Context] = []


def _begin(logs: Path, values: Mapping[str, float]) -> None:
    """What a process of the pool keeps between its entries. Ctrl-C reaches it too, and ends it at once."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    _CONTEXT[:] = [Context(logs, values)]


def _work(entry: Entry) -> Done:
    return _attempt(entry, _CONTEXT[0])


def _attempt(entry: Entry, context: Context) -> Done:
    """The entry's findings, or what went wrong: whatever it is, the other entries go on."""
    context.used()
    try:
        findings = entry.compute(context)
    except GranularError as error:
        return Done(entry, Findings(), context.used(), f"{type(error).__name__}: {error}")
    except Exception as error:
        return Done(entry, Findings(), context.used(), f"{type(error).__name__}: {error}", traceback.format_exc())
    return Done(entry, findings, context.used())
