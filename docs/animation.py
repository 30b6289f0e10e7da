"""Draw the moving picture of README.md and of the first page from a log: ``python docs/animation.py``."""

import tempfile
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from PIL import Image

import granular_env as ge
from granular_env.colours import diverging_colours
from granular_env.recording import Log

IMAGES = Path(__file__).parent / "images"
# Ink and paper of a light and of a dark page.
PAGES = {"": ("#202124", "#ffffff"), "-dark": ("#e2e4e9", "#1e2129")}
FRAMES, FRAME_SECONDS, COLOURS = 90, 0.05, 48
# Displacements are a few thousandths of a diameter; this factor makes them visible.
EXAGGERATION = 12.0


def four_grains(folder: Path) -> Log:
    """Run the paper's experiment 3.1 with four striking grains on a chain of 80, and return its log."""
    log = folder / "four-grains.mcap"
    ge.run(
        "nesterenko-1983/3.1-four-grains", overrides={"component.grains": 80, "duration": 7.2e-4, "record.every": 8e-6}, log=log
    )
    return ge.open_log(log)


def draw_frames(log: Log, ink: str, paper: str) -> list[Image.Image]:
    """Return the frames: the row of grains above, the velocity of each below."""
    times, velocity = log.series("velocity")
    displacement = log.series("displacement")[1]
    diameter = 6e-3
    count = velocity.shape[1]
    with matplotlib.rc_context({"text.color": ink, "axes.labelcolor": ink, "xtick.color": ink, "ytick.color": ink,
                                "axes.edgecolor": ink, "font.size": 10.0}):  # fmt: skip
        figure = Figure(figsize=(9.0, 2.9), dpi=90, facecolor=paper, layout="constrained")
        row, profile = figure.subplots(2, 1, height_ratios=(1.0, 3.4), sharex=True)
        places = np.arange(count, dtype=float)
        offsets = np.column_stack([places, np.zeros(count)])
        grains = EllipseCollection(
            np.ones(count), np.ones(count), np.zeros(count), units="x", offsets=offsets, offset_transform=row.transData,
            edgecolors=ink, linewidths=0.4,
        )  # fmt: skip
        row.add_collection(grains)
        row.set(xlim=(-3.0, count + 7.0), ylim=(-1.0, 1.0))
        row.axis("off")
        (line,) = profile.plot(places, velocity[0], color="#d55e00", marker="o", markersize=2.6, linewidth=1.2)
        profile.set(ylim=(-0.4, 7.2), xlabel="grain", ylabel="velocity [m/s]", facecolor=paper)
        profile.spines[["top", "right"]].set_visible(False)
        clock = profile.text(0.985, 0.86, "", transform=profile.transAxes, ha="right")
        canvas, pictures = FigureCanvasAgg(figure), []
        for index in np.linspace(0, len(times) - 1, FRAMES).round().astype(int):
            offsets[:, 0] = places + EXAGGERATION * displacement[index] / diameter
            grains.set_offsets(offsets)
            grains.set_facecolors(diverging_colours(velocity[index], 6.0) / 255.0)
            line.set_ydata(velocity[index])
            clock.set_text(f"{times[index] * 1e6:.0f} us")
            canvas.draw()
            pictures.append(Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy()))
    return pictures


def write_gif(pictures: list[Image.Image], path: Path) -> None:
    """Write an endless GIF whose frames share one palette; it rests on the last frame."""
    some = np.vstack([np.asarray(picture) for picture in pictures[:: FRAMES // 9]])
    palette = Image.fromarray(some).quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE)
    flat = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    durations = [round(1000 * FRAME_SECONDS)] * (len(flat) - 1) + [1200]
    flat[0].save(path, save_all=True, append_images=flat[1:], duration=durations, loop=0, optimize=True)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        recorded = four_grains(Path(place))
        for suffix, (ink, paper) in PAGES.items():
            target = IMAGES / f"four-grains{suffix}.gif"
            write_gif(draw_frames(recorded, ink, paper), target)
            print(target, target.stat().st_size)
