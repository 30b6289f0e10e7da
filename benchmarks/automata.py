"""Memory throughput of the automata relative to a triad, and the cost of the contact search."""

from __future__ import annotations

from collections.abc import Iterator
from time import perf_counter
from typing import Any

import numpy as np

import granular_env as ge

from .figures import Figure
from .grid import MEDIUM, triad
from .timing import median_ratio, repeats_for, time_interleaved

# Required fraction of the memory roof; largest bytes per automaton; largest share of the contact search in a cracking run.
WANTED, MOST_BYTES, MOST_SEARCH = 0.1, 600.0, 0.5
_SAMPLE_SECONDS = 0.2


def noisy_specimen(packing: str, side: int) -> Any:
    """Return a specimen of about side x side linked, moving automata."""
    row = 0.5 * 3.0**0.5 if packing == "hexagonal" else 1.0
    shape = {"name": "rectangle", "width": float(side), "height": side * row}
    automata: Any = ge.make("automata", shape=shape, diameter=1.0, packing=packing, material=MEDIUM)
    automata.reset(velocity=1e-4 * np.random.default_rng(1).standard_normal((automata.count, 2)))
    return automata


def tick_bytes(automata: Any) -> int:
    """Return the bytes that the motion of the automata reads and writes per tick, counting each array once."""
    return 2 * 6 * 8 * automata.count


def memory_bytes(automata: Any) -> int:
    """Return the memory of the automata's fields during a step [bytes]."""
    steps = automata.specimen
    arrays = (*automata.body[1:], steps.motion, *steps.scratch)
    return sum(array.nbytes for array in arrays if isinstance(array, np.ndarray))


def measure(side: int = 600, triad_words: int = 8_000_000, rounds: int = 11, cracking: float = 2.9e-4) -> Iterator[Figure]:
    """Measure both packings, too large for a cache, and the shipped specimen that fails."""
    arrays = [np.ones(triad_words) for _ in range(3)]
    for packing in ("square", "hexagonal"):
        automata = noisy_specimen(packing, side)
        step = automata.step_size
        ticks = repeats_for(lambda one=automata, h=step: one.step(h), _SAMPLE_SECONDS)
        times = time_interleaved(
            {
                "automata": lambda one=automata, t=ticks * step: one.step(t),
                "triad": lambda: triad(arrays[0], arrays[1], arrays[2], 1),
            },
            rounds,
        )
        moved, count = ticks * tick_bytes(automata) / (24 * triad_words), automata.count
        rate = ticks * count / float(np.median(times["automata"])) / 1e6
        yield Figure(
            f"automata / triad, bytes per second, {count} {packing}", moved * median_ratio(times["triad"], times["automata"]),
            at_least=WANTED, note=f"{rate:.1f} M automaton updates/s, {tick_bytes(automata) / count:.0f} bytes each",
        )  # fmt: skip
        yield Figure(f"memory per automaton, {packing}", memory_bytes(automata) / count, "bytes", at_most=MOST_BYTES)
    yield Figure("contact search, share of a cracking run", 100.0 * search_share(cracking), "%", at_most=100.0 * MOST_SEARCH)


def search_share(duration: float) -> float:
    """Return the contact search's share of the run time for the shipped specimen under compression."""
    automata: Any = ge.run("psakhie-2003/uniaxial-compression", overrides={"duration": 2.2e-4}).component
    steps, spent = automata.specimen, [0.0]
    find = steps.find_contacts

    def timed() -> int:
        begin = perf_counter()
        status = find()
        spent[0] += perf_counter() - begin
        return status

    steps.find_contacts = timed
    begin = perf_counter()
    automata.step(round((duration - automata.time) / automata.step_size) * automata.step_size)
    return spent[0] / (perf_counter() - begin)
