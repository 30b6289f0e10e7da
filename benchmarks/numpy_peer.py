"""The default integrator in plain NumPy, for comparison."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from . import chains
from .figures import Figure
from .timing import median_ratio, time_interleaved

_XI, _LAMBDA, _CHI = 0.1786178958448091, -0.2123418310626054, -0.06626458266981849
_DRIFTS = (_XI, _CHI, 1.0 - 2.0 * (_CHI + _XI), _CHI, _XI)
_KICKS = ((1.0 - 2.0 * _LAMBDA) / 2.0, _LAMBDA, _LAMBDA, (1.0 - 2.0 * _LAMBDA) / 2.0)


def pefrl(u: np.ndarray, v: np.ndarray, stiffness: float, mass: float, h: float, ticks: int) -> None:
    """Advance the displacements and velocities of a touching chain with free ends in place."""
    forces = np.zeros(len(u) + 1)
    for _ in range(ticks):
        for drift, kick in zip(_DRIFTS, _KICKS, strict=False):
            u += drift * h * v
            overlap = np.maximum(u[:-1] - u[1:], 0.0)
            forces[1:-1] = stiffness * overlap * np.sqrt(overlap)
            v += kick * h / mass * (forces[:-1] - forces[1:])
        u += _DRIFTS[-1] * h * v


def measure(grains: int = 1000, ticks: int = 200, rounds: int = 21) -> Iterator[Figure]:
    """Measure the time per step of NumPy's chain relative to ours, for the wave of section 3.1."""
    chain = chains.struck_chain(grains)
    u, v = np.zeros(grains), chain.get("velocity")

    def peer() -> None:
        pefrl(u, v, chains.STIFFNESS, chains.MASS, chain.step_size, ticks)

    def ours() -> None:
        chain._advance_state(10 * ticks)

    start = chain.save()
    peer()
    chain._advance_state(ticks)
    apart = float(np.abs(v - chain.get("velocity")).max()) / chains.SPEED
    chain.restore(start)
    times = time_interleaved({"peer": peer, "ours": ours}, rounds)
    note = f"the same PEFRL step; velocities agree to {apart:.1g} v0"
    yield Figure(f"numpy / ours, time per step, N = {grains}", 10.0 * median_ratio(times["peer"], times["ours"]), note=note)
