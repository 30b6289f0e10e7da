"""Template experiment files: a copy of an experiment, or all parameters of a component with their defaults."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, get_args

import numpy as np
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from granular_env.components import catalogue
from granular_env.components.component import Component
from granular_env.components.errors import ExperimentError
from granular_env.components.support.parameter_fields import absent_meaning, field_unit
from granular_env.components.support.validation import Parameters, table_choices
from granular_env.components.variables import Variable
from granular_env.documents import find_file, replace_name, to_toml, toml_value
from granular_env.documents.files import nearest_name_hint, read_data_file
from granular_env.output_files import write_files
from granular_env.package_contents import first_sentence, shipped_names

from .experiment import Experiment, load_experiment
from .inputs import csv_tables

_KEY_WIDTH = 40


def experiment_template(name: str, new_name: str | None = None, others: Iterable[str] = ()) -> str:
    """Return the text of an experiment file: for a component with all parameters, or of an experiment, as `new_name`.

    Raises:
        ExperimentError: unknown name; the message suggests the nearest name.
    """
    if name in catalogue.component_names():
        return _component_template(name)
    try:
        text = find_file(name, Experiment.kind, Experiment.shelf).read_text(encoding="utf-8")
    except ExperimentError as error:
        if Path(name).suffix == ".toml" or os.path.exists(name):
            raise
        advice = nearest_name_hint(name, [*shipped_names(), *others])
        raise ExperimentError(f"no component, experiment, plan or study named {name!r}", hint=advice) from error
    except (OSError, UnicodeDecodeError) as error:
        raise ExperimentError(f"cannot be read as text: {error}", expected="a TOML file", source=name) from error
    return text if new_name is None else replace_name(text, new_name)


def write_template(name: str, target: Path, force: bool = False, text: str = "") -> list[Path]:
    """Write a template file completely or not at all; replace nothing without `force`.

    Args:
        name: name of a template; the CSV files of an experiment are copied next to the new file.
        target: the file to write.
        force: whether existing files may be replaced.
        text: content of the file, if not from a template.

    Returns:
        The written files.
    """
    copies = {} if text or name in catalogue.component_names() else _data_files(name, target.parent)
    text = text or experiment_template(name, target.stem)
    for path in (target, *copies):
        if os.path.lexists(path) and not force:
            raise ExperimentError(f"{path} exists", hint="choose another name, or pass force=True (--force)")
    contents = {copied: read_data_file(original) for copied, original in copies.items()}
    write_files({**contents, target: text.encode("utf-8")}, ExperimentError)
    return [target, *copies]


def logged_experiment(path: str, new_name: str | None = None) -> str:
    """Return the experiment of a log as the text of a file.

    Raises:
        LogError: not a log.
        ExperimentError: the log of a script, without an experiment.
    """
    from granular_env.recording import open_log

    with open_log(path) as log:
        content = log.metadata.get("experiment")
    if not isinstance(content, dict):
        raise ExperimentError(
            "the log contains no experiment (recorded by a script)", hint="use `granular-env new chain`", source=str(path)
        )
    return to_toml({**content, "name": new_name} if new_name else content)


def _data_files(name: str, folder: Path) -> dict[Path, Path]:
    """Return a mapping from target to source path of the CSV files to copy; files with absolute paths are not copied."""
    experiment = load_experiment(name)
    named = [table["path"] for table in csv_tables(experiment.to_dict().get("input", {}))]
    found = {folder / path: experiment.folder / path for path in named if not Path(path).is_absolute()}
    return {copy: original for copy, original in found.items() if copy.resolve() != original.resolve()}


def _component_template(name: str) -> str:
    """Return a commented experiment file with all parameters, inputs and state variables of a component."""
    kind = catalogue.component_class(name)
    component = make_example(name, {})
    step = component.step_size
    lines = [
        f"# An experiment with the component {name!r}: {first_sentence(kind.__doc__ or '')}",
        '# Lines of the form "# key = value" show defaults; remove the "#" to change a value. Automatic values are computed',
        "# from other parameters; write key = value to set them.",
        f'name = "my-{name}"',
        'description = "purpose and result"',
        _commented_line(f"duration = {_format_float(1000 * step)}", "s"),
        "",
        "[component]",
        f'type = "{name}"',
    ]
    lines += _parameter_lines(kind.Parameters, example_values(kind.Parameters), "component")
    states = [v for v in component.variables.values() if v.state]
    lines += ["", "[start]                # a number or a row for all, a list, or { index = value or row }"]
    lines += [_commented_line(f"# {v.name} = {_example_elements(v)}", f"{v.unit}, {v.description}") for v in states]
    inputs = [v for v in component.variables.values() if v.causality == "input"]
    for number, variable in enumerate(inputs):
        # Set the first input, so that there is some motion.
        lines += ["", *_profile_lines(variable, step, "" if number == 0 else "# ")]
    kept = [v.name for v in states]
    lines += [
        "",
        _commented_line("# [[stop]]", "rule that ends the run early; several are allowed"),
        f'# variable = "{kept[0] if kept else "kinetic_energy"}"',
        _commented_line("# above = 1.0", "or below; for an array, an element NAME[3], or reduce"),
        "",
        "[record]",
        _commented_line(f"every = {_format_float(10 * step)}", "s between two frames"),
        "variables = [" + ", ".join(f'"{one}"' for one in kept) + "]",
    ]
    return "\n".join(lines) + "\n"


def _parameter_lines(model: type[BaseModel], example: Mapping[str, Any], table: str) -> list[str]:
    """Return the TOML lines of a table of parameters; tables within it follow as separate TOML tables.

    Args:
        model: model of the table.
        example: values of the keys to set; other keys are written as comments with their defaults.
        table: name of the table.
    """
    lines: list[str] = []
    parts = parameter_tables(model)
    for key, field in model.model_fields.items():
        if key not in parts:
            # A parameter that is computed from others has no default to show.
            has_no_value = not field.is_required() and field.default is None
            value = f"# {key}{':' if has_no_value else ' ='} {default_text(field)}"
            value = f"{key} = {toml_value(example[key])}" if key in example else value
            meaning = ", ".join(filter(None, (field_unit(field).removesuffix("1"), field.description)))
            is_other = key in example and not field.is_required() and field.default is not None
            lines.append(_commented_line(value, f"{meaning}; default: {default_text(field)}" if is_other else meaning))
    for key, part in parts.items():
        lines += ["", _commented_line(f"[{table}.{key}]", model.model_fields[key].description or "")]
        lines += _parameter_lines(part, example.get(key, {}), f"{table}.{key}")
    return lines


def parameter_tables(model: type[BaseModel]) -> dict[str, type[BaseModel]]:
    """Return the parameters of a model that are tables of parameters, such as those of a coupled part."""
    chosen = table_choices(model)
    return {
        key: field.annotation
        for key, field in model.model_fields.items()
        if key not in chosen and isinstance(field.annotation, type) and issubclass(field.annotation, Parameters)
    }


def _profile_lines(variable: Variable, step: float, mark: str) -> list[str]:
    """Return example lines of a half-sine profile for an input, each preceded by `mark` (the comment sign or nothing)."""
    peak = _format_float(variable.nominal)
    lines = [
        _commented_line(f"{mark}[input.{variable.name}]", f"{variable.unit}, {variable.description}: a time profile, or"),
        _commented_line(
            "", f"in [input] {variable.name} = {_example_elements(variable, variable.nominal)}, constant from the start"
        ),
        _commented_line(f'{mark}profile = "half_sine"', "constant, triangle, half_sine, table, csv, piecewise, sum"),
        _commented_line(f"{mark}peak = {peak}", variable.unit),
        _commented_line(f"{mark}duration = {_format_float(100 * step)}", "s"),
    ]
    if variable.shape:
        some = _example_elements(variable, 1.0)
        lines.append(_commented_line(f"{mark}pattern = {some}", "factor of each element; default: 1"))
    return lines


def _example_elements(variable: Variable, value: float = 0.0) -> str:
    """Return an example value of a variable as TOML: `value` or, for an array, `value` as element 0 or in row 0."""
    if not variable.shape:
        return toml_value(value)
    if len(variable.shape) == 1:
        return toml_value({0: value})
    row = np.zeros(variable.shape[1:])
    row[(0,) * row.ndim] = value
    return toml_value({0: row.tolist()})


def _commented_line(text: str, comment: str) -> str:
    return f"{text.ljust(_KEY_WIDTH)} # {comment}"


def _format_float(number: float) -> str:
    """Format a float without the last digits that come only from binary rounding, such as 0.30000000000000004."""
    return f"{number:.12g}"


def default_text(field: FieldInfo) -> str:
    """Return a parameter's default as TOML, or a text if there is none or it is computed."""
    if field.is_required():
        return "required"
    if field.default is not None:
        return value_text(field.default)
    return absent_meaning(field)


def value_text(value: Any) -> str:
    """Return a parameter's value as TOML."""
    return toml_value(_plain_value(value))


def _plain_value(value: Any) -> Any:
    """Return a parameter's value with its tables as mappings; a table with no key but its selecting name becomes that name."""
    if isinstance(value, BaseModel):
        value = value.model_dump(exclude_none=True)
        if value.keys() == {"name"}:
            return value["name"]
    if isinstance(value, Mapping):
        return {key: _plain_value(part) for key, part in value.items()}
    return [_plain_value(part) for part in value] if isinstance(value, list | tuple) else value


def make_example(name: str, parameters: dict[str, Any]) -> Component:
    """Return a component of the type `name`; parameters without a default, or with an example, get their example values."""
    return catalogue.make(name, **{**example_values(catalogue.component_class(name).Parameters), **parameters})


def example_values(model: type[BaseModel]) -> dict[str, Any]:
    """Return example values, by name, of the parameters that have no default or declare an example."""
    return {key: _example_value(field) for key, field in model.model_fields.items() if field.is_required() or field.examples}


def _example_value(field: FieldInfo) -> Any:
    """Return a field's first example, else the smallest number from 1 that satisfies its lower bound."""
    if field.examples:
        return field.examples[0]
    number = int if int in (field.annotation, *get_args(field.annotation)) else float
    bounds = [(getattr(one, "ge", None), getattr(one, "gt", None)) for one in field.metadata]
    return number(max([1, *(ge for ge, _ in bounds if ge is not None), *(gt + 1 for _, gt in bounds if gt is not None)]))
