"""A figure as SVG that takes its colours from the page: it is light or dark with the page, and scales with it."""

from __future__ import annotations

from html import escape

import numpy as np
import numpy.typing as npt

from .model import Curve, Figure, Mark
from .scales import Scale, horizontal, vertical

_WIDTH, _HEIGHT = 480.0, 300.0
_RIGHT, _TOP, _BOTTOM = 14.0, 12.0, 44.0
_LETTER = 6.6
PALETTE = 6


def svg(figure: Figure) -> str:
    """The drawing; its style sheet is `page`'s."""
    y = vertical(figure, _HEIGHT - _BOTTOM, _TOP)
    # Beside the names of the ticks there is room for the axis' own.
    left = max(_LETTER * len(name) for _, name in y.ticks) + 30.0
    x = horizontal(figure, left, _WIDTH - _RIGHT)
    clip = f"clip-{escape(figure.name, quote=True)}"
    inside = "".join(_curve(curve, x, y) for curve in figure.curves)
    marks = "".join(_mark(mark, number, x, y) for number, mark in enumerate(figure.marks))
    return (
        f'<svg viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" role="img" aria-label="{escape(figure.title, quote=True)}">'
        f'<clipPath id="{clip}"><rect x="{left:g}" y="{_TOP:g}" width="{_WIDTH - left - _RIGHT:g}" '
        f'height="{_HEIGHT - _TOP - _BOTTOM:g}"/></clipPath>'
        f'{_axes(figure, x, y)}<g clip-path="url(#{clip})">{inside}</g>{marks}</svg>'
    )


def legend(figure: Figure) -> str:
    """Names of the curves beside samples of them, and the paper's sign where the figure has marks, as HTML."""
    entries = [
        f'<span class="key"><i class="sample {curve.style} c{curve.colour % PALETTE}"></i>{escape(curve.label)}</span>'
        for curve in figure.curves
        if curve.label
    ]
    kinds = {"point" if mark.x is not None and mark.y is not None else "across" for mark in figure.marks}
    if kinds:
        samples = "".join(f'<i class="sample mark {kind}"></i>' for kind in sorted(kinds))
        entries.append(f'<span class="key">{samples}stated in the paper</span>')
    return f'<div class="legend">{"".join(entries)}</div>' if entries else ""


def _axes(figure: Figure, x: Scale, y: Scale) -> str:
    left, bottom, right = x.start, _HEIGHT - _BOTTOM, _WIDTH - _RIGHT
    parts = []
    for value, name in x.ticks:
        if x.holds(value):
            at = float(x.place(value))
            parts.append(f'<path class="grid" d="M{at:.1f} {_TOP:g}V{bottom:g}"/>')
            parts.append(f'<text class="tick" x="{at:.1f}" y="{bottom + 16:g}" text-anchor="middle">{escape(name)}</text>')
    for value, name in y.ticks:
        if y.holds(value):
            at = float(y.place(value))
            parts.append(f'<path class="grid" d="M{left:g} {at:.1f}H{right:g}"/>')
            parts.append(f'<text class="tick" x="{left - 6:g}" y="{at + 4:.1f}" text-anchor="end">{escape(name)}</text>')
    middle, centre = 0.5 * (left + right), 0.5 * (_TOP + bottom)
    parts.append(f'<path class="axis" d="M{left:g} {_TOP:g}V{bottom:g}H{right:g}"/>')
    parts.append(f'<text class="label" x="{middle:g}" y="{_HEIGHT - 8:g}" text-anchor="middle">{escape(figure.x.label)}</text>')
    parts.append(
        f'<text class="label" transform="translate(13 {centre:g}) rotate(-90)" text-anchor="middle">'
        f"{escape(figure.y.label)}</text>"
    )
    return "".join(parts)


def _curve(curve: Curve, x: Scale, y: Scale) -> str:
    across, up = (scale.place(values) for scale, values in zip((x, y), curve.points(), strict=True))
    style = f"{curve.style} c{curve.colour % PALETTE}"
    if curve.style == "points":
        shown = np.isfinite(across) & np.isfinite(up)
        # Dots of no length with round caps: one path, however many points.
        dots = "".join(f"M{px:.1f} {py:.1f}h0" for px, py in zip(across[shown], up[shown], strict=True))
        return f'<path class="{style}" d="{dots}"/>'
    return f'<path class="{style}" d="{_path(across, up, curve.style == "steps")}"/>'


def _path(across: npt.NDArray[np.float64], up: npt.NDArray[np.float64], steps: bool) -> str:
    """A polyline of tenths of a unit, broken at NaN; points that fall onto the one before are left out."""
    parts, before = [], None
    pen_down = False
    for px, py in zip(np.round(across, 1).tolist(), np.round(up, 1).tolist(), strict=True):
        if px != px or py != py:
            pen_down, before = False, None
        elif (px, py) != before:
            parts.append(f"{'L' if pen_down else 'M'}{px:g} {py:g}" if not (steps and pen_down) else f"H{px:g}V{py:g}")
            pen_down, before = True, (px, py)
    return "".join(parts)


def _mark(mark: Mark, number: int, x: Scale, y: Scale) -> str:
    """The paper's number, labelled; one that lies outside of the axes is not drawn."""
    if (mark.x is not None and not x.holds(mark.x)) or (mark.y is not None and not y.holds(mark.y)):
        return ""
    if mark.x is not None and mark.y is not None:
        px, py = float(x.place(mark.x)), float(y.place(mark.y))
        shape = f'<path class="mark point" d="M{px:.1f} {py - 6:.1f}l6 6l-6 6l-6 -6z"/>'
        return shape + _name(mark.label, px + 8.0, py - 6.0)
    if mark.y is not None:
        py = float(y.place(mark.y))
        shape = f'<path class="mark" d="M{x.start:g} {py:.1f}H{_WIDTH - _RIGHT:g}"/>'
        return shape + _name(mark.label, _WIDTH, py - 4.0 if py > _TOP + 16.0 else py + 12.0)
    assert mark.x is not None
    px = float(x.place(mark.x))
    shape = f'<path class="mark" d="M{px:.1f} {_TOP:g}V{_HEIGHT - _BOTTOM:g}"/>'
    return shape + _name(mark.label, px + 4.0, _TOP + 11.0 + 13.0 * (number % 4))


def _name(label: str, left: float, base: float) -> str:
    """A mark's label, moved to the left where it would leave the drawing."""
    long = _LETTER * len(label)
    left = max(40.0, min(left, _WIDTH - _RIGHT - long - 2.0))
    return f'<text class="marked" x="{left:.1f}" y="{base:.1f}">{escape(label)}</text>' if label else ""
