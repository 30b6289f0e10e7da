"""Force evaluations per second of the default chain, relative to square roots per second of the same core."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from . import chains, roof
from .figures import Figure
from .timing import median_ratio, repeats_for, time_interleaved

WANTED = {100: 0.4, 1000: 0.7, 1_000_000: 0.15}
_SAMPLE_SECONDS = 4e-3


def measure(sizes: tuple[int, ...] = (100, 1000, 1_000_000), rounds: int = 41) -> Iterator[Figure]:
    """Measure chains with all contacts closed, then a wave that enters a chain at rest."""
    for grains in sizes:
        chain = chains.precompressed_chain(grains)
        ticks = repeats_for(lambda chain=chain: chain._advance_state(1), _SAMPLE_SECONDS)
        yield _compare_with_roof(
            f"force evaluations / roots, N = {grains}", chain, lambda c=chain, t=ticks: c._advance_state(t), ticks, rounds
        )
    for grains in sizes:
        if grains <= 10_000:
            yield _entering_wave(grains, rounds)


def _entering_wave(grains: int, rounds: int) -> Figure:
    chain = chains.struck_chain(grains)
    ticks, start = chains.crossing_ticks(chain), chain.save()

    def cross() -> None:
        chain.restore(start)
        chain._advance_state(ticks)

    repeats = repeats_for(cross, _SAMPLE_SECONDS)

    def run() -> None:
        for _ in range(repeats):
            cross()

    return _compare_with_roof(
        f"the same, a wave crossing a chain at rest, N = {grains}", chain, run, ticks * repeats, rounds, False
    )


def _compare_with_roof(
    what: str, chain: Any, run: Callable[[], object], ticks: int, rounds: int, judged: bool = True
) -> Figure:
    grains = chain.parameters.grains
    evaluations = ticks * chain._scheme.evaluations * grains
    repeats = max(1, round(evaluations / roof.LENGTH))
    repeats = min(repeats, 50_000)  # long chains need long samples, but a shorter sample suffices for the roof
    rounds = rounds if grains <= 10_000 else max(1, rounds // 5)
    times = time_interleaved({"chain": run, **roof.loops(repeats)}, rounds)
    part = evaluations / (repeats * roof.LENGTH)
    fractions = {name: part * median_ratio(times[name], times["chain"]) for name in ("plain", "eight wide")}
    rate = evaluations / float(np.median(times["chain"]))
    note = f"{fractions['plain']:.2f} of a plain loop, {fractions['eight wide']:.2f} of a loop with eight lanes; {rate:.2g}/s"
    return Figure(what, min(fractions.values()), at_least=WANTED.get(grains) if judged else None, note=note)
