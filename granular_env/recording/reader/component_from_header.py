"""The component that a log's header speaks of, made anew; nothing of a stranger's is imported or opened."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...components.catalogue import component_class, own_names
from ...components.component import Component
from ...components.errors import GranularError, LogError, Option
from ...components.support.memory_limits import whole_memory
from ...components.support.validation import Parameters, validate_parameters
from ..container.limits import Limits
from ..format.records import damage

# The largest whole number among a component's parameters (grains, nodes, cells): at least, and at most, by the memory here.
_COUNT, _MOST = 10_000_000, 100_000_000
# A log that this machine could record, it may read as well: part of its memory that a component may take, and what one of
# the things that it counts takes in it, at least [bytes].
_COMPONENT_SHARE, _UNIT_BYTES = 2, 160


def own_or_given(name: Any, components: Mapping[str, type[Component]] | None) -> type[Component]:
    """Return the class of a component that a log names: a component of this package, or the class that the caller gives."""
    if components and name in components:
        return components[name]
    if not isinstance(name, str) or name not in own_names():
        raise LogError(
            f"the log is of a component {name!r}, which is not one of ours ({', '.join(own_names())})",
            hint=("if you trust it, pass ", Option("component", name, f"components={{{name!r}: ...}}, its class")),
            at="header.component",
        )
    try:
        return component_class(name)
    except (GranularError, ImportError, AttributeError) as error:
        raise LogError(f"{name!r} cannot be loaded: {error}", at="header.component") from error


def check_parameters(given: Mapping[str, Any], model: type[Parameters], limits: Limits) -> None:
    """Refuse too large whole numbers (grains, nodes, cells) among the parameters of a component to be built."""
    limit = max(_COUNT, min(_MOST, (whole_memory() or 0) // (_COMPONENT_SHARE * _UNIT_BYTES)))
    for name, field in model.model_fields.items():
        value = given.get(name)
        if field.annotation is int and isinstance(value, (int, float)) and not value <= limit:
            limits.check(f"parameter {name!r}", int(min(value, 2.0**62)), limit)


def build(header: Mapping[str, Any], limits: Limits, components: Mapping[str, type[Component]] | None) -> Component:
    """Return a fresh component with the log's parameters, whatever identity the log claims."""
    kind, given = own_or_given(header.get("component"), components), header.get("parameters")
    source = f"log {limits.path!r}"
    if not isinstance(given, dict) or not all(isinstance(name, str) for name in given):
        raise damage("missing", "header.parameters", limits.path)
    check_parameters(given, kind.Parameters, limits)
    try:
        validate_parameters(kind.Parameters, given, f"component {kind.name!r}")
        return kind(**given)
    except GranularError as error:
        raise LogError.of_content(error, "header", "parameters", source=source) from error
    except (ArithmeticError, ValueError, TypeError, MemoryError, RecursionError) as error:
        raise LogError(
            f"not valid for {kind.name!r}: {error}", at="header.parameters", source=f"log {limits.path!r}"
        ) from error


__all__ = ["build", "check_parameters", "own_or_given"]
