"""What a plan file holds.

version = 1
name = "amplitude"                     # optional: default the file's name; the results' folder is called so
experiment = "chains/tapered"          # a shipped name, or a TOML file beside the plan
every = 1e-6                           # s between two looks for extremes and histories; default: the experiment's record.every
seeds = 3                              # repetitions, or { count = 3, seed = 0, keys = ["component.arrangement.seed"] }

[set]                                  # keys of the experiment that are the same in every task, but for those below
[grid]                                 # keys, each with its values (axes.py)
[samples]                              # count, seed, and keys, each with its distribution
[measure]                              # the table's columns (measures.py)
[logs]                                 # keep = "none", "all" or "failed"; or every = N
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, model_validator

from granular_env.components.errors import ExperimentError
from granular_env.experiments.faults import Faults, Table, shortened
from granular_env.experiments.load import nearest_names, override_list, parse_override, read_document
from granular_env.shipped import shipped_files
from granular_env.toml_text import toml_value

from .axes import Distribution, Range, parse_distributions, parse_grid
from .measures import OWN_COLUMNS, Measure, parse_measures

VERSION = 1
LARGEST = 100_000


class Seeds(Table):
    """Repetitions of every point, each with a seed of its own."""

    count: int = Field(ge=1, description="how many")
    seed: int = Field(0, ge=0, lt=2**63, description="what they are derived from, with the values of the task's keys")
    keys: list[str] = Field(["seed"], min_length=1, description="the keys of the experiment that get the seed")


class SamplesSettings(Table):
    """The settings of the [samples] table; its other keys are distributions."""

    count: int = Field(ge=1, description="how many samples")
    seed: int = Field(0, ge=0, lt=2**63, description="of the draws")


class Logs(Table):
    """Which tasks leave a log."""

    keep: Literal["none", "all", "failed"] = Field("none", description="of every task, of those that fail, or of none")
    every: int | None = Field(None, ge=1, description="of each task whose number this divides")

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if self.every is not None and "keep" in self.model_fields_set:
            raise ValueError("give keep or every, not both")
        return self

    def wants(self, task: int) -> bool:
        """Whether a task's log is kept however it ends."""
        return self.keep == "all" if self.every is None else task % self.every == 0


class Settings(Table):
    """The plan's own keys, without its tables of keys of the experiment."""

    version: int = Field(description="the format of this file: 1")
    name: str = Field("", max_length=200, description="what the results are called")
    description: str = Field("", description="what it shows, for people")
    experiment: str = Field(min_length=1, description="a shipped experiment's name, or a TOML file beside the plan")
    every: float | None = Field(None, gt=0.0, description="time between two looks for extremes and histories [s]")
    seeds: Seeds | None = Field(None, description="repetitions of every point")
    logs: Logs = Field(default_factory=lambda: Logs.model_validate({}), description="which tasks leave a log")


@dataclass(frozen=True)
class Plan:
    """A plan, checked as far as that goes without its experiment.

    Attributes:
        settings: its own keys.
        fixed: ``"key=value"`` for every task.
        grid: key -> its values, or a range.
        samples: how many, and the draws' seed; None without.
        distributions: key -> where its samples come from.
        measures: column -> what stands in it.
        origin: the file, as messages call it.
        folder: what the experiment's path is relative to.
        text: the measures and settings that decide a task's result, as JSON values.
    """

    settings: Settings
    fixed: tuple[str, ...]
    grid: dict[str, list[Any] | Range]
    samples: SamplesSettings | None
    distributions: dict[str, Distribution]
    measures: dict[str, Measure]
    origin: str
    folder: Path
    text: dict[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """What the results are called."""
        return self.settings.name

    @property
    def size(self) -> int:
        """How many tasks there are; found without making them."""
        lengths = (values.count if isinstance(values, Range) else len(values) for values in self.grid.values())
        seeds = self.settings.seeds
        return math.prod(lengths) * (self.samples.count if self.samples else 1) * (seeds.count if seeds else 1)


def shipped_plans() -> dict[str, Path]:
    """Name -> file of the plans that come with the package."""
    return shipped_files("plans of sweeps")


def is_plan(document: Mapping[str, Any]) -> bool:
    """Whether the content of a TOML file is meant as a plan: it names an experiment, or measures, and no component."""
    return "component" not in document and ("experiment" in document or "measure" in document)


def load_plan(source: str | os.PathLike[str] | Mapping[str, Any], overrides: Iterable[str] = ()) -> Plan:
    """A plan, checked as far as that goes without its experiment.

    Args:
        source: a shipped plan's name, the path of a TOML file, or the content of one.
        overrides: ``"key=value"`` of the experiment, for every task, as if they stood in the plan's [set].

    Raises:
        ExperimentError: file, key, what came and what was expected.
    """
    if isinstance(source, Mapping):
        return _parsed(source, "plan", Path(), "sweep", overrides)
    path = _plan_path(source)
    return _parsed(read_document(path), str(path), path.parent, path.stem, overrides)


def _plan_path(source: str | os.PathLike[str]) -> Path:
    shipped = shipped_plans()
    try:
        path = Path(source)
        if path.is_file():
            return path
    except (TypeError, ValueError, OSError) as error:
        raise ExperimentError(f"plan {shortened(source)}: no name and no path: {error}") from None
    if str(source) in shipped:
        return shipped[str(source)]
    if path.suffix == ".toml" or path.exists():
        what = "it is no file, expected a TOML file" if path.exists() else "there is no such file"
        raise ExperimentError(f"{path}: {what}")
    raise ExperimentError(f"plan {shortened(str(source))}: no shipped plan and no file; {nearest_names(str(source), shipped)}")


_TABLES = ("set", "grid", "samples", "measure")


def _parsed(document: Mapping[str, Any], origin: str, folder: Path, name: str, overrides: Iterable[str]) -> Plan:
    faults = Faults(origin)
    version = document.get("version")
    if version != VERSION or isinstance(version, bool):
        came = "missing" if version is None else f"got {shortened(version)}"
        faults.add("version", f"{came}, this program reads plans of version {VERSION}")
        faults.raise_any()
    own = {key: value for key, value in document.items() if key not in _TABLES}
    _refuse_unknown(own, faults)
    if isinstance(own.get("seeds"), int) and not isinstance(own["seeds"], bool):
        own["seeds"] = {"count": own["seeds"]}
    for key, model in (("seeds", Seeds), ("logs", Logs)):
        if key in own:
            own[key] = faults.table(model, own[key], key)
    settings = None if faults.lines else faults.table(Settings, own, "")
    grid = parse_grid(document.get("grid", {}), faults)
    samples, distributions = _samples(document.get("samples"), faults)
    measures = parse_measures(document.get("measure"), faults)
    overrides = tuple(override_list(overrides))
    fixed = (*_fixed(document.get("set", {}), faults), *overrides)
    _refuse_clashes(grid, distributions, overrides, settings, faults)
    for column in measures:
        if column in OWN_COLUMNS or column in grid or column in distributions:
            faults.add(f"measure.{column}", "the table has a column of this name already; choose another")
    faults.raise_any()
    assert settings is not None
    settings = settings.model_copy(update={"name": settings.name or name})
    text = {"measure": document.get("measure"), "every": settings.every}
    return Plan(settings, fixed, grid, samples, distributions, measures, origin, folder, text)


def _refuse_unknown(own: Mapping[str, Any], faults: Faults) -> None:
    known = [*Settings.model_fields, *_TABLES]
    for key in own:
        if key not in known:
            faults.add(key, f"unknown; {nearest_key(key, known)}")


def nearest_key(key: str, known: Iterable[str]) -> str:
    """Advice for an unknown key of a plan; keys of the experiment belong into its tables."""
    from granular_env.components.errors import nearest

    if "." in key or key in ("component", "start", "input", "stop", "record", "duration"):
        return "keys of the experiment stand in [set], [grid] or [samples]"
    return nearest(key, known)


def _samples(content: Any, faults: Faults) -> tuple[SamplesSettings | None, dict[str, Distribution]]:
    if content is None:
        return None, {}
    if not isinstance(content, Mapping):
        faults.add("samples", f"got {shortened(content)}, expected a table: count, seed and distributions")
        return None, {}
    settings = faults.table(SamplesSettings, {key: content[key] for key in ("count", "seed") if key in content}, "samples")
    rest = {key: value for key, value in content.items() if key not in ("count", "seed")}
    found = parse_distributions(rest, faults)
    if not rest:
        faults.add(
            "samples", 'no key is drawn; add such as "component.radius" = { distribution = "uniform", from = ..., to = ... }'
        )
    return settings, found


def _fixed(content: Any, faults: Faults) -> list[str]:
    """The [set] table as overrides: dotted keys, or the experiment's own tables with the keys to set in them."""
    if not isinstance(content, Mapping):
        faults.add("set", f"got {shortened(content)}, expected a table of keys and values")
        return []
    found = []
    for key, value in content.items():
        inner = value if "." not in key and isinstance(value, Mapping) else None
        found += [assignment(key, value)] if inner is None else [assignment(f"{key}.{part}", it) for part, it in inner.items()]
    return found


def _refuse_clashes(
    grid: Mapping[str, Any], drawn: Mapping[str, Any], overrides: Iterable[str], settings: Settings | None, faults: Faults
) -> None:
    """A key that is given in two places: only one of them could hold."""
    seeds = settings.seeds.keys if settings is not None and settings.seeds is not None else []
    seen: dict[str, str] = {}
    for place, keys in (("grid", grid), ("samples", drawn), ("seeds.keys", seeds)):
        for key in keys:
            normal = ".".join(part.strip().strip("\"'") for part in key.split("."))
            if normal in seen:
                faults.add(f"{place}.{key}", f"this key is in {seen[normal]} too; give it once")
            seen[normal] = place
    for override in overrides:
        try:
            parts, _ = parse_override(override)
        except ExperimentError as error:
            faults.lines += str(error).splitlines()
            continue
        if (place := seen.get(".".join(parts))) is not None:
            faults.lines.append(
                f"override {shortened(override)}: {faults.origin} gives this key its values in {place}; edit it there"
            )


def assignment(key: str, value: Any) -> str:
    """``key=value`` with the value as TOML writes it, exact."""
    return f"{key}={toml_value(value, quoted=True)}"
