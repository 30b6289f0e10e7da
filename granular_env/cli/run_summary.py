"""The result of a finished run, printed in words, or as JSON for programs."""

from __future__ import annotations

import json
import math
import shlex
import warnings
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granular_env.cli.command import Status
from granular_env.cli.events import summary
from granular_env.components.errors import GranularWarning
from granular_env.output_files import count_of, readable_bytes
from granular_env.terminal_text import printable, wrap_text

if TYPE_CHECKING:
    from granular_env.components.events import Event
    from granular_env.run_loop import RunResult


def print_result(result: RunResult, quiet: bool = False, for_programs: bool = False) -> int:
    """Print it; return the exit status of the command that ran it."""
    if for_programs:
        print(json.dumps(_facts(result), indent=2))
    elif not quiet:
        _print_for_people(result)
    elif result.log is not None:
        print(shlex.quote(str(result.log)))
    return Status.INTERRUPTED if result.interrupted else Status.DONE


def silence_own_warnings() -> warnings.catch_warnings:
    """Silence the run's warnings, which the command prints with its result."""
    return warnings.catch_warnings(action="ignore", category=GranularWarning)


def _facts(result: RunResult) -> dict[str, Any]:
    """Return it as JSON values; figures that nothing gave rise to are null."""
    component = result.component
    found, earlier = _events(result)
    return {
        "log": None if result.log is None else str(result.log),
        "log_bytes": None if result.log is None else result.log.stat().st_size,
        "tick": component.tick,
        "time": component.time,
        "wall_seconds": result.seconds,
        "stopped_by": result.stopped_by,
        "interrupted": result.interrupted,
        "notes": [*result.warnings, *result.cautions],
        "conclusions": result.conclusions,
        "report": _finite(result.report),
        "events": dict(Counter(event.kind for event in found)),
        "earlier_events": dict(Counter(event.kind for event in earlier)),
        "balances": {b.quantity: _finite(b.entries) for b in component.balances()},
    }


def _events(result: RunResult) -> tuple[list[Event], list[Event]]:
    """Return the events of the run, and those that its component had before, such as before a branch."""
    found = result.component.events()
    return [event for event in found if event.tick > result.start], [event for event in found if event.tick <= result.start]


def _finite(values: Mapping[str, Any]) -> dict[str, Any]:
    return {name: _finite_number(value) for name, value in values.items()}


def _finite_number(value: Any) -> Any:
    """Return a number, or a list of those of a vector, with null for numbers that are not finite."""
    if hasattr(value, "tolist"):
        return [_finite_number(part) for part in value.tolist()]
    return value if math.isfinite(value) else None


def _print_for_people(result: RunResult) -> None:
    from granular_env.run_loop import energy_residual

    component = result.component
    wall = f"{result.seconds:.2f} s of wall time"
    print(f"{count_of(result.ticks, 'tick')}, to {component.time:.9g} s, in {wall}; {energy_residual(component)}")
    if result.stopped_by is not None:
        print(f"stopped: {result.stopped_by}")
    if result.interrupted:
        print("interrupted: the log is complete up to there" if result.log else "interrupted")
    found, earlier = _events(result)
    if found or earlier:
        lists = f"; granular-env events {shlex.quote(str(result.log))} lists them" if result.log else ""
        print(f"{summary(found, earlier, result.start * component.step_size)}{lists}")
    for text in result.conclusions:
        print(wrap_text(printable(text)))
    for text in (*result.warnings, *result.cautions):
        print(wrap_text(f"note: {printable(text)}"))
    for name, value in result.report.items():
        # Some figures have no value, such as the pressure where nothing touched.
        if not math.isnan(value):
            print(f"  {name}: {value:.4g}")
    if result.log is not None:
        _print_log(result.log)


def _print_log(path: Path) -> None:
    log = shlex.quote(str(path))
    print(f"log: {log} ({readable_bytes(path.stat().st_size)})")
    print(f"  granular-env view {log}              (or --web, or --screenshot FILE.png)")
    print(f"  granular-env replay {log} --verify")
