"""Draws the pictures of automata.md: ``python docs/automata.py``."""

from pathlib import Path

import appearance
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.ticker import FuncFormatter, MultipleLocator

import granular_env as ge
from granular_env.viewing.figures import drawing

IMAGES = Path(__file__).parent / "images"
MILLIMETRES = FuncFormatter(lambda place, _: f"{1e3 * place:.0f}")
# Experiment -> times that are shown [s].
SHOWN = {
    "psakhie-2003/uniaxial-compression": (2.5e-4, 2.6e-4, 2.75e-4, 3.0e-4),
    "psakhie-2003/brazilian-disc": (1.1e-4, 1.14e-4, 1.2e-4, 1.3e-4),
}


def show_automata(axes: Axes, automata: ge.Component) -> None:
    """Draw the automata where they are, coloured by damage."""
    points = automata.drawables()[0]
    size = np.full(len(points.radius), 2.0 * points.radius[0])
    centres = points.reference + automata.get("displacement")
    discs = EllipseCollection(
        size, size, 0.0, units="xy", offsets=centres, offset_transform=axes.transData, array=automata.get("damage"),
        cmap="inferno_r", clim=(0.0, 1.0), linewidths=0.0,
    )  # fmt: skip
    axes.add_collection(discs)
    low, high = points.reference.min(axis=0) - 3e-3, points.reference.max(axis=0) + 3e-3
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xticks=[], yticks=[])
    axes.set_title(f"{automata.time * 1e6:.0f} us, {automata.get('broken_links'):.0f} broken")


@drawing.use_style
def draw_failures() -> None:
    """Draw both experiments as they fail, one below the other."""
    figure = drawing.new_figure(10.4, 7.8)
    rows = figure.subplots(2, 4, height_ratios=(2.0, 1.1), sharey="row")
    for axes, (name, times) in zip(rows, SHOWN.items(), strict=True):
        for one, time in zip(axes, times, strict=True):
            show_automata(one, ge.run(name, overrides={"duration": time}).component)
            one.xaxis.set_major_locator(MultipleLocator(0.02))
            one.yaxis.set_major_locator(MultipleLocator(0.02))
            one.xaxis.set_major_formatter(MILLIMETRES)
            one.yaxis.set_major_formatter(MILLIMETRES)
            one.grid(visible=False)
            one.set_xlabel("x [mm]")
        axes[0].set_ylabel("y [mm]")
    damage = ScalarMappable(Normalize(0.0, 1.0), "inferno_r")
    figure.colorbar(damage, ax=rows, label="part of the faces that is broken", shrink=0.6)
    appearance.save_figure(figure, IMAGES / "automata.png", dots_per_inch=110, colours=128)


def show_grains(axes: Axes, automata: ge.Component) -> None:
    """Draw materials and broken links, with displacements magnified twenty times."""
    points, links = automata.drawables()
    centres = points.reference + 20.0 * automata.get("displacement")
    size = np.full(len(centres), 2.0 * points.radius[0])
    discs = EllipseCollection(
        size, size, 0.0, units="xy", offsets=centres, offset_transform=axes.transData, array=automata.automaton_material,
        cmap=ListedColormap(["#d9c9a8", "#8fa3b8"]), linewidths=0.0,
    )  # fmt: skip
    axes.add_collection(discs)
    middles = centres[links.pairs[automata.get("linked") < 1.0]].mean(axis=1)
    axes.scatter(*middles.T, s=2.0, color="black", linewidths=0.0)
    axes.set(xlim=(-2e-3, 6.2e-2), ylim=(-2e-3, 6.4e-2), aspect="equal", xticks=[], yticks=[])
    axes.set_title(f"{automata.time * 1e6:.0f} us, {automata.get('broken_links'):.0f} broken")


@drawing.use_style
def draw_grains() -> None:
    """Draw the grains in mortar as the crack runs along them."""
    figure = drawing.new_figure(9.6, 2.8)
    for axes, time in zip(figure.subplots(1, 4), (5.4e-5, 6.0e-5, 7.0e-5, 1.1e-4), strict=True):
        show_grains(axes, ge.run("psakhie-2003/grains-in-mortar", overrides={"duration": time}).component)
    appearance.save_figure(figure, IMAGES / "automata-grains.png", colours=64)


if __name__ == "__main__":
    draw_failures()
    draw_grains()
