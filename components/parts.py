"""The parts of a composite component: their parameters, variables, values and drawables, under a prefix."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any, TypeVar

from .component import Component
from .drawables import OUTPUT_FIELDS, Drawable
from .errors import ParameterError
from .support.float_arrays import FloatArray
from .variables import Variable

Part = TypeVar("Part", bound=Component)


def make_part(kind: type[Part], owner: Component, name: str, **changes: Any) -> Part:
    """Return a part with the owner's parameters under `name`, modified by `changes`.

    Raises:
        ParameterError: the parameters are not valid; its location is in the parameters of the owner.
    """
    try:
        return kind(**{**getattr(owner.parameters, name).model_dump(), **changes})
    except ParameterError as error:
        source = f"component {owner.name!r}"
        raise ParameterError(
            *(dataclasses.replace(fault, source=source).with_outer_location(name) for fault in error.faults)
        ) from None


def part_variables(parts: Mapping[str, Component], own_axes: Collection[str] = ()) -> Iterator[Variable]:
    """Yield the inputs and outputs of the parts with their names in the owner: `<prefix>_<name>`.

    Axes that differ between the parts, `own_axes`, such as gauges, get the prefix too.
    """
    for prefix, part in parts.items():
        for variable in part.declared_variables():
            names = tuple(f"{prefix} {axis}" if axis in own_axes else axis for axis in variable.axes)
            text = f"{prefix}: {variable.description}"
            yield dataclasses.replace(variable, name=f"{prefix}_{variable.name}", description=text, axes=names)


def part_readers(prefix: str, part: Component) -> dict[str, Callable[[], Any]]:
    """Return the readers of the outputs of a part, by their names in the owner."""
    names = [variable.name for variable in part.declared_variables() if variable.causality == "output"]
    return {f"{prefix}_{name}": lambda name=name: part.peek(name) for name in names}


def part_values(prefix: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return those of the owner's values that belong to a part, under the part's own names (without the prefix)."""
    return {name.removeprefix(f"{prefix}_"): value for name, value in values.items() if name.startswith(f"{prefix}_")}


def part_drawable(prefix: str, drawable: Drawable, **changes: FloatArray) -> Drawable:
    """Return a drawable of a part, with output names of the owner, and with `changes` of other fields."""
    names = {key: f"{prefix}_{name}" for key in OUTPUT_FIELDS if (name := getattr(drawable, key, ""))}
    fields: dict[str, Any] = {**names, **changes}
    return dataclasses.replace(drawable, **fields)
