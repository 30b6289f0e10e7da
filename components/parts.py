"""The parts of a component made of others: their parameters, variables, values and drawables, under a prefix."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar

from .component import Component
from .contract import Variable
from .drawables import Drawable
from .errors import ParameterError
from .support.arrays import FloatArray

Part = TypeVar("Part", bound=Component)
# Axes that mean the same in each part.
_ENTRIES = ("direction", "entry", "component", "station")
# What names an output, or "", in some kind of drawable.
_DRAWN = ("displacement", "colour", "rotation", "state", "field")


def make_part(kind: type[Part], owner: Component, name: str, **changes: Any) -> Part:
    """Return a part with the parameters that its owner has under `name`, but for the changes.

    Raises:
        ParameterError: what is wrong with its parameters, as of the owner's.
    """
    try:
        return kind(**{**getattr(owner.parameters, name).model_dump(), **changes})
    except ParameterError as error:
        source = f"component {owner.name!r}"
        raise ParameterError(*(dataclasses.replace(fault, source=source).within(name) for fault in error.faults)) from None


def part_variables(parts: Mapping[str, Component]) -> Iterator[Variable]:
    """Yield the inputs and outputs of the parts, given by prefix, with the names that they have in the whole.

    Axes keep their names, but for those that two parts have and that mean something else in each.
    """
    declared = {prefix: list(part.declared()) for prefix, part in parts.items()}
    axes = [{axis for variable in variables for axis in variable.axes} for variables in declared.values()]
    ambiguous = {axis for axis in set().union(*axes) - set(_ENTRIES) if sum(axis in some for some in axes) > 1}
    for prefix, variables in declared.items():
        for variable in variables:
            names = tuple(f"{prefix} {axis}" if axis in ambiguous else axis for axis in variable.axes)
            text = f"{prefix}: {variable.description}"
            yield dataclasses.replace(variable, name=f"{prefix}_{variable.name}", description=text, axes=names)


def part_readers(prefix: str, part: Component) -> dict[str, Callable[[], Any]]:
    """Return how to read the outputs of a part, by the names that they have in the whole."""
    names = [variable.name for variable in part.declared() if variable.causality == "output"]
    return {f"{prefix}_{name}": lambda name=name: part.peek(name) for name in names}


def part_values(prefix: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return those of the values that belong to a part, by its own names."""
    return {name.removeprefix(f"{prefix}_"): value for name, value in values.items() if name.startswith(f"{prefix}_")}


def part_drawable(prefix: str, drawable: Drawable, **changes: FloatArray) -> Drawable:
    """Return a drawable of a part, which names the outputs of the whole; `changes` of its other fields."""
    names = {key: f"{prefix}_{name}" for key in _DRAWN if (name := getattr(drawable, key, ""))}
    fields: dict[str, Any] = {**names, **changes}
    return dataclasses.replace(drawable, **fields)
