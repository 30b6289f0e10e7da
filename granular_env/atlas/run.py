"""Running an atlas: a paper's figures and numbers, computed and written."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from granular_env.components.errors import ParameterError, one_line
from granular_env.progress import Progress

from . import papers
from .computation import Atlas, chosen, compute
from .console import entry_progress
from .model import Paper
from .result_files import write


def run_atlas(
    paper: str | Paper,
    folder: str | os.PathLike[str] | None = None,
    *,
    overrides: Mapping[str, Any] | None = None,
    only: Iterable[str] = (),
    processes: int = 1,
    refinement: int = 1,
    progress: Progress = False,
) -> Atlas:
    """Compute a paper's figures and numbers anew, and write them beside the printed ones.

        done = ge.run_atlas("nesterenko-1983", "out", overrides={"A": 6.391e12})
        done.page

    The folder gets the page, ``atlas.json`` with all numbers, and the logs of the runs.

    Args:
        paper: its name, or a paper of one's own.
        folder: where to; default: ``atlas/`` and the paper's name.
        overrides: constants that are to differ from the paper's.
        only: names of the entries to compute; default: all.
        processes: how many entries are computed at a time. A script that defines entries of its own then needs
            ``if __name__ == "__main__":`` around what it does.
        refinement: by how much steps and sampling intervals are divided; digits that hold at 2 have converged.
        progress: show a bar, or call this with the part that is done.

    Raises:
        ParameterError: no such paper, constant or entry, or a value out of its range.
        GranularError: the folder cannot be written, another process computes there, or its `atlas.json` is not an atlas's.
    """
    found = papers.paper(paper) if isinstance(paper, str) else paper
    if not isinstance(found, Paper):
        raise ParameterError(f"got {one_line(found)}", expected="the name of a paper, or a Paper", at="paper")
    where, names = Path(folder) if folder is not None else Path("atlas") / found.name, list(only)
    with entry_progress(chosen(found, names), found.name, progress) as notify:
        done = compute(found, where, overrides, only=names, processes=processes, refinement=refinement, notify=notify)
    return dataclasses.replace(done, page=write(done, where))
