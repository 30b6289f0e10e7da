"""The gas: cell steps per second on one core, and memory throughput compared with a triad."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

import granular_env as ge

from .figures import Figure
from .grid import triad
from .timing import repeats_for, time_interleaved

# Cell steps per second on one core, in millions.
WANTED = 5.0
_SAMPLE_SECONDS = 0.2
_MOST_TICKS = 1500
_REACTIONS = ("pressure_burn", "arrhenius")


def burning_tube(cells: int, reaction: str) -> Any:
    """Return a tube with a detonation front and half of the gas burnt."""
    half = {"x": [0.0, 0.76], "pressure": 3e6, "temperature": 3000.0, "progress": 1.0}
    return ge.make("detonation", cells=cells, regions=[half], reaction=reaction)


def measure(cells: int = 1520, triad_words: int = 100_000, rounds: int = 11) -> Iterator[Figure]:
    """Measure a tube of 1.52 m; its state and the triad's arrays fit the second-level cache."""
    a, b, c = (np.ones(triad_words) for _ in range(3))
    moves = repeats_for(lambda: triad(a, b, c, 100), _SAMPLE_SECONDS) * 100
    for reaction in _REACTIONS:
        tube = burning_tube(cells, reaction)
        start = tube.save()

        def steps(ticks: int, tube: Any = tube, start: Any = start) -> None:
            tube.restore(start)
            tube._advance_state(ticks)

        # Limit the ticks, so that the front stays in the tube.
        ticks = min(repeats_for(lambda steps=steps: steps(20), _SAMPLE_SECONDS) * 20, _MOST_TICKS)
        times = time_interleaved({"gas": lambda steps=steps, n=ticks: steps(n), "triad": lambda: triad(a, b, c, moves)}, rounds)
        seconds = float(np.median(times["gas"])) / (ticks * cells)
        word = float(np.median(times["triad"])) / (moves * triad_words)
        yield Figure(
            f"gas, {reaction}, cell steps per second", 1e-6 / seconds, "M/s", at_least=WANTED,
            note=f"{1e9 * seconds:.0f} ns per cell step, {seconds / word:.0f} words of a triad in the cache",
        )  # fmt: skip
