"""Checks before a sweep begins: its keys, variables and measures exist, and its seeds have an effect."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path

from granular_env.components.errors import ExperimentError, Fault, GranularError, GranularWarning
from granular_env.experiments.preparation import Prepared

from .column_units import units_of
from .plan import Plan
from .worker import Computer, Job, Order

# A value that does not fit is the fault of its task; what so many tasks from all over the plan cannot do is the plan's. A prime
# number, so that they seldom have the value of a key in common.
_MOST_TRIED = 7


def validate_plan(plan: Plan, job: Job, orders: Mapping[str, Order], thorough: bool = False) -> dict[str, str]:
    """Prepare tasks from all over the plan until one can begin; return the units of the columns.

    Args:
        plan: which one.
        job: what its tasks share.
        orders: its tasks.
        thorough: prepare more tasks, and warn of those that cannot begin.

    Raises:
        ExperimentError: none of the tasks that were tried can begin; or repetitions do not differ.
    """
    units: dict[str, str] | None = None
    faults: list[GranularError] = []
    tasks, count = list(orders.values()), min(len(orders), _MOST_TRIED)
    tried = [tasks[number * len(tasks) // count] for number in range(count)]
    with _computer(job) as computer:
        for order in tried:
            try:
                ready = computer.prepare_task(order)
            except GranularError as error:
                faults.append(error)
                continue
            if units is None:
                _refuse_idle_seeds(plan, computer, order, ready)
                units = units_of(plan, ready.component)
            if not thorough:
                break
    if units is None:
        raise plan.error_of(faults[0])
    if thorough and faults:
        said = f"{len(faults)} of {len(tried)} tasks that were tried cannot begin, such as: {faults[0]}"
        warnings.warn(said, GranularWarning, stacklevel=3)
    return units


def _refuse_idle_seeds(plan: Plan, computer: Computer, order: Order, ready: Prepared) -> None:
    """Refuse repetitions whose seed changes nothing: they would all be the same."""
    seeds = plan.seeds
    if seeds is None or seeds.count == 1:
        return
    others = {key: value ^ 1 if key in seeds.keys else value for key, value in order.overrides}
    other = computer.prepare_task(Order("", tuple(others.items()))).component
    if other.identity == ready.component.identity and other.save().to_bytes() == ready.component.save().to_bytes():
        same = (
            f"{', '.join(seeds.keys)} changes nothing in component {ready.component.name!r}: all repetitions would be the same"
        )
        hint = 'name the key that is a seed, such as keys = ["component.arrangement.seed"]'
        raise ExperimentError(plan.locate_fault(Fault(("seeds", "keys"), same, hint=hint)))


@contextmanager
def _computer(job: Job) -> Iterator[Computer]:
    with ExitStack() as held:
        held.enter_context(warnings.catch_warnings(action="ignore", category=GranularWarning))
        folder = tempfile.gettempdir()
        if job.files:  # otherwise nothing is written, and a kill leaves nothing behind
            folder = held.enter_context(tempfile.TemporaryDirectory(prefix="granular-env-sweep-"))
        yield Computer(job, Path(folder))
