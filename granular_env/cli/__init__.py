"""The command line: one module per group of related commands; `program` lists all commands."""

from .program import main

__all__ = ["main"]
