"""The content of a plan file.

version = 1
name = "amplitude"                     # optional: default the file's name; the results' folder is called so
experiment = "chains/tapered"          # a shipped name, or a TOML file next to the plan
every = 1e-6                           # s between two looks for extremes and histories; default: the experiment's record.every
log_every = 10                         # keep the logs of the tasks 0, 10, 20, ...; default: none

[set]                                  # keys of the experiment that are the same in every task
[grid]                                 # keys, each with its values (parameter_values.py)
[samples]                              # count, seed, and keys, each with its distribution
[measure]                              # the table's columns (measures.py)
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from granular_env.components.errors import ExperimentError, Fault, GranularError, Override, ParameterError
from granular_env.documents import Document, Overrides, load
from granular_env.documents.overrides import source_of, to_overrides
from granular_env.experiments import Experiment, load_experiment, shipped_experiments

from .measures import OWN_COLUMNS, AnyMeasure
from .parameter_values import Axis, Range, Samples, flatten

LARGEST = 100_000


class Plan(Document):
    """A plan, checked as far as that goes without its experiment."""

    kind: ClassVar[str] = "plan"
    shelf: ClassVar[str] = "plans of sweeps"

    version: Literal[1] = Field(description="the format of this file: version = 1")
    name: str = Field("", max_length=200, description="what the results are called")
    description: str = Field("", description="what it shows, for people")
    experiment: str = Field(min_length=1, description="a shipped experiment's name, or a TOML file beside the plan")
    every: float | None = Field(None, gt=0.0, description="time between two looks for extremes and histories [s]")
    log_every: int | None = Field(None, ge=1, description="the logs of the tasks whose number this divides are kept")
    set: dict[str, Any] = Field({}, description="keys of the experiment that are the same in every task")
    grid: dict[str, Axis] = Field({}, description="keys of the experiment, each with its values")
    samples: Samples | None = Field(None, description="keys of the experiment that are drawn")
    measure: dict[str, AnyMeasure] = Field(
        min_length=1, json_schema_extra={"advice": 'give a table [measure], such as peak = "max velocity[40]"'}
    )

    @classmethod
    def advice_for_unknown(cls, key: str, given: Mapping[str, Any]) -> str:
        """Return where keys of the experiment belong."""
        if "." in key or key in Experiment.model_fields:
            return "keys of the experiment stand in [set], [grid] or [samples]"
        return ""

    @classmethod
    def parse(
        cls, content: Mapping[str, Any], origin: str = "", folder: Path | None = None, overrides: tuple[Override, ...] = ()
    ) -> Self:
        """Return a plan from the content of its file; keys of the experiment may be written as tables or with dots."""
        flat = {key: flatten(value) if key in ("grid", "samples") else value for key, value in content.items()}
        if isinstance(flat.get("set"), Mapping):
            flat["set"] = _one_level(flat["set"])
        return super().parse(flat, origin, folder, overrides)

    @model_validator(mode="after")
    def _check_keys(self) -> Self:
        """Refuse a key that is given in two places, of which only one could hold, and a measure with the name of a column."""
        drawn = self.samples.distributions if self.samples else ()
        seen: dict[str, str] = {}
        for table, keys in (("grid", self.grid), ("samples", drawn), ("set", self.set)):
            for key in keys:
                if key in seen:
                    raise ParameterError(f"this key is in {seen[key]} too", hint="give it once", at=(table, key))
                seen[key] = table
        for column in self.measure:
            if column in OWN_COLUMNS or column in self.keys:
                received = "the table has a column of this name already"
                raise ParameterError(received, hint="choose another", at=("measure", column))
        return self

    @property
    def keys(self) -> list[str]:
        """The keys of the grid, then those of the samples: the columns that a task is named by."""
        return [*self.grid, *(self.samples.distributions if self.samples else ())]

    @property
    def size(self) -> int:
        """Return the number of tasks, without making them."""
        lengths = (values.count if isinstance(values, Range) else len(values) for values in self.grid.values())
        return math.prod(lengths) * (self.samples.count if self.samples else 1)

    @property
    def title(self) -> str:
        """Return what the results are called: the plan's name, or its file's."""
        return self.name or (Path(self.origin).stem if self.origin != self.kind else "sweep")

    def load_experiment(self) -> Experiment:
        """Return its experiment with the keys that are the same in every task: a shipped one, or a file next to the plan."""
        beside = self.folder / self.experiment
        # For any other name, `load_experiment` names the nearest shipped one.
        is_file = self.experiment not in shipped_experiments() and (beside.exists() or beside.suffix == ".toml")
        try:
            return load_experiment(beside if is_file else self.experiment, self.set)
        except ExperimentError as error:
            raise self.error_of(error) from error

    def error_of(self, error: GranularError) -> ExperimentError:
        """Return the error of an experiment as one of the plan, or of the override from outside that holds the fault."""
        return ExperimentError(*map(self._fault_of, error.faults))

    def _fault_of(self, fault: Fault) -> Fault:
        if not isinstance(fault.source, Override):
            return fault.of(self.origin)
        return replace(fault, source=source_of(("set", ".".join(fault.source.key)), self.origin, self.overrides))


def _one_level(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return keys with dots, where some are written as the experiment's own tables with the keys to set in them."""
    found: dict[str, Any] = {}
    for key, value in content.items():
        inner = value if "." not in key and isinstance(value, Mapping) else None
        found |= {key: value} if inner is None else {f"{key}.{part}": one for part, one in inner.items()}
    return found


def load_plan(source: str | os.PathLike[str] | Mapping[str, Any], overrides: Overrides = ()) -> Plan:
    """Return a plan, checked as far as that goes without its experiment.

    Args:
        source: a shipped plan's name, the path of a TOML file, or the content of one.
        overrides: keys of the experiment, for every task, as if they stood in the plan's [set].

    Raises:
        ExperimentError: file, key, the value received and the expected one.
    """
    return load(Plan, source, [replace(one, key=("set", ".".join(one.key))) for one in to_overrides(overrides)])
