"""The component that a log's header speaks of, made anew; nothing of a stranger's is imported or opened."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...components.catalogue import component_class, own_names
from ...components.component import Component
from ...components.errors import GranularError, LogError
from ...components.support.validation import validate_parameters
from ..container.limits import Limits
from ..format.records import damage


def own_or_given(name: Any, components: Mapping[str, type[Component]] | None) -> type[Component]:
    """Return the class of a component that a log names: a component of this package, or the class that the caller gives."""
    if components and name in components:
        return components[name]
    if not isinstance(name, str) or name not in own_names():
        raise LogError(
            f"the log is of a component {name!r}, which is not one of ours ({', '.join(own_names())})",
            hint=f"if you trust it, pass its class: components={{{name!r}: ...}}",
            at="header.component",
        )
    try:
        return component_class(name)
    except (GranularError, ImportError, AttributeError) as error:
        raise LogError(f"{name!r} cannot be loaded: {error}", at="header.component") from error


def build(header: Mapping[str, Any], caps: Limits, components: Mapping[str, type[Component]] | None) -> Component:
    """Return a fresh component with the log's parameters, whatever identity the log claims."""
    kind, given = own_or_given(header.get("component"), components), header.get("parameters")
    if not isinstance(given, dict) or not all(isinstance(name, str) for name in given):
        raise damage("missing", "header.parameters", caps.path)
    caps.parameters(given, kind.Parameters)
    try:
        validate_parameters(kind.Parameters, given, f"component {kind.name!r}")
        return kind(**given)
    except GranularError as error:
        raise LogError.of_content(error, "header", "parameters", source=f"log {caps.path!r}") from error
    except (ArithmeticError, ValueError, TypeError, MemoryError, RecursionError) as error:
        raise LogError(f"not valid for {kind.name!r}: {error}", at="header.parameters", source=f"log {caps.path!r}") from error


__all__ = ["build", "own_or_given"]
