"""Drawing functions shared by all figures: style, x-t diagrams, curves, PNG and SVG output."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure, FigureBase
from matplotlib.ticker import MaxNLocator

from granular_env.colours import DIVERGING, PALETTE, symmetric_limit
from granular_env.components.support.float_arrays import FloatArray

from ..curves import Curve
from ..recorded_fields import Field
from ..unit_labels import scaled_label, scaled_unit

# Ignore matplotlib's warnings on missing glyphs, which would print raw characters from a log on the terminal.
warnings.filterwarnings("ignore", r"Glyph \d+")

_LINE_STYLES = ("-", "--", "-.", ":")
_ROWS, _FEW_ROWS = 800, 240
# In an x-t diagram, a frame fills the times up to this many usual intervals away; this covers one missing frame, not two.
_REACH_OF_FRAME = 1.05
# A frame also reaches at most 1/_FEWEST_FRAMES of the diagram up and down, so half as many even frames leave no gap.
_FEWEST_FRAMES = 40
# A curve whose change, relative to its size, is smaller than this counts as constant.
_FLAT = 1e-3
# Legends with longer texts are above the axes [letters].
_LONG_TEXT = 26
# Background of an x-t diagram, visible at times without a frame.
NOT_SAMPLED = "#8b9096"
_STYLE: Any = {
    "font.size": 11.0, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.alpha": 0.25,
    "axes.titlelocation": "left", "axes.formatter.useoffset": False, "legend.frameon": False, "lines.linewidth": 1.7,
    "text.parse_math": False,
}  # fmt: skip
# Decorator of drawing functions: they use our style, without a change of matplotlib's global settings.
use_style: Any = matplotlib.rc_context(_STYLE)
# For each colour of a figure in a file, the colour from the style sheet that replaces it in an HTML page.
_PAGE_COLOURS = {
    "#ffffff": "none", "#000000": "currentColor", "#b0b0b0": "var(--grid)", "#737373": "var(--dim)", "#595959": "var(--dim)",
    **{colour: f"var(--c{place})" for place, colour in enumerate(PALETTE)},
}  # fmt: skip
DARK: Any = {
    "figure.facecolor": "#0d1011", "axes.facecolor": "#0d1011", "text.color": "#e0e0e0", "axes.labelcolor": "#e0e0e0",
    "xtick.color": "#c0c0c0", "ytick.color": "#c0c0c0", "axes.edgecolor": "#707070", "font.size": 12.0,
}  # fmt: skip


class ShownFigure(Figure):
    """A figure that a notebook shows as the result of a cell, without pyplot."""

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png")
        return buffer.getvalue()


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of the given size [inch], of which pyplot does not know."""
    return ShownFigure(figsize=(width, height), layout="constrained")


def render_canvas(figure: Figure, dots_per_inch: float) -> FigureCanvasAgg:
    """Draw the figure into pixels, and return matplotlib's canvas with them."""
    figure.set_dpi(dots_per_inch)
    drawn = FigureCanvasAgg(figure)
    drawn.draw()
    return drawn


def to_png(figure: Figure, dots_per_inch: int = 130) -> bytes:
    """Return a figure as the bytes of a PNG file; equal figures give equal bytes."""
    buffer = io.BytesIO()
    figure.set_dpi(dots_per_inch)
    FigureCanvasAgg(figure).print_png(buffer, metadata={"Software": None})
    # The layout has been computed; skip the layout engine when the figure is drawn again.
    figure.set_layout_engine("none")
    return buffer.getvalue()


def to_svg(figure: Figure, name: str) -> str:
    """Return a figure as SVG for an HTML page, with colours from the page's style sheet; `name` is unique in the page."""
    buffer = io.StringIO()
    figure.set_dpi(150)  # resolution of embedded pictures
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": name}):
        FigureCanvasSVG(figure).print_svg(buffer, metadata={"Date": None, "Creator": None})
    # Omit the header of the file; the page's style sheet sets the colours.
    drawn = buffer.getvalue()
    drawn = drawn[drawn.index("<svg") :]
    drawn = re.sub(r"<metadata>.*?</metadata>|<style[^>]*>.*?</style>|<!--.*?-->|<!DOCTYPE[^>]*>", "", drawn, flags=re.DOTALL)
    drawn = re.sub(r' (?:width|height)="[0-9.]+pt"| xmlns(?::xlink)?="[^"]*"| version="[^"]*"', "", drawn)
    # Round to hundredths of a point, which are finer than any screen.
    drawn = re.sub(r' d="[^"]*"', lambda path: re.sub(r"(\.\d\d)\d+", r"\1", path[0]), drawn)
    used = set(re.findall(r'(?:url\(#|href="#)([^)"]+)', drawn))
    drawn = re.sub(r' id="([^"]*)"', lambda found: found[0] if found[1] in used else "", drawn)
    drawn = re.sub(r"(font(?:-family)?: (?:[0-9.]+px )?)'[^;\"]*", r"\1system-ui, sans-serif", drawn)
    for colour, variable in _PAGE_COLOURS.items():
        drawn = drawn.replace(f": {colour}", f": {variable}")
    return drawn


def draw_space_time(
    figure: FigureBase, axes: Axes, field: Field, limit: float | None, ends: tuple[float, float] | None = None
) -> None:
    """Draw an x-t diagram: the values of a field as colours over places (horizontal) and time (vertical), with a colour bar.

    Times far from any frame stay in a grey that is not part of the colour map.

    Args:
        figure: figure for the colour bar.
        axes: axes to draw in.
        field: the field to draw.
        limit: magnitude of the values at the ends of the colour map; None for the largest magnitude in the field.
        ends: first and last time of the diagram [s]; None for the first and last frame of the field.
    """
    limit = limit or symmetric_limit(field.values)
    factor, label = scaled_label(field.variable.name, field.variable.unit, limit)
    across, axis = field.place_axis
    first, last = ends or (float(field.times[0]), float(field.times[-1]))
    scale, unit = time_unit(last)
    start, end = first * scale, last * scale
    axes.set_facecolor(NOT_SAMPLED)
    image = axes.imshow(
        factor * _resample_evenly(field.times, field.values, first, last),
        origin="lower", aspect="auto", interpolation="nearest", vmin=-factor * limit, vmax=factor * limit,
        cmap=LinearSegmentedColormap.from_list("granular", DIVERGING),
        extent=(across * field.ends[0], across * field.ends[1], start, end if end > start else start + 1.0),
    )  # fmt: skip
    axes.grid(False)
    if field.coordinate is None:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set(xlabel=axis, ylabel=f"time [{unit}]")
    bar = figure.colorbar(image, ax=axes, label=label, pad=0.02)
    if not field.values.any():
        bar.set_ticks([0.0])
    if field.values.size and float(np.nanmin(field.values, initial=0.0)) >= 0.0 and ends is None:
        # If no value is negative, omit the blue half of the bar.
        bar.ax.set_ylim(0.0, factor * limit)


def _resample_evenly(times: FloatArray, values: FloatArray, first: float, last: float) -> FloatArray:
    """Return the rows of `values` at evenly spaced times, each from the nearest frame; NaN where no frame is near."""
    if len(times) < 2:
        return values
    instants = np.linspace(first, last, min(_ROWS, max(_FEW_ROWS, 4 * len(times))))
    frames = nearest_frames(times, instants)
    return np.where((frames >= 0)[:, None], values[frames], np.nan)


def nearest_frames(times: FloatArray, instants: FloatArray) -> npt.NDArray[np.int64]:
    """Return, for each time in `instants`, the index of the nearest frame, or -1 if that frame is too far away.

    A frame covers the times around it, up to the usual frame interval and at most a 20th of the range. A few frames of a
    long run therefore appear as stripes, not as a run at rest in between.

    Args:
        times: times of the frames, ascending, shape (frames,) [s].
        instants: times, ascending, shape (n,) [s].
    """
    frames = np.searchsorted(0.5 * (times[1:] + times[:-1]), instants, side="right")
    gaps = np.diff(times)
    usual = float(np.median(gaps[gaps > 0.0])) if np.any(gaps > 0.0) else np.inf
    reach = min(_REACH_OF_FRAME * usual, (instants[-1] - instants[0]) / _FEWEST_FRAMES)
    near = np.abs(times[frames] - instants) <= reach * (1.0 + 1e-9)
    return np.where(near, frames, -1)


def draw_curves(axes: Axes, curves: Sequence[Curve], name: str, valid_until: float = np.inf, runs: int = 1) -> None:
    """Draw curves of scalars of one unit over time, with a legend; `name` is the name of the vertical axis.

    The curves of equal elements of several runs follow each other.
    """
    scale, unit = time_unit(max(float(curve.times[-1]) for curve in curves if len(curve.times)))
    factor, label = value_scale(name, curves[0].unit, *(curve.values for curve in curves))
    for place, curve in enumerate(curves):
        # No line is drawn across a reset.
        times, values = np.insert(curve.times, curve.cuts, curve.times[curve.cuts]), np.insert(curve.values, curve.cuts, np.nan)
        words = curve.label or curve.name.replace("_", " ")
        axes.plot(scale * times, factor * values, label=words, **line_style(place, runs))
    axes.set(xlabel=f"time [{unit}]", ylabel=label)
    axes.margins(x=0.0)
    _show_zero_of_flat_lines(axes)
    if np.isfinite(end := valid_until * scale):
        axes.axvline(end, color=DIVERGING[-1], linewidth=0.8)
        axes.text(end, 0.98, " not valid", transform=axes.get_xaxis_transform(), va="top", color=DIVERGING[-1], fontsize=9)
    if len(curves) > 1 or curves[0].label:
        add_legend(axes)


def value_scale(name: str, unit: str, *values: FloatArray) -> tuple[float, str]:
    """Return the factor of values in a figure, and the label of their axis: name and suitable unit."""
    return scaled_label(name, unit, max(float(np.abs(one).max(initial=0.0, where=np.isfinite(one))) for one in values))


def _show_zero_of_flat_lines(axes: Axes) -> None:
    """Include zero in the value axis of nearly constant lines, because a narrow range would show rounding errors enlarged."""
    values = np.concatenate([np.asarray(line.get_ydata(), np.float64) for line in axes.lines])
    values = values[np.isfinite(values)]
    if not values.size or float(np.ptp(values)) > _FLAT * float(np.abs(values).max()):
        return
    largest = float(values[np.abs(values).argmax()])
    if largest != 0.0:
        axes.set_ylim(*sorted((0.0, 1.25 * largest)))


def line_style(place: int, runs: int = 1) -> dict[str, Any]:
    """Return colour and dashes of the line number `place`; with several runs, elements differ by colour, runs by dashes."""
    dashes = place % runs if runs > 1 else place
    return {"color": PALETTE[place // runs % len(PALETTE)], "linestyle": _LINE_STYLES[dashes % len(_LINE_STYLES)]}


def add_legend(axes: Axes) -> None:
    """Add a legend to the right of the axes or, if its texts are long, above axes without a title."""
    longest = max((len(text) for text in axes.get_legend_handles_labels()[1]), default=0)
    if longest <= _LONG_TEXT or axes.get_title(loc="left"):
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
    else:
        place, columns = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0)}, 1 if longest > 1.5 * _LONG_TEXT else 2
        axes.legend(**place, borderaxespad=0.2, ncols=columns, fontsize="small")


def time_unit(duration: float) -> tuple[float, str]:
    """Return a suitable unit for times up to a duration [s]: the factor from seconds, and the unit's name."""
    return scaled_unit("s", duration)
