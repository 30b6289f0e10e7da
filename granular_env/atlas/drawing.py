"""A figure as SVG, drawn by matplotlib, in colours of the page: light or dark with it."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, Any, Literal

from granular_env.colours import PALETTE
from granular_env.optional_packages import import_optional
from granular_env.viewing.figures.drawing import PAPER, new_figure, svg, with_style

from .model import Axis, CurveStyle, Figure, Mark
from .plane import draw_arrows, draw_letter, draw_shading, height_of_plane

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D
    from matplotlib.text import Annotation

# Of a drawing [pt], and points of an inch.
_WIDTH, _HEIGHT, _INCH = 480.0, 300.0, 72.0
_TICKS, _DIM, _GRID = 7, "#595959", "#b0b0b0"
_SETTINGS = {
    "font.size": 12.0, "axes.labelsize": 12.5, "axes.edgecolor": _DIM, "axes.axisbelow": True, "axes.xmargin": 0.0,
    "axes.ymargin": 0.04, "axes.formatter.limits": (-4, 5), "xtick.color": _GRID,
    "ytick.color": _GRID, "xtick.labelcolor": _DIM, "ytick.labelcolor": _DIM, "grid.color": _GRID, "grid.alpha": 1.0,
    "lines.solid_capstyle": "round", "lines.solid_joinstyle": "round",
}  # fmt: skip
_LINES: dict[CurveStyle, dict[str, Any]] = {
    "line": {},
    "steps": {"drawstyle": "steps-post"},
    "dashed": {"dashes": (5.0 / 1.7, 4.0 / 1.7)},
    "thin": {"linewidth": 0.8, "alpha": 0.55},
    "points": {"linestyle": "none", "marker": "o", "markersize": 4.5, "markeredgewidth": 0.0, "alpha": 0.85},
    "bar": {"linewidth": 9.0, "alpha": 0.35, "solid_capstyle": "butt"},
}
# Names of vertical lines stand below each other [pt].
_LINE_OF_TEXT, _ROWS = 13.0, 4


def draw(figure: Figure) -> str:
    """Return a figure as a part of the page; the same figure gives the same text.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    drawn = svg(_drawing(figure), figure.name)
    return drawn.replace("<svg", f'<svg role="img" aria-label="{escape(figure.title)}"', 1)


@with_style
def _drawing(figure: Figure) -> Any:
    with import_optional("matplotlib", "the atlas").rc_context(_SETTINGS):
        height = height_of_plane(figure, _WIDTH) if figure.equal else _HEIGHT
        drawn = new_figure(_WIDTH / _INCH, height / _INCH)
        axes = drawn.subplots()
        _draw_plane(axes, figure)
        for curve in figure.curves:
            axes.plot(*curve.points(), color=PALETTE[curve.colour % len(PALETTE)], **_LINES[curve.style])
        marks = [(mark, *_draw_mark(axes, mark, number)) for number, mark in enumerate(figure.marks)]
        _scale(axes, "x", figure.x)
        _scale(axes, "y", figure.y)
        if figure.equal:
            axes.set_aspect("equal")
        drawn.draw_without_rendering()
    drawn.set_layout_engine("none")
    for mark, line, name in marks:
        if _holds(axes.get_xlim(), mark.x) and _holds(axes.get_ylim(), mark.y):
            _keep_inside(axes, name)
        else:
            line.remove()
            name.remove()
    return drawn


def _draw_plane(axes: Axes, figure: Figure) -> None:
    """Draw what lies under the curves, and letters."""
    if figure.shading is not None:
        draw_shading(axes, figure.shading)
    if figure.arrows is not None:
        draw_arrows(axes, figure.arrows)
        axes.grid(False)
    for letter in figure.letters:
        draw_letter(axes, letter)


def _scale(axes: Axes, letter: Literal["x", "y"], axis: Axis) -> None:
    """Give one of the axes its label, limits and ticks."""
    low, high = getattr(axes, f"get_{letter}lim")()
    if axis.names:
        getattr(axes, f"set_{letter}ticks")([at for at, _ in axis.names], [_plain(name) for _, name in axis.names])
    else:
        axes.locator_params(axis=letter, nbins=_TICKS, steps=[1, 2, 5, 10])
    # Ticks with names of their own have widened the axes.
    limits = (low if axis.low is None else axis.low, high if axis.high is None else axis.high)
    axes.set(**{f"{letter}label": _plain(axis.label), f"{letter}lim": limits})


def _plain(text: str) -> str:
    """Return text in which a dollar sign begins no formula."""
    return text.replace("$", r"\$")


def _draw_mark(axes: Axes, mark: Mark, number: int) -> tuple[Line2D, Annotation]:
    """Draw the paper's number as a line across the axes or as a point; return that and its name."""
    line: dict[str, Any] = {"color": PAPER, "linewidth": 1.3, "dashes": (2.0 / 1.3, 3.0 / 1.3)}
    name: dict[str, Any] = {
        "text": _plain(mark.label),
        "color": PAPER,
        "fontweight": "bold",
        "textcoords": "offset points",
        "in_layout": False,
    }
    if mark.x is not None and mark.y is not None:
        [point] = axes.plot(mark.x, mark.y, "D", markersize=8.5, mfc="none", mec=PAPER, mew=1.6, clip_on=False)
        return point, axes.annotate(xy=(mark.x, mark.y), xytext=(8.0, 6.0), **name)
    if mark.y is not None:
        place = {"xy": (1.0, mark.y), "xytext": (0.0, 4.0), "xycoords": ("axes fraction", "data"), "ha": "right"}
        return axes.axhline(mark.y, **line), axes.annotate(**place, **name)
    assert mark.x is not None
    below = -11.0 - _LINE_OF_TEXT * (number % _ROWS)
    place = {"xy": (mark.x, 1.0), "xytext": (4.0, below), "xycoords": ("data", "axes fraction")}
    return axes.axvline(mark.x, **line), axes.annotate(**place, **name)


def _holds(limits: tuple[float, float], place: float | None) -> bool:
    return place is None or limits[0] <= place <= limits[1]


def _keep_inside(axes: Axes, name: Annotation) -> None:
    """Move a mark's name to where it does not leave the axes: to the side, or from above the mark to below it."""
    box, room = name.get_window_extent(), axes.bbox
    across = min(room.x1 - box.x1, 0.0) or max(room.x0 - box.x0, 0.0)
    points = 72.0 / axes.figure.dpi
    x, y = name.xyann
    below = box.y1 > room.y1 and y > 0.0
    name.xyann = (x + across * points, -y - box.height * points if below else y)
