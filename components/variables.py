"""Variables of components, and their elements in text form: ``velocity``, ``velocity[40]``, ``velocity[3,1]``."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Iterable, Mapping
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel

from .errors import Location, ParameterError, one_line, spelling_hint

# A variable name with or without an index, for use in longer patterns.
ELEMENT = r"[A-Za-z_]\w*(?:\[[^\[\]]*\])?"
_ELEMENT = re.compile(r"(?P<name>[A-Za-z_]\w*)(?:\[(?P<index>[^\[\]]*)\])?")
_DTYPES = {bool: "bool", int: "int64", str: "str"}
# Names of the entries along an axis, by the name of the axis and the number of entries.
DIRECTIONS = ("x", "y", "z")
_ENTRIES = {
    "direction": {count: DIRECTIONS[:count] for count in (1, 2, 3)},
    "entry": {3: ("xx", "yy", "xy"), 4: ("xx", "yy", "zz", "xy"), 6: ("xx", "yy", "zz", "xy", "yz", "zx")},
    "strain": {2: ("along", "across")},
}
_INDEX = re.compile(r"\s*[+-]?\d{1,9}\s*(?:,\s*[+-]?\d{1,9}\s*)*")


@dataclasses.dataclass(frozen=True, slots=True)
class Variable:
    """A named quantity of a component, with the metadata for files, Gymnasium spaces, schemas and documentation."""

    name: str
    causality: Literal["parameter", "input", "output"]
    unit: str
    shape: tuple[int, ...]
    description: str
    dtype: str = "float64"
    start: Any = None
    minimum: float = -math.inf
    maximum: float = math.inf
    state: bool = False
    """Whether the variable belongs to the state, so that `reset` accepts it and logs hash it."""
    axes: tuple[str, ...] = ()
    """Name of each axis of the shape, such as ("grain",). Variables with the same axis share it in a data set."""
    nominal: float = 1.0
    """Usual magnitude of the values; it is stored in logs, and templates of experiments use it in examples."""
    variability: Literal["", "constant", "fixed", "tunable", "discrete", "continuous"] = ""
    """FMI's variability; by default "fixed" for parameters, "continuous" for inputs and outputs."""
    initial: Literal["", "exact", "approx", "calculated"] = ""
    """FMI's initial; by default "calculated" for outputs that are not state, else "exact"."""

    def __post_init__(self) -> None:
        if not self.variability:
            object.__setattr__(self, "variability", "fixed" if self.causality == "parameter" else "continuous")
        if not self.initial:
            object.__setattr__(self, "initial", "exact" if self.state or self.causality != "output" else "calculated")


def entry_names(axis: str, size: int) -> tuple[str, ...]:
    """Return the names of the entries along an axis: x, y of vectors, xx, yy, xy of symmetric tensors, () of other arrays."""
    return _ENTRIES.get(axis, {}).get(size, ())


def parameter_variables(model: type[BaseModel], parameters: BaseModel | None = None) -> Iterable[Variable]:
    """Return the fields of a parameter model as variables: unit and shape come from each field's declaration."""
    for name, field in model.model_fields.items():
        extra = field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
        start = getattr(parameters, name) if parameters is not None else field.get_default()
        shape = np.shape(start) if isinstance(start, (list, tuple)) and all(isinstance(x, float) for x in start) else ()
        dtype = str(extra.get("dtype") or _DTYPES.get(type(start), "float64"))
        yield Variable(name, "parameter", str(extra.get("unit", "")), tuple(shape), field.description or "", dtype, start)


@dataclasses.dataclass(frozen=True)
class Element:
    """An element of a variable, or the whole variable.

    Attributes:
        name: name of the variable.
        index: an integer per axis, negative ones count from the end; empty for a scalar, or for all elements.
    """

    name: str
    index: tuple[int, ...] = ()

    def __str__(self) -> str:
        return f"{self.name}[{index_text(self.index)}]" if self.index else self.name

    def select_from(self, value: Any) -> Any:
        """Return this element of a value of the variable; without an index, the value itself."""
        return value[self.index] if self.index else value

    def find_variable(self, variables: Mapping[str, Variable], expected: str, *causalities: str) -> Variable:
        """Return the variable to which this element belongs, after checking that it exists and has an accepted causality.

        Args:
            variables: all variables of the component, by name.
            expected: for messages, such as "an output of component 'chain'".
            *causalities: accepted causalities.

        Raises:
            ParameterError: there is no such variable or no such element.
        """
        variable = variables.get(self.name)
        if variable is None or variable.causality not in causalities:
            known = [one.name for one in variables.values() if one.causality in causalities]
            raise ParameterError(f"got {self.name!r}", expected=expected, hint=spelling_hint(self.name, known))
        self.check_variable(variable)
        return variable

    def check_variable(self, variable: Variable) -> None:
        """Raise `ParameterError` if the variable has no such element."""
        if not self.index:
            return
        if not variable.shape:
            raise ParameterError(f"got {str(self)!r}", expected=f"no index: {self.name} is a single number")
        check_index((), self.index, variable.shape, f"{str(self)!r}", variable.axes)


def parse_element(text: Any) -> Element:
    """Return the element named by a text; `ParameterError` for anything else."""
    match = _ELEMENT.fullmatch("".join(text.split())) if isinstance(text, str) else None
    if match is None:
        expected = "a variable or an element of a variable, such as velocity, velocity[40] or velocity[3,1]"
        raise ParameterError(f"got {one_line(text)}", expected=expected)
    return Element(match["name"], () if match["index"] is None else parse_index(match["index"]))


def parse_index(value: Any) -> tuple[int, ...]:
    """Return an index from an integer, a tuple of integers, or a text such as "3,1"; `ParameterError` for anything else."""
    parts = value if isinstance(value, tuple) and value else (value,)
    if isinstance(value, str):
        text = value.strip().removeprefix("(").removesuffix(")").rstrip(", ")
        parts = text.split(",") if _INDEX.fullmatch(text) else (value,)
    try:
        return tuple(_whole_number(part) for part in parts)
    except (TypeError, ValueError, OverflowError):
        expected = "a whole number for each axis, such as 3 or 3,1"
        raise ParameterError(f"got the index {one_line(value)}", expected=expected) from None


def is_index(value: Any) -> bool:
    """Return whether `parse_index` accepts a value."""
    try:
        parse_index(value)
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
    """Raise `ParameterError` if an array of this shape has no such element; messages call the index `given`."""
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
    """Return an index in text form, such as "3,1"."""
    return ",".join(map(str, index))
