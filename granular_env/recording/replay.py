"""The component of a log, rebuilt from its header, and moved to states of the log.

Code or files named in an untrusted log are not imported or opened, and a log that would run for days is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..components.catalogue import built_in_names, component_class
from ..components.component import Component
from ..components.errors import GranularError, LogError, StepError
from ..components.inputs import Held
from ..components.snapshot import Snapshot
from ..components.support.memory_limits import total_memory
from ..components.support.validation import Parameters
from .container import Limits
from .records import damage_error

Changes = list[tuple[int, dict[str, Held]]]
# Limits on ticks in a log, and on ticks times words of state, for about a day's work.
_TICKS = 10_000_000_000
_WORK = 10**14


def check_work(ticks: int, component: Component, limits: Limits) -> None:
    """Refuse to run more internal steps than about a day's work, because the number in an untrusted log is arbitrary."""
    limits.check("the number of ticks", ticks, _TICKS)
    limits.check("the number of ticks times words of the state", ticks * max(component.state_bytes // 8, 1), _WORK)


def restore_snapshot(component: Component, snapshot: Snapshot) -> None:
    """Restore the component to a snapshot of a log; raise `LogError` if the snapshot does not fit the component."""
    try:
        component.restore(snapshot)
    except GranularError as error:
        raise LogError.from_content(error.with_argument("snapshot", "snapshots"), "snapshots") from error


def advance_to_tick(component: Component, changes: Changes, tick: int, report: Callable[[int], None] | None = None) -> None:
    """Run to a tick in as few steps as possible: one per input change. `changes` is in reverse order and gets emptied.

    A step of n ticks is bitwise identical to n steps of one tick, so this is exact and faster than the original steps.
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
        raise LogError.from_content(error, "steps") from error


# The limit on whole numbers among a component's parameters (grains, nodes, cells) depends on the memory, between these two.
_COUNT, _MOST = 10_000_000, 100_000_000
# A machine must accept logs that it could have recorded: a component may use 1/2 of the memory, with at least this per counted
# element [bytes].
_COMPONENT_SHARE, _UNIT_BYTES = 2, 160


def load_component_class(name: Any, components: Mapping[str, type[Component]] | None) -> type[Component]:
    """Return the class of the component named in a log: a component of this package, or a class given by the caller."""
    if components and name in components:
        return components[name]
    if not isinstance(name, str) or name not in built_in_names():
        raise LogError(
            f"the log is of a component {name!r}, which is not part of granular-env ({', '.join(built_in_names())})",
            hint=f"if you trust it, pass its class, components={{{name!r}: ...}} (--component {name})",
            at="header.component",
        )
    return component_class(name)


def check_parameters(parameters: Mapping[str, Any], model: type[Parameters], limits: Limits) -> None:
    """Raise an error if a whole number among the component's parameters (grains, nodes, cells) is too large for the memory."""
    limit = max(_COUNT, min(_MOST, (total_memory() or 0) // (_COMPONENT_SHARE * _UNIT_BYTES)))
    for name, field in model.model_fields.items():
        value = parameters.get(name)
        if field.annotation is int and isinstance(value, (int, float)) and not value <= limit:
            limits.check(f"parameter {name!r}", int(min(value, 2.0**62)), limit)


def make_component(header: Mapping[str, Any], limits: Limits, components: Mapping[str, type[Component]] | None) -> Component:
    """Return a new component with the parameters in a log's header; the identity in the log is not compared with it."""
    kind, given = load_component_class(header.get("component"), components), header.get("parameters")
    if not isinstance(given, dict) or not all(isinstance(name, str) for name in given):
        raise damage_error("missing", "header.parameters", limits.path)
    check_parameters(given, kind.Parameters, limits)
    try:
        return kind(**given)
    except GranularError as error:
        raise LogError.from_content(error, "header", "parameters", source=limits.source) from error
    except (ArithmeticError, ValueError, TypeError, MemoryError, RecursionError) as error:
        came = f"not valid for {kind.name!r}: {error}"
        raise LogError(came, at="header.parameters", source=limits.source) from error
