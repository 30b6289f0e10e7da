"""The component of a log, made again from its header, and brought to the states of the log.

Nothing of a stranger's is imported or opened, and a log that would keep the machine busy for days is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..components.catalogue import component_class, own_names
from ..components.component import Component
from ..components.errors import GranularError, LogError, StepError
from ..components.inputs import Held
from ..components.snapshot import Snapshot
from ..components.support.memory_limits import whole_memory
from ..components.support.validation import Parameters
from .container import Limits
from .records import damage

Changes = list[tuple[int, dict[str, Held]]]
# Ticks in one log, and ticks times words of state: about a day's work.
_TICKS = 10_000_000_000
_WORK = 10**14


def check_work(ticks: int, component: Component, limits: Limits) -> None:
    """Refuse to run again more internal steps than about a day's work; a stranger's log declares them."""
    limits.check("the number of ticks", ticks, _TICKS)
    limits.check("the number of ticks times the words of the state", ticks * max(component.state_bytes // 8, 1), _WORK)


def restore(component: Component, snapshot: Snapshot) -> None:
    """Restore, with `LogError` where a log's snapshot does not fit its component."""
    try:
        component.restore(snapshot)
    except GranularError as error:
        raise LogError.of_content(error.renamed("snapshot", "snapshots"), "snapshots") from error


def advance(component: Component, changes: Changes, tick: int, report: Callable[[int], None] | None = None) -> None:
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
            if report is not None:
                report(component.tick)
    except StepError:
        raise
    except GranularError as error:
        raise LogError.of_content(error, "steps") from error


# The largest whole number among a component's parameters (grains, nodes, cells): at least, and at most, by the memory here.
_COUNT, _MOST = 10_000_000, 100_000_000
# A log that this machine could record, it may read as well: part of its memory that a component may take, and what one of
# the things that it counts takes in it, at least [bytes].
_COMPONENT_SHARE, _UNIT_BYTES = 2, 160


def own_or_given(name: Any, components: Mapping[str, type[Component]] | None) -> type[Component]:
    """Return the class of a component that a log names: a component of this package, or the class that the caller gives."""
    if components and name in components:
        return components[name]
    if not isinstance(name, str) or name not in own_names():
        raise LogError(
            f"the log is of a component {name!r}, which is not one of ours ({', '.join(own_names())})",
            hint=f"if you trust it, pass components={{{name!r}: ...}}, its class (--component {name})",
            at="header.component",
        )
    return component_class(name)


def check_parameters(given: Mapping[str, Any], model: type[Parameters], limits: Limits) -> None:
    """Refuse too large whole numbers (grains, nodes, cells) among the parameters of a component to be built."""
    limit = max(_COUNT, min(_MOST, (whole_memory() or 0) // (_COMPONENT_SHARE * _UNIT_BYTES)))
    for name, field in model.model_fields.items():
        value = given.get(name)
        if field.annotation is int and isinstance(value, (int, float)) and not value <= limit:
            limits.check(f"parameter {name!r}", int(min(value, 2.0**62)), limit)


def build(header: Mapping[str, Any], limits: Limits, components: Mapping[str, type[Component]] | None) -> Component:
    """Return a fresh component with the log's parameters, whatever identity the log claims."""
    kind, given = own_or_given(header.get("component"), components), header.get("parameters")
    if not isinstance(given, dict) or not all(isinstance(name, str) for name in given):
        raise damage("missing", "header.parameters", limits.path)
    check_parameters(given, kind.Parameters, limits)
    try:
        return kind(**given)
    except GranularError as error:
        raise LogError.of_content(error, "header", "parameters", source=limits.source) from error
    except (ArithmeticError, ValueError, TypeError, MemoryError, RecursionError) as error:
        came = f"not valid for {kind.name!r}: {error}"
        raise LogError(came, at="header.parameters", source=limits.source) from error
