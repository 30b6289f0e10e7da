"""Cost of the coupling: a tick of a coupled grid and automata compared with ticks of both parts alone."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from typing import Any

import numpy as np

import granular_env as ge

from .figures import Figure
from .grid import MEDIUM
from .timing import median_ratio, repeats_for, time_interleaved

# Largest share of a tick for the interface and for the extra passes over the parts.
MOST_SHARE = 0.15
_SAMPLE_SECONDS = 0.2


def part_parameters(side: int, n: int) -> dict[str, dict[str, Any]]:
    """Return the parameters of side x side cells, and of automata of 1 / n of the cell size that fill an equal area."""
    mesh = {"name": "rectangle", "columns": side, "rows": side, "cell_size": 1.0, "centre": [-0.5 * side, 0.5 * side]}
    shape = {"name": "rectangle", "width": float(side), "height": float(side)}
    automata = {"shape": shape, "diameter": 1.0 / n, "packing": "square", "material": MEDIUM}
    return {"grid": {"mesh": mesh, "material": MEDIUM}, "automata": automata}


def measure(side: int = 300, rounds: int = 11) -> Iterator[Figure]:
    """Measure lockstep with automata of the cells' size, and two micro-steps with automata of half this size."""
    random = np.random.default_rng(1)
    for n, micro in ((1, 1), (2, 2)):
        both = part_parameters(side if n == 1 else max(side // 2, 2), n)
        medium: Any = ge.make("coupled", **both, micro_steps=micro)
        step = medium.step_size
        grid: Any = ge.make("grid", **both["grid"], step_size=step)
        automata: Any = ge.make("automata", **both["automata"], step_size=step / micro)
        ours, theirs = (1e-4 * random.standard_normal(shape) for shape in (grid.get("velocity").shape, (automata.count, 2)))
        medium.reset(grid_velocity=ours, automata_velocity=theirs)
        grid.reset(velocity=ours)
        automata.reset(velocity=theirs)
        ticks = repeats_for(lambda one=medium: one._advance_state(1), _SAMPLE_SECONDS)
        with one_core():
            times = time_interleaved(
                {
                    "coupled": lambda one=medium, t=ticks: one._advance_state(t),
                    "grid": lambda one=grid, t=ticks: one._advance_state(t),
                    "automata": lambda one=automata, t=ticks * micro: one._advance_state(t),
                },
                rounds, wall=True,
            )  # fmt: skip
        cells, count = len(grid.mesh.cells), automata.count * micro
        each = {name: float(np.median(times[name])) / ticks * 1e9 for name in times}
        share = 1.0 - median_ratio(times["grid"] + times["automata"], times["coupled"])
        kind = "lockstep" if micro == 1 else f"{micro} micro-steps"
        yield Figure(
            f"share of the coupling in a tick, {cells} cells and {automata.count} automata, {kind}", 100.0 * share, "%",
            at_most=100.0 * MOST_SHARE,
            note=f"{each['coupled'] / (cells + count):.0f} ns per cell or automaton step; alone {each['grid'] / cells:.0f} "
            f"per cell, {each['automata'] / count:.0f} per automaton step",
        )  # fmt: skip


@contextlib.contextmanager
def one_core() -> Iterator[None]:
    """Restrict the process to one core, if the system supports it, so that components use one thread."""
    cores = os.sched_getaffinity(0) if hasattr(os, "sched_setaffinity") else set()
    if cores:
        os.sched_setaffinity(0, {min(cores)})
    try:
        yield
    finally:
        if cores:
            os.sched_setaffinity(0, cores)
