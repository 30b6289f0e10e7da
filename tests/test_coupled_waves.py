"""Reflection and transmission of waves at the interface of a grid and automata.

The bounds come from a prototype of the method. The size of cells and automata, density and shear modulus are 1.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from support.coupled_tools import MEDIUM, P_SPEED, S_SPEED, SMALL, cell_mesh, make_coupled, rectangle, start_wave, strip
from support.grid_tools import pulse

from granular_env.components.grid import Grid
from granular_env.components.profiles import Profile
from granular_env.components.support.float_arrays import FloatArray


def burst(wavelength: float) -> Callable[[FloatArray], FloatArray]:
    """Return four waves with a bell-shaped envelope, from 1.5 to 5.5 wavelengths."""

    def shape(x: FloatArray) -> FloatArray:
        since = (x - 1.5 * wavelength) / wavelength
        bell = np.sin(0.25 * np.pi * np.clip(since, 0.0, 4.0)) ** 2
        return bell * np.sin(2.0 * np.pi * since)

    return shape


def reflection(packing: str, wavelength: int, shear: bool, n: int = 1) -> float:
    """Return the largest reflected velocity (difference from the grid alone), relative to the velocity of the wave."""
    medium, axis = strip(packing, 6 * wavelength, 6 * wavelength, 0.2 / n, n)
    edges = dict.fromkeys(("bottom", "top") if axis == 0 else ("left", "right"), "periodic")
    shape = cell_mesh(12 * wavelength, 2) if axis == 0 else cell_mesh(4, 12 * wavelength)
    whole = Grid(mesh=shape, material=MEDIUM, boundaries=edges, step_size=medium.step_size)
    speed, component = (S_SPEED, 1 - axis) if shear else (P_SPEED, axis)
    for one in (medium, whole):
        start_wave(one, axis, burst(wavelength), 6.0 * wavelength, shear)
        one.step(round(4.5 * wavelength / speed / 0.2) * 0.2)
    found, alone = (table(one.mesh.nodes, values[:, component]) for one, values in (
        (medium.grid, medium.get("grid_velocity")), (whole, whole.get("velocity")),
    ))  # fmt: skip
    inside = [place for place in found if place[axis] < 6 * wavelength - 0.5]
    return max(abs(found[place] - alone[place]) for place in inside) / SMALL


def table(nodes: FloatArray, values: FloatArray) -> dict[tuple[int, int], float]:
    """Return values by the position of their nodes."""
    places = np.rint(nodes).astype(int).tolist()
    return {(x, y): value for (x, y), value in zip(places, values.tolist(), strict=True)}


@pytest.mark.parametrize(("packing", "shear", "bound"), [
    ("square", False, 5e-3), ("square", True, 5e-3), ("hexagonal", False, 4e-3), ("hexagonal", True, 4e-3),
])  # fmt: skip
def test_the_interface_sends_little_back(packing: str, shear: bool, bound: float) -> None:
    """Reflection at a wavelength of 20 cells; it is proportional to the square of the cell size."""
    long, short = reflection(packing, 20, shear), reflection(packing, 10, shear)
    assert 0.0 < long <= bound
    assert 3.0 <= short / long <= 6.0


def go_there_and_back(packing: str, length: int, step: float = 0.2) -> dict[str, float]:
    """Send a pulse of `length` cells through the interface to the rigid end and back, about 5 lengths.

    Returns:
        The remaining height; the L2 misfit to the exact pulse, with and without alignment; the delay relative to the path;
        and the relative energy residual.
    """
    medium, axis = strip(packing, 5 * length // 2, 5 * length // 4, step)
    start_wave(medium, axis, lambda x: pulse(x - 0.75 * length, float(length)), 1.75 * length, False)
    energy, incident = medium.get("kinetic_energy") + medium.get("elastic_energy"), medium.get("grid_velocity")[:, axis]
    end = medium.reference[:, axis].max()
    medium.step(round(2.0 * (end - 1.25 * length) / P_SPEED / step) * step)
    velocity, x = medium.get("grid_velocity")[:, axis], medium.grid.mesh.nodes[:, axis]
    way, before = P_SPEED * medium.time, x < 2.5 * length - 5.0

    def misfit(delay: float) -> float:
        exact = -SMALL * pulse(2.0 * end - way - x - 0.75 * length + delay, float(length))
        return float(np.sqrt(((velocity - exact) ** 2)[before].sum() / (incident**2).sum()))

    delays = np.linspace(-1.0, 1.0, 801)
    misfits = [misfit(delay) for delay in delays]
    best = int(np.argmin(misfits))
    return {
        "height": np.abs(velocity).max() / incident.max(), "aligned": misfits[best], "unaligned": misfit(0.0),
        "delay": abs(delays[best]) / way, "residual": abs(medium.get("energy_residual")) / energy,
    }  # fmt: skip


@pytest.mark.parametrize("packing", ["square", "hexagonal"])
def test_a_pulse_comes_back_from_the_rigid_end_as_it_went(packing: str) -> None:
    """A pulse of 80 cells crosses the interface twice and travels 400 cells."""
    found = go_there_and_back(packing, 80)
    assert 0.9987 <= found["height"] <= 1.0007
    assert found["aligned"] <= 0.014
    # Without alignment; most of the misfit is the delay of a quarter of a cell.
    assert found["unaligned"] <= 0.017
    assert found["delay"] <= 6e-4
    assert found["residual"] <= 1e-12
    assert 3.5 <= go_there_and_back(packing, 40)["delay"] / found["delay"] <= 4.5


def secondary_waves(length: int, shift: int, hourglass: float = 1.0) -> tuple[float, float, float]:
    """Return the interface's effect on a surface load's waves in the grid: maximum below the surface, maximum, and L2 norm.

    The first two are relative to the largest velocity, the last is relative to the whole field including surface waves. The
    load is `shift` cells to the left of the interface. It rises and falls smoothly while S waves run `length` cells, and the
    result is taken after the same time again.
    """
    step = 0.2
    duration = round(length / S_SPEED / step) * step
    depth = int(2 * P_SPEED * duration) + 4
    half = depth + shift
    common = {"forced_nodes": [[half - shift, depth]], "hourglass": hourglass}
    automata = {"shape": rectangle(float(half), float(depth))}
    medium = make_coupled({"mesh": cell_mesh(half, depth), **common}, automata, origin=[half, 0.0], step_size=step)
    whole = Grid(mesh=cell_mesh(2 * half, depth), material=MEDIUM, step_size=step, **common)
    times = np.arange(round(duration / step) + 1) * step
    signal = Profile.table(times, SMALL * np.sin(np.pi * times / duration) ** 4) * [[0.0, -1.0]]
    medium.step(2 * duration, grid_force=signal)
    whole.step(2 * duration, force=signal)
    alone = whole.get("velocity").reshape(depth + 1, 2 * half + 1, 2)
    beside = medium.get("grid_velocity").reshape(depth + 1, half + 1, 2)
    difference = (beside - alone[:, : half + 1])[:, : half - 5]
    added = np.abs(difference).max(axis=2) / np.abs(alone).max()
    assert np.abs(alone[:, :5]).max() < 1e-3 * np.abs(alone).max()  # no wave has reached the sides
    return added[: depth - length // 2].max(), added.max(), float(np.sqrt((difference**2).sum() / (alone**2).sum()))


@pytest.mark.parametrize("placed", ["on the interface", "beside it"])
def test_the_interface_makes_few_secondary_waves(placed: str) -> None:
    inside, along, mean = secondary_waves(20, 0 if placed == "on the interface" else 20)
    assert 0.0 < inside <= 0.008 and mean <= 0.008
    # Along the surface the Rayleigh wave of automata is faster than the exact wave, and that of the grid slower.
    assert along <= 0.012


@pytest.mark.slow
@pytest.mark.parametrize("placed", ["on the interface", "beside it"])
def test_with_twice_as_many_cells_they_fall_to_a_quarter(placed: str) -> None:
    inside, along, mean = secondary_waves(40, 0 if placed == "on the interface" else 40)
    assert 0.0 < inside <= 0.002 and mean <= 0.002
    assert along <= 0.004
