"""What a run will cost: its wall time, measured on a few ticks, and the numbers that it records."""

from __future__ import annotations

from time import perf_counter

import numpy as np

from granular_env.components.contract import Component
from granular_env.components.errors import StepError

from .prepare import Prepared

# What lasts longer, or writes more, is told of.
_LONG, _LARGE = 60.0, 1e9  # s, bytes
_MEASURED = 0.02  # s of stepping that the speed is read off
_UNITS = ((86400.0, "days"), (3600.0, "h"), (60.0, "min"), (1.0, "s"))


def cost_note(ready: Prepared) -> str:
    """Return a sentence on the wall time and the size of the log where these are large; "" else. Steps the component."""
    seconds, size = ready.ticks * _seconds_per_tick(ready), _bytes_recorded(ready)
    if seconds < _LONG and size < _LARGE:
        return ""
    return f"this takes about {_duration(seconds)} on this machine, and records up to {size / 1e9:.3g} GB before compression"


def _seconds_per_tick(ready: Prepared) -> float:
    component, inputs, ticks, begin = ready.component, dict(ready.inputs), 1, perf_counter()
    first = component.tick
    while perf_counter() - begin < _MEASURED and component.tick < ready.ticks:
        ticks = min(2 * ticks, ready.ticks - component.tick)
        try:
            component.step(ticks * component.step_size, **inputs)
        except StepError:
            break
        inputs = {}
    return (perf_counter() - begin) / max(component.tick - first, 1)


def _bytes_recorded(ready: Prepared) -> float:
    component, record = ready.component, ready.experiment.record
    if record.every is None:
        return 0.0
    names = record.variables or [v.name for v in component.variables.values() if v.state]
    return 8.0 * ready.ticks / component.ticks_in(record.every) * sum(_numbers(component, name) for name in names)


def _numbers(component: Component, name: str) -> int:
    return int(np.prod(component.variables[name].shape))


def _duration(seconds: float) -> str:
    length, unit = next((pair for pair in _UNITS if seconds >= pair[0]), _UNITS[-1])
    return f"{seconds / length:.2g} {unit}"
