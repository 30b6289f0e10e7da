"""The exit statuses of the commands."""

from enum import IntEnum


class Status(IntEnum):
    """The exit status of a command."""

    DONE = 0
    DIFFERENT = 1
    ERROR = 2
    INCOMPLETE = 3
    FAULT = 70
    INTERRUPTED = 130


MEANINGS = (
    "Exit status: 0 done; 1 a verification found a difference, a file is not whole, or a task, an entry or a trial failed; "
    "2 an error, told in one message; 3 a verification of a log that is incomplete or holds no step; 70 a fault of "
    "granular-env itself; 130 ended by Ctrl-C."
)
