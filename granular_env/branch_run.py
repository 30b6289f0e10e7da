"""A branch of a log, advanced by the loop of `run_loop`: with its bar, and Ctrl-C between two pieces."""

from __future__ import annotations

import dataclasses
import os
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from granular_env.components.errors import LogError
from granular_env.progress import Progress
from granular_env.run_loop import Inputs, RunResult, advance, collect_warnings, memory_errors

if TYPE_CHECKING:
    from granular_env.recording.branch import Branch


def run_branch(
    branch: Branch,
    log: str | os.PathLike[str],
    inputs: Inputs,
    until: float | None = None,
    *,
    progress: Progress = False,
    overwrite: bool = False,
) -> RunResult:
    """Continue from a branch and record it; the bits are those of `Branch.run`.

    Args:
        branch: a fresh one.
        log: path of the new log.
        inputs: hold from here on instead of the log's own.
        until: time at which to stop, on the component's clock [s]; default where the log's segment ends.
        progress: show a bar, or call this with the part that is done.
        overwrite: whether an existing file may be replaced.

    Raises:
        ParameterError: an argument is not valid; nothing has been written.
        StepError: the physics would break down; the log until then is complete, a note of the error names it.
        LogError: the log cannot be written.
    """
    where, end = f"log {os.fspath(log)!r}", branch.end(until)
    with memory_errors(where, LogError), collect_warnings() as issued, ExitStack() as stack:
        stack.enter_context(branch.recording(log, inputs, overwrite=overwrite))
        result = advance(
            branch.component,
            end,
            {},
            changes=branch.changes(inputs),
            title=Path(log).name,
            progress=progress,
            log=Path(log),
            issued=issued,
            closing=stack,
        )
        return dataclasses.replace(result, start=branch.tick)
