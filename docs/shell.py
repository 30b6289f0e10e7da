"""Draws the picture of shell.md: ``python docs/shell.py``."""

from pathlib import Path
from typing import Any

import appearance
import numpy as np
from matplotlib.axes import Axes

import granular_env as ge
from granular_env.components.shell.theory import breathing_frequency, lame_displacement
from granular_env.viewing import figure_style

IMAGES = Path(__file__).parent / "images"
DARK_RED, BLUE = "#c1121f", "#274c77"
TIMES = (1e-5, 3e-5)


def show_breathing(axes: Axes) -> None:
    """Draw the hoop strain of the shipped breathing mode, and a step response of theory."""
    tube: Any = ge.run("gato-shie-2010/breathing-mode", overrides={"duration": 5e-7}).component
    body, material = tube.parameters.body, tube.parameters.material
    times, strains = [tube.time], [tube.get("gauge_strain")[0, 1]]
    while tube.time < 7e-5:
        tube.step(5e-7, pressure=3e6)
        times.append(tube.time)
        strains.append(tube.get("gauge_strain")[0, 1])
    middle, outer = body.inner_radius + 0.5 * body.wall, body.inner_radius + body.wall
    static = lame_displacement(material.young, material.poisson, body.inner_radius, body.wall, 3e6, outer) / outer
    turn = 2.0 * np.pi * breathing_frequency(material.young, material.poisson, material.density, middle)
    fine = np.linspace(0.0, 7e-5, 400)
    exact = static * (1.0 - np.cos(turn * fine))
    axes.plot(1e6 * np.array(times), 1e3 * np.array(strains), color=BLUE, linewidth=1.6, label="computed, at the gauge")
    axes.plot(1e6 * fine, 1e3 * exact, color=DARK_RED, linewidth=1.0, linestyle="--", label="Lamé, and 42.06 kHz")
    axes.axhline(1e3 * static, color="0.6", linewidth=0.8, linestyle=":")
    axes.set(xlabel="time [µs]", ylabel="hoop strain [1e-3]", xlim=(0.0, 70.0), title="a step of 3 MPa in the tube")
    axes.legend(frameon=False, fontsize=8, loc="upper right", bbox_to_anchor=(1.0, 1.02))
    axes.set_ylim(-0.1, 2.5)


def show_rod(axes: Axes, rod: Any, offset: float) -> Any:
    """Draw the upper surface of the rod, coloured by its plastic strain."""
    along, across = rod.parameters.body.along, rod.parameters.body.across
    place = (rod.nodes[rod.surface_nodes] + rod.get("surface_displacement")).reshape(along, across, 3)
    strain = rod.get("surface_plastic_strain").reshape(along, across)
    x, y = 1e3 * place[..., 0], 1e3 * (place[..., 1] - 0.5 * rod.parameters.body.side) + offset
    drawn = axes.pcolormesh(x, y, strain, shading="gouraud", cmap="YlOrRd", vmin=0.0, vmax=0.8)
    axes.plot(x, y, color="0.35", linewidth=0.3)
    axes.plot(x.T, y.T, color="0.35", linewidth=0.3)
    return drawn


@figure_style.with_style
def breathing_and_impact() -> None:
    """Draw the two shipped experiments on the solid."""
    figure = figure_style.new_figure(11.0, 3.6)
    left, right = figure.subplots(1, 2)
    show_breathing(left)
    for place, time in enumerate(TIMES):
        rod = ge.run("gato-shie-2010/taylor-rod", overrides={"duration": time}).component
        drawn = show_rod(right, rod, -15.0 * place)
        right.text(31.0, -15.0 * place, f"{1e6 * time:.0f} µs", fontsize=9, va="center")
    right.axvline(0.0, color="0.4", linewidth=2.0)
    right.set(aspect="equal", xlabel="x [mm]", xlim=(-1.0, 38.0), ylim=(-24.0, 9.0), yticks=[])
    right.set_title("a rod that hit a wall at 200 m/s")
    figure.colorbar(drawn, ax=right, label="plastic strain", shrink=0.8)
    appearance.save(figure, IMAGES / "shell.png", colours=128)


if __name__ == "__main__":
    breathing_and_impact()
