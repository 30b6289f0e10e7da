"""What the figures share: style, axes, units, pixels."""

from __future__ import annotations

import functools
import io
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np
import numpy.typing as npt

from granular_env.components.errors import ParameterError

from .colours import DIVERGING, PALETTE, symmetric_limit
from .extras import needed
from .footage import Curve, Motion

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]
Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

_LINE_STYLES = ("-", "--", "-.", ":")
_ROWS = 800
_STYLE = {
    "font.size": 11.0, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.alpha": 0.25,
    "axes.titlelocation": "left", "legend.frameon": False, "lines.linewidth": 1.7,
}  # fmt: skip
DARK = {
    "figure.facecolor": "#0d1011", "axes.facecolor": "#0d1011", "text.color": "#e0e0e0", "axes.labelcolor": "#e0e0e0",
    "xtick.color": "#c0c0c0", "ytick.color": "#c0c0c0", "axes.edgecolor": "#707070", "font.size": 12.0,
}  # fmt: skip


def styled(draw: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """A drawing function that runs in our style and leaves matplotlib's settings alone."""

    @functools.wraps(draw)
    def inside(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        with needed("matplotlib", "figures").rc_context(_STYLE):
            return draw(*args, **kwargs)

    return inside


def new_figure(width: float, height: float) -> Figure:
    """An empty figure [inch], outside pyplot."""
    return needed("matplotlib.figure", "figures").Figure(figsize=(width, height), layout="constrained")


def canvas(figure: Figure, dots_per_inch: int) -> FigureCanvasAgg:
    """The figure, drawn into pixels."""
    figure.set_dpi(dots_per_inch)
    drawn = needed("matplotlib.backends.backend_agg", "figures").FigureCanvasAgg(figure)
    drawn.draw()
    return drawn


def png(figure: Figure, dots_per_inch: int = 130) -> bytes:
    """A figure as the bytes of a PNG file; the same figure gives the same bytes."""
    buffer = io.BytesIO()
    figure.set_dpi(dots_per_inch)
    needed("matplotlib.backends.backend_agg", "figures").FigureCanvasAgg(figure).print_png(buffer, metadata={"Software": None})
    return buffer.getvalue()


def draw_space_time(figure: Figure, axes: Axes, motion: Motion, limit: float | None) -> None:
    """The colouring quantity of every particle (across) at every instant (up), with its colour bar."""
    colors = needed("matplotlib.colors", "figures")
    values = coloured(motion)
    limit = limit or symmetric_limit(values)
    scale, unit = time_unit(span(motion))
    start, end = float(motion.times[0]) * scale, float(motion.times[-1]) * scale
    image = axes.imshow(
        _evenly_timed(motion, values),
        origin="lower", aspect="auto", interpolation="nearest", vmin=-limit, vmax=limit,
        cmap=colors.LinearSegmentedColormap.from_list("granular", DIVERGING),
        extent=(-0.5 * motion.every, (values.shape[1] - 0.5) * motion.every, start, end if end > start else start + 1.0),
    )  # fmt: skip
    axes.grid(False)
    axes.xaxis.set_major_locator(needed("matplotlib.ticker", "figures").MaxNLocator(integer=True))
    axes.set(xlabel=particle_axis(motion), ylabel=f"time [{unit}]")
    figure.colorbar(image, ax=axes, label=quantity(motion), pad=0.02)


def _evenly_timed(motion: Motion, values: FloatArray) -> FloatArray:
    """Rows at even instants: at each the latest frame that is not later."""
    if len(motion.times) < 2:
        return values
    instants = np.linspace(motion.times[0], motion.times[-1], min(_ROWS, max(2, 4 * len(motion.times))))
    rows = np.searchsorted(motion.times, instants * (1.0 + 1e-12), side="right") - 1
    return values[np.clip(rows, 0, len(values) - 1)]


def draw_curves(axes: Axes, curves: Sequence[Curve], label: str) -> None:
    """Scalars in time, with a legend."""
    scale, unit = time_unit(max(float(curve.times[-1]) for curve in curves if len(curve.times)))
    for place, curve in enumerate(curves):
        axes.plot(*broken(curve.times * scale, curve.values, curve.cuts), label=curve.name.replace("_", " "), **line(place))
    axes.set(xlabel=f"time [{unit}]", ylabel=label)
    axes.margins(x=0.0)
    if len(curves) > 1:
        legend(axes)


def broken(times: FloatArray, values: FloatArray, cuts: npt.NDArray[np.int64]) -> tuple[FloatArray, FloatArray]:
    """Times and values with NaN before each cut, so that no line is drawn across it."""
    return np.insert(times, cuts, times[cuts]), np.insert(values, cuts, np.nan)


def line(place: int) -> dict[str, Any]:
    """Colour and dashes of the n-th line: no two lines are told apart by colour alone."""
    return {"color": PALETTE[place % len(PALETTE)], "linestyle": _LINE_STYLES[place % len(_LINE_STYLES)]}


def legend(axes: Axes) -> None:
    """A legend beside the axes, where it hides nothing."""
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)


def markers(motion: Motion) -> dict[str, Any]:
    """A dot on each particle, while they can be told apart."""
    return {"marker": "o", "markersize": 3} if len(motion.radius) <= 60 else {}


def coloured(motion: Motion) -> FloatArray:
    """The colouring quantity, shape (frames, n); `ParameterError` where it was not recorded."""
    if motion.colour is None:
        name = motion.colour_variable.name
        raise ParameterError(f"{name!r} was not recorded, so it cannot be drawn; add it to the recorded variables")
    return motion.colour


def quantity(motion: Motion) -> str:
    """Label of the colouring quantity."""
    return f"{motion.colour_variable.name.replace('_', ' ')} [{motion.colour_variable.unit}]"


def particle_axis(motion: Motion) -> str:
    """Label of the axis along the particles."""
    return "grain (0 is the left end)" if motion.every == 1 else f"grain (0 is the left end; each {motion.every}th is shown)"


def indices(motion: Motion) -> npt.NDArray[np.int64]:
    """Number of each particle that is shown."""
    return np.arange(len(motion.radius)) * motion.every


def span(motion: Motion) -> float:
    """The last instant [s]."""
    return float(motion.times[-1])


def time_unit(duration: float) -> tuple[float, str]:
    """Factor and name of the unit in which a duration [s] reads well."""
    for factor, unit, least in ((1.0, "s", 1.0), (1e3, "ms", 1e-3), (1e6, "\u00b5s", 1e-6)):
        if duration >= least:
            return factor, unit
    return 1e9, "ns"
