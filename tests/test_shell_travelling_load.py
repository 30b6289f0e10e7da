"""A pressure step that travels along a tube below, at and above the critical speed, against the theoretical steady state."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import granular_env as ge
from granular_env.components.shell.theory import critical_speed, front_amplification

LENGTH, RADIUS, WALL, YOUNG, DENSITY, PRESSURE = 0.072, 0.01, 6e-4, 69e9, 2719.0, 1e5
MEAN = RADIUS + 0.5 * WALL


def peaks(ratio: float) -> np.ndarray:
    """Return the largest radial displacements of the stations over the static value, with the front at 0.8 of the length.

    The load grows over the first 0.4 of the length, so that the start leaves no trace.
    """
    body = {"name": "tube", "length": LENGTH, "inner_radius": RADIUS, "wall": WALL, "along": 61, "around": 17, "half": True}
    elastic = {"name": "elastic", "young": YOUNG, "poisson": 0.0, "density": DENSITY}
    tube: Any = ge.make("shell", body=body, material=elastic, boundaries={"start": "symmetry", "end": "symmetry"})
    bounds, part = tube.lattice.axes[0].bounds, np.clip(tube.lattice.axes[0].positions / (0.4 * LENGTH), 0.0, 1.0)
    ramp = part * part * (3.0 - 2.0 * part)
    speed = ratio * critical_speed(YOUNG, 0.0, DENSITY, MEAN, WALL)
    ticks, largest = 4, np.zeros(61)
    while (front := speed * (tube.time + 0.5 * ticks * tube.step_size)) < 0.8 * LENGTH:
        covered = np.clip((front - bounds[:-1]) / np.diff(bounds), 0.0, 1.0)
        tube.step(ticks * tube.step_size, pressure=PRESSURE * ramp * covered)
        largest = np.maximum(largest, tube.get("mean_inner_radius") - RADIUS)
    return largest * YOUNG * WALL / (PRESSURE * RADIUS * MEAN)


def test_theory_in_its_limits() -> None:
    assert front_amplification(0.01) == pytest.approx(1.0 + 0.5 * math.exp(-0.75 * math.pi) * math.sqrt(0.5), rel=1e-3)
    assert front_amplification(10.0) == pytest.approx(2.0, rel=1e-3)
    assert front_amplification(1.0) == math.inf
    assert front_amplification(0.999) > 8.0 and front_amplification(1.001) > 8.0
    # The paper's detonation is three times as fast as the resonant waves.
    assert front_amplification(2374.0 / critical_speed(69e9, 0.33, 2719.0, 0.020195, 8.9e-4)) == pytest.approx(2.0037, abs=2e-4)


def test_a_fast_front() -> None:
    """The deviation from theory, which neglects shear, is 3 % for a wall of 0.06 radii."""
    found = peaks(1.4)[28:41]
    assert found.max() == pytest.approx(front_amplification(1.4), rel=0.04)
    assert np.ptp(found) < 0.02 * found.max()


@pytest.mark.slow
def test_a_slow_front_and_a_critical_one() -> None:
    """A slow front agrees with theory; at the critical speed the peak grows along the tube, above those of faster fronts."""
    assert peaks(0.6)[28:41].max() == pytest.approx(front_amplification(0.6), rel=0.03)
    critical = peaks(1.0)[24:44:5]
    assert (np.diff(critical) > 0.0).all()
    assert critical[-1] > 1.15 * front_amplification(1.4)
