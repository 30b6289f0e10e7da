"""The content of a study file.

version = 1
name = "pulse-forming"
description = "..."             # optional
budget = 200_000                # simulated control steps per method
seeds = [1]                     # every method runs once per seed
episodes = 1                    # search episodes per drive, if starts are sampled
test_episodes = 1               # different episodes that evaluate the result; 0: the search episodes

[task]                          # name: an environment, or module:name of user code; other keys are its arguments
[drive]                         # map from a few numbers to a drive (drive.py)
[[method]]                      # type: gradient, cma, random, ppo, sac; other keys are its options (methods/)
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from granular_env.components.errors import ParameterError, one_line
from granular_env.components.support.serialization import canonical_json, digest
from granular_env.documents import Document, Overrides, Table, TableChoice, load_document

from .methods import AnyMethod, MethodTable

# Seed of the first search episode and of the first test episode; further episodes have the following seeds.
_SEARCH_SEED, _TEST_SEED = 1_000_000, 2_000_000


class TaskTable(Table):
    """The environment: its name and, as further keys, its arguments."""

    model_config = ConfigDict(extra="allow")

    name: str = Field(description="environment, such as pulse-forming, or module:name of a function that returns one")

    @property
    def arguments(self) -> dict[str, Any]:
        """All keys of the table except the name."""
        return dict(self.model_extra or {})


class DriveTable(Table):
    """The [drive] table: the map from a few numbers, the knots, to the actions of an episode; see `DriveShape`."""

    knots: int = Field(
        default=32, ge=1, le=100_000, description="number of knots per entry of the action, over the driven steps"
    )
    between: Literal["linear", "held"] = Field(default="linear", description="action between two knots: linear or constant")
    driven: int | None = Field(
        default=None, ge=1, description="control steps spanned by the knots, after which the action is 0; default: all"
    )
    lowest: float = Field(default=-1.0, ge=-1.0, le=1.0, description="lower bound of a knot, in units of the action's scale")
    highest: float = Field(default=1.0, ge=-1.0, le=1.0, description="upper bound of a knot, in the same units")

    @model_validator(mode="after")
    def _validate_order(self) -> Self:
        if self.lowest >= self.highest:
            raise ParameterError(f"got {self.highest:g}", expected=f"more than lowest ({self.lowest:g})", at="highest")
        return self


class Study(Document):
    """The content of a study's file, validated as far as possible without building its environment."""

    kind: ClassVar[str] = "study"
    shelf: ClassVar[str] = "studies"

    version: Literal[1] = Field(description="version of the file's format")
    name: str = Field(min_length=1, max_length=200, description="name of the results")
    description: str = Field("", description="purpose and result of the study", examples=["a search against theory"])
    budget: int = Field(ge=1, description="maximum number of simulated control steps per method")
    seeds: list[int] = Field(default=[1], min_length=1, max_length=1000, description="seeds of the runs of each method")
    episodes: int = Field(1, ge=1, le=100_000, description="number of episodes that evaluate a drive during the search")
    test_episodes: int = Field(
        1, ge=0, le=100_000, description="number of other episodes that evaluate the result; 0: use the search episodes"
    )
    task: TaskTable = Field(
        description="environment and its arguments",
        json_schema_extra={"advice": 'give a table [task] with a name, such as name = "pulse-forming"'},
    )
    drive: DriveTable = Field(DriveTable(), description="map from the numbers chosen by a method to a drive")
    method: list[Annotated[AnyMethod, TableChoice("type")]] = Field(
        min_length=1,
        description="methods to compare",
        json_schema_extra={"advice": 'give tables [[method]], each with a type, such as type = "cma"'},
    )

    @model_validator(mode="after")
    def _refuse_duplicates(self) -> Self:
        labels = [method.label for method in self.method]
        if twice := sorted({label for label in labels if labels.count(label) > 1}):
            twice = ", ".join(map(repr, twice))
            raise ParameterError(f"{twice} occurs more than once", hint="give each a different name", at="method")
        if len(set(self.seeds)) < len(self.seeds) or any(not 0 <= seed < 2**31 for seed in self.seeds):
            expected = "different whole numbers from 0 to 2147483647"
            raise ParameterError(f"got {one_line(self.seeds, 60)}", expected=expected, at="seeds")
        return self

    @property
    def search_seeds(self) -> list[int]:
        """Return the seeds of the search episodes."""
        return [_SEARCH_SEED + place for place in range(self.episodes)]

    @property
    def test_seeds(self) -> list[int]:
        """Return the seeds of the test episodes."""
        return [_TEST_SEED + place for place in range(self.test_episodes)] or self.search_seeds

    def trial_identity(self, method: MethodTable, seed: int, code: str) -> str:
        """Return a hash of everything that determines a trial: the study without its other methods and seeds, and the code."""
        content = self.to_dict()
        kept = {key: content.get(key) for key in ("budget", "episodes", "test_episodes", "task", "drive")}
        return digest(canonical_json([kept, method.model_dump(), seed, code])).hex()


Source = str | os.PathLike[str] | Mapping[str, Any] | Study


def load_study(source: Source, overrides: Overrides = ()) -> Study:
    """Return a study, validated as far as possible without building its environment; see `documents.load_document`.

        load_study("pulse-forming", {"budget": 5000, "task.grains": 30, "method.0.population": 8})

    Raises:
        ExperimentError: names file, table, key, received and expected value; for unknown keys the nearest valid key.
    """
    return load_document(Study, source, overrides)
