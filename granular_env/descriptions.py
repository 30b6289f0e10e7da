"""Components and experiments as text: for `granular-env list` and `granular-env describe`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pydantic import BaseModel

from granular_env.components import catalogue
from granular_env.components.contract import Variable
from granular_env.components.support.validation import Parameters, tables
from granular_env.domains import domain_of
from granular_env.experiments.templates import default_of, example_of, example_values, parts_of, unit_of, value_text
from granular_env.package_contents import first_sentence
from granular_env.terminal_text import columns, wrap_text

_NO_BATCH = "no native batch: make_vec steps one after the other, in Gymnasium's SyncVectorEnv"


def describe_component(name: str, parameters: dict[str, Any]) -> str:
    """Describe a component's parameters, inputs and outputs with units, shapes and meaning."""
    kind = catalogue.component_class(name)
    parts = [wrap_text(f"component {name}, version {kind.version}: {first_sentence(kind.__doc__ or '')}"), "", "parameters"]
    parts.append(columns(_rows(kind.Parameters)))
    for parameter, choices in tables(kind.Parameters).items():
        for choice, model in choices.items():
            parts += ["", wrap_text(f'{parameter} = {{ name = "{choice}", ... }}: {first_sentence(model.__doc__ or "")}')]
            parts += [columns(rows)] if (rows := [row for row in _rows(model) if row[0] != "name"]) else []
    for parameter, model in parts_of(kind.Parameters).items():
        parts += ["", wrap_text(f"{parameter} = {{ ... }}: {_where_described(model)}")]
    component = example_of(name, parameters)
    variables = [v for v in component.variables.values() if v.causality != "parameter"]
    for causality in ("input", "output"):
        if chosen := [v for v in variables if v.causality == causality]:
            rows = [(v.name, v.unit, str(v.shape) if v.shape else "number", v.description + _remarks(v)) for v in chosen]
            parts += ["", f"{causality}s", columns(rows)]
    if component.event_kinds:
        parts += ["", "events", columns(component.event_kinds.items())]
    if offered := _environments(name):
        parts += ["", "environments (gymnasium.make, gymnasium.make_vec)", columns(offered)]
    parts += ["", "What is (state) can be given to reset and [start]."]
    if given := {**example_values(kind.Parameters), **parameters}:
        parts.append(wrap_text("Shapes and inputs are those of this example; see others with --set:"))
        parts.append(columns((key, "=", value_text(value)) for key, value in given.items()))
    return "\n".join(parts)


def _where_described(model: type[BaseModel]) -> str:
    """Return where the keys of a part are described: with the component that has them, or here, by name."""
    for name in catalogue.names():
        if catalogue.component_class(name).Parameters is model:
            return f"the keys that `granular-env describe {name}` names"
    return ", ".join(model.model_fields)


def component_facts(name: str, parameters: dict[str, Any]) -> dict[str, Any]:
    """Return the same as JSON values, for programs."""
    kind = catalogue.component_class(name)
    keys = ("name", "unit", "default", "description")
    variables = [v for v in example_of(name, parameters).variables.values() if v.causality != "parameter"]
    facts: dict[str, Any] = {"name": name, "version": kind.version, "description": first_sentence(kind.__doc__ or "")}
    offered = domain_of(name).load("environments") or {}
    facts["events"] = dict(kind.event_kinds)
    facts["environments"] = [
        {"name": registered, "native_batch": one.vector_entry_point is not None} for registered, one in offered.items()
    ]
    facts["parameters"] = [dict(zip(keys, row, strict=True)) for row in _rows(kind.Parameters)]
    for causality in ("input", "output"):
        facts[f"{causality}s"] = [_facts_of_variable(v) for v in variables if v.causality == causality]
    return facts


def _remarks(variable: Variable) -> str:
    """Return in brackets what else is declared of a variable: what its indices count, whether it is state, bounds."""
    remarks = [f"by {' and '.join(variable.axes)}"] if variable.axes else []
    remarks += ["state"] if variable.state else []
    remarks += [variable.variability] if variable.variability != "continuous" else []
    remarks += [f"from {variable.minimum:g}"] if math.isfinite(variable.minimum) else []
    remarks += [f"to {variable.maximum:g}"] if math.isfinite(variable.maximum) else []
    return f" ({', '.join(remarks)})" if remarks else ""


def _facts_of_variable(variable: Variable) -> dict[str, Any]:
    """Return the declaration of a variable as JSON values, its attributes by FMI's names; bounds that do not bind are null."""
    facts = {
        key: getattr(variable, key) for key in ("name", "unit", "state", "description", "variability", "initial", "nominal")
    }
    bounds = {key: getattr(variable, key) for key in ("minimum", "maximum")}
    facts |= {key: bound if math.isfinite(bound) else None for key, bound in bounds.items()}
    return {**facts, "shape": list(variable.shape), "axes": list(variable.axes), "start": np.asarray(variable.start).tolist()}


def _environments(name: str) -> list[tuple[str, str]]:
    """Return the registered environments of a component, each with what make_vec makes of it."""
    offered = domain_of(name).load("environments") or {}
    return [(registered, "native batch" if one.vector_entry_point else _NO_BATCH) for registered, one in offered.items()]


def _rows(model: type[Parameters]) -> list[tuple[str, str, str, str]]:
    """Name, unit, default and meaning of each field."""
    return [(key, unit_of(field), default_of(field), field.description or "") for key, field in model.model_fields.items()]
