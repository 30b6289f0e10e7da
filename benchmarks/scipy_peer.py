"""SciPy's DOP853 with a tolerance that gives the accuracy of the default chain."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from . import chains
from .figures import Figure
from .timing import median_ratio, time_interleaved

_TAUS = 60.0


def measure(grains: int = 100, tolerances: int = 33, rounds: int = 9) -> Iterator[Figure]:
    """Measure problem 3.1 up to 60 tau. SciPy uses the largest tolerance tried that reaches our accuracy."""
    chain = chains.struck_chain(grains)
    ticks = round(_TAUS * chains.TAU / chain.step_size)
    duration, start = ticks * chain.step_size, chain.save()
    reference = chains.struck_chain(grains, step_size=chain.step_size / 50)
    reference.step(duration)
    exact = reference.get("velocity") / chains.SPEED

    def ours() -> None:
        chain.restore(start)
        chain.step(duration)

    ours()
    own_error = _error(chain.get("velocity") / chains.SPEED, exact)
    tried = [(rtol, _error(_solve_velocities(grains, duration, rtol), exact)) for rtol in np.logspace(-2, -10, tolerances)]
    good = [found for found in tried if found[1] <= own_error] or [min(tried, key=lambda found: found[1])]
    rtol, error = good[0]
    times = time_interleaved({"scipy": lambda: _solve_velocities(grains, duration, rtol), "ours": ours}, rounds)
    note = f"max |dv|/v0: ours {own_error:.1e}, scipy {error:.1e} at rtol = atol = {rtol:.1e}; {ticks} steps of ours"
    yield Figure(
        f"scipy DOP853 / ours at equal accuracy, N = {grains}",
        median_ratio(times["scipy"], times["ours"]),
        at_least=150.0,
        note=note,
    )


def _solve_velocities(grains: int, duration: float, rtol: float) -> Any:
    """Return the final velocities / v0. With m = A = v0 = 1, a tolerance means the same for both halves of the state."""
    from scipy.integrate import solve_ivp

    start = np.zeros(2 * grains)
    start[grains] = 1.0
    forces = np.zeros(grains + 1)

    def slope(_: float, state: np.ndarray) -> np.ndarray:
        result = np.empty_like(state)
        result[:grains] = state[grains:]
        overlap = np.maximum(state[: grains - 1] - state[1:grains], 0.0)
        forces[1:-1] = overlap * np.sqrt(overlap)
        np.subtract(forces[:-1], forces[1:], out=result[grains:])
        return result

    found = solve_ivp(slope, (0.0, duration / chains.TAU), start, method="DOP853", rtol=max(rtol, 2.3e-14), atol=rtol)
    return found.y[grains:, -1]


def _error(velocity: np.ndarray, exact: np.ndarray) -> float:
    return float(np.abs(velocity - exact).max())
