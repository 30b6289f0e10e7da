"""Validation of parameters against their model, and of single numbers; every fault has a location."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, TypeVar, get_args

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError, model_validator

from ..errors import Fault, GranularError, Location, ParameterError, location_text, one_line, spelling_hint, to_location
from .parameter_fields import field_unit
from .quantities import to_si

Model = TypeVar("Model", bound=BaseModel)
_FLOAT = np.dtype(np.float64)
_INDEX = re.compile(r"-?\d{1,9}(,-?\d{1,9})*")


class Fixed(BaseModel):
    """Immutable values, validated on construction: no conversions, no unknown keys, finite numbers."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_"):
            hint = f"{type(self).__name__} is read-only; create a new one with that value"
            raise ParameterError(f"got {one_line(value)}", hint=hint, at=(name,))
        super().__setattr__(name, value)

    @model_validator(mode="before")
    @classmethod
    def _plain_fields(cls, fields: Any) -> Any:
        """Return the fields in types that pydantic accepts: arrays and tuples as lists, numbers and quantities as floats."""
        if not isinstance(fields, dict):
            return fields
        units = {field.alias or name: field_unit(field) for name, field in cls.model_fields.items()}
        plain = {name: to_plain(value) for name, value in fields.items()}
        return {
            name: to_si(value, unit, (name,)) if (unit := units.get(name, "1")) not in ("", "1") else value
            for name, value in plain.items()
        }


class Parameters(Fixed):
    """Base of parameters of components: read-only, no unknown keys, finite numbers, and a unit for every field."""

    model_config = ConfigDict(validate_default=True)


@dataclass(frozen=True)
class Choices:
    """Annotation of a parameter field whose value is one of several tables.

    Attributes:
        choices: the model of each table, by its name.
    """

    choices: Mapping[str, type[Parameters]]


def table_choices(model: type[BaseModel]) -> dict[str, Mapping[str, type[Parameters]]]:
    """Return the parameters of a model that are tables chosen by name: parameter -> name -> table."""
    marks = ((name, mark) for name, field in model.model_fields.items() for mark in field.metadata)
    return {name: mark.choices for name, mark in marks if isinstance(mark, Choices)}


def validate_parameters(model: type[Model], fields: Mapping[str, Any], source: str) -> Model:
    """Return a model from keyword arguments; one `ParameterError` reports all faults and the names nearest to unknown ones."""
    try:
        return model(**fields)
    except ValidationError as error:
        raise ParameterError(*(replace(fault, source=source) for fault in validation_faults(error, fields, model))) from None


def validation_faults(error: ValidationError, given: Any, model: type[BaseModel]) -> list[Fault]:
    """Return pydantic's errors as faults, located by the keys and indices of the given values."""
    groups: dict[str, list[Any]] = {}
    for one in error.errors():
        groups.setdefault(str(one["loc"][0]) if one["loc"] else "", []).append(one)
    return list({str(fault): fault for group in groups.values() for fault in _field_faults(group, given, model)}.values())


# The expected value for each type of pydantic error.
_EXPECTED = {
    "bool_type": "true or false",
    "finite_number": "a finite number",
    "float_type": "a number",
    "greater_than": "greater than {gt:.10g}",
    "greater_than_equal": "greater than or equal to {ge:.10g}",
    "int_parsing": "a whole number",
    "int_type": "a whole number",
    "less_than": "less than {lt:.10g}",
    "less_than_equal": "less than or equal to {le:.10g}",
    "list_type": "a list",
    "literal_error": "{expected}",
    "string_pattern_mismatch": "a text that matches {pattern}",
    "string_too_long": "a text of at most {max_length} characters",
    "string_too_short": "a text of at least {min_length} characters",
    "string_type": "a text",
    "too_long": "at most {max_length} items",
    "too_short": "at least {min_length} items",
    "union_tag_invalid": "{expected_tags}",
}


def _field_faults(errors: list[Any], given: Any, model: type[BaseModel]) -> list[Fault]:
    """Return the faults of one field; for a union, those of the alternative with the matching type.

    The matching alternative has a value out of range, or the most deeply nested type error.
    """
    located = [(_fault_location(one["loc"], given), one["type"].endswith(("_type", "_parsing")), one) for one in errors]
    outermost = min(len(place) for place, *_ in located)
    meant = []
    for place, is_of_type, one in located:
        better = (other[: len(place)] == place and (len(other) > len(place) or not of_type) for other, of_type, _ in located)
        if not is_of_type or (len(place) > outermost and not any(better)):
            meant.append(one)
    alternatives = {one["loc"][1] for one in errors if len(one["loc"]) > 1}
    chosen = meant or (errors[:1] if len(alternatives) > 1 else errors)
    return [fault for one in chosen for fault in _error_faults(one, given, model)]


def _error_faults(error: Any, given: Any, model: type[BaseModel]) -> list[Fault]:
    raised, place = error.get("ctx", {}).get("error"), _fault_location(error["loc"], given)
    if isinstance(raised, GranularError):  # raised by our own validator
        return [replace(fault, location=(*place, *fault.location), source="") for fault in raised.faults]
    return [_fault_from_error(error, place, given, model)]


def _fault_from_error(error: Any, place: Location, given: Any, model: type[BaseModel]) -> Fault:
    kind = error["type"]
    if kind == "extra_forbidden":
        advice = _advice_for_unknown(place, given, error["input"], model)
        key = str(place[-1])
        return Fault((*place[:-1], *to_location(f"[{key}]")) if _INDEX.fullmatch(key) else place, "unknown", hint=advice)
    if kind == "missing":
        place = (*_fault_location(error["loc"][:-1], given), error["loc"][-1])
        return Fault(place, "missing", hint=_advice_for_missing(place, model))
    if kind == "value_error":
        return Fault(place, str(error["ctx"]["error"]))
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return Fault(place, f"got {one_line(error['input'])}", "a table of keys and values")
    if kind == "list_type" and isinstance(error["input"], Mapping):
        hint = f"write the tables of a list as [[{location_text(place)}]], with two brackets"
        return Fault(place, f"got {one_line(error['input'])}", "a list", hint)
    expected = _EXPECTED[kind].format(**error.get("ctx", {})) if kind in _EXPECTED else error["msg"]
    return Fault(place, f"got {one_line(error['input'])}", expected)


def _fault_location(loc: Location, given: Any) -> Location:
    """Return pydantic's location of an error without the names that it inserts for the alternatives of a union."""
    place = list(loc[:1])
    inner: Any = given.get(loc[0]) if loc and isinstance(given, Mapping) else None
    for part in loc[1:]:
        with suppress(TypeError, LookupError):
            inner = inner[part]
            place.append(part)
    return tuple(place)


def _advice_for_unknown(place: Location, given: Any, value: Any, model: type[BaseModel]) -> str:
    first, *further = place
    if further:
        part = _nested_model(model, first)
        return _advice_for_unknown(tuple(further), given[first], value, part) if part else "remove it"
    own = getattr(model, "advice_for_unknown", None)
    if own is not None and (advice := own(str(place[0]), given)):
        return advice
    known = (field.alias or key for key, field in model.model_fields.items())
    return _owner_hint(model, str(place[0]), value) or spelling_hint(str(place[0]), known)


def _nested_model(model: type[BaseModel], name: str | int) -> type[BaseModel] | None:
    """Return the model of the table that a field (perhaps optional) holds; None for a field without a table."""
    field = model.model_fields.get(str(name))
    kinds = (field.annotation, *get_args(field.annotation)) if field else ()
    return next((kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel)), None)


def _advice_for_missing(place: Location, model: type[BaseModel]) -> str:
    part = _nested_model(model, place[0]) if len(place) > 1 else None
    if part is not None:
        return _advice_for_missing(place[1:], part)
    fields = {field.alias or key: field for key, field in model.model_fields.items()}
    field = fields.get(str(place[0])) if len(place) == 1 else None
    if field is None:
        return "it has no default"
    extra = field.json_schema_extra
    own = extra.get("advice") if isinstance(extra, dict) else None
    return str(own) if own else f"meaning: {field.description}" if field.description else "it has no default"


def _owner_hint(model: type[BaseModel], name: str, value: Any) -> str:
    """Return the hint for a name that belongs to a table chosen by another parameter; otherwise ""."""
    for parameter, choices in table_choices(model).items():
        owners = [choice for choice, table in choices.items() if name in table.model_fields]
        if owners:
            example = f'{parameter} = {{"name": "{owners[0]}", "{name}": {one_line(value, 30)}}}'
            known = " or ".join(filter(None, [", ".join(map(repr, owners[:-1])), repr(owners[-1])]))
            return f"it belongs to {parameter} {known}: give {example}"
    return ""


def finite_number(at: str | Location, value: Any, expected: str = "a number", hint: str = "") -> float:
    """Return `value` as a finite float; `ParameterError` for text, truth values, arrays and anything else."""
    try:
        if isinstance(value, str | bytes | bool) or np.ndim(value) or getattr(value, "dtype", _FLOAT).kind not in "fiu":
            raise TypeError
        if isinstance(value, np.ma.MaskedArray):
            raise TypeError
        with np.errstate(over="ignore"):  # for a wider float type
            number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise ParameterError(f"got {one_line(value)}", expected=expected, hint=hint, at=at) from None
    if not math.isfinite(number):
        raise ParameterError(f"got {number}", expected="a finite number", at=at)
    return number


def positive_number(at: str | Location, value: Any) -> float:
    """Return `value` as a float above 0; `ParameterError` otherwise."""
    number = finite_number(at, value)
    if number <= 0.0:
        raise ParameterError(f"got {number:g}", expected="more than 0", at=at)
    return number


def whole_number(at: str | Location, value: Any, least: int = 1, most: int | None = None) -> int:
    """Return `value` as an int from `least` to `most`; `ParameterError` for anything else."""
    if (
        isinstance(value, bool)
        or not isinstance(value, (int, np.integer))
        or value < least
        or (most is not None and value > most)
    ):
        limits = f"of at least {least}" if most is None else f"from {least} to {most}"
        raise ParameterError(f"got {one_line(value)}", expected=f"a whole number {limits}", at=at)
    return int(value)


def to_plain(value: Any) -> Any:
    """Return a parameter in types that pydantic accepts; a masked array is returned unchanged, so that it is refused."""
    match value:
        case np.ma.MaskedArray():
            return value
        case np.ndarray() | np.generic():
            return value.tolist()
        case list() | tuple():
            return [to_plain(part) for part in value]
        case dict():
            return {key: to_plain(part) for key, part in value.items()}
    return value
