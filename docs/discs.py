"""Draws the picture of contract.md: ``python docs/discs.py``."""

from pathlib import Path

import appearance
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.patches import Circle, Rectangle

from granular_env.components.discs import Discs
from granular_env.viewing.figures import drawing

IMAGES = Path(__file__).parent / "images"
TIMES = (0.0, 0.04, 0.08, 0.16)


def show_discs(axes: Axes, discs: Discs) -> None:
    """Draw the box, the discs coloured by speed, and the links that hold."""
    points, links = discs.drawables()
    centres = points.reference + discs.get("displacement")
    shown = PatchCollection([Circle(tuple(centre), radius) for centre, radius in zip(centres, points.radius, strict=True)])
    shown.set(array=discs.get("speed"), clim=(0.0, 0.8), cmap="Blues", edgecolor="0.35")
    axes.add_patch(Rectangle((0.0, 0.0), *discs.box, fill=False, linewidth=1.5))
    axes.add_collection(shown)
    axes.add_collection(LineCollection(list(centres[links.pairs[discs.get("linked") > 0.0]]), colors="#c1121f", linewidths=2.0))
    axes.set(xlim=(0.0, discs.box[0]), ylim=(0.0, discs.box[1]), aspect="equal", xticks=[], yticks=[])
    axes.set_title(f"{discs.time * 1e3:.0f} ms, {discs.get('broken_links'):.0f} broken links")


@drawing.use_style
def draw_breaking_block() -> None:
    """Draw a block of discs that breaks."""
    figure = drawing.new_figure(11.0, 2.9)
    discs = Discs(rows=3, columns=4, clearance=0.02)
    discs.reset(velocity={0: (1.0, 0.0), 8: (-1.0, 0.5)})
    for axes, time in zip(np.ravel(figure.subplots(1, len(TIMES))), TIMES, strict=True):
        if time > 0.0:
            discs.step(time - discs.time)
        show_discs(axes, discs)
    appearance.save_figure(figure, IMAGES / "discs.png")


if __name__ == "__main__":
    draw_breaking_block()
