"""The cost of a run: its wall time, measured on a few ticks, and the size of its log."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from time import perf_counter

from granular_env.components.errors import ExperimentError, StepError, caution
from granular_env.output_files import readable_bytes
from granular_env.recording.schedule import estimated_bytes, make_schedule, names_to_record

from .preparation import Prepared

# `check` notes longer runs [s] and larger logs [bytes]; `run` notes logs from the second size on, on a terminal.
_LONG, LARGE_LOG, NOTED_LOG = 60.0, 200_000_000, 10_000_000
_MEASURED = 0.02  # wall time of the measured steps [s]
_LESS = "record less often (record.every), fewer variables (record.variables) or fewer snapshots (record.snapshot_every)"
# Least size of a log on the disk, over its size before compression; that of a large body mostly at rest takes 0.04.
_COMPRESSED = 0.02
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


def log_bytes(ready: Prepared) -> int:
    """Return about the largest size of the log of an experiment before compression [bytes]."""
    component, record, duration = ready.component, ready.experiment.record, {"duration": ready.experiment.duration}
    names = names_to_record(component, record.variables)
    schedule = make_schedule(component, record.every, record.hash_every, record.snapshot_every, duration, names)
    return estimated_bytes(component, schedule, names, ready.ticks)


def announce_log(ready: Prepared, folder: Path, at_once: bool) -> None:
    """Print the estimated size of a log in a folder, which may not exist yet, or warn of a large one.

    Args:
        ready: the experiment.
        folder: where the log will be.
        at_once: print it on the terminal.

    Raises:
        ExperimentError: the file system has no room for the log.
    """
    size = log_bytes(ready)
    note = f"the log takes up to {readable_bytes(size)} before compression, and on the disk "
    existing = next(one for one in (folder.absolute(), *folder.absolute().parents) if one.exists())
    free = shutil.disk_usage(existing).free
    if _COMPRESSED * size > free:
        raise ExperimentError(
            f"{note}at least 2 % of that, and {readable_bytes(free)} are free in {str(existing)!r}",
            hint=f"choose a shorter duration, {_LESS}, or run without a log",
            at="duration",
            source=ready.experiment.origin,
        ) from OSError("no space")
    note += f"at most two thirds of that{f'; {_LESS} for a smaller one' if size >= LARGE_LOG else ''}"
    if at_once and size >= NOTED_LOG:
        print(f"note: {note}", file=sys.stderr)
    elif size >= LARGE_LOG:
        caution(note)
