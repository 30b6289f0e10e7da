"""Printing of the result of a run, as text or as JSON."""

from __future__ import annotations

import math
import shlex
import warnings
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granular_env.cli.command import Status, print_json
from granular_env.components.errors import GranularWarning
from granular_env.output_files import count_text, size_text
from granular_env.terminal_text import printable_text, wrap_text

if TYPE_CHECKING:
    from granular_env.components.events import Event
    from granular_env.run_loop import RunResult


def print_result(result: RunResult, quiet: bool = False, as_json: bool = False) -> int:
    """Print the result of a run; return the exit status of the command."""
    if as_json:
        print_json(_result_facts(result))
    elif not quiet:
        _print_summary(result)
    elif result.log is not None:
        print(shlex.quote(str(result.log)))
    return Status.INTERRUPTED if result.interrupted else Status.DONE


def silence_own_warnings() -> warnings.catch_warnings:
    """Silence the run's warnings, which the command prints with its result."""
    return warnings.catch_warnings(action="ignore", category=GranularWarning)


def _result_facts(result: RunResult) -> dict[str, Any]:
    """Return the result of a run as data for JSON."""
    component = result.component
    found, earlier = _split_events(result)
    return {
        "log": None if result.log is None else str(result.log),
        "log_bytes": None if result.log is None else result.log.stat().st_size,
        "tick": component.tick,
        "time": component.time,
        "wall_seconds": result.seconds,
        "stopped_by": result.stopped_by,
        "unmet_stops": result.unmet_stops,
        "interrupted": result.interrupted,
        "notes": [*result.warnings, *result.cautions],
        "conclusions": result.conclusions,
        "report": result.report,
        "events": dict(Counter(event.kind for event in found)),
        "earlier_events": dict(Counter(event.kind for event in earlier)),
        "balances": {b.quantity: b.entries for b in component.balances()},
    }


def _split_events(result: RunResult) -> tuple[list[Event], list[Event]]:
    """Return the events of the run, and the component's events before the run, such as those before a branch."""
    found = result.component.events()
    return [event for event in found if event.tick > result.start], [event for event in found if event.tick <= result.start]


def _print_summary(result: RunResult) -> None:
    from granular_env.recording.event_places import event_summary
    from granular_env.run_loop import energy_residual_text

    component = result.component
    wall = f"{result.seconds:.2f} s of wall time"
    print(f"{count_text(result.ticks, 'tick')}, to {component.time:.9g} s, in {wall}; {energy_residual_text(component)}")
    if result.stopped_by is not None:
        print(f"stopped: {result.stopped_by}")
    if result.unmet_stops:
        print(f"no stop rule was met: {'; '.join(result.unmet_stops)}")
    if result.interrupted:
        print("interrupted: the log is complete up to this time" if result.log else "interrupted")
    found, earlier = _split_events(result)
    if found or earlier:
        lists = f"; granular-env events {shlex.quote(str(result.log))} lists them" if result.log else ""
        print(f"{printable_text(event_summary(found, earlier, result.start * component.step_size))}{lists}")
    for text in result.conclusions:
        print(wrap_text(printable_text(text)))
    for text in (*result.warnings, *result.cautions):
        print(wrap_text(f"note: {printable_text(text)}"))
    for name, value in result.report.items():
        # Some reported numbers have no value, such as the contact pressure if there are no contacts.
        if not math.isnan(value):
            print(f"  {name}: {value:.4g}")
    if result.log is not None:
        _print_log_commands(result.log)


def _print_log_commands(path: Path) -> None:
    log = shlex.quote(str(path))
    print(f"log: {log} ({size_text(path.stat().st_size)})")
    print(f"  granular-env view {log}              (or --web, or --screenshot FILE.png)")
    print(f"  granular-env replay {log} --verify")
