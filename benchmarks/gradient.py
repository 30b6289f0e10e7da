"""Cost of an exact gradient, in forward runs of the same native loop, and its memory."""

from __future__ import annotations

import tracemalloc
from collections.abc import Iterator
from typing import Any

import numpy as np

from granular_env import Chain
from granular_env.components.chain.adjoint import evaluate_objective
from granular_env.domains.chain.control import total, value_and_grad, velocity

from .figures import Figure
from .timing import median_ratio, time_interleaved

_GRAINS, _TICKS, _AT_MOST = 64, 3, 6.0
_BY = ("drive", "radius", "contact_stiffness", "precompression")
CHAINS: dict[str, dict[str, Any]] = {
    "PEFRL, pressed": {},
    "PEFRL, viscous": {"law": {"name": "viscous", "dissipation": 10.0}},
    "PEFRL, Kuwabara-Kono": {"law": {"name": "kuwabara_kono", "dissipation": 1e4}},
    "leapfrog, precompressed": {"integrator": "leapfrog"},
    "PEFRL, power 1.4": {"law": {"name": "power", "exponent": 1.4}, "contact_stiffness": 6e9},
}


def measure(steps: int = 512, rounds: int = 21, chains: tuple[str, ...] = tuple(CHAINS)) -> Iterator[Figure]:
    """Measure value and gradient (drive, radii, stiffness, load) for 64 grains and three steps per control step."""
    for name in chains:
        chain = _chain(**CHAINS[name])
        objective, drive = total(chain, velocity(-1).at_end()), _drive(steps)
        times = time_interleaved(
            {
                "plain": lambda c=chain, d=drive, o=objective: evaluate_objective(c, d[None], _TICKS, o),
                "gradient": lambda c=chain, d=drive, o=objective: value_and_grad(o, c, d, ticks=_TICKS, with_respect_to=_BY),
            },
            rounds,
        )
        runs = median_ratio(times["gradient"], times["plain"])
        note = f"target: 4; a plain run takes {np.median(times['plain']) * 1e3:.2f} ms"
        yield Figure(f"value and gradient / plain runs, {name}", runs, at_most=_AT_MOST, note=note)
    yield from _memory(steps // 2)


def _memory(steps: int) -> Iterator[Figure]:
    """Measure the memory in addition to the drive, its copy and its gradient, at horizons T, 4 T and 16 T."""
    chain = _chain()
    objective, held = total(chain, velocity(-1).at_end()), []
    for horizon in (steps, 4 * steps, 16 * steps):
        drive = _drive(horizon)
        value_and_grad(objective, chain, drive, ticks=_TICKS)
        tracemalloc.start()
        value_and_grad(objective, chain, drive, ticks=_TICKS)
        held.append(tracemalloc.get_traced_memory()[1] - 2 * drive.nbytes)
        tracemalloc.stop()
    note = ", ".join(f"{size / 1e3:.0f} kB" for size in held) + f" at {steps}, {4 * steps}, {16 * steps} control steps"
    yield Figure("memory of a gradient, 16 times the horizon", held[2] / held[0], at_most=4.2, note=note)


def _chain(**parameters: Any) -> Chain:
    return Chain(**({"grains": _GRAINS, "right": "plane", "precompression": 100.0, "step_size": 4e-7} | parameters))


def _drive(steps: int) -> np.ndarray:
    """Return a push of forty control steps, or of all steps if there are fewer."""
    pushed = min(steps, 40)
    drive = np.zeros((steps, 2))
    drive[:pushed, 0] = 100.0 * np.sin(np.pi * np.arange(pushed) / 40)
    return drive
