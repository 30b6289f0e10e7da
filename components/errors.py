"""The family of errors of this package, and their common wording.

Every error names the argument, the value received, the expected value and the remedy.
"""

from __future__ import annotations

import dataclasses
import difflib
import itertools
import re
import sys
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Self

Location = tuple[str | int, ...]

# A part of a location in text form: a name, or an index with or without brackets.
_PART = re.compile(r"\[\s*(-?\d+(?:\s*,\s*-?\d+)*)\s*\]|([^.\[\]]+)|[.\[\]]")


def to_location(location: str | Location) -> Location:
    """Return the location that a text denotes: ("input", "force", 0, 1) for "input.force[0,1]"."""
    if isinstance(location, tuple):
        return location
    parts: list[str | int] = []
    for index, name in _PART.findall(location):
        parts += map(int, index.split(",")) if index else [int(name) if name.isdecimal() else name] if name else []
    return tuple(parts)


def location_text(location: Location) -> str:
    """Return a location in text form: names separated by dots, indices in brackets, such as "input.force[0,1]"."""
    text = ""
    for is_index, parts in itertools.groupby(location, lambda part: isinstance(part, int)):
        if is_index:
            text += f"[{','.join(map(str, parts))}]"
        else:
            text += ("." if text else "") + ".".join(_shorten_text(str(part)) for part in parts)
    return text


@dataclass(frozen=True)
class Override:
    """A key of a document that a Python mapping or `--set` on the command line overrides.

    Attributes:
        key: path of the key, beginning with the outermost table.
        value: new value of the key.
        text: key and value, as ``key=value``.
    """

    key: tuple[str, ...]
    value: Any
    text: str

    def __str__(self) -> str:
        return f"override {one_line(self.text, 60)}"


@dataclass(frozen=True)
class Fault:
    """A fault as data.

    Attributes:
        location: the keys and indices that lead to the faulty value.
        received: for example "got -1", "missing" or "unknown"; or a description of the fault.
        expected: description of a valid value.
        hint: advice.
        source: the file, component or override that contains the value.
    """

    location: Location = ()
    received: str = ""
    expected: str = ""
    hint: str = ""
    source: str | Override = ""

    def __str__(self) -> str:
        said = ", ".join(filter(None, (self.received, f"expected {self.expected}" if self.expected else "")))
        said = "; ".join(filter(None, (said, self.hint)))
        return ": ".join(filter(None, (str(self.source), location_text(self.location), said)))

    def with_outer_location(self, *location: str | int) -> Fault:
        """Return the fault with an outer location prepended, unless its location already begins with it."""
        if self.location[: len(location)] == location:
            return self
        return dataclasses.replace(self, location=(*location, *self.location))

    def with_source(self, source: str) -> Fault:
        """Return the fault with a source prepended to its source."""
        return dataclasses.replace(self, source=": ".join(filter(None, (source, str(self.source)))))

    def with_hint(self, hint: str) -> Fault:
        """Return the fault with a hint appended to its hint."""
        return dataclasses.replace(self, hint="; ".join(filter(None, (self.hint, hint))))


def _shorten_text(text: str, length: int = 60) -> str:
    return text if len(text) <= length else f"{text[: length - 3]}..."


class GranularError(Exception):
    """Base of the errors that this package raises on purpose.

        raise ParameterError("got -1", expected="a number above 0", at="start.velocity[3]")

    Args:
        *faults: texts (the value received, or a whole sentence), `Fault` objects, or errors of this package, whose faults are
            added (Gymnasium re-raises the errors of its workers as ``kind(error)``).
        expected: description of a valid value.
        at: the location: a text such as "input.force[0,1]", or its parts.
        hint: advice.
        source: the file, component or override that contains the value.

    Attributes:
        faults: the faults as data; the text of the error is rendered from them.
    """

    def __init__(
        self,
        *faults: str | Fault | GranularError,
        at: str | Location = (),
        expected: str = "",
        hint: str = "",
        source: str = "",
    ) -> None:
        super().__init__(*faults)
        self.faults: tuple[Fault, ...] = ()
        for one in faults:
            if isinstance(one, GranularError):
                self.faults += one.faults
            else:
                self.faults += (one if isinstance(one, Fault) else Fault(to_location(at), one, expected, hint, source),)

    def __reduce__(self) -> tuple[Any, ...]:
        """Support pickle: workers send errors to the process that displays them."""
        return _recreate_error, (type(self), self.args, vars(self))

    def with_outer_location(self, *location: str | int) -> Self:
        """Return the error with an outer location prepended, to be raised instead."""
        return self._map_faults(lambda fault: fault.with_outer_location(*location))

    def with_source(self, source: str) -> Self:
        """Return the error with a source for faults without one, to be raised instead."""
        return self._map_faults(lambda fault: fault if fault.source else dataclasses.replace(fault, source=source))

    def with_hint(self, hint: str) -> Self:
        """Return the error with an additional hint, to be raised instead."""
        return self._map_faults(lambda fault: fault.with_hint(hint))

    def with_argument(self, argument: str, name: str) -> Self:
        """Return the error with an argument renamed, to be raised instead."""
        return self._map_faults(
            lambda fault: (
                dataclasses.replace(fault, location=(name, *fault.location[1:])) if fault.location[:1] == (argument,) else fault
            )
        )

    def _map_faults(self, change: Callable[[Fault], Fault]) -> Self:
        error = _recreate_error(type(self), self.args, vars(self))
        error.faults = tuple(map(change, self.faults))
        return error

    def __str__(self) -> str:
        return "\n".join(map(str, self.faults))


def _recreate_error(kind: type[Any], arguments: tuple[Any, ...], attributes: dict[str, Any]) -> Any:
    """Return a copy of an error, without calling its constructor."""
    error: Any = kind.__new__(kind, *arguments)
    error.args = arguments
    error.__dict__.update(attributes)
    return error


class ParameterError(GranularError, ValueError):
    """An argument, a parameter, an input or a start value is not valid."""


class StepError(GranularError, ArithmeticError):
    """The physics of a step would break down; the component has the state from before the step.

    Args:
        message: what happened to the variable, the expected value, and advice.
        at: location, such as "velocity[3]"; its first part is the variable.

    Attributes:
        time: simulated time at which the limit was passed [s].
        variable: name of the variable that passed its limit.
        index: index of the element of this variable, or of the cell or point; None for a scalar.
        value: value reached.
        limit: limit that was exceeded.
    """

    def __init__(
        self,
        message: str,
        *,
        time: float,
        variable: str,
        index: int | None,
        value: float,
        limit: float,
        at: str | Location = (),
    ):
        super().__init__(message, at=at)
        self.time, self.variable, self.index, self.value, self.limit = time, variable, index, value, limit

    def with_part_prefix(self, part: str) -> Self:
        """Return the error with the prefix of a part added to the name of its variable."""
        name = f"{part}_{self.variable}"
        error = self.with_argument(self.variable, name)
        error.variable = name
        return error


class LogError(GranularError):
    """A log or a snapshot cannot be written, is damaged, is not a log or snapshot, or exceeds the limits."""

    @classmethod
    def from_content(cls, error: GranularError, *location: str, source: str = "") -> Self:
        """Return an error in the content of a log as a `LogError`, with all its faults."""
        faults = (fault.with_outer_location(*location) for fault in error.faults)
        return cls(*(fault.with_source(source) for fault in faults))


class ExperimentError(GranularError, ValueError):
    """An experiment file or one of the files it names is not valid."""


class SweepError(GranularError):
    """Results of a sweep cannot be stored or read, or its processes or its cluster fail."""


class MissingExtraError(GranularError, ImportError):
    """An optional package is needed but not installed."""


class GranularWarning(UserWarning):
    """A warning about a run that continues."""


def one_line(value: object, length: int = 80) -> str:
    """Return a value in one line: its shortened repr; for an array, dtype and shape."""
    dtype, shape = getattr(value, "dtype", None), getattr(value, "shape", None)
    if dtype is not None and isinstance(shape, tuple):
        if shape or hasattr(value, "mask"):
            return f"{'a masked' if hasattr(value, 'mask') else 'an'} array of {dtype} of shape {shape}"
        value = getattr(value, "item", lambda: value)()
    try:
        text = " ".join(line.strip() for line in repr(value).splitlines())
    except Exception:  # e.g. repr fails for integers with more than 4300 digits
        text = f"a {type(value).__name__}"
    return _shorten_text(text, length)


def issue_warning(message: str) -> None:
    """Issue a `GranularWarning` located at the caller's own code."""
    level, frame = 1, sys._getframe()
    package = __name__.partition(".")[0]
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == package:
        level, frame = level + 1, frame.f_back
    warnings.warn(message, GranularWarning, stacklevel=level)


def spelling_hint(word: str, known_names: Iterable[str], addition: str = "") -> str:
    """Return the hint for an unknown name: a similar known one, or the list of all; then the text `addition`."""
    names = sorted(known_names)
    close = difflib.get_close_matches(str(word), names, n=1, cutoff=0.7)
    if close:
        return f"did you mean {close[0]!r}?{addition and ' '}{addition}"
    return f"known: {', '.join(names) or 'none'}{addition and '; '}{addition}"
