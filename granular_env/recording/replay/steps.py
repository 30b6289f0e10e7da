"""A component brought to the states of a log: restored from its snapshots, and stepped with its inputs.

A log of a stranger that would keep the machine busy for days is refused.
"""

from __future__ import annotations

from collections.abc import Callable

from ...components.component import Component
from ...components.errors import GranularError, LogError, StepError
from ...components.inputs import Held
from ...components.snapshot import Snapshot
from ..container.limits import Limits

Changes = list[tuple[int, dict[str, Held]]]
# Ticks in one log, and ticks times words of state: about a day's work.
_TICKS = 10_000_000_000
_WORK = 10**14


def check_work(ticks: int, component: Component, limits: Limits) -> None:
    """Refuse to run again so many internal steps that a stranger's log says it has."""
    limits.check("the number of ticks", ticks, _TICKS)
    limits.check("the number of ticks times the words of the state", ticks * max(component.state_bytes // 8, 1), _WORK)


def restore(component: Component, snapshot: Snapshot) -> None:
    """Restore, with `LogError` where a log's snapshot does not fit its component."""
    try:
        component.restore(snapshot)
    except GranularError as error:
        raise LogError.of_content(error.renamed("snapshot", "snapshots"), "snapshots") from error


def advance(component: Component, changes: Changes, tick: int, tell: Callable[[], None] | None = None) -> None:
    """Run to a tick in as few long steps as the changes of inputs allow; `changes` is reversed, and used up.

    A step of n ticks gives the bits of n steps of one, so this is as exact as the original steps and faster.
    """
    try:
        step_size = component.step_size
        while (now := component.tick) < tick:
            inputs: dict[str, Held] = {}
            while changes and changes[-1][0] <= now:
                inputs = {**inputs, **changes.pop()[1]} if inputs else changes.pop()[1]
            stop = changes[-1][0] if changes and changes[-1][0] < tick else tick
            component.step((stop - now) * step_size, **inputs)
            if tell is not None:
                tell()
    except StepError:
        raise
    except GranularError as error:
        raise LogError.of_content(error, "steps") from error
