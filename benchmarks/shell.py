"""The solid, with and without a notch: throughput against memory and arithmetic roofs, gain of a thread, bytes per node."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from typing import Any

import numba
import numpy as np

import granular_env as ge
from granular_env.components.shell import ticks as ticking

from .figures import Figure
from .grid import triad
from .timing import median_ratio, repeats_for, time_interleaved

# Node updates per second on one core, in millions; bytes per node; fraction of the roof; gain from a second thread.
WANTED, ALLOWED_BYTES, LEAST_PART, LEAST_GAIN = 1.25, 900.0, 0.35, 1.3
_SAMPLE_SECONDS = 0.3
# Operations per neighbour of a point (products and sums for nine gradients and the forces), and per point in `strain_and_spin`,
# `rotate_tensor` and `nominal_stress`, without the law, the hourglass control and the kicks.
_OF_NEIGHBOUR, _OF_POINT = 36, 440
_NOTCH = {"length": 0.0127, "depth": 0.0006, "width": 0.0005}
_BODIES = {
    "elastic": ("elastic", {}), "thermoviscoplastic": ("thermoviscoplastic", {}),
    "thermoviscoplastic with a notch": ("thermoviscoplastic", {"notch": _NOTCH}),
}  # fmt: skip
# Neighbours in the loop of the arithmetic roof; their rows and displacements fit the first-level cache.
_CACHED = 216


@numba.njit
def outer_products(u, g, out, repeats):
    """Sum outer products of displacements and gradients from the first-level cache, as points do (18 operations each)."""
    for _ in range(repeats):
        axx, axy, axz, ayx, ayy, ayz, azx, azy, azz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(u.shape[0]):
            ux, uy, uz, gx, gy, gz = u[j, 0], u[j, 1], u[j, 2], g[j, 0], g[j, 1], g[j, 2]
            axx, axy, axz = axx + ux * gx, axy + ux * gy, axz + ux * gz
            ayx, ayy, ayz = ayx + uy * gx, ayy + uy * gy, ayz + uy * gz
            azx, azy, azz = azx + uz * gx, azy + uz * gy, azz + uz * gz
        out[0] += axx + axy + axz + ayx + ayy + ayz + azx + azy + azz


def loaded_tube(along: int, around: int, material: str, **notch: Any) -> Any:
    """Return a moving piece of the paper's tube."""
    tube = ge.make(
        "shell",
        body={"name": "tube", "length": 1e-3 * (along - 1), "along": along, "around": around, **notch},
        material=material,
        boundaries={"start": "symmetry", "end": "symmetry"},
    )
    tube.step(4 * tube.step_size, pressure=5e6)
    return tube


def words_moved(tube: Any) -> float:
    """Return the least number of words that a tick reads and writes per node.

    A point reads its neighbour list, and reads and writes gradient, stress and pull. A node accesses displacement, velocity,
    force, mass, and the list of points that have it in their support. Shape function gradients stay in the cache.
    """
    solid, state, scratch, _ = tube.tables()
    seen, nodes = solid.points, solid.nodes
    lists = seen.nodes, seen.kind, nodes.points, nodes.slot
    indices = sum(one.nbytes for one in lists) / 8
    points = (
        2 * (state.gradient.size + state.stress.size + 3 * len(state.plastic_strain))
        + 2 * scratch.pull.size
        + 3 * len(seen.volume)
    )
    moved = 2 * (state.displacement.size + state.velocity.size + state.force.size) + len(nodes.mass)
    return (indices + points + moved) / len(nodes.mass)


def make_threaded_advance(tube: Any, ticks: int, threads: int) -> Callable[[], object]:
    """Return a function that advances a tube by `ticks` ticks in `threads` threads."""
    tables = tube.tables()
    inputs = np.ones((ticks, 1)), np.full(tube.lattice.shape[0], 5e6), 0, np.zeros(2, dtype=np.int64)

    def advance() -> None:
        os.environ["GRANULAR_ENV_THREADS"] = str(threads)
        ticking.advance(tables, *inputs)

    return advance


def measure(along: int = 101, around: int = 128, triad_words: int = 4_000_000, rounds: int = 7) -> Iterator[Figure]:
    """Measure tubes that, like the triad's arrays, exceed the cache."""
    a, b, c = (np.ones(triad_words) for _ in range(3))
    moves = repeats_for(lambda: triad(a, b, c, 1), _SAMPLE_SECONDS)
    u, g, total = np.full((_CACHED, 3), 1e-3), np.full((_CACHED, 3), 1e-3), np.zeros(1)
    sums = 1000 * repeats_for(lambda: outer_products(u, g, total, 1000), _SAMPLE_SECONDS)
    for name, (material, notch) in _BODIES.items():
        tube = loaded_tube(along, around, material, **notch)
        nodes = len(tube.mass)
        ticks = repeats_for(make_threaded_advance(tube, 1, 1), _SAMPLE_SECONDS)
        times = time_interleaved(
            {
                "solid": make_threaded_advance(tube, ticks, 1), "triad": lambda: triad(a, b, c, moves),
                "sums": lambda: outer_products(u, g, total, sums),
            },
            rounds,
        )  # fmt: skip
        seconds = float(np.median(times["solid"])) / (ticks * nodes)
        word = float(np.median(times["triad"])) / (3 * moves * triad_words)
        operation = float(np.median(times["sums"])) / (18 * sums * _CACHED)
        moving = words_moved(tube) * word
        seen = tube.tables().solid.points
        operations = (_OF_NEIGHBOUR * len(seen.nodes) + _OF_POINT * len(seen.kind)) / nodes
        computing = operations * operation
        yield Figure(
            f"solid, {name}, node updates per second", 1e-6 / seconds, "M/s", at_least=WANTED, note=f"{1e9 * seconds:.0f} ns",
        )  # fmt: skip
        yield Figure(
            f"solid, {name}, fraction of the roof", 100.0 * max(moving, computing) / seconds, "%",
            at_least=None if notch else 100.0 * LEAST_PART,
            note=f"memory: {words_moved(tube):.0f} words of a triad that exceeds the cache, {1e9 * moving:.0f} ns; arithmetic: "
            f"{operations:.0f} products and sums from the first-level cache, {1e9 * computing:.0f} ns",
        )  # fmt: skip
        taken = type(tube).memory_needed(tube.parameters) / nodes
        yield Figure(
            f"solid, {name}, bytes per node", taken, "B", at_most=ALLOWED_BYTES, note="tables, state and copy, scratch"
        )
    yield _two_threads(loaded_tube(along, around, "thermoviscoplastic"), rounds)


def _two_threads(tube: Any, rounds: int) -> Figure:
    """Return the gain from a second thread for a tube."""
    times = time_interleaved(
        {"one": make_threaded_advance(tube, 4, 1), "two": make_threaded_advance(tube, 4, 2)}, rounds, wall=True
    )
    return Figure(
        f"solid, one thread / two, {len(tube.mass)} nodes", median_ratio(times["one"], times["two"]), at_least=LEAST_GAIN
    )
