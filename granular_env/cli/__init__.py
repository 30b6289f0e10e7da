"""The command line: parses, calls, prints. One module holds a few related commands; `program` names them all."""

from .program import main

__all__ = ["main"]
