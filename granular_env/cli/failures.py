"""Errors that end a command early, as one message on standard error and an exit status; streams that are closed or full."""

from __future__ import annotations

import io
import os
import sys

import click

from granular_env.cli.status import Status
from granular_env.components.errors import GranularError, Override, Term, shortened
from granular_env.terminal import printable


def report_failure(command: str, failure: BaseException) -> int:
    """Write what ended a command in words; return its exit status."""
    message, status = _message(failure)
    if status is Status.FAULT:
        import traceback

        traceback.print_exception(failure)
    lines = [printable(line) for line in message.split("\n")]
    print(f"{f'granular-env {command}'.rstrip()}: " + "\n".join(lines), file=sys.stderr)
    discard_output()
    return status


def report_misuse(misuse: click.ClickException) -> int:
    """Write what is wrong with the words of a command line, with its usage; return the exit status."""
    text = io.StringIO()
    misuse.show(text)
    print("\n".join(map(printable, text.getvalue().rstrip("\n").split("\n"))), file=sys.stderr)
    return Status.ERROR


def _message(failure: BaseException) -> tuple[str, Status]:
    match failure:
        case GranularError():
            return "\n".join([failure.text(command_words), *getattr(failure, "__notes__", ())]), Status.ERROR
        case MemoryError():
            return "it asks for more memory than there is; ask for less", Status.ERROR
        case KeyboardInterrupt():
            return "interrupted", Status.INTERRUPTED
        case OSError():  # a full disk behind standard output, too many open files, a folder that is gone
            where = f"{failure.filename!r}: " if failure.filename is not None else ""
            return f"{where}the system refused it: {failure.strerror or failure}", Status.ERROR
    return "this is a fault of granular-env, not of what you gave; please report it with the lines above", Status.FAULT


def command_words(term: Term) -> str:
    """Return an option or an override as it is given on the command line."""
    if isinstance(term, Override):
        return f"--set {shortened(term.text, 60)}"
    option = f"--{term.name.replace('_', '-')}"
    return option if term.value is True else f"{option} {term.value}"


def open_missing_streams() -> None:
    """Give programs that were begun with closed streams ones that lead nowhere, so that no file takes their place."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # gets the lowest free number: this one
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115


def discard_output() -> None:
    """Throw away what Python would flush at exit, where standard output cannot be written."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
