"""Bitwise identical results with the JIT off, tick by tick, and in plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from support.chain_tools import INTEGRATORS, bit_cases, run_python

import granular_env as ge
from granular_env.components.chain.integrators import compositions

GRAINS, TICKS = 11, 40

_UNJITTED = """
from support import chain_tools
chain_tools.print_bit_cases({schemes!r}, {grains}, {ticks})
"""


def compiled(schemes: tuple[str, ...], grains: int, ticks: int) -> list[str]:
    return [f"{name}: {digest}" for name, digest in bit_cases(schemes, grains, ticks)]


@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
def test_the_same_bits_with_the_jit_off() -> None:
    said = run_python(_UNJITTED.format(schemes=INTEGRATORS, grains=GRAINS, ticks=TICKS), NUMBA_DISABLE_JIT="1")
    assert said.splitlines() == compiled(INTEGRATORS, GRAINS, TICKS)


def plain_numpy(chain: ge.Chain, velocity: np.ndarray, ticks: int) -> tuple[np.ndarray, np.ndarray]:
    """Run PEFRL with arrays for a chain between two planes, with the same order of operations for each grain."""
    shape, h, mass = chain.geometry, chain.step_size, chain.geometry.mass
    u, v = np.zeros(len(velocity) + 2), velocity.copy()
    for _ in range(ticks):
        u[1:-1] += compositions.PEFRL.drifts[0] * h * v
        for kick, drift in zip(compositions.PEFRL.kicks, compositions.PEFRL.drifts[1:], strict=True):
            d = np.maximum(u[:-1] - u[1:] + shape.rest_overlap, 0.0)
            force = shape.stiffness * (d * np.sqrt(d))
            v += kick * h * (1.0 / mass) * (force[:-1] - force[1:])
            u[1:-1] += drift * h * v
    return u[1:-1], v


@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
def test_against_plain_numpy_and_itself_tick_by_tick() -> None:
    grains, velocity = 100, np.random.default_rng(5).uniform(-1.0, 1.0, 100)
    chain = ge.make(
        "chain", grains=grains, left="plane", right="plane", radius={"low": 1e-3, "high": 3e-3, "seed": 1}, step_size=1e-7
    )
    chain.reset(velocity=velocity)
    chain.step(70 * chain.step_size)
    whole = chain.save().to_bytes()
    u, v = plain_numpy(chain, velocity, 70)
    assert np.array_equal(chain.get("displacement"), u)
    assert np.array_equal(chain.get("velocity"), v)
    chain.reset(velocity=velocity)
    for _ in range(70):
        chain.step()
    assert chain.save().to_bytes() == whole
