"""Lamb's problem: a line load on a half-space, against the exact solution of Cagniard and de Hoop."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.grid_tools import MEDIUM, P_SPEED, S_SPEED, SMALL

from granular_env.components.grid import Grid
from granular_env.components.grid.theory import LineLoad, rayleigh_speed
from granular_env.components.profiles import Profile
from granular_env.components.support.float_arrays import FloatArray

# Positions in units of L = c_s T, T being the duration of the load: near the surface (Rayleigh wave), and inside.
RAYLEIGH = [(2.5, 0.1), (1.8, 0.5)]
BODY = [(1.5, 1.5), (0.5, 2.0)]
# Final time, after the Rayleigh wave has passed the first position and before reflections from the bottom or the side.
TIMES = 3.75


def load(time: FloatArray, duration: float) -> FloatArray:
    """Return 64 (t/T)^3 (1 - t/T)^3, a smooth pulse of height 1."""
    part = np.clip(time / duration, 0.0, 1.0)
    return 64.0 * part**3 * (1.0 - part) ** 3


def misfits(length: int, places: list[tuple[float, float]], hourglass: float = 1.0) -> list[float]:
    """Return the relative L2 misfit of the displacement at given positions, with `length` cells per L."""
    # Rays from the source via a wall to the last position take longer than the run.
    width, depth = round(4.6 * length), round(4.4 * length)
    grid = Grid(
        mesh={"name": "rectangle", "columns": width, "rows": depth, "cell_size": 1.0, "centre": [0.5 * width, -0.5 * depth]},
        material=MEDIUM, boundaries={"left": "symmetry"}, forced_nodes=[[0.0, 0.0]], step_size=0.5, hourglass=hourglass,
        receivers=[[x * length, -z * length] for x, z in places],
    )  # fmt: skip
    duration = length / S_SPEED
    powers = 64.0 * np.array([0, 0, 0, 1, -3, 3, -1]) / duration ** np.arange(7)
    signal = Profile.piecewise([0.0, duration], [powers, [0.0]])
    # Half of the load; the other half acts on the mirror image.
    grid.step(0.5, force=signal * np.array([[0.0, -0.5 * SMALL]]))
    every = max(1, length // 20)
    times, seen = [], []
    while grid.time < TIMES * duration:
        grid.step(0.5 * every)
        times.append(grid.time)
        seen.append(grid.get("receiver_displacement") / SMALL * [1.0, -1.0])
    exact = LineLoad(MEDIUM, lambda time: load(time, duration), duration)
    found = []
    for place, (x, z) in enumerate(places):
        reference = exact.displacement(x * length, z * length, np.array(times))
        error = np.array(seen)[:, place] - reference
        found.append(math.sqrt((error**2).sum() / (reference**2).sum()))
    return found


def test_waves_of_a_line_load_at_20_cells() -> None:
    # Second-order: four times the bound for 40 cells.
    assert max(misfits(20, RAYLEIGH)) <= 4 * 0.03
    assert max(misfits(20, BODY)) <= 4 * 0.02


def test_the_order_from_10_to_20_cells() -> None:
    coarse, fine = misfits(10, RAYLEIGH + BODY), misfits(20, RAYLEIGH + BODY)
    assert all(math.log2(one / other) >= 1.7 for one, other in zip(coarse, fine, strict=True))


def test_weak_hourglass_forces_spoil_rayleigh_waves() -> None:
    """The reason for the default, the stiffness of full integration."""
    weak, full = (misfits(20, RAYLEIGH[:1], hourglass=one)[0] for one in (0.05, 1.0))
    assert weak > 2.0 * full


@pytest.mark.slow
def test_waves_of_a_line_load_at_40_cells() -> None:
    coarse, fine = misfits(20, RAYLEIGH + BODY), misfits(40, RAYLEIGH + BODY)
    assert max(fine[:2]) <= 0.03
    assert max(fine[2:]) <= 0.02
    assert all(math.log2(one / other) >= 1.7 for one, other in zip(coarse, fine, strict=True))


# -- the exact solution -----------------------------------------------------------------------------------------------------


def line_load(duration: float = 1.0) -> LineLoad:
    return LineLoad(MEDIUM, lambda time: load(time, duration), duration)


def test_the_speed_of_rayleigh_waves() -> None:
    # Tabulated for nu = 1/4: sqrt(2 - 2 / sqrt 3) times the shear speed.
    assert rayleigh_speed(MEDIUM) / S_SPEED == pytest.approx(math.sqrt(2.0 - 2.0 / math.sqrt(3.0)), rel=1e-12)


@pytest.mark.parametrize(("x", "z"), [(0.3, 2.0), (3.0, 1.0), (6.0, 0.2)])
def test_nothing_moves_before_the_first_wave(x: float, z: float) -> None:
    exact = line_load()
    arrivals = exact.arrivals(x, z)
    assert list(arrivals.values()) == sorted(arrivals.values())
    assert ("head" in arrivals) == (math.atan2(x, z) > math.asin(S_SPEED / P_SPEED))
    times = np.array([0.5, 0.999, 1.05]) * arrivals["P"]
    moved = np.abs(exact.displacement(x, z, times)).max(axis=1)
    assert moved[0] == moved[1] == 0.0 < moved[2]


def test_the_load_gives_its_impulse_to_the_half_space() -> None:
    """Density times the integral of the displacement over the region behind the wave is the twice-integrated load."""
    exact, reach, step = line_load(0.5), 4.0, 0.1
    time = 2.0
    x, z = np.meshgrid(np.arange(0.5 * step, reach, step), np.arange(0.5 * step, reach, step))
    near = x * x + z * z < (P_SPEED * time) ** 2
    down = [
        exact.displacement(float(one), float(other), np.array([time]))[0, 1]
        for one, other in zip(x[near], z[near], strict=True)
    ]
    fine = np.linspace(0.0, time, 4001)
    impulse = np.cumsum(load(fine, 0.5)) * fine[1]
    wanted = float(impulse.sum() * fine[1])
    # Both sides of x = 0. The midpoint rule errs by about a percent near the load, where the displacement is logarithmic.
    assert 2.0 * MEDIUM.density * step * step * sum(down) == pytest.approx(wanted, rel=0.01)


def test_displacements_mirror_in_x() -> None:
    exact, times = line_load(), np.linspace(0.0, 8.0, 40)
    np.testing.assert_array_equal(exact.displacement(-3.0, 0.5, times), exact.displacement(3.0, 0.5, times) * [-1.0, 1.0])
