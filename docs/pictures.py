"""Draws the pictures of README.md and of these pages: ``python docs/pictures.py``."""

import contextlib
import re
import tempfile
from pathlib import Path
from typing import Any
from unittest import mock

import appearance
import law_pictures
import matplotlib
import numpy as np
from matplotlib.figure import Figure

import granular_env as ge
import granular_env.envs  # noqa: F401  it registers the environments
from granular_env.colours import DIVERGING
from granular_env.components.chain import theory
from granular_env.viewing.figures import drawing
from granular_env.viewing.recorded_fields import load_fields

DOCS = Path(__file__).parent
IMAGES = DOCS / "images"
_STYLE = {
    "backend": "agg", "savefig.dpi": 110, "font.size": 11.0, "axes.spines.top": False, "axes.spines.right": False,
    "lines.linewidth": 1.7, "legend.frameon": False,
}  # fmt: skip
_COLOURS = 48


@drawing.use_style
def piston() -> None:
    """Draw the x-t diagram of the shipped piston experiment, with the profile at its end (the paper's figure 6)."""
    with tempfile.TemporaryDirectory() as folder:
        result = ge.run("nesterenko-1983/3.4-piston", log=Path(folder) / "piston.mcap")
        [field] = load_fields(ge.open_log(result.log), "velocity", 400)
    figure = drawing.new_figure(8.6, 6.4)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2, 5])
    drawing.draw_space_time(figure, below, field, None)
    above.fill_between(field.coordinates, field.values[-1], color=DIVERGING[-1], alpha=0.2, linewidth=0.0)
    above.plot(field.coordinates, field.values[-1], color=DIVERGING[-1], linewidth=1.2)
    above.set(ylabel="velocity [m/s]", title="A piston at 5 m/s drives a shock front into 200 steel grains")
    above.text(0.01, 0.95, f"at {1e6 * field.times[-1]:.4g} \u00b5s", transform=above.transAxes, va="top")
    appearance.save_figure(figure, IMAGES / "piston.png")


@drawing.use_style
def stationary_waves() -> None:
    """W(y) with its extremes (the paper's figure 1), and the solitary wave's speed: continuum, soliton and the chain itself."""
    figure = drawing.new_figure(9.6, 4.0)
    left, right = figure.subplots(1, 2)
    y = np.linspace(0.0, 1.4, 400)
    for place, (c3, name) in enumerate(((4.0 / 27.0, "4/27"), (0.1, "0.1"))):
        left.plot(y, theory.W(y, c3), **drawing.line_style(place), label=f"C3 = {name}")
        found = np.array(theory.extremes(c3))
        left.plot(found, theory.W(found, c3), "o", color=drawing.line_style(place)["color"])
    left.set(xlabel="y", ylabel="W(y)", title="The potential, y1 and y2")
    ratios = np.geomspace(1.05, 300.0, 200)
    right.semilogx(ratios, theory.speed_ratio(ratios), **drawing.line_style(0), label="(2.4), closed form")
    small = ratios[ratios < 12.0]
    right.semilogx(small, theory.korteweg_de_vries_speed_ratio(small - 1.0), **drawing.line_style(1), label="(2.3), soliton")
    points = np.array([1.563, 3.0, 7.93, 30.0, 185.8])
    chain = [theory.lattice_wave(1.0, ratio - 1.0).speed_ratio for ratio in points]
    right.semilogx(points, chain, "o", color=drawing.line_style(2)["color"], label="the chain")
    right.set(xlabel="largest strain / strain at rest", ylabel="V / c0", title="Speed of the solitary wave")
    for axes in (left, right):
        axes.legend()
    appearance.save_figure(figure, IMAGES / "stationary-waves.png")


@drawing.use_style
def sweep() -> None:
    """Draw the shipped sweep: a solitary wave's speed against its amplitude, and its difference from the lattice's wave."""
    with tempfile.TemporaryDirectory() as folder:
        table = ge.run_sweep("solitary-wave-speed", Path(folder) / "sweep", engine="serial").table
    amplitudes, speeds = table["amplitude"].to_numpy(), table["speed"].to_numpy()
    figure = drawing.new_figure(9.6, 4.0)
    left, right = figure.subplots(1, 2)
    wave = _solitary_speeds(amplitudes)
    left.loglog(amplitudes, wave, **drawing.line_style(0), label="the lattice's wave, V ~ v^(1/5)")
    left.loglog(amplitudes, speeds, "o", color=drawing.line_style(1)["color"], label="the tasks of the sweep")
    left.set(xlabel="amplitude v [m/s]", ylabel="speed V [m/s]", title="Speed of the solitary wave")
    left.set_yticks([250, 500, 1000], ["250", "500", "1000"])
    left.minorticks_off()
    left.legend()
    right.axhline(0.0, **drawing.line_style(0))
    right.semilogx(amplitudes, 1e6 * (speeds / wave - 1.0), "o", color=drawing.line_style(1)["color"])
    right.set(xlabel="amplitude v [m/s]", ylabel="difference [millionths of V]", title="From the lattice's wave")
    appearance.save_figure(figure, IMAGES / "sweep-speed.png")


def _solitary_speeds(amplitudes: np.ndarray) -> np.ndarray:
    """Return the speeds of waves without precompression [m/s] in the paper's grains: k/m = 5.6e12 N/(m^1.5 kg), 6 mm."""
    return theory.SOLITARY_SPEED * 6e-3 * 5.6e12**0.4 * amplitudes**0.2


def draw_page(page: str, colours: int = _COLOURS) -> None:
    """Draw a page's pictures by running the code on the page; with few colours, for small files."""
    blocks = re.findall(r"^```python\n(.*?)^```$", (DOCS / f"{page}.md").read_text(), re.MULTILINE | re.DOTALL)
    last = max(place for place, block in enumerate(blocks) if "savefig" in block)
    drawn: dict[str, Figure] = {}

    def keep(figure: Figure, name: str, **_: object) -> None:
        drawn[name] = figure

    folder = tempfile.TemporaryDirectory()
    with folder as logs, contextlib.chdir(logs), matplotlib.rc_context(_STYLE), mock.patch.object(Figure, "savefig", keep):
        names: dict[str, object] = {}
        for block in blocks[: last + 1]:
            exec(block, names)
    for name, figure in drawn.items():
        appearance.save_figure(figure, IMAGES / f"{page}-{name}", 110, colours)


@drawing.use_style
def control() -> None:
    """Draw the drives that the code of the page on control finds, and the remaining motion of the chain."""
    blocks = re.findall(r"^```python\n(.*?)^```$", (DOCS / "control.md").read_text(), re.MULTILINE | re.DOTALL)
    last = max(place for place, block in enumerate(blocks) if "by_evolution" in block)
    names: dict[str, Any] = {}
    with contextlib.redirect_stdout(None):
        for block in blocks[: last + 1]:
            exec(block, names)
    found = {
        "by hand": names["by_hand"], "by theory": np.array(names["actions"]), "by gradient": names["by_gradient"],
        "by evolution": names["by_evolution"],
    }  # fmt: skip
    env, scale = names["env"], 1000.0
    time = np.arange(100) * env.duration * 1e6
    figure = drawing.new_figure(11.0, 5.0)
    above, below = figure.subplots(2, len(found), sharey="row")
    for place, (name, actions) in enumerate(found.items()):
        distance = -names["score"](actions)
        above[place].step(time, scale * actions, where="post", **drawing.line_style(0))
        above[place].set(title=f"{name}: {distance:.1g}", xlabel="time [us]")
        below[place].bar(range(32), env.component.get("velocity"), width=1.0, color=drawing.line_style(1)["color"])
        below[place].set(xlabel="grain, at the deadline")
    above[0].set_ylabel("force [N]")
    below[0].set_ylabel("velocity [m/s]")
    appearance.save_figure(figure, IMAGES / "control.png")


if __name__ == "__main__":
    piston()
    draw_page("tutorial")
    draw_page("measurement")
    draw_page("seam", 200)
    stationary_waves()
    control()
    sweep()
    law_pictures.draw_laws()
