"""The content of a plan file.

version = 1
name = "amplitude"                     # optional: default the file's name; the results' folder is called so
experiment = "chains/tapered"          # a shipped name, or a TOML file beside the plan
every = 1e-6                           # s between two looks for extremes and histories; default: the experiment's record.every
seeds = 3                              # repetitions, or { count = 3, seed = 0, keys = ["component.arrangement.seed"] }

[set]                                  # keys of the experiment that are the same in every task, but for those below
[grid]                                 # keys, each with its values (parameter_values.py)
[samples]                              # count, seed, and keys, each with its distribution
[measure]                              # the table's columns (measures.py)
[logs]                                 # keep = "none", "all" or "failed"; or every = N
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, PrivateAttr, model_validator

from granular_env.components.errors import ExperimentError, Fault, GranularError, Override
from granular_env.components.support.validation import refusal
from granular_env.documents import Document, Overrides, Table, load
from granular_env.documents.overrides import source_of, to_overrides
from granular_env.experiments import Experiment, load_experiment, shipped_experiments
from granular_env.package_contents import shipped_files

from .measures import OWN_COLUMNS, AnyMeasure
from .parameter_values import Axis, Range, Samples, Value, flatten

LARGEST = 100_000


class Seeds(Table):
    """Repetitions of every point, each with a seed of its own."""

    count: int = Field(ge=1, description="how many")
    seed: int = Field(0, ge=0, lt=2**63, description="what they are derived from, with the values of the task's keys")
    keys: list[str] = Field(["seed"], min_length=1, description="the keys of the experiment that get the seed")


def _seeds(given: Any) -> Any:
    return {"count": given} if isinstance(given, int) and not isinstance(given, bool) else given


class Logs(Table):
    """A choice of the tasks that leave a log."""

    keep: Literal["none", "all", "failed"] = Field("none", description="of every task, of those that fail, or of none")
    every: int | None = Field(None, ge=1, description="of each task whose number this divides")

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if self.every is not None and "keep" in self.model_fields_set:
            raise refusal("give keep or every, not both")
        return self

    def of_task(self, number: int) -> Literal["never", "failed", "always"]:
        """Return when the log of a task is kept."""
        if self.every is not None:
            return "always" if number % self.every == 0 else "never"
        choices: dict[str, Literal["never", "failed", "always"]] = {"none": "never", "failed": "failed", "all": "always"}
        return choices[self.keep]


class Plan(Document):
    """A plan, checked as far as that goes without its experiment."""

    kind: ClassVar[str] = "plan"
    shelf: ClassVar[str] = "plans of sweeps"

    version: Literal[1] = Field(description="the format of this file: version = 1")
    name: str = Field("", max_length=200, description="what the results are called")
    description: str = Field("", description="what it shows, for people")
    experiment: str = Field(min_length=1, description="a shipped experiment's name, or a TOML file beside the plan")
    every: float | None = Field(None, gt=0.0, description="time between two looks for extremes and histories [s]")
    seeds: Annotated[Seeds | None, BeforeValidator(_seeds)] = Field(None, description="repetitions of every point")
    set: dict[str, Value] = Field({}, description="keys of the experiment that are the same in every task")
    grid: dict[str, Axis] = Field({}, description="keys of the experiment, each with its values")
    samples: Samples | None = Field(None, description="keys of the experiment that are drawn")
    measure: dict[str, AnyMeasure] = Field(
        json_schema_extra={"advice": 'give a table [measure], such as peak = "max velocity[40]"'}
    )
    logs: Logs = Field(default_factory=lambda: Logs.model_validate({}), description="which tasks leave a log")

    _given: Mapping[str, Any] = PrivateAttr(default_factory=dict)
    _of_experiment: tuple[Override, ...] = PrivateAttr(())

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
        if flat.get("measure") == {}:
            del flat["measure"]
        plan = super().parse(flat, origin, folder, overrides)
        plan._given = flat
        return plan

    @model_validator(mode="after")
    def _check_keys(self) -> Self:
        """Refuse a key that is given in two places, of which only one could hold, and a measure with the name of a column."""
        seen: dict[str, str] = {}
        for table, keys in self._tables():
            for key in keys:
                if key in seen:
                    raise refusal(f"this key is in {seen[key]} too", hint="give it once", at=(table, key))
                seen[key] = table
        for column in self.measure:
            if column in OWN_COLUMNS or column in self.keys:
                received = "the table has a column of this name already"
                raise refusal(received, hint="choose another", at=("measure", column))
        return self

    def _tables(self) -> list[tuple[str, list[str]]]:
        """Return the tables that give keys values of their own in each task, and those keys."""
        drawn = list(self.samples.distributions) if self.samples else []
        return [("grid", list(self.grid)), ("samples", drawn), ("seeds.keys", self.seeds.keys if self.seeds else [])]

    @property
    def keys(self) -> list[str]:
        """The keys of the grid, then those of the samples: the columns that a task is named by."""
        return [key for _, keys in self._tables()[:2] for key in keys]

    @property
    def size(self) -> int:
        """Return the number of tasks, without making them."""
        lengths = (values.count if isinstance(values, Range) else len(values) for values in self.grid.values())
        return math.prod(lengths) * (self.samples.count if self.samples else 1) * (self.seeds.count if self.seeds else 1)

    @property
    def title(self) -> str:
        """Return what the results are called: the plan's name, or its file's."""
        return self.name or (Path(self.origin).stem if self.origin != self.kind else "sweep")

    @property
    def text(self) -> dict[str, Any]:
        """Return what decides a task's result besides the experiment, as JSON values: the measures and when they look."""
        return {"measure": self._given["measure"], "every": self.every}

    def load_experiment(self) -> Experiment:
        """Return its experiment with the keys that are the same in every task: a shipped one, or a file beside the plan."""
        beside = self.folder / self.experiment
        # For any other name, `load_experiment` names the nearest shipped one.
        is_file = self.experiment not in shipped_experiments() and (beside.exists() or beside.suffix == ".toml")
        try:
            overrides = (*to_overrides(self.set), *self._of_experiment)
            return load_experiment(beside if is_file else self.experiment, overrides)
        except ExperimentError as error:
            raise self.error_of(error) from error

    def error_of(self, error: GranularError) -> ExperimentError:
        """Return the error of an experiment as one of the plan, or of the override from outside that holds the fault."""
        return ExperimentError(*map(self._fault_of, error.faults))

    def _fault_of(self, fault: Fault) -> Fault:
        if isinstance(fault.source, Override):
            return fault if fault.source in self._of_experiment else replace(fault, source=self.origin)
        if fault.location[:1] and fault.location[0] in Experiment.model_fields:
            held_by = source_of(fault.location, f"experiment {self.experiment!r}", self._of_experiment)
            fault = replace(fault, source=held_by)
        return fault if isinstance(fault.source, Override) else fault.of(self.origin)


def _one_level(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return keys with dots, where some are written as the experiment's own tables with the keys to set in them."""
    found: dict[str, Any] = {}
    for key, value in content.items():
        inner = value if "." not in key and isinstance(value, Mapping) else None
        found |= {key: value} if inner is None else {f"{key}.{part}": one for part, one in inner.items()}
    return found


def shipped_plans() -> dict[str, Path]:
    """Return name -> file of the plans that come with the package."""
    return shipped_files(Plan.shelf)


def is_plan(content: Mapping[str, Any]) -> bool:
    """Return whether the content of a TOML file is meant as a plan: it names an experiment, or measures, and no component."""
    return "component" not in content and ("experiment" in content or "measure" in content)


def load_plan(source: str | os.PathLike[str] | Mapping[str, Any] | Plan, overrides: Overrides = ()) -> Plan:
    """Return a plan, checked as far as that goes without its experiment.

    Args:
        source: a shipped plan's name, the path of a TOML file, the content of one, or a plan.
        overrides: keys of the experiment, for every task, as if they stood in the plan's [set].

    Raises:
        ExperimentError: file, key, what came and what was expected.
    """
    changes = to_overrides(overrides)
    plan = load(Plan, source).model_copy()
    plan._of_experiment = changes
    varied = {key: table for table, keys in plan._tables() for key in keys}
    faults = [
        Fault(received=f"{plan.origin} gives this key its values in {varied[key]}", hint="edit it there", source=override)
        for override in changes
        if (key := ".".join(override.key)) in varied
    ]
    if faults:
        raise ExperimentError(*faults)
    return plan
