"""The arguments of a recording, checked before any file exists."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...components.component import Component
from ...components.drawables import drawn_outputs
from ...components.errors import ParameterError, nearest, one_line
from .sampling import HASH_EVERY, Schedule, doubling_for, frames_for, least_snapshot_interval


def names_to_record(component: Component, variables: Sequence[str] | None) -> list[str]:
    """Return the names to record, by default the state and what viewers draw; the balances' entries always come along."""
    given = variables is not None
    if variables is None:
        variables = [*(v.name for v in component.variables.values() if v.state), *drawn_outputs(component.drawables())]
    if isinstance(variables, str):
        expected = f"a list of names, such as [{variables!r}]"
        raise ParameterError(f"got the text {variables!r}", expected=expected, at="variables")
    known = [v.name for v in component.variables.values() if v.causality != "parameter"]
    for place, name in enumerate(variables):
        at = ("variables", place)
        if name not in known:
            expected = f"an output or input of component {component.name!r}"
            raise ParameterError(f"got {one_line(name)}", expected=expected, hint=nearest(name, known), at=at)
        if given and name in variables[:place]:
            raise ParameterError(f"got {name!r} again", expected="each name once", at=at)
        _refuse_misshapen(component, name)
    return list(dict.fromkeys([*variables, *component.balance_names]))


def _refuse_misshapen(component: Component, name: str) -> None:
    """Refuse an output whose author declared another shape than it has: nobody could read its frames."""
    variable = component.variables[name]
    if variable.causality == "output" and np.shape(found := component.peek(name)) != variable.shape:
        raise ParameterError(
            f"it has the shape {np.shape(found)}", expected=f"{variable.shape}, as component {component.name!r} declares it",
            hint="mend the declaration, or what `_outputs` gives", at=("variables", name),
        )  # fmt: skip


def make_schedule(
    component: Component,
    every: float | None,
    hash_every: int | None,
    snapshot_every: float | None,
    experiment: Any,
    names: list[str],
) -> Schedule:
    """Return when frames, hashes and snapshots are taken."""
    if hash_every is not None and (
        not isinstance(hash_every, (int, np.integer)) or isinstance(hash_every, bool) or hash_every < 1
    ):
        raise ParameterError(f"got {hash_every!r}", expected="a whole number of ticks, at least 1", at="hash_every")
    duration = experiment.get("duration") if isinstance(experiment, Mapping) else None
    frame_every, values = 0, sum(math.prod(component.variables[name].shape) for name in names)
    if every is not None:
        frame_every = component.ticks_in(every, "every")
    elif isinstance(duration, (int, float)) and duration > 0.0:
        frame_every = frames_for(round(duration / component.step_size), values, _words(component))
    schedule = Schedule(frame_every, doubling_for(values), int(hash_every or HASH_EVERY), 0)
    if snapshot_every is not None:
        return replace(schedule, snapshot_every=component.ticks_in(snapshot_every, "snapshot_every"))
    least = least_snapshot_interval(_words(component), component.work_in_tick)
    return replace(schedule, least_snapshot_interval=least)


def _words(component: Component) -> int:
    return component.state_bytes // 8
