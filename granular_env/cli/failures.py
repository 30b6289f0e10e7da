"""Errors that end a command early, as one message on standard error and an exit status."""

from __future__ import annotations

import io
import os
import sys
from dataclasses import replace

import click

from granular_env.cli.command import Status
from granular_env.components.errors import Fault, GranularError
from granular_env.terminal_text import printable_text


def report_failure(command: click.Command | None, failure: BaseException) -> int:
    """Print the error that ended a command; return the exit status."""
    message, status = _failure_message(command, failure)
    if status is Status.FAULT:
        import traceback

        traceback.print_exception(failure)
    lines = [printable_text(line) for line in message.split("\n")]
    print(f"granular-env {command.name}: " if command else "granular-env: ", end="", file=sys.stderr)
    print("\n".join(lines), file=sys.stderr)
    discard_output()
    return status


def report_misuse(misuse: click.ClickException) -> int:
    """Print an error in the arguments of a command, with its usage; return the exit status."""
    text = io.StringIO()
    misuse.show(text)
    print("\n".join(map(printable_text, text.getvalue().rstrip("\n").split("\n"))), file=sys.stderr)
    return Status.ERROR


def _failure_message(command: click.Command | None, failure: BaseException) -> tuple[str, Status]:
    match failure:
        case GranularError():
            faults = [str(_name_option(command, fault)) for fault in failure.faults]
            return "\n".join([*faults, *getattr(failure, "__notes__", ())]), Status.ERROR
        case MemoryError():
            return "not enough memory; reduce the size of the model", Status.ERROR
        case KeyboardInterrupt():
            return "interrupted", Status.INTERRUPTED
        case OSError():  # a full disk behind standard output, too many open files, a folder that is gone
            where = f"{failure.filename!r}: " if failure.filename is not None else ""
            return f"{where}{failure.strerror or failure}", Status.ERROR
    return "this is an error in the program, not in your input; please report it with the lines above", Status.FAULT


def _name_option(command: click.Command | None, fault: Fault) -> Fault:
    """Return a fault that names the option that set the argument; a fault in a file (it has a source) is returned unchanged."""
    flags: dict[str | int | None, str] = {}
    for option in command.params if command else ():
        if isinstance(option, click.Option):
            flag = max(option.opts, key=len)
            flags |= {option.name: flag, flag.lstrip("-").replace("-", "_"): flag}
    first, *rest = fault.location or (None,)
    return fault if fault.source or first not in flags else replace(fault, location=(flags[first], *rest))


def discard_output() -> None:
    """Discard the output that Python would flush at exit, if standard output cannot be written."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
