"""Experiment files: their content, and finding and reading them.

name = "my-pulse"
description = "..."             # optional, as is source: the citation
duration = 5.45e-4              # s

[component]                     # type: a catalogue name; other keys are its parameters
[start]                         # start values of state variables: a number, a list, or { index = value }
[input.left_force]              # per input a number, a list, or a table with a profile (inputs.py)
[[stop]]                        # rules that end the run early (stop_rules.py)
[record]                        # content of the log in addition to inputs and hashes
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from granular_env.components import catalogue
from granular_env.components.errors import ParameterError
from granular_env.components.support.quantities import Quantities, Seconds
from granular_env.components.support.validation import validation_faults
from granular_env.documents import Document, Overrides, Table, load_document
from granular_env.package_contents import shipped_files

from .inputs import Input
from .stop_rules import StopRule


class ComponentTable(Table):
    """The component: its type and, as further keys, its parameters."""

    model_config = ConfigDict(extra="allow")

    type: str = Field(description="name of the component's type, such as 'chain'")

    @property
    def parameters(self) -> dict[str, Any]:
        """The parameters of the component: all keys of the table except `type`."""
        return dict(self.model_extra or {})

    @model_validator(mode="after")
    def _check_parameters(self) -> Self:
        try:
            model = catalogue.component_class(self.type).Parameters
        except ParameterError as error:
            raise error.with_outer_location("type") from None
        try:
            valid = model(**self.parameters)
        except ValidationError as error:
            raise ParameterError(*validation_faults(error, self.parameters, model)) from None
        (self.__pydantic_extra__ or {}).update(_with_numbers(self.parameters, valid))
        return self


def _with_numbers(given: Any, valid: Any) -> Any:
    """Return given parameters, with the numbers of the validated ones where a text denotes a quantity."""
    match given, valid:
        case str(), float():
            return valid
        case dict(), BaseModel():
            return {key: _with_numbers(part, getattr(valid, key, None)) for key, part in given.items()}
        case dict(), [BaseModel() as only]:
            return _with_numbers(given, only)
        case dict(), dict() if len(given) == len(valid):
            return {key: _with_numbers(part, one) for (key, part), one in zip(given.items(), valid.values(), strict=True)}
        case list(), list() if len(given) == len(valid):
            return [_with_numbers(part, one) for part, one in zip(given, valid, strict=True)]
    return given


class RecordTable(Table):
    """The table `record`: what the log contains in addition to inputs, hashes of the state, and snapshots."""

    every: Seconds | None = Field(
        default=None, gt=0.0, description="time between two frames of the outputs [s]; default: 160 to 400 frames"
    )
    variables: list[str] | None = Field(
        default=None, description="names of the recorded outputs; default: the state, drawn outputs and scalars"
    )
    hash_every: int | None = Field(
        default=None, ge=1, description="ticks between two hashes of the state; default: 4096", examples=[1]
    )
    snapshot_every: Seconds | None = Field(
        default=None, gt=0.0, description="time between two snapshots [s]; default: automatic", examples=[1e-4]
    )

    @field_validator("variables")
    @classmethod
    def _refuse_duplicates(cls, names: list[str] | None) -> list[str] | None:
        for place, name in enumerate(names or []):
            if name in (names or [])[:place]:
                raise ParameterError(f"got {name!r} again", expected="each name once", at=(place,))
        return names


class Experiment(Document):
    """The content of an experiment file, validated as far as possible without building its component."""

    kind: ClassVar[str] = "experiment"
    shelf: ClassVar[str] = "experiments"

    name: str = Field(min_length=1, max_length=200, description="name of the experiment in logs and reports")
    description: str = Field("", description="purpose and result of the experiment", examples=["a solitary wave at 5 m/s"])
    source: str | None = Field(None, description="a citation")
    duration: Seconds = Field(gt=0.0, description="simulated time from start to end [s]")
    seed: int | None = Field(None, ge=0, lt=2**63, description="seed of components that use random numbers", examples=[1])
    component: ComponentTable = Field(
        description="type and parameters of the component",
        examples=[{"type": "chain", "grains": 40}],
        json_schema_extra={"advice": 'give a table [component] with a type, such as type = "chain"'},
    )
    start: Annotated[dict[str, Any], Quantities] = Field(default_factory=dict, description="start values of state variables")
    input: dict[str, Input] = Field(
        default_factory=dict, description="inputs of the component: numbers, lists, or time profiles"
    )
    stop: list[StopRule] = Field(
        default_factory=list, description="rules that end the run early", examples=[[{"variable": "position", "above": 1.0}]]
    )
    record: RecordTable = Field(RecordTable(), description="content of the log")

    @classmethod
    def advice_for_unknown(cls, key: str, given: Mapping[str, Any]) -> str:
        """Return the hint for a key written outside its table: for `grains`, the full key `component.grains`."""
        for table, fields in (("component", _parameters(given.get("component"))), ("record", RecordTable.model_fields)):
            if key in fields:
                return f"did you mean {f'{table}.{key}'!r}?"
        return ""


Source = str | os.PathLike[str] | Mapping[str, Any] | Experiment


def _parameters(component: Any) -> Mapping[str, Any]:
    with suppress(ParameterError, KeyError, TypeError):
        model: type[BaseModel] = catalogue.component_class(component["type"]).Parameters
        return model.model_fields
    return {}


def shipped_experiments() -> list[str]:
    """Return the names of the shipped experiments, such as ``nesterenko-1983/3.4-piston``."""
    return list(shipped_files(Experiment.shelf))


def load_experiment(source: Source, overrides: Overrides = (), folder: Path | None = None) -> Experiment:
    """Return an experiment, validated as far as possible without building its component; see `documents.load_document`.

        load_experiment("nesterenko-1983/3.4-piston", {"component.grains": 500, "duration": 1e-3})

    Raises:
        ExperimentError: names file, table, key, received and expected value; for unknown keys the nearest valid key.
    """
    return load_document(Experiment, source, overrides, folder)
