"""The solid: nodes and ticks a second on one core, beside what a triad moves in the same time, and bytes per node."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

import granular_env as ge

from .figures import Figure
from .grid import triad
from .timing import interleaved, repeats_for

# Node-updates a second on one core, in millions, and bytes a node.
WANTED, ALLOWED_BYTES = 1.25, 900.0
_SAMPLE_SECONDS = 0.3
_MATERIALS = ("elastic", "thermoviscoplastic")


def loaded_tube(along: int, around: int, material: str) -> Any:
    """Return a piece of the paper's tube, in motion."""
    tube = ge.make(
        "shell",
        body={"name": "tube", "length": 1e-3 * (along - 1), "along": along, "around": around},
        material=material,
        boundaries={"start": "symmetry", "end": "symmetry"},
    )
    tube.step(4 * tube.step_size, pressure=5e6)
    return tube


def words_moved(tube: Any) -> float:
    """Return the words that a tick has to read and write at least, for each node.

    A point reads its neighbours (half words of indices), reads and writes gradient, stress and pull; a node displacement,
    velocity, force, mass, and the points that see it. Gradients of shape functions stay in the cache.
    """
    solid, state, scratch, _ = tube.tables()
    body = solid.body
    indices = 0.5 * (len(body.nodes) + len(body.kind) + 2 * len(body.seen_point))
    points = (
        2 * (state.gradient.size + state.stress.size + 3 * len(state.plastic_strain))
        + 2 * scratch.pull.size
        + 3 * len(body.volume)
    )
    nodes = 2 * (state.displacement.size + state.velocity.size + state.force.size) + len(body.mass)
    return (indices + points + nodes) / len(body.mass)


def measure(along: int = 101, around: int = 128, triad_words: int = 4_000_000, rounds: int = 7) -> Iterator[Figure]:
    """A tube that no cache holds, as the triad."""
    a, b, c = (np.ones(triad_words) for _ in range(3))
    moves = repeats_for(lambda: triad(a, b, c, 1), _SAMPLE_SECONDS)
    for material in _MATERIALS:
        tube = loaded_tube(along, around, material)
        nodes = len(tube.mass)
        ticks = repeats_for(lambda tube=tube: tube._advance(1), _SAMPLE_SECONDS)
        times = interleaved(
            {"solid": lambda tube=tube, n=ticks: tube._advance(n), "triad": lambda: triad(a, b, c, moves)}, rounds
        )
        seconds = float(np.median(times["solid"])) / (ticks * nodes)
        word = float(np.median(times["triad"])) / (3 * moves * triad_words)
        least = words_moved(tube) * word
        yield Figure(
            f"solid, {material}, nodes and ticks a second", 1e-6 / seconds, "M/s", at_least=WANTED,
            note=f"{1e9 * seconds:.0f} ns; {words_moved(tube):.0f} words of a triad outside the cache would take "
            f"{1e9 * least:.0f} ns: {least / seconds:.0%} of that roof",
        )  # fmt: skip
        taken = type(tube).memory_needed(tube.parameters) / nodes
        yield Figure(
            f"solid, {material}, bytes a node", taken, "B", at_most=ALLOWED_BYTES, note="tables, state and its copy, scratch"
        )
