"""Draws the picture of grid.md: ``python docs/grid.py``."""

from pathlib import Path

import appearance
import numpy as np
from matplotlib.axes import Axes

import granular_env as ge
from granular_env.components.grid.theory import load_fronts
from granular_env.viewing.figures import drawing

IMAGES = Path(__file__).parent / "images"
TIME = 7e-5
# Distance of a letter from its front [m].
OFF = 0.018
RED, BLUE = "#e63946", "#3b7dbf"


def show_fronts(axes: Axes, material: ge.Material, source: float = 0.0) -> None:
    """Draw where theory expects the fronts of waves from a place of the surface, and their letters."""
    for front in load_fronts(material, TIME, source):
        axes.plot(front.points[:, 0], front.points[:, 1], color=RED, linewidth=0.9, linestyle="--")
        place = front.outward[0] + OFF * front.outward[1]
        axes.text(*place, front.name, color=RED, fontsize=12, fontweight="bold", ha="center", va="center", clip_on=True)


@drawing.use_style
def draw_load_waves() -> None:
    """Draw velocities and speed of the shipped Lamb experiment, with the fronts of theory."""
    grid = ge.run("psakhie-2003/lamb-grid", overrides={"duration": TIME}).component
    nodes, velocity = grid.mesh.nodes, grid.get("velocity")
    shape = (81, 161)
    x, y = (nodes[:, axis].reshape(shape) for axis in (0, 1))
    vx, vy = (velocity[:, axis].reshape(shape) for axis in (0, 1))
    speed = np.sqrt(vx * vx + vy * vy)
    figure = drawing.new_figure(11.0, 3.6)
    left, right = figure.subplots(1, 2, sharey=True)
    # Square roots make the weaker P wave visible next to the Rayleigh wave.
    some = (slice(None, None, 3), slice(None, None, 3))
    length = np.sqrt(np.maximum(speed, 1e-12))
    left.quiver(x[some], y[some], (vx / length)[some], (vy / length)[some], scale=8.0, width=0.0013, color=BLUE)
    right.pcolormesh(x, y, np.sqrt(speed), shading="gouraud", cmap="Greys")
    for axes, title in ((left, "velocity vectors"), (right, "speed")):
        show_fronts(axes, grid.parameters.materials[0])
        axes.set(aspect="equal", xlim=(-0.4, 0.4), ylim=(-0.4, 0.04), xlabel="x [m]", title=f"{title} at 70 µs")
    left.set_ylabel("y [m]")
    appearance.save_figure(figure, IMAGES / "grid.png", colours=64)


if __name__ == "__main__":
    draw_load_waves()
