"""Draws the picture of the kinds of figures in viewing.md: ``python docs/plots.py``."""

import tempfile
from pathlib import Path

import appearance
from matplotlib.figure import Figure
from PIL import Image

import granular_env as ge
from granular_env.recording.log import Log

IMAGE = Path(__file__).parent / "images" / "plot-kinds.png"
# Width of one of the four figures [pixel], colours of the picture.
WIDTH, COLOURS = 580, 160


def run(experiment: str, folder: Path, **overrides: str) -> Log:
    """Return the log of a shipped experiment."""
    result = ge.run(experiment, log=folder / f"{experiment.rpartition('/')[2]}.mcap", overrides=overrides)
    assert result.log is not None
    return ge.open_log(result.log)


def four_figures(folder: Path) -> list[Figure]:
    """Return a map, the dispersion and two spectra of a chain, and the histories of a log and its branch."""
    with run("psakhie-2003/brazilian-disc", folder) as log:
        disc = ge.viewing.plot(log, "damage", at=[1.2e-4, 1.3e-4])
    with run("chains/dimer-band-gap", folder) as log:
        dispersion = ge.viewing.plot(log, "velocity", "dispersion")
        spectra = ge.viewing.plot(log, "velocity", "spectrum", indices=[50])
        spectra.axes[0].set_xlim(0.0, 7.0)
    with run("nesterenko-1983/3.4-piston-20", folder, name="parent") as log:
        branch = log.branch(5e-5).component
        with ge.record(branch, folder / "branch.mcap", every=1e-6):
            branch.step(1.5e-4, left_velocity=2.5)
        with ge.open_log(folder / "branch.mcap") as other:
            histories = ge.viewing.plot([log, other], "velocity", "histories", indices=[5, 10])
    return [disc, dispersion, histories, spectra]


def join_pictures(paths: list[Path]) -> Image.Image:
    """Return four pictures in two columns, on the background of the first one."""
    pictures = [Image.open(path).convert("RGB") for path in paths]
    pictures = [one.resize((WIDTH, round(one.height * WIDTH / one.width)), Image.Resampling.LANCZOS) for one in pictures]
    heights = [max(one.height for one in pictures[row : row + 2]) for row in (0, 2)]
    joined = Image.new("RGB", (2 * WIDTH, sum(heights)), pictures[0].getpixel((0, 0)))
    for place, one in enumerate(pictures):
        joined.paste(one, (place % 2 * WIDTH, place // 2 * heights[0]))
    return joined.quantize(COLOURS, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)


def main() -> None:
    """Draw the picture for light and for dark pages."""
    with tempfile.TemporaryDirectory() as name:
        paths = [Path(name) / f"{place}.png" for place in range(4)]
        for path, figure in zip(paths, four_figures(Path(name)), strict=True):
            appearance.save_figure(figure, path, keep_maps=True)
        join_pictures(paths).save(IMAGE, optimize=True)
        dark = [path.with_stem(f"{path.stem}-dark") for path in paths]
        join_pictures(dark).save(IMAGE.with_stem(f"{IMAGE.stem}-dark"), optimize=True)


if __name__ == "__main__":
    main()
