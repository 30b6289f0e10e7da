"""Helpers for tests of the chain: the paper's chain, a dimensionless chain, histories, peaks, and bitwise test cases."""

from __future__ import annotations

import hashlib
import math
import os
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import granular_env as ge

ROOT = Path(__file__).resolve().parents[2]
INTEGRATORS = ("pefrl", "leapfrog", "rk4", "hamming")


def laws_and_integrators(laws: Iterable[Any], integrators: Sequence[str] = INTEGRATORS) -> list[Any]:
    """Return pairs of laws (name or table) and integrators; pairs that `make test` omits are marked slow.

    An integrator calls the functions of all laws alike, and each pair takes seconds to compile. Therefore one elastic law runs
    with every integrator, one dissipative law and one law with history with all but Hamming's, the others with the first.
    """
    everywhere = {*product(("hertz",), INTEGRATORS), *product(("viscous", "elastic_plastic"), ("pefrl", "leapfrog", "rk4"))}
    pairs = []
    for law, integrator in product(laws, integrators):
        name = law["name"] if isinstance(law, dict) else law
        fast = integrator == integrators[0] or (name, integrator) in everywhere
        pairs.append(pytest.param(law, integrator, marks=[] if fast else pytest.mark.slow))
    return pairs


# Nesterenko (1983), section 3.1: A = 5.6e12 N/(m^1.5 kg), R = 3 mm, 7800 kg/m^3, v0 = 5 m/s.
RADIUS = 3e-3
MASS = 7800.0 * 4.0 / 3.0 * math.pi * RADIUS**3
STIFFNESS = 5.6e12 * MASS
SPEED = 5.0


def paper_chain(grains: int = 100, **parameters: object) -> ge.Chain:
    """Return the paper's chain, by default with steps short enough to neglect their errors."""
    given = {"grains": grains, "radius": RADIUS, "contact_stiffness": STIFFNESS, "step_size": 2e-8}
    return ge.make("chain", **(given | parameters))


def unit_chain(grains: int = 100, **parameters: object) -> ge.Chain:
    """Return a chain with m = A = 1; for a speed of 1, times are in tau, the unit of (3.1)."""
    given = {"radius": 100.0, "mass": 1.0, "contact_stiffness": 1.0, "overlap_limit": 0.5, "step_size": 0.1}
    return ge.make("chain", grains=grains, **(given | parameters))


def advance_chain(chain: ge.Chain, time: float, **inputs: object) -> ge.Chain:
    """Advance by the number of internal steps nearest to `time`."""
    chain.step(round(time / chain.step_size) * chain.step_size, **inputs)
    return chain


def velocity_history(chain: ge.Chain, time: float, grains: Sequence[int], **inputs: object) -> np.ndarray:
    """Return the velocities of given grains after every internal step, shape (steps, grains)."""
    rows = []
    for _ in range(round(time / chain.step_size)):
        chain.step(**inputs)
        inputs = {}
        rows.append(chain.get("velocity")[list(grains)])
    return np.array(rows)


def peaks(samples: np.ndarray, above: float) -> list[tuple[float, float]]:
    """Return maxima higher than `above` as (step, height), from a polynomial of degree 8 through nine samples."""
    found = []
    for i in range(4, len(samples) - 4):
        if samples[i] > above and samples[i - 1] <= samples[i] > samples[i + 1]:
            curve = np.polynomial.Polynomial.fit(np.arange(-4, 5), samples[i - 4 : i + 5], 8)
            near = [root.real for root in curve.deriv().roots() if abs(root.imag) < 1e-6 and abs(root) <= 1.0]
            place = max(near, key=curve)
            found.append((i + 1 + place, float(curve(place))))
    return found


def peak_heights(samples: np.ndarray, above: float) -> list[float]:
    return [height for _, height in peaks(samples, above)]


def momentum_magnitude(chain: ge.Chain) -> float:
    """Return the sum of |p|."""
    return float(np.abs(chain.geometry.mass * chain.get("velocity")).sum())


def state_hash(chain: ge.Chain) -> str:
    """Return the hash of all bits of a snapshot."""
    return hashlib.sha256(chain.save().to_bytes()).hexdigest()


def run_python(code: str, *, folder: Path = ROOT, **environment: str) -> str:
    """Run code in a new interpreter, which can import test helpers, and return its output."""
    paths = os.pathsep.join((str(folder), str(ROOT / "tests")))
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code],
        cwd=folder, env={**os.environ, "PYTHONPATH": paths, **environment}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


# -- cases for bitwise comparison of ways to run the same kernels ------------------------------------------------------

ENDS = (
    ("free", "free"), ("piston", "free"), ("free", "piston"), ("piston", "rigid_plane"), ("plane", "free"),
    ("fixed_grain", "plane"), ("piston", "piston"),
)  # fmt: skip
PUSH = ge.Profile.half_sine(40.0, 3.1e-6, start=0.4e-6)
MOTION = ge.Profile(np.array([0.0, 2e-6]), np.array([[0.5, 1e5, -2e10], [0.62, -2e4, 0.0]]))


def example_drives(left: str, right: str) -> dict[str, object]:
    """Return inputs for a chain: a profile on the left and a number on the right, if the end accepts an input."""
    inputs: dict[str, object] = {}
    if left in ("free", "piston"):
        inputs |= {"left_velocity": MOTION} if left == "piston" else {"left_force": PUSH}
    if right in ("free", "piston"):
        inputs |= {"right_velocity": -0.3} if right == "piston" else {"right_force": -7.0}
    return inputs


def bit_cases(schemes: Sequence[str], grains: int, ticks: int) -> Iterator[tuple[str, str]]:
    """Yield name and hash for every pair of ends and scheme: driven random chains, half of them precompressed."""
    for scheme in schemes:
        for number, (left, right) in enumerate(ENDS):
            random = np.random.default_rng(number)
            chain = ge.make(
                "chain", grains=grains, radius=random.uniform(1e-3, 3e-3, grains).tolist(), left=left, right=right,
                integrator=scheme, step_size=1e-7, precompression=20.0 * (number % 2),
            )  # fmt: skip
            chain.reset(velocity=random.uniform(-3.0, 3.0, grains))
            chain.step(ticks * chain.step_size, **example_drives(left, right))
            chain.step(3 * chain.step_size)
            yield f"{scheme} {left} {right}", state_hash(chain)


def print_bit_cases(schemes: Sequence[str], grains: int, ticks: int) -> None:
    for name, digest in bit_cases(schemes, grains, ticks):
        print(f"{name}: {digest}")
