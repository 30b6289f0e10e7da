"""One element of a variable, or all of it, as people write it everywhere: `velocity`, `velocity[40]`, `velocity[3,1]`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .errors import Location, ParameterError, nearest, one_line

if TYPE_CHECKING:
    from .contract import Variable

# A name with or without an index, as a part of a longer text.
ELEMENT = r"[A-Za-z_]\w*(?:\[[^\[\]]*\])?"
_ELEMENT = re.compile(r"(?P<name>[A-Za-z_]\w*)(?:\[(?P<index>[^\[\]]*)\])?")
_INDEX = re.compile(r"\s*[+-]?\d{1,9}\s*(?:,\s*[+-]?\d{1,9}\s*)*")


@dataclass(frozen=True)
class Element:
    """An element of a variable, or all of it.

    Attributes:
        name: of the variable.
        index: a whole number for each axis, negative ones count from the end; empty for a number, or for all elements.
    """

    name: str
    index: tuple[int, ...] = ()

    def __str__(self) -> str:
        return f"{self.name}[{index_text(self.index)}]" if self.index else self.name

    def of(self, value: Any) -> Any:
        """Return the element of a value of the variable; the value itself without an index."""
        return value[self.index] if self.index else value

    def counted_from_the_start(self, shape: tuple[int, ...]) -> Element:
        """Return the same element of an array of that shape with no negative number in its index."""
        return Element(self.name, tuple(number % size for number, size in zip(self.index, shape, strict=False)))

    def find(self, variables: Mapping[str, Variable], what: str, *causalities: str) -> Variable:
        """Return the variable.

        Args:
            variables: of the component, by name.
            what: what is expected, for messages, such as "an output of component 'chain'".
            *causalities: those that may be meant.

        Raises:
            ParameterError: there is none of that name, the nearest is named; or no such element.
        """
        variable = variables.get(self.name)
        if variable is None or variable.causality not in causalities:
            known = [one.name for one in variables.values() if one.causality in causalities]
            raise ParameterError(f"got {self.name!r}", expected=what, hint=nearest(self.name, known))
        self.check(variable)
        return variable

    def check(self, variable: Variable) -> None:
        """Raise `ParameterError` where the variable has no such element."""
        if not self.index:
            return
        if not variable.shape:
            raise ParameterError(f"got {str(self)!r}", expected=f"no index: {self.name} is a single number")
        check_index((), self.index, variable.shape, f"{str(self)!r}", variable.axes)


def parse_element(text: Any) -> Element:
    """Return the element that a text names.

    Raises:
        ParameterError: it is no name, or its index is none.
    """
    match = _ELEMENT.fullmatch("".join(text.split())) if isinstance(text, str) else None
    if match is None:
        expected = "a variable, or an element of one, such as velocity, velocity[40] or velocity[3,1]"
        raise ParameterError(f"got {one_line(text)}", expected=expected)
    return Element(match["name"], () if match["index"] is None else parse_index(match["index"]))


def parse_index(given: Any) -> tuple[int, ...]:
    """Return the index that a whole number, a tuple of them, or a text such as "3,1" stands for.

    Raises:
        ParameterError: it is none.
    """
    parts = given if isinstance(given, tuple) and given else (given,)
    if isinstance(given, str):
        text = given.strip().removeprefix("(").removesuffix(")").rstrip(", ")
        parts = text.split(",") if _INDEX.fullmatch(text) else (given,)
    try:
        return tuple(_whole_number(part) for part in parts)
    except (TypeError, ValueError, OverflowError):
        expected = "a whole number for each axis, such as 3 or 3,1"
        raise ParameterError(f"got the index {one_line(given)}", expected=expected) from None


def is_index(given: Any) -> bool:
    """Return whether that stands for an index."""
    try:
        parse_index(given)
    except ParameterError:
        return False
    return True


def _whole_number(part: Any) -> int:
    number = int(part if not isinstance(part, bool) else "")
    if (isinstance(part, float) and part != number) or abs(number) >= 2**63:
        raise ValueError
    return number


def check_index(
    at: Location, index: tuple[int, ...], shape: tuple[int, ...], given: str = "", axes: tuple[str, ...] = ()
) -> None:
    """Raise `ParameterError` where an array of that shape has no such element; `given` is what messages call it."""
    if len(index) == len(shape) and all(-size <= number < size for number, size in zip(index, shape, strict=True)):
        return
    names = axes if len(axes) == len(shape) else ("",) * len(shape)
    limits = [f"{-size} to {size - 1}{f' ({name})' if name else ''}" for size, name in zip(shape, names, strict=True)]
    count = f"{len(shape)} numbers: " if len(shape) > 1 else ""
    expected = f"an index of {count}{', '.join(limits)}"
    if given:
        raise ParameterError(f"got {given}", expected=expected, at=at)
    raise ParameterError("there is no such element", expected=expected, at=(*at, *index))


def index_text(index: tuple[int, ...]) -> str:
    """Return an index as people write it, such as "3,1"."""
    return ",".join(map(str, index))
