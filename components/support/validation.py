"""Checking what people give: parameters against their model, start values against shapes; one sentence for each fault."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, ValidationError, model_validator

from ..errors import ParameterError, nearest, shortened

FloatArray = npt.NDArray[np.float64]
Model = TypeVar("Model", bound=BaseModel)


class Fixed(BaseModel):
    """Values that are checked when they are given, and do not change: no unknown keys, finite numbers."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_"):
            raise ParameterError(
                f"{name}: got {shortened(value)}, but {type(self).__name__} is fixed; make a new one with that value"
            )
        super().__setattr__(name, value)


class Parameters(Fixed):
    """Base of every component's parameters: frozen, no unknown keys, finite numbers; every field declares a unit."""

    model_config = ConfigDict(validate_default=True)

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, fields: Any) -> Any:
        if not isinstance(fields, dict):
            return fields
        truths = {name for name, field in cls.model_fields.items() if field.annotation is bool}
        return {name: value if name in truths else plain(name, value) for name, value in fields.items()}


def validated(model: type[Model], fields: Mapping[str, Any], where: str) -> Model:
    """A pydantic model from keyword arguments; every fault in one `ParameterError`, unknown names with the nearest."""
    try:
        return model(**fields)
    except ValidationError as error:
        raise ParameterError(f"{where}: " + "\n  ".join(explained(error, model))) from None


def explained(error: ValidationError, model: type[BaseModel]) -> list[str]:
    """One sentence for each fault that pydantic found: argument, what came, what was expected."""
    faults: dict[str, list[Any]] = {}
    for fault in error.errors():
        faults.setdefault(str(fault["loc"][0]) if fault["loc"] else "", []).append(fault)
    lines = [_sentence(fault, model) for group in faults.values() for fault in _telling(group)]
    return list(dict.fromkeys(lines))


def _telling(faults: list[Any]) -> list[Any]:
    """Of the faults of one field, those of the alternative that was meant: of the right type, but out of range."""
    meant = [fault for fault in faults if not fault["type"].endswith(("_type", "_parsing"))]
    alternatives = {fault["loc"][1] for fault in faults if len(fault["loc"]) > 1}
    return meant or (faults[:1] if len(alternatives) > 1 else faults)


def _sentence(fault: Any, model: type[BaseModel]) -> str:
    place = [str(part) for part in fault["loc"] if not _is_union_tag(part, model)]
    name = ".".join(place) or "parameters"
    if fault["type"] == "extra_forbidden":
        known = (field.alias or key for key, field in model.model_fields.items())
        advice = nearest(str(fault["loc"][-1]), known) if len(fault["loc"]) == 1 else "remove it"
        return f"{name}: unknown; {_owner(model, name, fault['input']) or advice}"
    if fault["type"] == "missing":
        return f"{name}: missing; {_meaning(model, place)}"
    if fault["msg"].startswith("Value error, "):
        text = fault["msg"].removeprefix("Value error, ")
        # A check of the whole model names its field itself.
        return f"{name}: {text}" if place else text
    expected = fault["msg"].removeprefix("Input should be ")
    return f"{name}: got {shortened(fault['input'])}, expected {expected}"


def _owner(model: type[BaseModel], name: str, value: Any) -> str:
    """Advice where a name belongs to a table that another parameter chooses by name; empty where it does not."""
    from .tagged_union import tables

    for parameter, choices in tables(model).items():
        owners = [choice for choice, table in choices.items() if name in table.model_fields]
        if owners:
            example = f'{parameter} = {{"name": "{owners[0]}", "{name}": {shortened(value, 30)}}}'
            return f"it belongs to {parameter} {' or '.join(map(repr, owners))}: give {example}"
    return ""


_TYPE_TAGS = {"float", "int", "str", "list", "constrained-str", "dict"}


def _is_union_tag(part: Any, model: type[BaseModel]) -> bool:
    """Pydantic adds the name of each tried alternative to a fault's place; people need only the place."""
    if not isinstance(part, str) or part in model.model_fields:
        return False
    return part in _TYPE_TAGS or not part.isidentifier() or part[:1].isupper()


def _meaning(model: type[BaseModel], place: list[str]) -> str:
    field = model.model_fields.get(place[0]) if place else None
    return f"it is {field.description}" if field is not None and field.description else "it has no default"


def start_array(name: str, value: Any, shape: tuple[int, ...]) -> FloatArray:
    """Return an array of `shape` from a number or a row for all, an array, or {index: value or row} (the rest is 0).

    A row is what one index of the first axis holds: for shape (n, 2) two numbers.

    Raises:
        ParameterError: it is none of these, or not finite.
    """
    array = np.zeros(shape)
    if not isinstance(value, Mapping):
        array[...] = _values(name, value, shape, "a single number, or")
        return array
    if not shape:
        raise ParameterError(f"{name}: got {{index: value}}, expected a single number")
    indices = [_index(name, key, shape[0]) for key in value]
    if len(set(indices)) < len(indices):
        raise ParameterError(f"{name}: got the indices {shortened(list(value))}, expected each index once")
    for index, item in zip(indices, value.values(), strict=True):
        place = f"{name}[{index}]"
        array[index] = _values(place, item, shape[1:], "a number, or") if len(shape) > 1 else finite_number(place, item)
    return array


def _values(name: str, value: Any, shape: tuple[int, ...], also: str) -> FloatArray:
    """Return finite numbers that can be laid over an array of that shape: one, a row, or all of them."""
    try:
        given = np.asarray(value)
    except ValueError as error:  # rows of unlike length
        raise ParameterError(f"{name}: got {shortened(value)}, expected a number or an array of shape {shape}") from error
    if given.dtype.kind not in "fiub":
        raise ParameterError(
            f"{name}: got {shortened(value)}, expected a number, an array of shape {shape}, or {{index: value}}"
        )
    # A row for all only where there are several axes: for shape (n,) a row is a number.
    rows = [shape[1:]] if len(shape) > 1 else []
    if given.shape not in ((), *rows, shape):
        known = " or ".join(f"shape {one}" for one in (*rows, shape))
        raise ParameterError(f"{name}: got shape {given.shape}, expected {also} {known}")
    if not np.isfinite(given).all():
        where = [int(index) for index in np.argwhere(~np.isfinite(given))[0]]
        raise ParameterError(f"{name}{where or ''}: got {given[tuple(where)]}, expected a finite number")
    return given.astype(np.float64)


def _index(name: str, key: Any, length: int) -> int:
    try:
        index = int(key if not isinstance(key, bool) else "")
    except (TypeError, ValueError, OverflowError) as error:
        raise ParameterError(f"{name}: got the index {shortened(key)}, expected a whole number") from error
    if not -length <= index < length or (isinstance(key, float) and key != index):
        raise ParameterError(f"{name}: got the index {key}, expected {-length} to {length - 1}")
    return index % length


def finite_number(name: str, value: Any, expected: str = "a number") -> float:
    """`value` as a float; `ParameterError` for text, arrays, NaN, infinity and whatever else is no number."""
    try:
        if isinstance(value, (str, bytes, bool)) or np.ndim(value):
            raise TypeError
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise ParameterError(f"{name}: got {shortened(value)}, expected {expected}") from error
    if not math.isfinite(number):
        raise ParameterError(f"{name}: got {number}, expected a finite number")
    return number


def positive_number(name: str, value: Any) -> float:
    """`value` as a float above 0; `ParameterError` otherwise."""
    number = finite_number(name, value)
    if number <= 0.0:
        raise ParameterError(f"{name}: got {number:g}, expected more than 0")
    return number


def plain(name: str, value: Any) -> Any:
    """A parameter as pydantic takes it: arrays and tuples as lists, numpy's numbers as Python's, no truth values."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, tuple):
        return list(value)
    if isinstance(value, bool):
        raise ValueError(f"{name}: got {value}, expected no truth value")
    return value
