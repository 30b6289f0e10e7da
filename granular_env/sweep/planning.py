"""From a plan to its tasks: the experiment is loaded, its files are gathered, everything gets its hash."""

from __future__ import annotations

import hashlib
import json
import re
from typing import Any

from granular_env.components.errors import ExperimentError, GranularError
from granular_env.components.support.serialization import canonical_json
from granular_env.experiments.load import load_experiment, shipped_experiments
from granular_env.experiments.schema import Experiment

from .axes import Distribution
from .computing import Job, program
from .files import gathered
from .plan import Plan
from .tasks import Task, axes, basis_of, make_tasks


def planned(plan: Plan) -> tuple[Job, list[Task], dict[str, Any]]:
    """What the tasks share, the tasks, and how the results' folder describes them.

    Raises:
        ExperimentError: the experiment is not valid, a file that it names cannot be read, or a value has no hash.
    """
    experiment = _experiment(plan)
    grid = axes(plan)
    assigned = [(key, value) for key, values in grid.items() for value in values]
    assigned += [(key, value) for key, one in plan.distributions.items() for value in _choices(one)]
    document, names, contents = gathered(experiment.to_dict(), experiment.folder, assigned)
    try:
        basis = basis_of(document, plan, program())
        tasks = make_tasks(plan, basis, names)
    except (ValueError, TypeError) as error:
        raise ExperimentError(
            f"{plan.origin}: a value cannot be written as JSON: {error}; take numbers, texts, lists"
        ) from None
    job = Job(document, contents, plan.measures, plan.settings.every, program())
    return job, tasks, _described(plan, experiment, grid, tasks)


def _experiment(plan: Plan) -> Experiment:
    """Shipped ones by name, others by their path from the plan's folder."""
    named, beside = plan.settings.experiment, plan.folder / plan.settings.experiment
    # What is neither is told of with the nearest shipped name.
    source = beside if named not in shipped_experiments() and (beside.exists() or beside.suffix == ".toml") else named
    try:
        return load_experiment(source, plan.fixed)
    except ExperimentError as error:
        raise as_in_plan(plan, error) from error


def as_in_plan(plan: Plan, error: GranularError) -> ExperimentError:
    """A fault of an experiment as one of the plan: what a task sets stands there as a key."""
    told = re.sub(r"override (['\"])(.*?)\1", r"\2", str(error))
    return ExperimentError("\n".join(f"{plan.origin}: {line}" for line in told.splitlines()))


def _choices(distribution: Distribution) -> list[Any]:
    return distribution.values or []


def _described(plan: Plan, experiment: Experiment, grid: dict[str, list[Any]], tasks: list[Task]) -> dict[str, Any]:
    seeds = plan.settings.seeds
    return {
        "name": plan.name,
        "plan": hashlib.sha256(canonical_json([task.hash for task in tasks])).hexdigest()[:32],
        "program": program(),
        "experiment": experiment.name,
        "grid": grid,
        "samples": list(plan.distributions),
        "sample_count": plan.samples.count if plan.samples else 0,
        "repetitions": seeds.count if seeds else 0,
        "measures": {
            name: words if isinstance(words, str) else json.dumps(words) for name, words in plan.text["measure"].items()
        },
        "tasks": [[list(task.values), task.sample, task.repetition, task.seed, task.hash] for task in tasks],
    }
