"""Commands of the program: help, exit status, and a decorator that makes a command of a function."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from enum import IntEnum
from typing import Any

import click

from granular_env.package_contents import first_sentence
from granular_env.terminal_text import align_columns, wrap_text

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


def print_json(facts: Any) -> None:
    """Print facts as JSON; numbers that are not finite are null, paths and other objects are texts."""
    import json

    print(json.dumps(_json_value(facts), indent=2, default=str))


def _json_value(value: Any) -> Any:
    match value:
        case Mapping():
            return {str(key): _json_value(part) for key, part in value.items()}
        case list() | tuple():
            return [_json_value(part) for part in value]
        case float() if not math.isfinite(value):
            return None
    return _json_value(value.tolist()) if hasattr(value, "tolist") else value


def print_lists(lists: Mapping[str, Mapping[str, str]], as_json: bool, closing: str) -> None:
    """Print names and their descriptions, in one list per kind, and a closing sentence."""
    if as_json:
        print_json(lists)
        return
    for kind, entries in lists.items():
        print(f"{kind}\n{align_columns(entries.items())}\n")
    print(wrap_text(closing))


class Command(click.Command):
    """A command with the complete first sentence of its docstring in the list of commands."""

    def get_short_help_str(self, limit: int = 45) -> str:
        """Return the first sentence of the help."""
        return first_sentence(self.help or "")


def command(name: str, **attributes: Any) -> Callable[[Body], Command]:
    """Return a decorator that makes a command of a function; the function's docstring is the help of the command."""
    return click.command(name, cls=Command, **attributes)
