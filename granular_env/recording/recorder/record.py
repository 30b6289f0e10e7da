"""Begin to record, and say which log a run that failed has left; the arguments are checked before any file exists."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from ...components.component import Component
from ...components.errors import GranularError, ParameterError, one_line
from ..format.header import plain_json
from .arguments import make_schedule, names_to_record
from .log_file import create
from .log_writer import as_path
from .recorder import Recorder


def record(
    component: Component,
    path: str | os.PathLike[str],
    *,
    every: float | None = None,
    variables: Sequence[str] | None = None,
    hash_every: int | None = None,
    snapshot_every: float | None = None,
    experiment: Mapping[str, Any] | None = None,
    parent: Mapping[str, Any] | None = None,
    overwrite: bool = False,
) -> Recorder:
    """Record everything that `component` does from now until the recorder is closed.

        with ge.record(chain, "logs/mine.mcap", every=1e-6, variables=["velocity"]):
            chain.reset(velocity={0: 5.0})
            chain.step(1e-4)

    Every input and the state at the start are kept exactly, so that the log can be re-run; frames are for looking.

    Args:
        component: what to look at.
        path: the file; by custom it ends in ``.mcap``.
        every: time between frames [s], a whole number of ticks. Default: for an experiment with a duration 160 to
            400 frames; otherwise every tick at first, and half as often each time the run has become twice as long.
        variables: names of outputs or inputs to keep in each frame, beside the balances. Default: the
            state variables and the outputs that viewers draw.
        hash_every: ticks between hashes of the state; 1 lets a verification name the very step. Default: 4096.
        snapshot_every: time between snapshots [s]. Default: each time the run has become a sixteenth longer, at least 4096
            ticks apart; fewer where a tick of a large state, or of many steps of a part, takes long.
        experiment: JSON values to keep with the log.
        parent: which log and tick this one branched off.
        overwrite: whether an existing log may be replaced; it stays until the new one holds its first step.

    Raises:
        ParameterError: an argument is not valid, or the file exists, is no log, or is being written by another recorder;
            nothing has been written.
        LogError: the file cannot be written.
    """
    if not isinstance(component, Component):
        raise ParameterError(f"got {one_line(component)}", expected="a component", at="component")
    target = as_path(path)
    names = names_to_record(component, variables)
    schedule = make_schedule(component, every, hash_every, snapshot_every, experiment, names)
    facts = plain_json("experiment", experiment), plain_json("parent", parent)
    return Recorder(component, target, create(target, overwrite), names, schedule, *facts)


@contextmanager
def note_log_on_error(recorder: Recorder) -> Iterator[None]:
    """Add a note to an error that ends a recorded run: where the log is, and until when it is complete.

    Enter it before the recorder, so that the log is closed by the time that it is looked at.
    """
    try:
        yield
    except GranularError as error:
        error.add_note(_log_note(recorder.path) if recorder.published else f"log: what stood at {str(recorder.path)!r} is kept")
        raise


def _log_note(path: str | os.PathLike[str]) -> str:
    from ..reader.log_reader import LogReader

    name = os.fspath(path)
    try:
        with LogReader(as_path(path), allow_large=True) as log:
            end = f"{log.end_tick * log.step_size:.9g} s"
            if log.complete:
                return f"log: {name!r} is complete until {end}"
            return f"log: {name!r} is incomplete, it holds the run until {end}; `granular-env recover` makes it whole"
    except GranularError:
        return f"log: {name!r} cannot be read"
