"""Pictures of the outer surface, rolled out: equivalent stress as a shade, cracks as lines."""

from __future__ import annotations

import numpy as np

from granular_env.atlas.model import Axis, Curve, Figure, Shading
from granular_env.components.support.float_arrays import FloatArray

from .cases import INCH, RADIUS, WALL
from .outcome import Outcome

_MILLI = 1e3
_COLUMNS, _ROWS = 320, 124
_OUTER = RADIUS + WALL


def rolled_out(name: str, title: str, caption: str, one: Outcome, inches: int) -> Figure:
    """Return a picture of the whole circumference, the notch in its middle; one half is the mirror image of the other."""
    x, y, stress = _samples(one)
    curves = [Curve("cracks", *_crack_lines(one), "line", 1)] if one.cut.any() else []
    # Above the cracks: one of them lies in it.
    curves.append(Curve("notch", [-0.5 * inches * INCH * _MILLI, 0.5 * inches * INCH * _MILLI], [0.0, 0.0], "dashed", 0))
    half = np.pi * _OUTER * _MILLI
    return Figure(
        name, title, caption, Axis("x from the middle of the notch, mm", float(x[0]), float(x[-1])),
        Axis("around the tube, mm", -half, half), curves, shading=Shading("equivalent stress, MPa", x, y, stress), equal=True,
    )  # fmt: skip


def _samples(one: Outcome) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y [mm] and the stress [MPa] on an even grid, linear between nodes."""
    places, angles = np.unique(np.round(one.x, 9)), np.unique(np.round(one.arc, 9))
    field = one.stress.reshape(len(places), len(angles))
    x = np.linspace(places[0], places[-1], _COLUMNS)
    y = np.linspace(-np.pi, np.pi, _ROWS)
    along = np.stack([np.interp(x, places, row) for row in field.T])
    rolled = np.stack([np.interp(np.abs(y), angles, column) for column in along.T], axis=1)
    return x * _MILLI, y * _OUTER * _MILLI, rolled * 1e-6


def _crack_lines(one: Outcome) -> tuple[FloatArray, FloatArray]:
    """Return the cracks as lines with breaks between them: one across each pair that is cut, as long as pairs are apart."""
    x, arc = one.x[one.pairs][one.cut], one.arc[one.pairs][one.cut]
    around = one.crosses_axis()[one.cut]
    size = float(np.median(np.abs(np.diff(one.arc[one.pairs], axis=1))[~one.crosses_axis()]))
    step = float(np.median(np.abs(np.diff(one.x[one.pairs], axis=1))[one.crosses_axis()]))
    middle, angle = x.mean(axis=1), arc.mean(axis=1)
    ends_x = np.stack([middle - 0.5 * step * ~around, middle + 0.5 * step * ~around, np.full(len(middle), np.nan)], axis=1)
    ends_y = np.stack([angle - 0.5 * size * around, angle + 0.5 * size * around, np.full(len(middle), np.nan)], axis=1)
    lines = np.concatenate([ends_x.ravel(), ends_x.ravel()]), np.concatenate([ends_y.ravel(), -ends_y.ravel()])
    return lines[0] * _MILLI, lines[1] * _OUTER * _MILLI
