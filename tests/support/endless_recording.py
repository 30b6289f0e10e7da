"""An endless recording in a process that tests kill."""

from __future__ import annotations

import time
from pathlib import Path

from granular_env.components.catalogue import make
from granular_env.recording import record


def record_endlessly(path: Path, report_path: Path, idle_at: int) -> None:
    """Step indefinitely, and regularly write the tick and the running time of the process.

    Args:
        path: the log.
        report_path: file for the messages: "ready", then lines with a tick and a time [s].
        idle_at: tick at which stepping stops.
    """
    component = make("oscillator")
    with report_path.open("w") as out, record(component, path, every=0.01):
        component.reset(velocity=1.0)
        print("ready", file=out, flush=True)
        while True:
            component.step(0.01, force=float(component.tick % 5))
            if component.tick % 50 == 0:
                print(component.tick, time.process_time(), file=out, flush=True)
            if component.tick == idle_at:
                time.sleep(60)
