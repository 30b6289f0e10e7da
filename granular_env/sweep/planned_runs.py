"""The runs of a plan, called its tasks: what each sets, and a hash of everything that decides its result."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from granular_env.components.errors import ExperimentError, Fault, Option
from granular_env.components.support.serialization import canonical_json

from .csv_files import names_a_file
from .parameter_values import Range, draws
from .plan import LARGEST, Plan


@dataclass(frozen=True, slots=True)
class Task:
    """One run of a plan.

    Attributes:
        number: its place in the plan: the last key of the grid varies fastest, then the samples, then the repetitions.
        values: of the grid's keys, then of the samples'.
        sample: which one; 0 without.
        repetition: which one; 0 without.
        seed: of this repetition; None without.
        overrides: the keys of the experiment that it sets, with their values.
        hash: of the experiment, the overrides, the measures and the program.
    """

    number: int
    values: tuple[Any, ...]
    sample: int
    repetition: int
    seed: int | None
    overrides: tuple[tuple[str, Any], ...]
    hash: str


def axes(plan: Plan) -> dict[str, list[Any]]:
    """Key -> values of the grid."""
    return {key: values.values() if isinstance(values, Range) else values for key, values in plan.grid.items()}


def make_tasks(plan: Plan, basis: str, files: Mapping[str, str]) -> list[Task]:
    """All tasks of a plan, in its order.

    Args:
        plan: which one.
        basis: hash of what all tasks share.
        files: CSV files that values name -> their names in the results' folder.
    """
    return [_task(plan, basis, files, number, *point) for number, point in enumerate(_points(plan))]


def refuse_too_many(plan: Plan, allow_large: bool) -> None:
    """`ExperimentError` for more tasks than the limit allows; nothing is made for it."""
    if plan.size > LARGEST and not allow_large:
        many = f"it asks for {plan.size} tasks, at most {LARGEST} are computed unasked"
        hint = ("take fewer values, or pass ", Option("allow_large"))
        raise ExperimentError(Fault(received=many, hint=hint, source=plan.origin))


def _points(plan: Plan) -> Any:
    """(values of the grid, values of the samples, sample, repetition)."""
    grid = axes(plan)
    drawn: list[list[Any]] = []
    if plan.samples is not None:
        drawn = [draws(one, key, plan.samples.seed, plan.samples.count) for key, one in plan.samples.distributions.items()]
    samples: Sequence[tuple[Any, ...]] = list(zip(*drawn, strict=True)) if drawn else [()]
    repetitions = range(plan.seeds.count if plan.seeds else 1)
    return itertools.product(itertools.product(*grid.values()), enumerate(samples), repetitions)


def _task(
    plan: Plan,
    basis: str,
    files: Mapping[str, str],
    number: int,
    point: tuple[Any, ...],
    sample: tuple[int, tuple[Any, ...]],
    repetition: int,
) -> Task:
    values = (*point, *sample[1])
    chosen = tuple(
        (key, files.get(value, value) if names_a_file(key, value) else value)
        for key, value in zip(plan.keys, values, strict=True)
    )
    seeds, seed = plan.seeds, None
    if seeds is not None:
        seed = derived_seed(seeds.seed, chosen, repetition)
        chosen += tuple((key, seed) for key in seeds.keys)
    return Task(number, values, sample[0], repetition, seed, chosen, _hash([basis, chosen]))


def derived_seed(seed: int, overrides: tuple[tuple[str, Any], ...], repetition: int) -> int:
    """Derive a repetition's seed from the plan's and from what the task sets, so that an edited plan keeps it."""
    return int(_hash([seed, overrides, repetition])[:8], 16)


def _hash(content: Any) -> str:
    return hashlib.sha256(canonical_json(content)).hexdigest()[:32]


def basis_of(document: Mapping[str, Any], plan: Plan, program: str) -> str:
    """Hash of what all tasks of a plan share: the experiment, the measures, the program."""
    content = {key: value for key, value in document.items() if key not in ("name", "description", "source")}
    return _hash([content, plan.text, program])
