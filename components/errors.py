"""The one family of errors, and the wording they share.

Every error names the argument, what came, what was expected and what to do. Nothing else leaves the public API.
"""

from __future__ import annotations

import dataclasses
import difflib
import sys
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

Location = tuple[str | int, ...]


@dataclass(frozen=True)
class Option:
    """An argument that a hint advises: `overwrite=True` in Python, `--overwrite` on the command line.

    Attributes:
        name: of the argument.
        value: to give.
        call: what a script writes instead where that is a function of its own.
    """

    name: str
    value: object = True
    call: str = ""


@dataclass(frozen=True)
class Override:
    """A key of a document that is set from outside: by a mapping in Python, by `--set` on the command line.

    Attributes:
        key: its parts, from the outermost table on.
        value: what it is set to.
        text: both, as ``key=value``.
    """

    key: tuple[str, ...]
    value: Any
    text: str


Term = Option | Override
Phrase = str | Term | tuple[str | Term, ...]
Words = Callable[[Term], str]


def python_words(term: Term) -> str:
    """Return an option or an override as a script writes it."""
    if isinstance(term, Option):
        return term.call or f"{term.name}={term.value!r}"
    return f"override {shortened(term.text, 60)}"


@dataclass(frozen=True)
class Fault:
    """One thing that is wrong, as data: each front end renders it in its own words.

    Attributes:
        location: the keys and indices that lead to it.
        received: what came, such as "got -1", "missing" or "unknown"; or the whole sentence.
        expected: what would be right.
        hint: what to do.
        source: what holds it: a file, a component, an override.
    """

    location: Location = ()
    received: Phrase = ""
    expected: Phrase = ""
    hint: Phrase = ""
    source: Phrase = ""

    def text(self, words: Words = python_words) -> str:
        """Return it as a sentence; `words` writes the options and overrides in it."""
        source, received, expected, hint = (
            _render(part, words) for part in (self.source, self.received, self.expected, self.hint)
        )
        said = ", ".join(filter(None, (received, f"expected {expected}" if expected else "")))
        said = "; ".join(filter(None, (said, hint)))
        place = ".".join(_cut(str(part)) for part in self.location)
        return ": ".join(filter(None, (source, place, said)))

    __str__ = text

    def within(self, *location: str | int) -> Fault:
        """Return it with the location of what it was found in before its own, unless it begins with that already."""
        if self.location[: len(location)] == location:
            return self
        return dataclasses.replace(self, location=(*location, *self.location))

    def of(self, source: str) -> Fault:
        """Return it with one more source before its own."""
        own = self.source if isinstance(self.source, tuple) else (self.source,)
        return dataclasses.replace(self, source=(source, ": ", *own) if own != ("",) else source)


def _cut(text: str, length: int = 60) -> str:
    return text if len(text) <= length else f"{text[: length - 3]}..."


def _render(phrase: Phrase, words: Words) -> str:
    parts = phrase if isinstance(phrase, tuple) else (phrase,)
    return "".join(part if isinstance(part, str) else words(part) for part in parts)


class GranularError(Exception):
    """Base of every error that this package raises on purpose.

    Args:
        faults: what is wrong; a plain sentence will do.
        at: the location of what the sentences are about, with dots between its parts.

    Attributes:
        faults: what is wrong, as data; the error's text is rendered from them.
    """

    def __init__(self, *faults: str | Fault, at: str = "") -> None:
        super().__init__(*faults)
        location = tuple(at.split(".")) if at else ()
        self.faults = tuple(one if isinstance(one, Fault) else Fault(location, one) for one in faults)

    def text(self, words: Words = python_words) -> str:
        """Return all faults, one a line."""
        return "\n".join(fault.text(words) for fault in self.faults)

    def __str__(self) -> str:
        return self.text()


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
    """Return a value for a message: its repr, cut where it is long."""
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
