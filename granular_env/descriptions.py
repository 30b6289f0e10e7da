"""Text on components and experiments for `granular-env list` and `granular-env describe`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, NamedTuple, get_args, get_origin

import numpy as np
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from granular_env.components import catalogue
from granular_env.components.component import Component
from granular_env.components.support.parameter_fields import field_unit
from granular_env.components.support.validation import Choices, Parameters, table_choices
from granular_env.components.variables import Variable
from granular_env.domains import find_domain
from granular_env.experiments.templates import default_text, example_values, make_example, parameter_tables, value_text
from granular_env.package_contents import first_sentence
from granular_env.terminal_text import align_columns, wrap_text


class DescribedTable(NamedTuple):
    """A printed table of parameters or variables: the parameter it describes ("": the component), its title, and its rows."""

    key: str
    text: str
    rows: Sequence[tuple[str, ...]]


_NO_BATCH = "no native batch: make_vec steps the environments one by one, in Gymnasium's SyncVectorEnv"


def describe_component(name: str, parameters: dict[str, Any]) -> str:
    """Describe a component's parameters, inputs and outputs with units, shapes and meaning."""
    kind = catalogue.component_class(name)
    component = make_example(name, parameters)
    parts = [wrap_text(f"component {name}, version {kind.version}: {first_sentence(kind.__doc__ or '')}")]
    for table in described_parameters(kind.Parameters):
        parts += ["", wrap_text(": ".join(filter(None, table[:2])))] + ([align_columns(table.rows)] if table.rows else [])
    if any("[]" in part or ".*" in part for part in parts):
        parts += ["", wrap_text("NAME[] stands for each element of the list NAME, NAME.* for each table in NAME.")]
    for table in described_variables(component):
        parts += ["", table.text, align_columns(table.rows)]
    if offered := _component_environments(name):
        parts += ["", "environments (gymnasium.make, gymnasium.make_vec)", align_columns(offered)]
    parts += ["", "Variables marked (state) can be set with reset and in [start]."]
    if given := {**example_values(kind.Parameters), **parameters}:
        parts.append(wrap_text("Shapes and inputs are listed for this example; change its parameters with --set:"))
        parts.append(align_columns((key, "=", value_text(value)) for key, value in given.items()))
    return "\n".join(parts)


def described_parameters(model: type[BaseModel]) -> list[DescribedTable]:
    """Return the table of a model's parameters (name, unit, default, meaning), then one table for each named choice."""
    found = [DescribedTable("", "parameters", _parameter_rows(model))]
    for parameter, choice, table in _chosen_tables(model):
        rows = [row for row in _parameter_rows(table) if row[0] != "name"]
        found.append(DescribedTable(f'{parameter} = {{ name = "{choice}", ... }}', first_sentence(table.__doc__ or ""), rows))
    for parameter, part in parameter_tables(model).items():
        if component := _component_name(part):
            text = f"the keys listed by `granular-env describe {component}`"
            found.append(DescribedTable(f"{parameter} = {{ ... }}", text, []))
    return found


def described_variables(component: Component) -> list[DescribedTable]:
    """Return tables of a component's inputs and outputs (name, unit, shape, meaning) and of its events (name, meaning)."""
    found: list[DescribedTable] = []
    for causality in ("input", "output"):
        chosen = [v for v in component.variables.values() if v.causality == causality]
        rows = [(v.name, v.unit, str(v.shape) if v.shape else "number", v.description + _variable_remarks(v)) for v in chosen]
        found.append(DescribedTable("", f"{causality}s", rows))
    found.append(DescribedTable("", "events", list(component.event_kinds.items())))
    return [table for table in found if table.rows]


def _component_name(model: type[BaseModel]) -> str:
    """Return the name of the component whose parameters this pydantic model describes; "" if it belongs to no component.

    Only imported components are searched: a component imports its parts, and importing all components takes seconds.
    """
    return next((kind.name for kind in Component.__subclasses__() if kind.Parameters is model), "")


def component_facts(name: str, parameters: dict[str, Any]) -> dict[str, Any]:
    """Return the description of a component as JSON values."""
    kind = catalogue.component_class(name)
    variables = make_example(name, parameters).variables.values()
    facts: dict[str, Any] = {"name": name, "version": kind.version, "description": first_sentence(kind.__doc__ or "")}
    facts["events"] = dict(kind.event_kinds)
    facts["environments"] = [{"name": one, "native_batch": text != _NO_BATCH} for one, text in _component_environments(name)]
    facts["parameters"] = _parameter_facts(kind.Parameters)
    for causality in ("input", "output"):
        facts[f"{causality}s"] = [_variable_facts(v) for v in variables if v.causality == causality]
    return facts


def _variable_remarks(variable: Variable) -> str:
    """Return further properties of a variable as text in brackets: its axes, its bounds, whether it is part of the state."""
    remarks = [f"by {' and '.join(variable.axes)}"] if variable.axes else []
    remarks += ["state"] if variable.state else []
    remarks += [variable.variability] if variable.variability != "continuous" else []
    remarks += [f"from {variable.minimum:g}"] if math.isfinite(variable.minimum) else []
    remarks += [f"to {variable.maximum:g}"] if math.isfinite(variable.maximum) else []
    return f" ({', '.join(remarks)})" if remarks else ""


def _variable_facts(variable: Variable) -> dict[str, Any]:
    """Return the declaration of a variable as JSON values with FMI's attribute names; infinite bounds are null."""
    keys = ("name", "unit", "state", "description", "variability", "initial", "nominal")
    facts = {key: getattr(variable, key) for key in keys}
    bounds = {"minimum": variable.minimum, "maximum": variable.maximum}
    facts |= {key: bound if math.isfinite(bound) else None for key, bound in bounds.items()}
    return {**facts, "shape": list(variable.shape), "axes": list(variable.axes), "start": np.asarray(variable.start).tolist()}


def _component_environments(name: str) -> list[tuple[str, str]]:
    """Return the registered Gymnasium environments of a component, each with the kind of batch that `make_vec` gives."""
    offered = find_domain(name).load_attribute("environments") or {}
    return [(registered, "native batch" if find_domain(name).rows else _NO_BATCH) for registered in offered]


def _parameter_rows(model: type[BaseModel], prefix: str = "") -> list[tuple[str, str, str, str]]:
    """Return rows (name, unit, default, meaning) of a model's fields; a table's keys follow it, such as `notch.depth`."""
    rows = []
    for key, field in model.model_fields.items():
        name = prefix + key
        rows.append((name, field_unit(field), _short_default(field), field.description or ""))
        for place, table in _field_tables(field):
            rows += _parameter_rows(table, f"{name}{place}.")
    return rows


def _short_default(field: FieldInfo) -> str:
    """Return a field's default as TOML; of a table, only the keys that differ from the defaults shown in their own lines."""
    value = field.default
    if not isinstance(value, BaseModel | Mapping):
        return default_text(field)
    if isinstance(value, BaseModel):
        value = value.model_dump(exclude_defaults=True, exclude_none=True)
    return value_text(value if value.keys() != {"name"} else value["name"]) if value else "{}"


def _chosen_tables(model: type[BaseModel], prefix: str = "") -> Iterator[tuple[str, str, type[Parameters]]]:
    """Yield (parameter, name, model) of each table that is chosen by a name, such as a contact law, also inside tables."""
    for key, field in model.model_fields.items():
        for place, choice, table in _field_choices(model, key):
            yield f"{prefix}{key}{place}", choice, table
            yield from _chosen_tables(table, f"{prefix}{key}{place}.")
        for place, table in _field_tables(field):
            yield from _chosen_tables(table, f"{prefix}{key}{place}.")


def _field_choices(model: type[BaseModel], key: str) -> list[tuple[str, str, type[Parameters]]]:
    """Return the models, with locations, of the tables chosen by name in a field or its elements; see `_parts_of_type`."""
    if key in (own := table_choices(model)):
        return [("", choice, table) for choice, table in own[key].items()]
    found = _parts_of_type(model.model_fields[key].annotation)
    chosen = [(place, part.choices) for place, part in found if isinstance(part, Choices)]
    return [(place, choice, table) for place, choices in chosen for choice, table in choices.items()]


def _field_tables(field: FieldInfo) -> list[tuple[str, type[Parameters]]]:
    """Return the models of a field's tables that are not chosen by name, except of components; see `_parts_of_type`."""
    if any(isinstance(mark, Choices) for mark in field.metadata):
        return []
    found = _parts_of_type(field.annotation)
    return [(place, part) for place, part in found if not isinstance(part, Choices) and not _component_name(part)]


def _parts_of_type(annotation: Any, place: str = "") -> Iterator[tuple[str, type[Parameters] | Choices]]:
    """Yield the table models in a type annotation, with location: "" the type itself, "[]" in a list, ".*" in a mapping."""
    if isinstance(annotation, type) and issubclass(annotation, Parameters):
        yield place, annotation
        return
    kind, parts = get_origin(annotation), get_args(annotation)
    if kind is Annotated and (chosen := [mark for mark in parts[1:] if isinstance(mark, Choices)]):
        yield place, chosen[0]
        return
    if kind is dict:
        place, parts = f"{place}.*", parts[1:]
    elif kind in (list, tuple):
        place = f"{place}[]"
    for part in parts[:1] if kind is Annotated else parts:
        yield from _parts_of_type(part, place)


def _parameter_facts(model: type[BaseModel]) -> list[dict[str, Any]]:
    """Return the parameters of a model as JSON values; parameters that are tables have nested `parameters` and `choices`."""
    found = []
    for key, field in model.model_fields.items():
        facts: dict[str, Any] = {"name": key, "unit": field_unit(field), "default": default_text(field)}
        facts["description"] = field.description or ""
        if further := [one for _, table in _field_tables(field) for one in _parameter_facts(table)]:
            facts["parameters"] = further
        for _, choice, table in _field_choices(model, key):
            text = first_sentence(table.__doc__ or "")
            facts.setdefault("choices", {})[choice] = {"description": text, "parameters": _parameter_facts(table)}
        found.append(facts)
    return found
