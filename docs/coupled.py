"""Draws the pictures of coupled.md: ``python docs/coupled.py``."""

from pathlib import Path

import appearance
import numpy as np
from grid import BLUE, TIME, show_fronts
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, PolyCollection
from matplotlib.colors import Normalize

import granular_env as ge
from granular_env.components.coupled import Coupled
from granular_env.viewing.figures import drawing

IMAGES = Path(__file__).parent / "images"
ROWS = 81
# Largest pressure of the colour scale [MPa].
_LARGEST = 15.0


def velocity_fields(medium: Coupled) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return x, y and the velocities of nodes and automata, side by side, shape (rows, columns)."""
    parts = []
    for points, velocity in (
        (medium.grid.mesh.nodes, medium.get("grid_velocity")),
        (medium.reference, medium.get("automata_velocity")),
    ):
        parts.append(np.concatenate([points, velocity], axis=1).reshape(ROWS, -1, 4))
    both = np.concatenate([parts[0], parts[1][:, 1:]], axis=1)
    return both[..., 0], both[..., 1], both[..., 2], both[..., 3]


def show_seam(axes: Axes, medium: Coupled, source: float) -> None:
    """Draw the interface, and where theory expects the fronts of the waves of a load at x = source."""
    axes.axvline(0.0, color="0.45", linewidth=0.8)
    axes.text(-0.01, -0.39, "grid", ha="right", color="0.45")
    axes.text(0.01, -0.39, "automata", color="0.45")
    show_fronts(axes, medium.grid.parameters.materials[0], source)


@drawing.use_style
def draw_interface_waves() -> None:
    """Draw velocities of both shipped Lamb experiments, with the fronts of theory (figures 7 and 8 of the paper)."""
    figure = drawing.new_figure(15.0, 6.0)
    for pair, (name, source) in zip(figure.subplots(2, 3), (("symmetric", 0.0), ("asymmetric", -0.1)), strict=True):
        medium = ge.run(f"psakhie-2003/lamb-{name}", overrides={"duration": TIME}).component
        x, y, vx, vy = velocity_fields(medium)
        speed = np.sqrt(vx * vx + vy * vy)
        # Square roots make the weaker P wave visible next to the Rayleigh wave.
        some, length = (slice(None, None, 3), slice(None, None, 3)), np.sqrt(np.maximum(speed, 1e-12))
        pair[0].quiver(x[some], y[some], (vx / length)[some], (vy / length)[some], scale=8.0, width=0.0013, color=BLUE)
        pair[1].pcolormesh(x, y, np.sqrt(speed), shading="gouraud", cmap="Greys")
        # P waves do not turn anything: before S, what turns is head waves.
        turning = np.gradient(vy, x[0], axis=1) - np.gradient(vx, y[:, 0], axis=0)
        limit = 0.03 * np.abs(turning).max()
        pair[2].pcolormesh(x, y, turning, shading="gouraud", cmap="RdBu_r", vmin=-limit, vmax=limit)
        for axes, title in zip(pair, ("velocity vectors", "speed", "curl of the velocity"), strict=True):
            show_seam(axes, medium, source)
            axes.set(aspect="equal", xlim=(-0.48, 0.4), ylim=(-0.4, 0.04), xlabel="x [m]", title=f"{name}: {title} at 70 µs")
        pair[0].set_ylabel("y [m]")
    appearance.save_figure(figure, IMAGES / "coupled.png", dots_per_inch=110, colours=256)


def mean_pressure(stress: np.ndarray) -> np.ndarray:
    """Return minus the mean of both normal stresses in the plane [MPa]."""
    return -0.5e-6 * (stress[:, 0] + stress[:, 1])


def show_core(axes: Axes, medium: Coupled) -> None:
    """Draw mean stresses in the plane, displacements tenfold, automata with broken links, and cells that have yielded."""
    stretch, limit = 10.0, _LARGEST
    corners = (medium.grid.mesh.nodes + stretch * medium.get("grid_displacement"))[medium.grid.mesh.cells]
    pressure = {"cmap": "RdBu_r", "clim": (-limit, limit), "linewidths": 0.0}
    axes.add_collection(PolyCollection(corners, array=mean_pressure(medium.get("grid_stress")), **pressure))
    centres = medium.reference + stretch * medium.get("automata_displacement")
    damage = medium.get("automata_damage")
    size = np.full(len(centres), medium.automata.parameters.diameter)
    discs = {"units": "xy", "offset_transform": axes.transData, "linewidths": 0.0}
    mean = mean_pressure(medium.get("automata_stress"))
    axes.add_collection(
        EllipseCollection(size, size, 0.0, offsets=centres, array=mean, cmap="RdBu_r", clim=(-limit, limit), **discs)
    )
    broken = damage > 0.0
    size = size[broken]
    axes.add_collection(EllipseCollection(size, size, 0.0, offsets=centres[broken], facecolors="black", **discs))
    middles = corners.mean(axis=1)[medium.get("grid_plastic_strain") > 0.0]
    axes.plot(middles[:, 0], middles[:, 1], ".", color="#e09f3e", markersize=2.0)
    axes.set(xlim=(-0.1, 0.1), ylim=(-0.004, 0.125), aspect="equal")
    axes.set_title(f"{medium.time * 1e6:.0f} µs, {medium.get('automata_broken_links'):.0f} broken links")


@drawing.use_style
def draw_cracking_core() -> None:
    """Draw the shipped impacts, on a square and on a hexagonal packing, at three instants."""
    figure = drawing.new_figure(12.0, 4.9)
    rows = figure.subplots(2, 3, sharex=True, sharey=True)
    for row, (core, packing) in zip(rows, (("cracking-core", "square"), ("hexagonal-layer", "hexagonal")), strict=True):
        for axes, time in zip(row, (1.8e-5, 3.2e-5, 6e-5), strict=True):
            show_core(axes, ge.run(f"psakhie-2003/impact-on-a-{core}", overrides={"duration": time}).component)
        row[0].set_ylabel(f"{packing}, y [m]")
    for axes in rows[-1]:
        axes.set_xlabel("x [m]")
    pressure = ScalarMappable(Normalize(-_LARGEST, _LARGEST), "RdBu_r")
    figure.colorbar(pressure, ax=rows, label="pressure in the plane [MPa]", shrink=0.7)
    appearance.save_figure(figure, IMAGES / "coupled-impact.png", dots_per_inch=110, colours=256)


if __name__ == "__main__":
    draw_interface_waves()
    draw_cracking_core()
