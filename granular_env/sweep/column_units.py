"""Units of a sweep's columns: of the keys that it varies, and of its measures."""

from __future__ import annotations

from typing import Any

from granular_env.components.component import Component
from granular_env.components.support.parameter_fields import unit_of

from .plan import Plan

_SECONDS = ("duration", "record.every", "record.snapshot_every")
# Keys of an input's profile that are times; the others have the input's unit.
_TIMES = ("duration", "rise", "start", "offset_time")


def units_of(plan: Plan, component: Component) -> dict[str, str]:
    """Return the unit of each key and measure that has one, by its column; "1" where it is a plain number."""
    found = {key: _of_key(key, component) for key in plan.keys}
    found |= {name: measure.unit(component) for name, measure in plan.measure.items()}
    return {name: unit for name, unit in found.items() if unit}


def _of_key(key: str, component: Component) -> str:
    table, _, rest = key.partition(".")
    name, *inner = (part.strip("\"'") for part in rest.split("."))
    if key in _SECONDS or (table == "input" and inner and inner[-1] in _TIMES):
        return "s"
    if table == "component" and inner:
        return _of_field(component.parameters, name, *inner)
    variable = component.variables.get(name.partition("[")[0])
    return variable.unit if variable is not None and table in ("component", "start", "input") else ""


def _of_field(table: Any, name: str, *inner: str) -> str:
    """Return the unit of a field of a law, an arrangement or another table of parameters."""
    if inner:
        return _of_field(getattr(table, name, None), *inner)
    field = getattr(type(table), "model_fields", {}).get(name)
    return unit_of(field) if field is not None else ""
