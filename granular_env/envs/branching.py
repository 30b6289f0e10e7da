"""The state at an instant of a log, for an environment that goes on from there."""

from __future__ import annotations

import os
from contextlib import closing
from typing import Any

from ..components.contract import Component, Snapshot
from ..components.errors import ParameterError, shortened


def snapshot_at(component: Component, log: str | os.PathLike[str], at: float) -> Snapshot:
    """The state at a time [s] of a recorded log, which `component` can be restored to.

    Raises:
        ParameterError: the log's component is another one, or has other parameters; or the time is outside of the log.
        LogError: it is no log, or cannot be re-run.
    """
    from ..recording import open_log

    with closing(open_log(log)) as opened:
        recorded = opened.rebuilt({component.name: type(component)})
        if recorded.identity != component.identity:
            raise ParameterError(f"log {str(opened.path)!r}: {_difference(component, recorded)}; make the environment so")
        return opened.branch(at, {component.name: type(component)}).component.save()


def _difference(component: Component, recorded: Component) -> str:
    if recorded.name != component.name:
        return f"it was recorded from {recorded.name!r}, this environment has {component.name!r}"
    theirs, ours = (one.parameters.model_dump(mode="json") for one in (recorded, component))  # type: ignore[attr-defined]
    differ = [name for name in theirs if theirs[name] != ours.get(name)]
    told = "; ".join(f"{name} is {_short(theirs[name])} there and {_short(ours.get(name))} here" for name in differ[:5])
    return told or f"it was recorded from another version of {component.name!r}"


def _short(value: Any) -> str:
    return shortened(value, 40)
