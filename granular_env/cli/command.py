"""Commands of the program: help, exit status, and a decorator that makes a command of a function."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from typing import Any

import click

from granular_env.package_contents import first_sentence

Body = Callable[..., int]


class Status(IntEnum):
    """The exit status of a command."""

    DONE = 0
    DIFFERENT = 1
    ERROR = 2
    INCOMPLETE = 3
    FAULT = 70
    INTERRUPTED = 130


MEANINGS = {
    Status.DONE: "done",
    Status.DIFFERENT: "a verification found a difference, a file is incomplete, or a task, an entry or a trial failed",
    Status.ERROR: "an error, reported in one message",
    Status.INCOMPLETE: "a verification of a log that is incomplete or contains no step",
    Status.FAULT: "an internal error of granular-env",
    Status.INTERRUPTED: "ended by Ctrl-C",
}
EXIT_STATUS = f"Exit status: {'; '.join(f'{status:d} {meaning}' for status, meaning in MEANINGS.items())}."


class Command(click.Command):
    """A command with the complete first sentence of its docstring in the list of commands."""

    def get_short_help_str(self, limit: int = 45) -> str:
        """Return the first sentence of the help."""
        return first_sentence(self.help or "")


def command(name: str, **attributes: Any) -> Callable[[Body], Command]:
    """Return a decorator that makes a command of a function; the function's docstring is the help of the command."""
    return click.command(name, cls=Command, **attributes)
