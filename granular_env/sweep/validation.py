"""Before a sweep begins: do its keys, variables and measures exist, does the seed do anything, are the kernels compiled."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path

from granular_env.components.errors import ExperimentError, Fault, GranularError, GranularWarning
from granular_env.experiments.preparation import Prepared

from .column_units import units_of
from .plan import Plan
from .worker import Computer, Job, Order

# A value that does not fit is the fault of its task; what so many tasks from all over the plan cannot do is the plan's.
_MOST_TRIED = 8
# So many kinds of tasks are compiled for: whatever tells tasks apart that is no number.
_MOST_KINDS = 32


def validate_plan(plan: Plan, job: Job, orders: Mapping[str, Order]) -> dict[str, str]:
    """Hold the plan against its component; return the units of its columns.

    Raises:
        ExperimentError: none of the tasks that were tried can begin; or repetitions do not differ.
    """
    with _computer(job) as computer:
        faults: list[GranularError] = []
        tried = list(orders.values())[:: max(1, len(orders) // _MOST_TRIED)][: _MOST_TRIED + 1]
        for order in tried:
            try:
                ready = computer.prepare_task(order)
            except GranularError as error:
                faults.append(error)
                continue
            _refuse_idle_seeds(plan, computer, order, ready)
            return units_of(plan, ready.component)
        raise plan.error_of(faults[0])


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


def compile_kernels(job: Job, orders: Iterable[Order], folder: Path) -> None:
    """Compile what the tasks need, once, before many processes would do it at the same time; `folder` is the results'."""
    computer = Computer(job, folder)
    for order in list(_kinds(orders).values())[:_MOST_KINDS]:
        computer.warm(order)


def _kinds(orders: Iterable[Order]) -> dict[str, Order]:
    """One task of each kind: numbers change no machine code, laws and integrators do."""
    found: dict[str, Order] = {}
    for order in orders:
        kind = repr([(key, value) for key, value in order.overrides if not isinstance(value, int | float)])
        found.setdefault(kind, order)
    return found


@contextmanager
def _computer(job: Job) -> Iterator[Computer]:
    with ExitStack() as held:
        held.enter_context(warnings.catch_warnings(action="ignore", category=GranularWarning))
        folder = tempfile.gettempdir()
        if job.files:  # otherwise nothing is written, and a kill leaves nothing behind
            folder = held.enter_context(tempfile.TemporaryDirectory(prefix="granular-env-sweep-"))
        yield Computer(job, Path(folder))
