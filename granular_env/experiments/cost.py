"""The cost of a run: its wall time, measured on a few ticks, and the numbers that it records."""

from __future__ import annotations

import shutil
from pathlib import Path
from time import perf_counter

from granular_env.components.errors import ExperimentError, StepError
from granular_env.output_files import readable_bytes
from granular_env.recording.size_estimate import estimated_bytes

from .preparation import Prepared

# What lasts longer, or writes more, is told of; on a terminal the size of smaller logs too.
_LONG, LARGE_LOG, TOLD_LOG = 60.0, 200_000_000, 10_000_000  # s, bytes
_MEASURED = 0.02  # s of stepping that the speed is read off
_LESS = "record less often (record.every), fewer variables (record.variables) or fewer snapshots (record.snapshot_every)"
# A part of its size that no log falls below on the disk; that of a large body mostly at rest takes 0.04.
_COMPRESSED = 0.02
_UNITS = ((86400.0, "days"), (3600.0, "h"), (60.0, "min"), (1.0, "s"))


def cost_note(ready: Prepared) -> str:
    """Return a sentence on the wall time and the size of the log where these are large; "" else. Steps the component."""
    size = recorded_bytes(ready, Path.cwd())
    seconds = ready.ticks * _seconds_per_tick(ready)
    if seconds < _LONG and size < LARGE_LOG:
        return ""
    return f"this takes about {_duration(seconds)} on this machine, and records up to {readable_bytes(size)} before compression"


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


def size_note(ready: Prepared, folder: Path, least: int) -> str:
    """Return a sentence on the size of a log of `least` bytes or more, and how to make a large one smaller; "" for others."""
    size = recorded_bytes(ready, folder)
    if size < least:
        return ""
    note = f"the log takes up to {readable_bytes(size)} before compression, and on the disk at most two thirds of that"
    if size < LARGE_LOG:
        return note
    return f"{note}; {_LESS} for a smaller one"


def recorded_bytes(ready: Prepared, folder: Path) -> int:
    """Return how many bytes the log of an experiment takes at most, before compression.

    Args:
        ready: the experiment.
        folder: where the log will be written; it may not exist yet.

    Raises:
        ExperimentError: the file system of the folder has no room for the log.
    """
    experiment = ready.experiment
    size = estimated_bytes(
        ready.component, ready.ticks, experiment={"duration": experiment.duration}, **experiment.record.model_dump()
    )
    existing = next(one for one in (folder.absolute(), *folder.absolute().parents) if one.exists())
    free = shutil.disk_usage(existing).free
    if _COMPRESSED * size > free:
        raise ExperimentError(
            f"the log takes up to {readable_bytes(size)} before compression, on the disk at least 2 % of that, and "
            f"{readable_bytes(free)} are free in {str(existing)!r}",
            hint=f"choose a shorter duration, {_LESS}, or run without a log",
            at="duration",
            source=experiment.origin,
        ) from OSError("no space")
    return size


def _duration(seconds: float) -> str:
    length, unit = next((pair for pair in _UNITS if seconds >= pair[0]), _UNITS[-1])
    return f"{seconds / length:.2g} {unit}"
