"""The cost of a run: its wall time, measured on a few ticks, and the size of its log."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from time import perf_counter

from granular_env.components.errors import ExperimentError, StepError, issue_warning
from granular_env.output_files import size_text
from granular_env.recording.schedule import estimate_bytes, make_schedule, names_to_record

from .preparation import Prepared

# `check` reports runs longer than _LONG [s] and logs above LARGE_LOG [bytes]; `run` on a terminal, logs above NOTED_LOG.
_LONG, LARGE_LOG, NOTED_LOG = 60.0, 200_000_000, 10_000_000
# Size of a compressed log over its size before compression: at least this for a large body that is mostly at rest.
_LEAST_SHARE = 0.04
_MEASURED = 0.02  # wall time of the measured steps [s]
_LESS = "record less often (record.every), fewer variables (record.variables) or fewer snapshots (record.snapshot_every)"
_UNITS = ((86400.0, "days"), (3600.0, "h"), (60.0, "min"), (1.0, "s"))


def cost_note(ready: Prepared) -> str:
    """Return a sentence on the run's wall time and log size if one is large, else ""; to measure, the component is stepped."""
    size = log_bytes(ready)
    seconds = ready.ticks * _seconds_per_tick(ready)
    if seconds < _LONG and size < LARGE_LOG:
        return ""
    length, unit = next((pair for pair in _UNITS if seconds >= pair[0]), _UNITS[-1])
    duration = f"{seconds / length:.2g} {unit}"
    return f"the run takes about {duration} on this machine, and records up to {size_text(size)} before compression"


def refuse_oversized_log(ready: Prepared, log: Path) -> None:
    """Raise `ExperimentError` if a log cannot fit on the file system of `log`; a run with stop rules may end early."""
    folder = next(parent for parent in log.absolute().parents if parent.exists())
    least, free = _LEAST_SHARE * log_bytes(ready), shutil.disk_usage(folder).free
    if least > free and not ready.experiment.stop:
        came = f"the log takes at least {size_text(int(least))}, but {folder} has {size_text(free)} of free space"
        raise ExperimentError(came, hint=f"check the duration, or {_LESS}", at="duration", source=ready.experiment.origin)


def _seconds_per_tick(ready: Prepared) -> float:
    component, ticks = ready.component, 1
    component.wake()
    try:
        # Do not time the first step, which may compile.
        component.step(None, **ready.inputs)
        first, begin = component.tick, perf_counter()
        while perf_counter() - begin < _MEASURED and component.tick < ready.ticks:
            ticks = min(2 * ticks, ready.ticks - component.tick)
            component.step(ticks * component.step_size)
        return (perf_counter() - begin) / max(component.tick - first, 1)
    except StepError:
        return 0.0


def log_bytes(ready: Prepared) -> int:
    """Return an estimate of the largest log size of an experiment before compression [bytes]."""
    component, record, duration = ready.component, ready.experiment.record, {"duration": ready.experiment.duration}
    names = names_to_record(component, record.variables)
    schedule = make_schedule(component, record.every, record.hash_every, record.snapshot_every, duration, names)
    return estimate_bytes(component, schedule, names, ready.ticks)


def announce_log_size(ready: Prepared, at_once: bool) -> None:
    """Announce a large log: print a note from 10 MB if `at_once` is set; otherwise issue a warning from 200 MB."""
    size = log_bytes(ready)
    note = f"the log takes up to {size_text(size)} before compression, and at most two thirds of that on the disk"
    if size >= LARGE_LOG:
        note += f"; {_LESS} for a smaller log"
    if at_once and size >= NOTED_LOG:
        print(f"note: {note}", file=sys.stderr)
    elif size >= LARGE_LOG:
        issue_warning(note)
