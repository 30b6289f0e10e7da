"""What an experiment file holds.

name = "my-pulse"
description = "what it shows"   # optional, as is source: the citation
duration = 5.45e-4              # s

[component]                     # type: a catalogue name; the rest are its parameters
[start]                         # start values of state variables: a number, a list, or { index = value }
[input.left_force]              # for each input a number, or a table with a profile (inputs.py)
[[stop]]                        # rules that end the run early (stops.py)
[record]                        # what the log keeps besides the inputs and the hashes
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ConfigDict, Field, PrivateAttr

from granular_env.components import catalogue
from granular_env.components.errors import ExperimentError, ParameterError, nearest
from granular_env.components.support.validation import validated

from .faults import Faults, Table, shortened
from .inputs import ProfileTable, parse_input
from .stops import StopRule


class ComponentTable(Table):
    """The `[component]` table: the type, and that type's parameters."""

    model_config = ConfigDict(extra="allow")

    type: str = Field(description="a catalogue name, such as 'chain'")

    @property
    def parameters(self) -> dict[str, Any]:
        """Everything but the type."""
        return dict(self.model_extra or {})


class RecordTable(Table):
    """The `[record]` table."""

    every: float | None = Field(default=None, gt=0.0, description="time between two frames of the outputs [s]")
    variables: list[str] | None = Field(
        default=None, description="names of the outputs to keep; default: the component's own choice"
    )
    hash_every: int | None = Field(default=None, ge=1, description="internal steps between two hashes of the state")
    key_every: float | None = Field(default=None, gt=0.0, description="time between two whole snapshots [s]")


class Experiment(Table):
    """One experiment, checked as far as that is possible without building its component."""

    name: str = Field(min_length=1, max_length=200, description="what logs and pages call it")
    description: str = Field("", description="what it shows, for people")
    source: str | None = Field(None, description="where it comes from: a citation")
    duration: float = Field(gt=0.0, description="simulated time from start to end [s]")
    seed: int | None = Field(None, ge=0, lt=2**63, description="for components that draw random numbers")
    component: ComponentTable
    start: dict[str, Any] = Field(default_factory=dict, description="start values of state variables")
    input: dict[str, float | ProfileTable] = Field(default_factory=dict, description="numbers, or profiles of time")
    stop: list[StopRule] = Field(default_factory=list, description="rules that end the run early")
    record: RecordTable = RecordTable()

    _origin: str = PrivateAttr("experiment")
    _folder: Path = PrivateAttr(default_factory=Path)
    _overrides: tuple[str, ...] = PrivateAttr(())

    @property
    def origin(self) -> str:
        """The file it came from, as messages call it."""
        return self._origin

    @property
    def folder(self) -> Path:
        """The folder that paths in the experiment are relative to."""
        return self._folder

    @property
    def overrides(self) -> tuple[str, ...]:
        """The ``"a.b=value"`` that changed what the file says."""
        return self._overrides

    def to_dict(self) -> dict[str, Any]:
        """Plain values for TOML, JSON and `parse`; what was left out stays out."""
        return self.model_dump(mode="json", exclude_none=True, exclude_unset=True, serialize_as_any=True)


_TABLES = {"component", "start", "input", "stop", "record"}


def parse(document: Mapping[str, Any], origin: str = "experiment", folder: Path | None = None) -> Experiment:
    """An experiment from the content of a TOML file; `ExperimentError` names every fault in it."""
    faults = Faults(origin)
    fields = {key: value for key, value in document.items() if key not in _TABLES}
    fields["component"] = _component(document.get("component"), faults)
    if "start" in document:
        fields["start"] = _start(document["start"], faults)
    if "input" in document:
        fields["input"] = _inputs(document["input"], faults)
    if "stop" in document:
        fields["stop"] = _stops(document["stop"], faults)
    if "record" in document:
        fields["record"] = faults.table(RecordTable, document["record"], "record")
    if faults.lines:
        # The rest is still looked at, with stand-ins where a table is broken.
        fields = {key: value for key, value in fields.items() if key not in _TABLES}
        fields["component"] = ComponentTable(type="none")
    experiment = faults.table(Experiment, fields, "")
    faults.raise_any()
    assert experiment is not None
    experiment._origin, experiment._folder = origin, folder if folder is not None else Path()
    return experiment


def _component(content: Any, faults: Faults) -> ComponentTable | None:
    if content is None:
        faults.add("component", 'missing; give a table [component] with a type, such as type = "chain"')
        return None
    table = faults.table(ComponentTable, content, "component")
    if table is not None:
        try:
            validated(catalogue.component_class(table.type).Parameters, table.parameters, f"{table.type!r}")
        except ParameterError as error:
            for line in str(error).splitlines():
                faults.add("component", line)
        except (ValueError, TypeError, OverflowError, ArithmeticError, RecursionError, LookupError) as error:
            faults.add("component", f"not usable: {error}")
        except MemoryError:
            faults.add("component", "it asks for more memory than there is; make it smaller")
    return table


def _start(content: Any, faults: Faults) -> dict[str, Any] | None:
    if not isinstance(content, Mapping):
        faults.add("start", f"got {shortened(content)}, expected a table of state variables")
        return None
    return dict(content)


def _inputs(content: Any, faults: Faults) -> dict[str, float | ProfileTable] | None:
    if not isinstance(content, Mapping):
        faults.add("input", f"got {shortened(content)}, expected a table of inputs")
        return None
    parsed = {name: parse_input(value, f"input.{name}", faults) for name, value in content.items()}
    return {name: value for name, value in parsed.items() if value is not None}


def _stops(content: Any, faults: Faults) -> list[StopRule] | None:
    if not isinstance(content, list):
        faults.add("stop", f"got {shortened(content)}, expected tables [[stop]], with two brackets")
        return None
    rules = [faults.table(StopRule, rule, f"stop.{place}") for place, rule in enumerate(content)]
    return [rule for rule in rules if rule is not None]


def known_keys(section: str, document: Mapping[str, Any]) -> list[str] | None:
    """The keys that a table of the file may have; None where any name may come (start, input) or the table is no table."""
    if section == "":
        return list(Experiment.model_fields)
    if section == "record":
        return list(RecordTable.model_fields)
    if section == "component":
        table = document.get("component")
        kind = table.get("type") if isinstance(table, Mapping) else None
        if isinstance(kind, str):
            try:
                return ["type", *catalogue.component_class(kind).Parameters.model_fields]
            except ParameterError:
                return None
    return None


def refuse_unknown(key: str, known: list[str] | None, place: str) -> None:
    """`ExperimentError` with the nearest right name, where a key is none of the known."""
    if known is not None and key not in known:
        raise ExperimentError(f"{place}: {key!r} is unknown; {nearest(key, known)}")
