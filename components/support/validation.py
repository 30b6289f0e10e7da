"""Checking what people give: parameters against their model, start values against shapes; one sentence for each fault."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from ..elements import check_index, index_text, parse_index
from ..errors import Fault, Location, ParameterError, nearest, shortened
from .arrays import FloatArray

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


def validate_parameters(model: type[Model], fields: Mapping[str, Any], where: str) -> Model:
    """Return a pydantic model from keyword arguments; every fault in one `ParameterError`, unknown names with the nearest."""
    try:
        return model(**fields)
    except ValidationError as error:
        raise ParameterError(*(replace(fault, source=where) for fault in faults_of(error, fields, model))) from None


def faults_of(error: ValidationError, given: Any, model: type[BaseModel]) -> list[Fault]:
    """Return what pydantic found as faults, located by the keys and indices of what was given."""
    groups: dict[str, list[Any]] = {}
    for one in error.errors():
        groups.setdefault(str(one["loc"][0]) if one["loc"] else "", []).append(one)
    return list({str(fault): fault for group in groups.values() for fault in _faults_of_field(group, given, model)}.values())


def refusal(received: str, expected: str = "", hint: str = "", at: Location = ()) -> PydanticCustomError:
    """Return a fault as what a pydantic validator raises; `at` is its location below what is validated."""
    return PydanticCustomError(_FAULT, "{fault}", {"fault": Fault(at, received, expected, hint)})


def as_validation_error(faults: Iterable[Fault]) -> ValidationError:
    """Return faults as an error of pydantic: raised in a validator, they come out of the outermost model, located there."""
    details = [
        InitErrorDetails(
            type=PydanticCustomError(_FAULT, "{fault}", {"fault": replace(fault, location=())}), loc=fault.location, input=None
        )
        for fault in faults
    ]
    return ValidationError.from_exception_data("faults", details)


# The type of pydantic's errors that carry a fault.
_FAULT = "fault"
# What each type of pydantic's errors expected, with its figures.
_EXPECTED = {
    "bool_parsing": "true or false",
    "bool_type": "true or false",
    "finite_number": "a finite number",
    "float_parsing": "a number",
    "float_type": "a number",
    "greater_than": "greater than {gt:.10g}",
    "greater_than_equal": "greater than or equal to {ge:.10g}",
    "int_from_float": "a whole number",
    "int_parsing": "a whole number",
    "int_parsing_size": "a smaller whole number",
    "int_type": "a whole number",
    "less_than": "less than {lt:.10g}",
    "less_than_equal": "less than or equal to {le:.10g}",
    "list_type": "a list",
    "literal_error": "{expected}",
    "string_pattern_mismatch": "a text that matches {pattern}",
    "string_too_short": "a text of at least {min_length} letters",
    "string_type": "a text",
    "too_long": "at most {max_length} of them",
    "too_short": "at least {min_length} of them",
    "tuple_type": "a list",
    "union_tag_invalid": "{expected_tags}",
}


def _faults_of_field(errors: list[Any], given: Any, model: type[BaseModel]) -> list[Fault]:
    """Return the faults of one field; of a union those of the alternative that was meant: the right type, but out of range."""
    meant = [one for one in errors if not one["type"].endswith(("_type", "_parsing"))]
    alternatives = {one["loc"][1] for one in errors if len(one["loc"]) > 1}
    return [_fault(one, given, model) for one in meant or (errors[:1] if len(alternatives) > 1 else errors)]


def _fault(error: Any, given: Any, model: type[BaseModel]) -> Fault:
    kind = error["type"]
    place = _place(error["loc"], given, kind in ("missing", _FAULT))
    if kind == _FAULT:
        fault = error["ctx"]["fault"]
        return replace(fault, location=(*place, *fault.location))
    if kind == "extra_forbidden":
        return Fault(place, "unknown", hint=_advice_for_unknown(place, given, error["input"], model))
    if kind == "missing":
        return Fault(place, "missing", hint=_advice_for_missing(place, model))
    if kind == "value_error":
        return Fault(place, str(error["ctx"]["error"]))
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return Fault(place, f"got {shortened(error['input'])}", "a table of keys and values")
    if kind == "list_type" and isinstance(error["input"], Mapping):
        name = ".".join(map(str, place))
        return Fault(
            place, f"got {shortened(error['input'])}", f"a list; tables of a list are written [[{name}]], with two brackets"
        )
    expected = _EXPECTED[kind].format(**error.get("ctx", {})) if kind in _EXPECTED else error["msg"]
    return Fault(place, f"got {shortened(error['input'])}", expected)


def _place(loc: Location, given: Any, may_be_missing: bool) -> Location:
    """Return a location without the names that pydantic puts in for the alternatives of a union that it tried."""
    place: list[str | int] = []
    for depth, part in enumerate(loc):
        if _holds(given, part):
            place.append(part)
            given = given[part]
        elif may_be_missing and depth == len(loc) - 1:
            place.append(part)
    return tuple(place)


def _holds(given: Any, part: str | int) -> bool:
    if isinstance(given, Mapping):
        return part in given
    return isinstance(given, list | tuple | np.ndarray) and isinstance(part, int) and part < len(given)


def _advice_for_unknown(place: Location, given: Any, value: Any, model: type[BaseModel]) -> str:
    if len(place) != 1:
        return "remove it"
    own = getattr(model, "advice_for_unknown", None)
    if own is not None and (advice := own(str(place[0]), given)):
        return advice
    known = (field.alias or key for key, field in model.model_fields.items())
    return _owner(model, str(place[0]), value) or nearest(str(place[0]), known)


def _advice_for_missing(place: Location, model: type[BaseModel]) -> str:
    fields = {field.alias or key: field for key, field in model.model_fields.items()}
    field = fields.get(str(place[0])) if place else None
    if field is None:
        return "it has no default"
    extra = field.json_schema_extra
    own = extra.get("advice") if isinstance(extra, dict) else None
    return str(own) if own else f"it is {field.description}" if field.description else "it has no default"


def _owner(model: type[BaseModel], name: str, value: Any) -> str:
    """Return advice where a name belongs to a table that another parameter chooses by name; empty where it does not."""
    from .tagged_union import tables

    for parameter, choices in tables(model).items():
        owners = [choice for choice, table in choices.items() if name in table.model_fields]
        if owners:
            example = f'{parameter} = {{"name": "{owners[0]}", "{name}": {shortened(value, 30)}}}'
            known = " or ".join(filter(None, [", ".join(map(repr, owners[:-1])), repr(owners[-1])]))
            return f"it belongs to {parameter} {known}: give {example}"
    return ""


def start_array(name: str, value: Any, shape: tuple[int, ...]) -> FloatArray:
    """Return an array of `shape` from a number or a row for all, an array, or {index: value or row} (the rest is 0).

    A row is what one index of the first axis holds: for shape (n, 2) two numbers; {"3,1": value} or {(3, 1): value} gives a
    single element.

    Raises:
        ParameterError: it is none of these, or not finite.
    """
    array = np.zeros(shape)
    if not isinstance(value, Mapping):
        array[...] = _values(name, value, shape, "a single number, or")
        return array
    if not shape:
        raise ParameterError("got {index: value}, expected a single number", at=name)
    indices = [_index(name, key, shape) for key in value]
    if len(set(indices)) < len(indices):
        raise ParameterError(f"got the indices {shortened(list(value))}, expected each index once", at=name)
    for index, item in zip(indices, value.values(), strict=True):
        place, rest = f"{name}[{index_text(index)}]", shape[len(index) :]
        array[index] = _values(place, item, rest, "a number, or") if rest else finite_number(place, item)
    return array


def _values(name: str, value: Any, shape: tuple[int, ...], also: str) -> FloatArray:
    """Return finite numbers that can be laid over an array of that shape: one, a row, or all of them."""
    try:
        given = np.asarray(value)
    except ValueError as error:  # rows of unlike length
        raise ParameterError(f"got {shortened(value)}, expected a number or an array of shape {shape}", at=name) from error
    if given.dtype.kind not in "fiub":
        raise ParameterError(
            f"got {shortened(value)}, expected a number, an array of shape {shape}, or {{index: value}}", at=name
        )
    # A row for all only where there are several axes: for shape (n,) a row is a number.
    rows = [shape[1:]] if len(shape) > 1 else []
    if given.shape not in ((), *rows, shape):
        known = " or ".join(f"shape {one}" for one in (*rows, shape))
        raise ParameterError(f"got shape {given.shape}, expected {also} {known}", at=name)
    if not np.isfinite(given).all():
        where = [int(index) for index in np.argwhere(~np.isfinite(given))[0]]
        raise ParameterError(f"got {given[tuple(where)]}, expected a finite number", at=f"{name}{where or ''}")
    return given.astype(np.float64)


def _index(name: str, key: Any, shape: tuple[int, ...]) -> tuple[int, ...]:
    """Return the index of a row or of an element, counted from 0."""
    try:
        index = parse_index(key)
        # One number is a row's; more must be an element's.
        check_index(index, shape[:1] if len(index) == 1 else shape, f"got the index {shortened(key)}")
    except ParameterError as error:
        raise ParameterError(*(fault.within(*name.split(".")) for fault in error.faults)) from None
    return tuple(number % size for number, size in zip(index, shape, strict=False))


def finite_number(name: str, value: Any, expected: str = "a number") -> float:
    """`value` as a float; `ParameterError` for text, arrays, NaN, infinity and whatever else is no number."""
    try:
        if isinstance(value, (str, bytes, bool)) or np.ndim(value):
            raise TypeError
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise ParameterError(f"got {shortened(value)}, expected {expected}", at=name) from error
    if not math.isfinite(number):
        raise ParameterError(f"got {number}, expected a finite number", at=name)
    return number


def positive_number(name: str, value: Any) -> float:
    """`value` as a float above 0; `ParameterError` otherwise."""
    number = finite_number(name, value)
    if number <= 0.0:
        raise ParameterError(f"got {number:g}, expected more than 0", at=name)
    return number


def whole_number(name: str, value: Any, least: int = 1, most: int | None = None) -> int:
    """`value` as an int from `least` to `most`; `ParameterError` for truth values, fractions and whatever else is none."""
    if (
        isinstance(value, bool)
        or not isinstance(value, (int, np.integer))
        or value < least
        or (most is not None and value > most)
    ):
        limits = f"of at least {least}" if most is None else f"from {least} to {most}"
        raise ParameterError(f"got {shortened(value)}, expected a whole number {limits}", at=name)
    return int(value)


def plain(name: str, value: Any) -> Any:
    """Return a parameter as pydantic takes it: arrays and tuples as lists, numpy's numbers as Python's, no truth values."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, tuple):
        return list(value)
    if isinstance(value, bool):
        raise ValueError(f"{name}: got {value}, expected no truth value")
    return value
