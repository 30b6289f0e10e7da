"""Pictures for light and for dark pages: one figure, saved twice, as ``NAME.png`` and ``NAME-dark.png``."""

import colorsys
import io
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import Collection
from matplotlib.colors import Colormap, ListedColormap, to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text
from PIL import Image

from granular_env.viewing.figures import drawing

# Colours of light pages and their counterparts on dark pages.
DARK = {"#000000": "#e2e4e9", "#ffffff": "#1e2129", "#cccccc": "#4a4d57"}


def save_figure(
    figure: Figure, path: Path, dots_per_inch: int = 130, colours: int | None = None, keep_maps: bool = False
) -> None:
    """Write a figure for light pages to `path`, and one for dark pages next to it.

    Args:
        figure: drawn in black on white; its colours are those of dark pages afterwards.
        path: ends in ``.png``.
        dots_per_inch: resolution.
        colours: number of colours of the picture, for a small file.
        keep_maps: whether dark pages have the same colour maps as light ones.
    """
    _write_figure(figure, path, dots_per_inch, colours)
    darken_figure(figure, keep_maps)
    _write_figure(figure, path.with_stem(f"{path.stem}-dark"), dots_per_inch, colours)


def darken_figure(figure: Figure, keep_maps: bool = False) -> None:
    """Exchange black and white in all that is drawn in them and, unless `keep_maps`, the lightness of colour maps."""
    figure.set_facecolor(DARK["#ffffff"])
    for text in figure.findobj(Text):
        text.set_color(_dark_colour(text.get_color()))
    for line in figure.findobj(Line2D):
        for part in ("color", "markeredgecolor", "markerfacecolor"):
            getattr(line, f"set_{part}")(_dark_colour(getattr(line, f"get_{part}")()))
    for patch in figure.findobj(Patch):
        patch.set(facecolor=_dark_colour(patch.get_facecolor()), edgecolor=_dark_colour(patch.get_edgecolor()))
    for axes in figure.findobj(Axes):
        axes.set_facecolor(_dark_colour(axes.get_facecolor()))
        axes.tick_params(color=DARK["#000000"], labelcolor=DARK["#000000"], which="both")
    for image in () if keep_maps else figure.findobj(AxesImage):
        image.set_cmap(_dark_map(image.get_cmap()))
    for marks in figure.findobj(Collection):
        if marks.get_array() is not None and keep_maps:
            continue
        if marks.get_array() is not None:
            marks.set_cmap(_dark_map(marks.get_cmap()))
        elif len(marks.get_facecolor()) == 1:
            # Many colours are data.
            marks.set_facecolor(_dark_colour(tuple(marks.get_facecolor()[0])))
    for legend in figure.findobj(Legend):
        legend.get_frame().set_facecolor(DARK["#ffffff"])


def _dark_colour(colour: object) -> object:
    if isinstance(colour, str) and colour in ("none", "auto"):
        return colour
    if isinstance(colour, tuple) and len(colour) == 4 and colour[3] == 0.0:
        return colour
    return DARK.get(to_hex(colour), colour)


def _dark_map(colours: Colormap) -> ListedColormap:
    """Invert the lightness of a colour map, from white to that of the dark page, and keep its hues."""
    floor = max(to_rgb(DARK["#ffffff"]))
    inverted = []
    for red, green, blue, _ in colours(np.linspace(0.0, 1.0, 256)):
        hue, lightness, saturation = colorsys.rgb_to_hls(red, green, blue)
        dark = floor + (1.0 - floor) * (1.0 - lightness)
        # Keep the chroma, not the saturation, which means little near white.
        chroma = saturation * (1.0 - abs(2.0 * lightness - 1.0))
        inverted.append(colorsys.hls_to_rgb(hue, dark, min(1.0, chroma / max(1.0 - abs(2.0 * dark - 1.0), 1e-9))))
    return ListedColormap(inverted, f"{colours.name}-dark")


def _write_figure(figure: Figure, path: Path, dots_per_inch: int, colours: int | None) -> None:
    data = drawing.to_png(figure, dots_per_inch)
    if colours is None:
        path.write_bytes(data)
    else:
        Image.open(io.BytesIO(data)).convert("RGB").quantize(
            colours, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE
        ).save(path, optimize=True)
