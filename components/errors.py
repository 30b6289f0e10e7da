"""The one family of errors, and the wording they share.

Every error names the argument, what came, what was expected and what to do. Nothing else leaves the public API.
"""

from __future__ import annotations

import difflib
import sys
import warnings
from collections.abc import Iterable


class GranularError(Exception):
    """Base of every error that this package raises on purpose."""


class ParameterError(GranularError, ValueError):
    """An argument, a parameter, an input or a start value is not what was declared."""


class StepError(GranularError, ArithmeticError):
    """A step would have left the physics; the component still has the state from before it.

    Attributes:
        time: simulated time at which the limit was passed [s].
        variable: name of the variable that passed it.
        index: position in that variable, or None for a scalar.
        value: what was reached.
        limit: what is allowed.
    """

    def __init__(self, message: str, *, time: float, variable: str, index: int | None, value: float, limit: float):
        super().__init__(message)
        self.time, self.variable, self.index, self.value, self.limit = time, variable, index, value, limit


class LogError(GranularError):
    """A log or a snapshot cannot be written, or is not one, or is damaged, or asks for more than the caps allow."""


class ExperimentError(GranularError, ValueError):
    """An experiment file or one of the files it names is not valid."""


class SweepError(GranularError):
    """A sweep's results cannot be kept or read, or the processes or the cluster that compute it cannot be used."""


class FmuError(GranularError):
    """An FMU cannot be exported, loaded or run."""


class MissingExtraError(GranularError, ImportError):
    """An optional package is needed and not installed."""


class GranularWarning(UserWarning):
    """Something a scientist should know about a run that goes on."""


def shortened(value: object, length: int = 80) -> str:
    """What came, for a message: its repr, cut where it is long."""
    try:
        text = repr(value)
    except Exception:  # an integer of more than 4300 digits has none
        text = f"a {type(value).__name__}"
    return text if len(text) <= length else f"{text[: length - 3]}..."


def caution(message: str) -> None:
    """Warn, and point at the line of the caller's own code that led here."""
    level, frame = 1, sys._getframe()
    package = __name__.partition(".")[0]
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == package:
        level, frame = level + 1, frame.f_back
    warnings.warn(message, GranularWarning, stacklevel=level)


def nearest(word: str, known: Iterable[str]) -> str:
    """Advice for a name that is not known: the nearest right one, or the list of all of them."""
    names = sorted(known)
    close = difflib.get_close_matches(str(word), names, n=1, cutoff=0.6)
    if close:
        return f"did you mean {close[0]!r}?"
    return f"known: {', '.join(names) or 'none'}"
