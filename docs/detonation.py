"""Draws the picture of the gas in detonation.md: ``python docs/detonation.py``."""

from pathlib import Path

import appearance
import numpy as np
from matplotlib.axes import Axes

import granular_env as ge
from granular_env.components.detonation import DetonationTube
from granular_env.components.detonation.theory import TaylorWave
from granular_env.viewing.figures import drawing

IMAGES = Path(__file__).parent / "images"
TIMES = (2e-4, 5e-4, 8e-4)
DARK_RED, BLUE = "#c1121f", "#274c77"
# Spark and gauge of the shipped experiment.
SPARK = ge.Profile.half_sine(2e7, 1e-5)
GAUGE = 1


def show_profiles(axes: Axes, tube: DetonationTube, wave: TaylorWave) -> None:
    """Draw the pressure along the tube at three instants, and the wave of theory with its front at the same place."""
    for time in TIMES:
        tube.step(round((time - tube.time) / tube.step_size) * tube.step_size, ignition_power=SPARK)
        front = tube.get("right_front")
        x = np.append(np.linspace(0.0, front, 400), front)
        axes.plot(tube.centres, tube.get("pressure") / 1e6, color=BLUE, linewidth=1.4)
        exact = wave.state(x, front / tube.front.speed)[2] / 1e6
        axes.plot(x, exact, color=DARK_RED, linewidth=1.0, linestyle="--")
        axes.text(front + 0.02, 3.0, f"{1e6 * time:.0f} µs", fontsize=9)
    axes.axhline(tube.front.burnt.pressure / 1e6, color="0.6", linewidth=0.8, linestyle=":")
    axes.text(0.03, tube.front.burnt.pressure / 1e6 + 0.06, "Chapman-Jouguet pressure", fontsize=9)
    axes.set(xlabel="x [m]", ylabel="pressure [MPa]", xlim=(0.0, 2.13), ylim=(0.0, 4.0), title="along the tube")


def show_history(axes: Axes, tube: DetonationTube, wave: TaylorWave) -> None:
    """Draw the pressure in the middle of the specimen, which loads the wall, with the wave of theory and its fit."""
    place = tube.parameters.gauges[GAUGE]
    tube.reset()
    times, pressures = [], []
    for _ in range(1200):
        tube.step(1e-6, ignition_power=SPARK)
        times.append(tube.time)
        pressures.append(tube.get("gauge_pressure")[GAUGE])
    time = np.array(times)
    passed = (
        next(event.tick for event in tube.events() if (event.kind, event.index) == ("front_passed", GAUGE)) * tube.step_size
    )
    axes.plot(1e6 * time, np.array(pressures) / 1e6, color=BLUE, linewidth=1.4, label="computed")
    since = np.linspace(0.0, 2.8e-4, 200)
    exact = wave.state(np.full(200, place), place / tube.front.speed + since)[2]
    axes.plot(1e6 * (passed + since), exact / 1e6, color=DARK_RED, linewidth=1.0, linestyle="--", label="Taylor wave")
    fit = wave.plateau + (tube.front.burnt.pressure - wave.plateau) * np.exp(-since / (place / (3.0 * tube.front.speed)))
    axes.plot(1e6 * (passed + since), fit / 1e6, color="0.45", linewidth=1.0, linestyle=":", label="exp(-t / T), T = x / 3D")
    axes.set(xlabel="time [µs]", xlim=(700.0, 1200.0), ylim=(0.0, 4.0), title="in the middle of the specimen")
    axes.legend(frameon=False, fontsize=9)


@drawing.use_style
def draw_detonation() -> None:
    """Draw profiles and a history of the shipped detonation tube."""
    tube = ge.run("gato-shie-2010/detonation-tube", overrides={"duration": 1e-5}).component
    assert isinstance(tube, DetonationTube)
    tube.reset()
    wave = TaylorWave(tube.front, tube.ahead, tube.gas.gamma)
    figure = drawing.new_figure(11.0, 3.6)
    left, right = figure.subplots(1, 2, sharey=True)
    show_profiles(left, tube, wave)
    show_history(right, tube, wave)
    appearance.save_figure(figure, IMAGES / "detonation.png", colours=64)


if __name__ == "__main__":
    draw_detonation()
