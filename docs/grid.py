"""Draws the picture of grid.md: ``python docs/grid.py``."""

import math
from pathlib import Path

import appearance
import numpy as np
from matplotlib.axes import Axes

import granular_env as ge
from granular_env.components.grid.theory import rayleigh_speed
from granular_env.viewing import figure_style

IMAGES = Path(__file__).parent / "images"
TIME = 7e-5
# The load lasts 20 us: fronts are drawn for its middle.
MIDDLE = 1e-5
DARK_RED = "#c1121f"


def fronts(material: ge.Material, time: float) -> list[tuple[str, np.ndarray, tuple[float, float]]]:
    """Return name, points and place of the label of each wave's front, x along the surface and y upwards [m]."""
    fast, slow = material.longitudinal_speed, material.shear_speed
    angles = np.linspace(math.pi, 2.0 * math.pi, 200)
    arcs = [(name, speed * time) for name, speed in (("P", fast), ("S", slow))]
    found = []
    for name, radius in arcs:
        points = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        found.append((name, points, (0.74 * radius, -0.74 * radius)))
    # Head waves leave the surface where P has been and touch the front of S at the critical angle.
    critical = math.asin(slow / fast)
    touch = slow * time * np.array([math.sin(critical), -math.cos(critical)])
    line = np.array([[fast * time, 0.0], touch])
    found += [("C", line, (0.5 * (line[0, 0] + line[1, 0]) + 0.01, 0.55 * line[1, 1])), ("", line * [-1.0, 1.0], (0.0, 0.0))]
    ground = rayleigh_speed(material) * time
    found += [
        ("R", np.array([[side * ground, 0.0], [side * ground, -0.05]]), (side * ground - 0.012, -0.075)) for side in (1, -1)
    ]
    return found


def show_fronts(axes: Axes, material: ge.Material) -> None:
    """Draw where theory expects the waves, and their letters."""
    for name, points, place in fronts(material, TIME - MIDDLE):
        axes.plot(points[:, 0], points[:, 1], color=DARK_RED, linewidth=0.9, linestyle="--")
        axes.text(*place, name, color=DARK_RED, fontsize=12, fontweight="bold")


@figure_style.with_style
def waves_of_a_load() -> None:
    """Draw velocities and speed of the shipped Lamb experiment, with the fronts of theory."""
    grid = ge.run("psakhie-2003/lamb-grid", overrides={"duration": TIME}).component
    nodes, velocity = grid.mesh.nodes, grid.get("velocity")
    shape = (81, 161)
    x, y = (nodes[:, axis].reshape(shape) for axis in (0, 1))
    vx, vy = (velocity[:, axis].reshape(shape) for axis in (0, 1))
    speed = np.sqrt(vx * vx + vy * vy)
    figure = figure_style.new_figure(11.0, 3.6)
    left, right = figure.subplots(1, 2, sharey=True)
    # Roots, so that the weaker P wave is seen beside the Rayleigh wave.
    some = (slice(None, None, 3), slice(None, None, 3))
    length = np.sqrt(np.maximum(speed, 1e-12))
    left.quiver(x[some], y[some], (vx / length)[some], (vy / length)[some], scale=8.0, width=0.0013, color="#274c77")
    right.pcolormesh(x, y, np.sqrt(speed), shading="gouraud", cmap="Greys")
    for axes, title in ((left, "velocity vectors"), (right, "speed")):
        show_fronts(axes, grid.parameters.materials[0])
        axes.set(aspect="equal", xlim=(-0.4, 0.4), ylim=(-0.4, 0.01), xlabel="x [m]", title=f"{title} at 70 µs")
    left.set_ylabel("y [m]")
    appearance.save(figure, IMAGES / "grid.png", colours=64)


if __name__ == "__main__":
    waves_of_a_load()
