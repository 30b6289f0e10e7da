"""The parts of a component made of others: their parameters, variables, values and drawables, under a prefix."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar

from .component import Component
from .contract import Variable
from .drawables import Drawable
from .errors import ParameterError
from .snapshot import FloatArray

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


def part_variables(prefix: str, part: Component) -> Iterator[Variable]:
    """Yield the inputs and outputs of a part, with the names that they have in the whole."""
    for variable in part.declared():
        axes = tuple(axis if axis in _ENTRIES else f"{prefix} {axis}" for axis in variable.axes)
        text = f"{prefix}: {variable.description}"
        yield dataclasses.replace(variable, name=f"{prefix}_{variable.name}", description=text, axes=axes)


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
