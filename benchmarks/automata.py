"""The automata against memory: bytes that a tick has to move, over what a triad moves; and what finding contacts costs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from time import perf_counter
from typing import Any

import numpy as np

import granular_env as ge
from granular_env.components.automata import linked_steps, parallel_steps

from .figures import Figure
from .grid import MEDIUM, triad
from .timing import interleaved, ratio, repeats_for

# Of the roof of memory; bytes that an automaton may take; what a second thread has to give a large specimen; part of a cracking
# run that finding contacts may take.
WANTED, MOST_BYTES, LEAST_GAIN, MOST_SEARCH = 0.5, 200.0, 1.3, 0.5
_SAMPLE_SECONDS = 0.2
# The smallest square for which two threads are used: they must not be slower there than one.
SMALLEST = math.isqrt(parallel_steps.LEAST_AUTOMATA - 1)


def noisy(packing: str, side: int) -> Any:
    """A specimen of about side x side linked automata that all move."""
    row = 0.5 * 3.0**0.5 if packing == "hexagonal" else 1.0
    shape = {"name": "rectangle", "width": float(side), "height": side * row}
    automata = ge.make("automata", shape=shape, diameter=1.0, packing=packing, material=MEDIUM)
    automata.reset(velocity=1e-4 * np.random.default_rng(1).standard_normal((automata.count, 2)))
    return automata


def _advance_alone(automata: Any, ticks: int) -> None:
    """Advance in one thread."""
    linked_steps.advance(automata.steps.body, automata.steps.whole, *automata.steps.arguments(ticks))


def bytes_of_tick(automata: Any) -> int:
    """What a tick has to read and write, each array once: the motion, and which neighbours there are."""
    return automata.body.neighbours.nbytes + automata.body.kind.nbytes + 2 * sum(part.nbytes for part in automata.motion)


def bytes_of_memory(automata: Any) -> int:
    """What the automata take while they step."""
    arrays = (automata.body.neighbours, automata.body.kind, *automata.motion, *automata.scratch)
    rings = [array for part in automata.steps.parts for array in part if isinstance(array, np.ndarray)]
    return sum(array.nbytes for array in (*arrays, *rings))


def measure(
    side: int = 600, triad_words: int = 8_000_000, rounds: int = 11, cracking: float = 2.9e-4, smallest: int = SMALLEST
) -> Iterator[Figure]:
    """Both packings, too large for a cache; the smallest that two threads share; and the shipped sample that fails."""
    arrays = [np.ones(triad_words) for _ in range(3)]
    for packing in ("square", "hexagonal"):
        automata = noisy(packing, side)
        ticks = repeats_for(lambda one=automata: _advance_alone(one, 1), _SAMPLE_SECONDS)
        times = interleaved(
            {"automata": lambda one=automata, t=ticks: _advance_alone(one, t), "triad": lambda: triad(*arrays, 1)}, rounds
        )
        moved, count = ticks * bytes_of_tick(automata) / (24 * triad_words), automata.count
        rate = ticks * count / float(np.median(times["automata"])) / 1e6
        yield Figure(
            f"automata / triad, bytes a second, {count} {packing}", moved * ratio(times["triad"], times["automata"]),
            at_least=WANTED, note=f"{rate:.1f} M automaton updates/s, {bytes_of_tick(automata) / count:.0f} bytes each",
        )  # fmt: skip
        yield Figure(f"memory of an automaton, {packing}", bytes_of_memory(automata) / count, "bytes", at_most=MOST_BYTES)
        yield _two_threads(automata, rounds, LEAST_GAIN)
    yield _two_threads(noisy("square", smallest), rounds, 1.0)
    yield Figure("finding contacts, part of a run that cracks", 100.0 * search_part(cracking), "%", at_most=100.0 * MOST_SEARCH)


def _two_threads(automata: Any, rounds: int, at_least: float) -> Figure:
    """Two parts of one specimen by two threads, against the whole by one."""
    steps = automata.steps
    arguments = steps.arguments(repeats_for(lambda: _advance_alone(automata, 1), _SAMPLE_SECONDS))
    if len(steps.parts) == 1:
        return Figure("one thread / two, automata", 1.0, at_least=at_least, note="too small for two threads")
    times = interleaved(
        {
            "one": lambda: linked_steps.advance(steps.body, steps.whole, *arguments),
            "two": lambda: parallel_steps.advance(steps.body, steps.parts, *arguments),
        },
        rounds,
        wall=True,
    )
    name = f"one thread / two, {automata.count} {automata.packing.lattice.name} automata"
    return Figure(name, ratio(times["one"], times["two"]), at_least=at_least)


def search_part(duration: float) -> float:
    """Return what part of the time of the shipped sample under compression finding contacts takes."""
    automata: Any = ge.run("psakhie-2003/uniaxial-compression", overrides={"duration": 2.2e-4}).component
    steps, spent = automata.steps, [0.0]
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
