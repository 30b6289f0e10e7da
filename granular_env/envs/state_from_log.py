"""The state at an instant of a log, for an environment that goes on from there."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import closing
from typing import TYPE_CHECKING, Any

from ..components.component import Component
from ..components.errors import ParameterError, one_line
from ..components.snapshot import Snapshot

if TYPE_CHECKING:
    from .environment import Ready


def snapshot_at(
    present: Component, like: Callable[[Component], Ready], log: str | os.PathLike[str], at: float
) -> tuple[Ready, Snapshot]:
    """Return the state at a time [s] of a recorded log, and the component that can go on from it.

    Args:
        present: the environment's component.
        like: gives the component of the environment, and what belongs to it, for that of the log.
        log: path of the log.
        at: time of the log [s].

    Raises:
        ParameterError: the log's component is another one, or has other parameters; or the time is outside of the log.
        LogError: it is no log, or cannot be re-run.
    """
    from ..recording import open_log

    with closing(open_log(log, components={present.name: type(present)})) as opened:
        recorded = opened.rebuilt()
        ready = like(recorded)
        component = ready[0]
        if recorded.identity != component.identity:
            raise ParameterError(
                f"{_difference(component, recorded)}", hint="make the environment so", source=f"log {str(opened.path)!r}"
            )
        return ready, opened.branch(at).component.save()


def _difference(component: Component, recorded: Component) -> str:
    if recorded.name != component.name:
        return f"it was recorded from {recorded.name!r}, this environment has {component.name!r}"
    theirs, ours = (one.parameters.model_dump(mode="json") for one in (recorded, component))  # type: ignore[attr-defined]
    differ = [name for name in theirs if theirs[name] != ours.get(name)]
    text = "; ".join(f"{name} is {_short(theirs[name])} there and {_short(ours.get(name))} here" for name in differ[:5])
    return text or f"it was recorded from another version of {component.name!r}"


def _short(value: Any) -> str:
    return one_line(value, 40)
