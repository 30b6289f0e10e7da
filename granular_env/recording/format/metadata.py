"""The MCAP Metadata record of a log, which Foxglove, rerun and the `mcap` tool show; derived from the header, never read."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pydantic import BaseModel

from ...documents import to_toml, toml_value
from .records import damage

METADATA_NAME = "granular-env"
# Longer texts, such as the radius of each of many grains, are cut: the header has them whole.
_LONGEST, _LONGEST_VALUE = 20_000, 200


def metadata_of(header: Mapping[str, Any], parameters: type[BaseModel] | None = None) -> dict[str, str]:
    """Return the texts of the record, by key.

    Args:
        header: the log's header, as `header.header_of` makes it.
        parameters: the component's parameter model, which knows the units of the parameters.
    """
    experiment = header.get("experiment")
    versions = header.get("versions") or {}
    found = {
        "name": title_of(header),
        "component": f"{header.get('component')}, version {header.get('version')}",
        "created": header.get("created"),
        "versions": ", ".join(f"{name} {version}" for name, version in versions.items()),
        "step_size": f"{header.get('step_size')!r} s",
        "experiment": to_toml(experiment) if isinstance(experiment, Mapping) else "recorded from a script",
    }
    found["parameters"] = "".join(_parameter_lines(header.get("parameters") or {}, parameters))
    found["units"] = "; ".join(_units([*(header.get("variables") or ()), *(header.get("inputs") or ())]))
    return {name: _shorten(str(text), _LONGEST) for name, text in found.items()}


def metadata_of_log(header: Mapping[str, Any], parameters: type[BaseModel] | None) -> dict[str, str]:
    """Return `metadata_of` a header that somebody else may have written; `LogError` where it describes nothing."""
    try:
        return metadata_of(header, parameters)
    except (AttributeError, KeyError, TypeError, ValueError, RecursionError) as error:
        raise damage(f"it describes its run wrongly: {error}", "header") from error


def title_of(header: Mapping[str, Any]) -> str:
    """Return the name of the experiment, else of the component."""
    experiment = header.get("experiment")
    named = experiment.get("name") if isinstance(experiment, Mapping) else None
    return str(named or header.get("component") or "run")


def _unit(parameters: type[BaseModel] | None, name: str) -> str:
    field = None if parameters is None else parameters.model_fields.get(name)
    extra = None if field is None else field.json_schema_extra
    return str(extra.get("unit", "")) if isinstance(extra, dict) else ""


def _parameter_lines(values: Mapping[str, Any], model: type[BaseModel] | None) -> Iterator[str]:
    """Yield the parameters as lines of TOML, units as comments."""
    for name, value in values.items():
        if value is not None:
            unit = _unit(model, name)
            yield f"{name} = {_shorten(toml_value(value), _LONGEST_VALUE)}{f'  # {unit}' if unit not in ('', '1') else ''}\n"


def _units(variables: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    """Yield a unit and the names of the variables and inputs that have it, such as ``m/s: velocity, left_velocity``."""
    names: dict[str, list[str]] = {}
    for variable in variables:
        names.setdefault(variable["unit"], []).append(variable["name"])
    for unit, having in names.items():
        yield f"{unit}: {', '.join(having)}"


def _shorten(text: str, longest: int) -> str:
    return text if len(text) <= longest else text[: longest - 1] + "\u2026"
