"""The content of a plan file.

version = 1
name = "amplitude"                     # optional, default: the file's name; also the name of the results' folder
experiment = "chains/tapered"          # a shipped name, or a TOML file next to the plan
every = 1e-6                           # sampling interval for extremes and histories [s]; default: record.every
log_every = 10                         # keep the logs of tasks 0, 10, 20, ...; default: none

[set]                                  # keys of the experiment for all tasks
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
from granular_env.components.support.quantities import Seconds
from granular_env.documents import Document, Overrides, load_document
from granular_env.documents.overrides import fault_source, to_overrides
from granular_env.experiments import Experiment, load_experiment, shipped_experiments

from .measures import OWN_COLUMNS, AnyMeasure
from .parameter_values import Axis, Range, Samples, flatten_table

LARGEST = 100_000


class Plan(Document):
    """The content of a plan file, validated as far as possible without its experiment."""

    kind: ClassVar[str] = "plan"
    shelf: ClassVar[str] = "plans of sweeps"

    version: Literal[1] = Field(description="version of the file's format")
    name: str = Field("", max_length=200, description="name of the results; default: the file's name", examples=["speeds"])
    description: str = Field("", description="purpose and result of the sweep", examples=["speed against amplitude"])
    experiment: str = Field(min_length=1, description="name of a shipped experiment, or a TOML file next to the plan")
    every: Seconds | None = Field(
        None, gt=0.0, description="sampling interval of extremes and histories [s]; default: record.every, or each tick"
    )
    log_every: int | None = Field(
        None, ge=1, description="interval N of the tasks whose logs are kept (0, N, 2N, ...); default: keep none", examples=[10]
    )
    set: dict[str, Any] = Field({}, description="keys of the experiment with one value for all tasks")
    grid: dict[str, Axis] = Field(
        {},
        description="keys of the experiment, each with its values; all combinations run",
        examples=[{"component.grains": [20, 40]}],
    )
    samples: Samples | None = Field(
        None,
        description="keys of the experiment with random values",
        examples=[{"count": 9, "duration": {"distribution": "uniform", "from": 1e-4, "to": 2e-4}}],
    )
    measure: dict[str, AnyMeasure] = Field(
        min_length=1,
        description="columns of the results, each with its measure",
        examples=[{"peak": "max velocity[40]"}],
        json_schema_extra={"advice": 'give a table [measure], such as peak = "max velocity[40]"'},
    )

    @classmethod
    def advice_for_unknown(cls, key: str, given: Mapping[str, Any]) -> str:
        """Return advice for an unknown key: keys of the experiment belong in the tables [set], [grid] or [samples]."""
        if "." in key or key in Experiment.model_fields:
            return "keys of the experiment belong in [set], [grid] or [samples]"
        return ""

    @classmethod
    def parse(
        cls, content: Mapping[str, Any], origin: str = "", folder: Path | None = None, overrides: tuple[Override, ...] = ()
    ) -> Self:
        """Return a plan from the content of its file; keys of the experiment may be dotted ("a.b") or nested tables."""
        flat = {key: flatten_table(value) if key in ("grid", "samples") else value for key, value in content.items()}
        if isinstance(flat.get("set"), Mapping):
            flat["set"] = _flatten_tables(flat["set"])
        return super().parse(flat, origin, folder, overrides)

    @model_validator(mode="after")
    def _check_keys(self) -> Self:
        """Refuse a key that is in two of the tables, and a measure whose name is that of another column."""
        drawn = self.samples.distributions if self.samples else ()
        seen: dict[str, str] = {}
        for table, keys in (("grid", self.grid), ("samples", drawn), ("set", self.set)):
            for key in keys:
                if key in seen:
                    raise ParameterError(f"the key is also in {seen[key]}", hint="give it once", at=(table, key))
                seen[key] = table
        for column in self.measure:
            if column in OWN_COLUMNS or column in self.keys:
                received = "the table already has a column of this name"
                raise ParameterError(received, hint="choose another name", at=("measure", column))
        return self

    @property
    def keys(self) -> list[str]:
        """The keys whose values differ between tasks: those of the grid, then those of the samples."""
        return [*self.grid, *(self.samples.distributions if self.samples else ())]

    @property
    def size(self) -> int:
        """Return the number of tasks without creating them."""
        lengths = (values.count if isinstance(values, Range) else len(values) for values in self.grid.values())
        return math.prod(lengths) * (self.samples.count if self.samples else 1)

    @property
    def title(self) -> str:
        """Return the name of the results: the plan's name, or its file's name."""
        return self.name or (Path(self.origin).stem if self.origin != self.kind else "sweep")

    def load_experiment(self) -> Experiment:
        """Return the plan's experiment (shipped, or a file next to the plan) with the keys common to all tasks."""
        beside = self.folder / self.experiment
        # For any other name, `load_experiment` suggests the nearest shipped experiment.
        is_file = self.experiment not in shipped_experiments() and (beside.exists() or beside.suffix == ".toml")
        try:
            return load_experiment(beside if is_file else self.experiment, self.set)
        except ExperimentError as error:
            raise self.plan_error(error) from error

    def plan_error(self, error: GranularError) -> ExperimentError:
        """Return an error of the experiment as an error of the plan, or of the override (not in the file) that caused it."""
        return ExperimentError(*map(self._plan_fault, error.faults))

    def _plan_fault(self, fault: Fault) -> Fault:
        if not isinstance(fault.source, Override):
            return fault.with_source(self.origin)
        return replace(fault, source=fault_source(("set", ".".join(fault.source.key)), self.origin, self.overrides))


def _flatten_tables(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of [set] with dotted keys; keys of the experiment may be written as in the experiment's tables."""
    found: dict[str, Any] = {}
    for key, value in content.items():
        inner = value if "." not in key and isinstance(value, Mapping) else None
        found |= {key: value} if inner is None else {f"{key}.{part}": one for part, one in inner.items()}
    return found


def load_plan(source: str | os.PathLike[str] | Mapping[str, Any], overrides: Overrides = ()) -> Plan:
    """Return a plan, validated as far as possible without its experiment.

    Args:
        source: a shipped plan's name, the path of a TOML file, or the content of one.
        overrides: keys of the experiment for all tasks, as in the plan's [set].

    Raises:
        ExperimentError: the plan is invalid; the message names file, key, received and expected value.
    """
    return load_document(Plan, source, [replace(one, key=("set", ".".join(one.key))) for one in to_overrides(overrides)])
