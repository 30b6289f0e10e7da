"""The keys below a picture of a body: scale bar, displacement factor, samples of overlays, colour bars."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D
from matplotlib.offsetbox import AnchoredOffsetbox, AuxTransformBox, HPacker, OffsetBox, TextArea, VPacker

from granular_env.components.support.round_numbers import round_down_to_125

from ..unit_labels import scaled_unit
from .colour_bar import fill_with_colour_bars

if TYPE_CHECKING:
    from .plane import Plane

# Largest length of the scale bar, as a fraction of the picture's width.
_LENGTH_PART = 0.25
# Heights of a row of keys and of a labelled colour bar [inch]; gaps between keys, and between a sample and its label [point].
_ROW, _BAR, _GAP, _SEPARATION = 0.27, 0.72, 18.0, 5.0
_FONT_SIZE = 10.0


def keys_height(plane: Plane, bars: bool = True) -> float:
    """Return the height of the keys with or without colour bars [inch]."""
    return _ROW * (1 + len(plane.overlays)) + 0.1 + (_BAR * len(plane.colour_scales) if bars else 0.0)


def draw_keys(figure: Figure | SubFigure, axes: Axes, plane: Plane, bars: bool = True) -> None:
    """Fill a figure with the keys of a picture.

    Args:
        figure: an empty figure of the height `keys_height`.
        axes: axes of the picture, which give the samples their lengths.
        plane: what the picture shows.
        bars: whether to draw colour bars.
    """
    scales = plane.colour_scales if bars else ()
    if scales:
        figure, below = figure.subfigures(
            2, 1, squeeze=False, height_ratios=[keys_height(plane, bars=False), _BAR * len(scales)]
        ).flat
        fill_with_colour_bars(below, scales)
    samples = [[_scale_bar(axes, plane)], *(overlay.key() for overlay in plane.overlays)]
    rows = [[_labelled_sample(axes, *one) for one in row] for row in samples]
    rows[0] += [_text(one) for one in displacement_notes(plane)]
    lines: list[Artist] = [HPacker(children=[*row], align="center", pad=0.0, sep=_GAP) for row in rows]
    box = VPacker(children=lines, align="left", pad=0.0, sep=3.0)
    place = {"bbox_to_anchor": (0.01, 1.0), "bbox_transform": figure.transSubfigure}
    figure.add_artist(AnchoredOffsetbox("upper left", child=box, frameon=False, pad=0.0, borderpad=0.2, **place))


def _scale_bar(axes: Axes, plane: Plane) -> tuple[Artist, str]:
    low, high = plane.bounding_box
    length = round_down_to_125(_LENGTH_PART * float(high[0] - low[0]))
    factor, unit = scaled_unit("m", length)
    bar = Line2D([0.0, length], [0.0, 0.0], color=axes.title.get_color(), linewidth=1.5, solid_capstyle="butt")
    return bar, f"{factor * length:g} {unit}"


def displacement_notes(plane: Plane) -> list[str]:
    """Return the displacement factor and the names of shapes without recorded displacements, as texts for a picture."""
    factor, still = plane.scales.exaggeration, plane.scene.unmoved_shapes
    notes = [] if factor == 1.0 else [f"displacements \u00d7 {factor:,.12g}".replace(",", "\u2009")]
    return notes + ([f"{', '.join(still)}: initial positions"] if still else [])


def _labelled_sample(axes: Axes, sample: Artist, label: str) -> OffsetBox:
    drawn = AuxTransformBox(axes.transData)
    drawn.add_artist(sample)
    return HPacker(children=[drawn, _text(label)], align="center", pad=0.0, sep=_SEPARATION)


def _text(label: str) -> TextArea:
    return TextArea(label, textprops={"fontsize": _FONT_SIZE})
