"""The cost of a run: its wall time, measured on a few ticks, and the size of its log."""

from __future__ import annotations

from time import perf_counter

from granular_env.components.errors import StepError
from granular_env.output_files import readable_bytes
from granular_env.recording.size_estimate import estimated_bytes

from .preparation import Prepared

# `check` notes longer runs [s] and larger logs [bytes]; `run` notes logs from the second size on, on a terminal.
_LONG, LARGE_LOG, NOTED_LOG = 60.0, 200_000_000, 10_000_000
_MEASURED = 0.02  # wall time of the measured steps [s]
_LESS = "record less often (record.every), fewer variables (record.variables) or fewer snapshots (record.snapshot_every)"
_UNITS = ((86400.0, "days"), (3600.0, "h"), (60.0, "min"), (1.0, "s"))


def cost_note(ready: Prepared) -> str:
    """Return a sentence on the wall time and the size of the log if these are large, else "". Steps the component."""
    size = log_bytes(ready)
    seconds = ready.ticks * _seconds_per_tick(ready)
    if seconds < _LONG and size < LARGE_LOG:
        return ""
    length, unit = next((pair for pair in _UNITS if seconds >= pair[0]), _UNITS[-1])
    duration = f"{seconds / length:.2g} {unit}"
    return f"this takes about {duration} on this machine, and records up to {readable_bytes(size)} before compression"


def _seconds_per_tick(ready: Prepared) -> float:
    component, ticks = ready.component, 1
    component.wake()
    try:
        # Not timed: the first step may compile.
        component.step(None, **ready.inputs)
        first, begin = component.tick, perf_counter()
        while perf_counter() - begin < _MEASURED and component.tick < ready.ticks:
            ticks = min(2 * ticks, ready.ticks - component.tick)
            component.step(ticks * component.step_size)
        return (perf_counter() - begin) / max(component.tick - first, 1)
    except StepError:
        return 0.0


def size_note(ready: Prepared, least: int) -> str:
    """Return a sentence on the size of a log of `least` bytes or more, and how to make a large one smaller; else ""."""
    size = log_bytes(ready)
    if size < least:
        return ""
    note = f"the log takes up to {readable_bytes(size)} before compression, and on the disk at most two thirds of that"
    return note if size < LARGE_LOG else f"{note}; {_LESS} for a smaller one"


def log_bytes(ready: Prepared) -> int:
    """Return the largest size of the log of an experiment before compression [bytes]."""
    experiment = ready.experiment
    facts = {"duration": experiment.duration}
    return estimated_bytes(ready.component, ready.ticks, experiment=facts, **experiment.record.model_dump())
