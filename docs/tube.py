"""Draws the picture of the tube in detonation.md: ``python docs/tube.py``."""

from pathlib import Path
from typing import Any

import appearance
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import granular_env as ge
from granular_env.components.shell.theory import critical_speed, front_amplification
from granular_env.viewing.figures import drawing

IMAGES = Path(__file__).parent / "images"
DARK_RED, BLUE, GREY = "#c1121f", "#274c77", "0.55"
# Heat of the reaction [J/kg] -> duration until the front has left the section [s], colour.
LOADS = {5.4e5: (5.4e-4, GREY), 1.084e6: (4e-4, DARK_RED), 2.36e6: (2.8e-4, BLUE)}
MEAN, WALL, YOUNG = 0.020195, 0.00089, 69e9


def show_history(figure: Figure, axes: Axes) -> None:
    """Draw the radial displacement over place and time, and where the front is."""
    tube: Any = ge.run("gato-shie-2010/whole-tube-coarse", overrides={"duration": 6e-4}).component
    times, radial, front = [], [], []
    while tube.time < 1e-3 - 1e-9:
        tube.step(2e-6)
        times.append(1e3 * tube.time)
        radial.append(1e6 * tube.get("radial_displacement"))
        front.append(tube.get("gas_right_front"))
    x = tube.parameters.position + tube.shell.lattice.axes[0].positions
    drawn = axes.pcolormesh(x, times, np.array(radial), cmap="RdBu_r", vmin=-50.0, vmax=50.0, shading="nearest")
    ahead = np.array(front) < 2.125
    axes.plot(np.array(front)[ahead], np.array(times)[ahead], color="0.15", linewidth=1.0, linestyle="--")
    axes.text(1.62, 0.655, "front of the detonation", fontsize=8, rotation=17)
    axes.set(xlabel="x [m]", ylabel="time [ms]", xlim=(1.52, 2.13), ylim=(0.6, 1.0), title="the wall behind a detonation")
    figure.colorbar(drawn, ax=axes, label="radial displacement [µm]")


def show_resonance(axes: Axes) -> None:
    """Draw how far the wall swings out along the tube, for fronts of three speeds."""
    critical = critical_speed(YOUNG, 0.33, 2719.0, MEAN, WALL)
    for heat, (duration, colour) in LOADS.items():
        changes = {"component.gas.gas.heat_release": heat, "duration": 1e-6}
        tube: Any = ge.run("gato-shie-2010/travelling-load", overrides=changes).component
        peak = np.zeros(len(tube.interface.width))
        while tube.time < duration:
            tube.step(1e-6)
            peak = np.maximum(peak, tube.get("radial_displacement"))
        static = (tube.get("peak_pressure") - 1e5) * 0.01975 * MEAN / (YOUNG * WALL)
        x, speed = 1e3 * tube.shell.lattice.axes[0].positions, tube.gas.front.speed
        axes.plot(x, peak / static, color=colour, linewidth=1.6, label=f"front at {speed:.0f} m/s")
        if (limit := front_amplification(speed / critical)) < 4.0:
            axes.axhline(limit, color=colour, linewidth=0.8, linestyle=":")
    axes.set(xlabel="along the section [mm]", xlim=(0.0, 140.0), ylim=(0.0, 3.2), title="a load that travels; dotted: theory")
    axes.set_ylabel("largest over static displacement")
    axes.legend(frameon=False, fontsize=8, loc="lower right")


@drawing.use_style
def draw_wall_waves() -> None:
    """Draw the two shipped experiments on gas and solid together."""
    figure = drawing.new_figure(11.0, 3.8)
    left, right = figure.subplots(1, 2)
    show_history(figure, left)
    show_resonance(right)
    appearance.save_figure(figure, IMAGES / "tube.png", colours=128)


if __name__ == "__main__":
    draw_wall_waves()
