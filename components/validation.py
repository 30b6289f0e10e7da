"""Checking what people give: parameters against their model, start values against shapes; one sentence for each fault."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ValidationError

from .errors import ParameterError, nearest, shortened
from .profiles import finite_number

FloatArray = npt.NDArray[np.float64]
Model = TypeVar("Model", bound=BaseModel)


def validated(model: type[Model], fields: Mapping[str, Any], where: str) -> Model:
    """A pydantic model from keyword arguments; every fault in one `ParameterError`, unknown names with the nearest."""
    try:
        return model(**fields)
    except ValidationError as error:
        raise ParameterError("\n".join(f"{where}: {line}" for line in explained(error, model))) from None


def explained(error: ValidationError, model: type[BaseModel]) -> list[str]:
    """One sentence for each fault that pydantic found: argument, what came, what was expected."""
    lines: list[str] = []
    for fault in error.errors():
        place = [str(part) for part in fault["loc"] if not _is_union_tag(part, model)]
        name = ".".join(place) or "parameters"
        if fault["type"] == "extra_forbidden":
            advice = nearest(str(fault["loc"][-1]), model.model_fields) if len(fault["loc"]) == 1 else "remove it"
            lines.append(f"{name}: unknown; {advice}")
        elif fault["type"] == "missing":
            lines.append(f"{name}: missing; {_meaning(model, place)}")
        else:
            text = fault["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
            given = repr(fault["input"])
            lines.append(
                f"{name}: got {given if len(given) < 80 else given[:77] + '...'}, expected {text}"
                if "Value error" not in fault["msg"]
                else f"{name}: {text}"
            )
    return list(dict.fromkeys(lines))


def _is_union_tag(part: Any, model: type[BaseModel]) -> bool:
    """Pydantic adds the name of each tried alternative to a fault's place; people need only the place."""
    return (
        isinstance(part, str)
        and part not in model.model_fields
        and not part.isidentifier()
        or part
        in {
            "float",
            "int",
            "str",
            "list",
            "constrained-str",
            "dict",
        }
    )


def _meaning(model: type[BaseModel], place: list[str]) -> str:
    field = model.model_fields.get(place[0]) if place else None
    return f"it is {field.description}" if field is not None and field.description else "it has no default"


def filled(name: str, value: Any, shape: tuple[int, ...]) -> FloatArray:
    """An array of `shape` from a number, an array, or {index: value} (the rest is 0); `ParameterError` otherwise."""
    array = np.zeros(shape)
    if isinstance(value, Mapping):
        for key, item in value.items():
            array[_index(name, key, shape)] = finite_number(f"{name}[{key}]", item)
        return array
    try:
        given = np.asarray(value)
    except ValueError as error:  # rows of unlike length
        raise ParameterError(f"{name}: got {shortened(value)}, expected a number or an array of shape {shape}") from error
    if given.dtype.kind not in "fiub":
        raise ParameterError(
            f"{name}: got {shortened(value)}, expected a number, an array of shape {shape}, or {{index: value}}"
        )
    if given.shape not in ((), shape):
        raise ParameterError(f"{name}: got shape {given.shape}, expected a single number or shape {shape}")
    if not np.isfinite(given).all():
        raise ParameterError(f"{name}: got NaN or infinity, expected finite numbers")
    array[...] = given
    return array


def _index(name: str, key: Any, shape: tuple[int, ...]) -> int:
    if len(shape) != 1:
        raise ParameterError(f"{name}: got {{index: value}} for shape {shape}, expected a number or an array of that shape")
    length = shape[0]
    try:
        index = int(key)
    except (TypeError, ValueError, OverflowError) as error:
        raise ParameterError(f"{name}: got the index {shortened(key)}, expected a whole number") from error
    if not -length <= index < length or (isinstance(key, float) and key != index):
        raise ParameterError(f"{name}: got the index {key}, expected {-length} to {length - 1}")
    return index
