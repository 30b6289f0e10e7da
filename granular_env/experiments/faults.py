"""How faults of an experiment file are told: file, table, key, what came, what was expected."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from granular_env.components.errors import ExperimentError, GranularError, StepError
from granular_env.components.support.validation import explained

Model = TypeVar("Model", bound="Table")


class Table(BaseModel):
    """Base of every table of an experiment file: frozen, strict about types, no unknown keys, finite numbers."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False, validate_default=True)


class Faults:
    """Collects what is wrong, so that a file's author sees all of it at once."""

    def __init__(self, origin: str) -> None:
        self.origin = origin
        self.lines: list[str] = []

    def add(self, place: str, message: str) -> None:
        """One more fault, at a key of the file."""
        self.lines.append(f"{self.origin}: {place}: {message}" if place else f"{self.origin}: {message}")

    def raise_any(self) -> None:
        """`ExperimentError` with a line for each fault, if there were any."""
        if self.lines:
            raise ExperimentError("\n".join(self.lines))

    def table(self, model: type[Model], content: Any, place: str) -> Model | None:
        """A table of the file as its model; None, and faults added, where it is not valid."""
        if not isinstance(content, Mapping):
            self.add(place, f"got {shortened(content)}, expected a table of keys and values")
            return None
        try:
            return model(**{str(key): value for key, value in content.items()})
        except ValidationError as error:
            for line in explained(error, model):
                self.lines.append(f"{self.origin}: {place + '.' if place else ''}{line}")
        except (ValueError, TypeError, OverflowError, RecursionError) as error:
            self.add(place, f"not usable: {error}")
        return None


@contextmanager
def blamed(origin: str, place: str) -> Iterator[None]:
    """Puts the file's name and the table in front of an error that a component raised about it."""
    try:
        yield
    except (ExperimentError, StepError):
        raise
    except GranularError as error:
        lines = str(error).splitlines() or [type(error).__name__]
        raise ExperimentError("\n".join(f"{origin}: {_placed(place, line)}" for line in lines)) from error
    except MemoryError as error:
        raise ExperimentError(f"{origin}: {place}: it asks for more memory than there is; make it smaller") from error


@contextmanager
def overridden(origin: str, overrides: Sequence[str]) -> Iterator[None]:
    """Names the override, instead of the file, in what is said of a key that it set."""
    try:
        yield
    except ExperimentError as error:
        if not overrides:
            raise
        lines = [_blamed(line, origin, overrides) for line in str(error).splitlines()]
        raise ExperimentError("\n".join(lines)) from error


def _blamed(line: str, origin: str, overrides: Sequence[str]) -> str:
    rest = line.removeprefix(f"{origin}: ")
    if rest == line:
        return line
    for override in reversed(overrides):
        table, *keys = (re.escape(part.strip()) for part in override.partition("=")[0].split("."))
        # What belongs to a component is told with its name: "component: 'chain': mass: ...".
        between = r"\W+(?:component\W+)?(?:'\w+'\W+)?" if keys else ""
        if re.match(rf"{table}{between}" + r"\W+".join(keys) + r"(?!\w)", rest):
            return f"override {shortened(override)}: {rest}"
    near = [override for override in overrides if re.match(rf"{re.escape(override.partition('.')[0])}\b", rest)]
    return f"{origin} with override {', '.join(map(shortened, near))}: {rest}" if near else line


def _placed(place: str, line: str) -> str:
    """The table in front of a message that does not begin with it already."""
    return line if line.startswith((f"{place}.", f"{place}:")) else f"{place}: {line}"


def shortened(value: Any, width: int = 60) -> str:
    """A value for a message, cut where it is long."""
    text = repr(value)
    return text if len(text) <= width else text[: width - 3] + "..."
