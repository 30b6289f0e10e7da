"""What a run that failed left behind, told with its error."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from ..components.errors import GranularError
from .reader import open_log
from .recorder import Recorder


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
    name = os.fspath(path)
    try:
        with open_log(path, allow_large=True) as log:
            end = f"{log.end_tick * log.step_size:.9g} s"
            if log.complete:
                return f"log: {name!r} is complete until {end}"
            return f"log: {name!r} is incomplete, it holds the run until {end}; `granular-env recover` makes it whole"
    except GranularError:
        return f"log: {name!r} cannot be read"
