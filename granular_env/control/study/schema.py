"""What a study file holds.

version = 1
name = "pulse-forming"
description = "what it shows"   # optional
budget = 200_000                # control steps that every method may simulate
seeds = [1]                     # every method runs once with each
episodes = 1                    # starts that a drive is tried from while it is searched, where starts are drawn
test_episodes = 1               # other starts, on which what was found is judged; 0: on those of the search

[task]                          # name: an environment, or module:name of one's own; the rest are its arguments
[drive]                         # how a few numbers become a drive (control/drive.py)
[[method]]                      # type: gradient, cma, random, policy, ppo, sac; the rest are its options (methods/)
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, Self

from pydantic import ConfigDict, Field, PrivateAttr, model_validator

from granular_env.components.errors import ExperimentError, nearest
from granular_env.components.support.serialization import canonical_json, digest
from granular_env.experiments.faults import Faults, Table, shortened

from .methods import METHODS, MethodTable
from .methods.random_search import RandomSearch

VERSION = 1
# Episodes are drawn with seeds of their own, so that what was found is judged on starts that no search has seen.
_SEARCH_SEED, _TEST_SEED = 1_000_000, 2_000_000
# What may be changed between a study and its continuation: it changes nothing that has been computed.
_LOOSE = {"name", "description", "budget"}


class TaskTable(Table):
    """The `[task]` table: an environment's name, and its arguments."""

    model_config = ConfigDict(extra="allow")

    name: str = Field(description="an environment, such as 'pulse-forming', or 'module:name' of what makes your own")

    @property
    def arguments(self) -> dict[str, Any]:
        """Everything but the name."""
        return dict(self.model_extra or {})


class DriveTable(Table):
    """The `[drive]` table: see `DriveShape`."""

    knots: int = Field(default=32, ge=1, le=100_000, description="values of each entry of the action over the driven steps")
    between: Literal["linear", "held"] = Field(default="linear", description="what the action is between two knots")
    driven: int | None = Field(default=None, ge=1, description="control steps that the knots span; after them the action is 0")
    lowest: float = Field(default=-1.0, ge=-1.0, le=1.0, description="least value of a knot, in units of the action's scale")
    highest: float = Field(default=1.0, ge=-1.0, le=1.0, description="greatest value of a knot")
    rate: float | None = Field(default=None, gt=0.0, description="largest change of the action per control step")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.lowest >= self.highest:
            raise ValueError(f"highest: got {self.highest:g}, expected more than lowest, {self.lowest:g}")
        return self


class Study(Table):
    """One study, checked as far as that is possible without building its environment."""

    version: Literal[1] = Field(description="version of the file's format")
    name: str = Field(min_length=1, max_length=200, description="what folders and pages call it")
    description: str = Field("", description="what it shows, for people")
    budget: int = Field(ge=1, description="control steps that every method may simulate")
    seeds: list[int] = Field(default=[1], min_length=1, max_length=1000, description="every method runs once with each")
    episodes: int = Field(1, ge=1, le=100_000, description="starts that a drive is tried from while it is searched")
    test_episodes: int = Field(1, ge=0, le=100_000, description="other starts, to judge what was found; 0: the search's own")
    task: TaskTable
    drive: DriveTable = DriveTable()
    method: list[MethodTable] = Field(min_length=1, description="the methods that are compared")

    _origin: str = PrivateAttr("study")

    @model_validator(mode="after")
    def _distinct(self) -> Self:
        labels = [method.label for method in self.method]
        if twice := sorted({label for label in labels if labels.count(label) > 1}):
            raise ValueError(f"method: {', '.join(map(repr, twice))} more than once; give each a name of its own")
        if len(set(self.seeds)) < len(self.seeds) or any(not 0 <= seed < 2**31 for seed in self.seeds):
            raise ValueError(f"seeds: got {shortened(self.seeds)}, expected different whole numbers from 0 to 2147483647")
        return self

    @property
    def origin(self) -> str:
        """The file it came from, as messages call it."""
        return self._origin

    @property
    def search_seeds(self) -> list[int]:
        """Of the episodes that a drive is tried in while it is searched."""
        return [_SEARCH_SEED + place for place in range(self.episodes)]

    @property
    def test_seeds(self) -> list[int]:
        """Of the episodes in which what was found is judged."""
        return [_TEST_SEED + place for place in range(self.test_episodes)] or self.search_seeds

    @property
    def identity(self) -> str:
        """Changes when anything does that changes what is computed; the budget may grow."""
        kept = {key: value for key, value in self.to_dict().items() if key not in _LOOSE}
        return digest(canonical_json(kept)).hex()

    def to_dict(self) -> dict[str, Any]:
        """Plain values for TOML, JSON and `parse`; what was left out stays out."""
        return self.model_dump(mode="json", exclude_none=True, exclude_unset=True, serialize_as_any=True)


def parse(document: Mapping[str, Any], origin: str = "study") -> Study:
    """A study from the content of a TOML file; `ExperimentError` names every fault in it."""
    faults = Faults(origin)
    version = document.get("version")
    if version != VERSION or isinstance(version, bool):
        came = "none" if version is None else shortened(version)
        raise ExperimentError(f"{origin}: version: got {came}, this program reads studies of version {VERSION}")
    fields: dict[str, Any] = {key: value for key, value in document.items() if key not in ("task", "drive", "method")}
    fields["task"] = _task(document.get("task"), faults)
    if "drive" in document:
        fields["drive"] = faults.table(DriveTable, document["drive"], "drive")
    fields["method"] = _methods(document.get("method"), faults)
    if faults.lines:
        # The rest is still looked at, with stand-ins where a table is broken.
        fields.pop("drive", None)
        fields |= {"task": TaskTable(name="none"), "method": [RandomSearch()]}
    study = faults.table(Study, fields, "")
    faults.raise_any()
    assert study is not None
    study._origin = origin
    return study


def _task(content: Any, faults: Faults) -> TaskTable | None:
    if content is None:
        faults.add("task", 'missing; give a table [task] with a name, such as name = "pulse-forming"')
        return None
    table = faults.table(TaskTable, content, "task")
    try:
        canonical_json(table.arguments if table is not None else {})
    except (TypeError, ValueError, RecursionError) as error:
        faults.add("task", f"not usable: {error}")
    return table


def _methods(content: Any, faults: Faults) -> list[MethodTable]:
    if not isinstance(content, list) or not content:
        came = "missing" if content is None else f"got {shortened(content)}"
        faults.add("method", f'{came}; give tables [[method]], each with a type, such as type = "cma"')
        return []
    return [table for place, one in enumerate(content) if (table := _method(one, f"method.{place}", faults)) is not None]


def _method(content: Any, place: str, faults: Faults) -> MethodTable | None:
    if not isinstance(content, Mapping):
        faults.add(place, f"got {shortened(content)}, expected a table of keys and values")
        return None
    kind = content.get("type")
    if not isinstance(kind, str) or kind not in METHODS:
        came = "missing" if kind is None else f"got {shortened(kind)}"
        faults.add(f"{place}.type", f"{came}; {nearest(str(kind), METHODS)}")
        return None
    return faults.table(METHODS[kind], content, place)
