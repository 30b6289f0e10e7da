"""The tasks of a plan: the keys that each task sets, and a hash of everything that determines its result."""

from __future__ import annotations

import copy
import hashlib
import itertools
import json
from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple

from granular_env.code_hash import code_hash
from granular_env.components.component import Component
from granular_env.components.errors import ExperimentError
from granular_env.components.support.parameter_fields import field_unit
from granular_env.components.support.serialization import canonical_json
from granular_env.documents.files import read_data_file
from granular_env.experiments.inputs import csv_tables

from .parameter_values import Range, sample_values
from .plan import LARGEST, Plan
from .worker import Job, Task

_SECONDS = ("duration", "record.every", "record.snapshot_every")
# Keys of an input's profile that are times [s]; other keys have the unit of the input.
_TIMES = ("duration", "rise", "start", "offset_time")


class Workload(NamedTuple):
    """The tasks of a plan, and what they have in common.

    Attributes:
        job: the data that all tasks have in common.
        keys: column -> its value in each task; the columns are the keys of the grid and the samples, then the sample's number.
        tasks: all tasks in order: the sample changes from one to the next, then the last key of the grid.
    """

    job: Job
    keys: dict[str, list[Any]]
    tasks: list[Task]

    def distinct_tasks(self, part: tuple[int, int] = (0, 1)) -> dict[str, Task]:
        """Return hash -> task for tasks i, i + n, ... of `part` (i, n); of equal tasks, the first number counts."""
        index, count = part
        first: dict[str, int] = {}
        found: dict[str, Task] = {}
        for number, task in enumerate(self.tasks):
            if first.setdefault(task.hash, number) % count == index and (task.hash not in found or task.is_logged):
                found[task.hash] = task
        return found


def make_workload(plan: Plan, time_limit: float | None = None, allow_large: bool = False) -> Workload:
    """Load the experiment of a plan and its CSV files, and create the tasks; `time_limit` is that of a task [s].

    Raises:
        ExperimentError: too many tasks, an invalid experiment, or a file that cannot be read.
    """
    if plan.size > LARGEST and not allow_large:
        hint = "use fewer values, or pass allow_large=True (--allow-large)"
        raise ExperimentError(f"the plan has {plan.size} tasks", expected=f"at most {LARGEST}", hint=hint, source=plan.origin)
    experiment = plan.load_experiment()
    files: dict[str, bytes] = {}

    @cache
    def store_file(path: str) -> str:
        """Read a CSV file, which is sent with the tasks; return its name in the folder ``inputs/``, a hash of its content."""
        data = read_data_file(experiment.folder / path)
        name = f"{hashlib.sha256(data).hexdigest()[:32]}.csv"
        files[name] = data
        return name

    document = copy.deepcopy(experiment.to_dict())
    for table in csv_tables(document.get("input", {})):
        table["path"] = store_file(table["path"])
    content = {key: document[key] for key in document.keys() - {"name", "description", "source"}}
    basis = _content_hash([content, {name: repr(measure) for name, measure in plan.measure.items()}, plan.every, code_hash()])
    columns: dict[str, list[Any]] = {name: [] for name in (*plan.keys, *(["sample"] if plan.samples else []))}
    tasks: list[Task] = []
    for number, (values, sample) in enumerate(_sample_points(plan)):
        chosen = tuple(
            (key, store_file(value) if key.startswith("input.") and key.endswith(".path") else value)
            for key, value in zip(plan.keys, values, strict=True)
        )
        for column, value in zip(columns.values(), (*values, sample), strict=False):
            column.append(json.dumps(value) if isinstance(value, list | dict) else value)
        is_logged = plan.log_every is not None and number % plan.log_every == 0
        tasks.append(Task(_content_hash([basis, chosen]), chosen, is_logged))
    return Workload(Job(document, files, plan.measure, plan.every, code_hash(), time_limit), columns, tasks)


def _sample_points(plan: Plan) -> Iterator[tuple[tuple[Any, ...], int]]:
    """Yield for each task the values of its keys (grid and samples), and the number of its sample."""
    grid = [values.values() if isinstance(values, Range) else values for values in plan.grid.values()]
    samples: list[tuple[Any, ...]] = [()]
    if plan.samples is not None:
        drawn = plan.samples.distributions.items()
        columns = [sample_values(one, key, plan.samples.seed, plan.samples.count) for key, one in drawn]
        samples = list(zip(*columns, strict=True))
    for point, (sample, values) in itertools.product(itertools.product(*grid), enumerate(samples)):
        yield (*point, *values), sample


def _content_hash(content: Any) -> str:
    try:
        return hashlib.sha256(canonical_json(content)).hexdigest()[:32]
    except (ValueError, TypeError) as error:
        raise ExperimentError(f"a value is not valid JSON: {error}", hint="use finite numbers, strings, lists") from None


def column_units(plan: Plan, component: Component) -> dict[str, str]:
    """Return name of a key or a measure -> SI unit, "1" for dimensionless numbers; keys of unknown unit are left out."""
    found = {key: _key_unit(key, component) for key in plan.keys}
    found |= {name: measure.unit(component) for name, measure in plan.measure.items()}
    return {name: unit for name, unit in found.items() if unit}


def _key_unit(key: str, component: Component) -> str:
    table, _, rest = key.partition(".")
    name, *inner = rest.split(".")
    if key in _SECONDS or (table == "input" and inner and inner[-1] in _TIMES):
        return "s"
    if table == "component" and inner:
        holder: Any = component.parameters
        for part in (name, *inner[:-1]):
            holder = getattr(holder, part, None)
        field = getattr(type(holder), "model_fields", {}).get(inner[-1])
        return field_unit(field) if field is not None else ""
    variable = component.variables.get(name.partition("[")[0])
    return variable.unit if variable is not None and table in ("component", "start", "input") else ""
