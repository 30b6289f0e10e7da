"""A recording that never ends, in a process that is there to be killed."""

from __future__ import annotations

import time
from pathlib import Path

from granular_env.components.catalogue import make
from granular_env.recording import record


def record_for_ever(path: Path, told: Path, idle_at: int) -> None:
    """Step on, and now and then write how far it is and how long the process has been running.

    Args:
        path: the log.
        told: what is said: "ready", then lines of a tick and a time [s].
        idle_at: the tick from which on nothing happens any more.
    """
    component = make("oscillator")
    with told.open("w") as out, record(component, path, every=0.01):
        component.reset(velocity=1.0)
        print("ready", file=out, flush=True)
        while True:
            component.step(0.01, force=float(component.tick % 5))
            if component.tick % 50 == 0:
                print(component.tick, time.process_time(), file=out, flush=True)
            if component.tick == idle_at:
                time.sleep(60)
