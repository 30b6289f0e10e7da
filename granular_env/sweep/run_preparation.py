"""Preparation of a plan's tasks: the experiment is loaded, its files are gathered, everything gets its hash."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from granular_env.components.errors import ExperimentError
from granular_env.components.support.serialization import canonical_json
from granular_env.experiments import Experiment

from .csv_files import gather_files
from .parameter_values import Choice
from .plan import Plan
from .planned_runs import Task, axes, basis_of, make_tasks
from .worker import Job, program


def plan_tasks(plan: Plan, time_limit: float | None = None) -> tuple[Job, list[Task], dict[str, Any]]:
    """Return what the tasks share, the tasks, and their description in the results' folder.

    Args:
        plan: which one.
        time_limit: wall time of a task [s].

    Raises:
        ExperimentError: the experiment is not valid, a file that it names cannot be read, or a value has no hash.
    """
    experiment = plan.load_experiment()
    grid = axes(plan)
    assigned = [(key, value) for key, values in grid.items() for value in values]
    document, names, contents = gather_files(experiment.to_dict(), experiment.folder, [*assigned, *_choices(plan)])
    code = program(document["component"]["type"])
    try:
        basis = basis_of(document, plan, code)
        tasks = make_tasks(plan, basis, names)
    except (ValueError, TypeError) as error:
        raise ExperimentError(
            f"a value cannot be written as JSON: {error}", hint="take numbers, texts, lists", source=str(plan.origin)
        ) from None
    job = Job(document, contents, plan.measure, plan.every, code, time_limit)
    return job, tasks, _describe(plan, experiment, code, grid, tasks)


def _choices(plan: Plan) -> list[tuple[str, Any]]:
    """Return the keys of the samples that choose from a list, each with every value of it."""
    drawn = plan.samples.distributions.items() if plan.samples else ()
    return [(key, value) for key, one in drawn if isinstance(one, Choice) for value in one.values]


def _describe(plan: Plan, experiment: Experiment, code: str, grid: dict[str, list[Any]], tasks: list[Task]) -> dict[str, Any]:
    return {
        "name": plan.title,
        "plan": hashlib.sha256(canonical_json([task.hash for task in tasks])).hexdigest()[:32],
        "program": code,
        "experiment": experiment.name,
        "grid": grid,
        "samples": list(plan.samples.distributions) if plan.samples else [],
        "sample_count": plan.samples.count if plan.samples else 0,
        "repetitions": plan.seeds.count if plan.seeds else 0,
        "measures": {
            name: words if isinstance(words, str) else json.dumps(words) for name, words in plan.text["measure"].items()
        },
        "tasks": [[list(task.values), task.sample, task.repetition, task.seed, task.hash] for task in tasks],
    }
