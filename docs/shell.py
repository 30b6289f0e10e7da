"""Draws the pictures of shell.md and cracked-tube.md: ``python docs/shell.py``."""

import tempfile
from pathlib import Path
from typing import Any

import appearance
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection, QuadMesh

import granular_env as ge
from granular_env.components.shell.theory import breathing_frequency, lame_displacement
from granular_env.viewing.figures import drawing
from granular_env.viewing.figures.colour_bar import add_colour_bar
from granular_env.viewing.figures.plane import draw_instant, load_plane
from granular_env.viewing.scene_builder import load_scene

IMAGES = Path(__file__).parent / "images"
DARK_RED, BLUE = "#c1121f", "#274c77"
TIMES = (1e-5, 3e-5)
# A piece of the tube with a notch in the middle.
NOTCHED = {
    "body": {
        "name": "tube", "length": 0.02, "along": 25, "around": 90,
        "notch": {"length": 0.008, "depth": 0.0006, "width": 0.0005},
    },
    "material": "thermoviscoplastic",
    "fracture": {"name": "principal_stress", "factor": 1.3},
    "boundaries": {"start": "clamped", "end": "clamped"},
}  # fmt: skip


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


@drawing.use_style
def draw_breathing_and_impact() -> None:
    """Draw the two shipped experiments on the solid."""
    figure = drawing.new_figure(11.0, 3.6)
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
    appearance.save_figure(figure, IMAGES / "shell.png", colours=128)


def whole_cells(solid: Any) -> np.ndarray:
    """Return the corners of the cells of the outer surface that no crack crosses, as numbers of columns."""
    return solid.drawables()[0].connectivity[solid.get("surface_cells") != 0.0]


def show_cells(axes: Axes, x: np.ndarray, y: np.ndarray, cells: np.ndarray, values: np.ndarray, most: float) -> Any:
    """Draw cells in the plane, coloured by the mean of their corners."""
    shapes = np.stack([x[cells], y[cells]], axis=-1)
    drawn = PolyCollection(list(shapes), array=values[cells].mean(axis=1), cmap="YlOrRd", edgecolors="0.35", linewidths=0.25)
    drawn.set_clim(0.0, most)
    axes.add_collection(drawn)
    axes.set(aspect="equal", facecolor="white")
    return drawn


@drawing.use_style
def draw_cracks() -> None:
    """Draw the shipped ring in pieces, and a tube whose notch has torn open, unrolled."""
    figure = drawing.new_figure(11.0, 4.2)
    left, right = figure.subplots(1, 2, width_ratios=[1.0, 1.0])
    ring: Any = ge.run("gato-shie-2010/expanding-ring", overrides={"record.variables": ["pieces"]}).component
    place = 1e3 * (ring.nodes[ring.surface_nodes] + ring.get("surface_displacement"))
    # Seen along its axis the ring is its wall: the cells are drawn a little towards the eye.
    away = 1.0 + 0.06 * place[:, 0] / place[:, 0].max()
    strain = ring.get("surface_plastic_strain")
    drawn = show_cells(left, place[:, 1] * away, place[:, 2] * away, whole_cells(ring), strain, 0.3)
    left.set(xlim=(-34.0, 34.0), ylim=(-34.0, 34.0), xlabel="y [mm]", ylabel="z [mm]")
    left.set_title(f"a ring in {ring.get('pieces'):.0f} pieces after 50 µs")
    figure.colorbar(drawn, ax=left, label="plastic strain", shrink=0.8)
    tube: Any = ge.make("shell", **NOTCHED)
    tube.step(3e-5, pressure=5e6)
    place = 1e3 * (tube.nodes[tube.surface_nodes] + tube.get("surface_displacement"))
    turned = np.arctan2(place[:, 1], place[:, 2])
    radius = 20.64
    cells = whole_cells(tube)
    cells = cells[np.ptp(turned[cells], axis=1) < 1.0]
    stress = 1e-6 * tube.get("surface_stress")
    drawn = show_cells(right, place[:, 0], radius * turned, cells, stress, 400.0)
    right.set(xlim=(-5.5, 25.5), ylim=(-15.0, 15.0), xlabel="along the tube [mm]", ylabel="around [mm]")
    right.set_title("a notched tube, 5 MPa, after 30 µs")
    figure.colorbar(drawn, ax=right, label="equivalent stress [MPa]", shrink=0.8)
    appearance.save_figure(figure, IMAGES / "shell-fracture.png", colours=128)


@drawing.use_style
def draw_torn_tube() -> None:
    """Draw three instants of the tube of cracked-tube.md, whose notch tears open, obliquely, as a report does."""
    body = {
        "name": "tube", "length": 0.024, "along": 25, "around": 60,
        "notch": {"length": 0.01, "depth": 0.0006, "width": 0.0008},
    }  # fmt: skip
    tube: Any = ge.make("shell", **{**NOTCHED, "body": body})
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "torn.mcap"
        with ge.record(tube, path, every=1e-6, variables=["surface_displacement", "surface_stress", "surface_cells"]):
            tube.step(2.4e-5, pressure=5e6)
        with ge.open_log(path) as log:
            shown = load_plane(log, load_scene(log), [0.0, 6e-6, 2.4e-5])
    assert shown is not None
    figure = drawing.new_figure(11.0, 4.4)
    panels = figure.subplots(1, 3)
    for frame, (axes, time) in enumerate(zip(panels, shown.times, strict=True)):
        draw_instant(axes, shown, frame)
        axes.set_title(f"{1e6 * time:.0f} µs", fontsize=11)
    for scale in shown.scales.colours:
        add_colour_bar(figure, scale, ax=panels, shrink=0.5, aspect=40, pad=0.02)
    for marks in figure.findobj(QuadMesh):
        # The bar keeps its colours on dark pages, as the tube does.
        shades = marks.to_rgba(np.ravel(marks.get_array()))
        marks.set_array(None)
        marks.set_facecolor(shades)
    appearance.save_figure(figure, IMAGES / "cracked-tube.png", colours=256)


if __name__ == "__main__":
    draw_breathing_and_impact()
    draw_cracks()
    draw_torn_tube()
