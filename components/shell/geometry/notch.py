"""A notch: a slot in the outer surface of a tube, or in the upper surface of a plate.

Compared with plane finite elements (Wilson's incompatible modes, 40,000 unknowns), a ligament one column wide is 1.15 times too
stiff and, when it flows, 1.6 times too strong. With three columns both errors are below 4 %. A ligament with two planes of
nodes locks, with stresses across it of 4 times the yield stress. The wall has three planes; its triaxiality stays below 1.5.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
import numpy.typing as npt

from ...errors import ParameterError
from ...support.parameter_fields import Magnitude, NotNegativeMagnitude, field
from ...support.validation import Parameters
from .axis import Axis, graded_axis, refuse_coinciding_planes
from .lattice import Hollow, Lattice

# Positions count as equal within this fraction of the size of the notch.
_ROUNDING = 1e-9
_FEWEST_ALONG, _MOST_COLUMNS = 3, 1000
# Planes above the bottom of a notch may be closer together than those below it by at most this factor.
_CROWDED = 20.0


class Notch(Parameters):
    """A slot in the outer surface; the lattice is graded to resolve it."""

    length: Magnitude = field(0.0254, "length of the slot", "m")
    depth: Magnitude = field(0.0006, "depth below the outer surface, less than the wall thickness", "m")
    width: Magnitude = field(0.0005, "width of the slot", "m")
    position: NotNegativeMagnitude | None = field(None, "position of its middle along the body; default: half way", "m")
    around: NotNegativeMagnitude = field(0.0, "position of its middle around a tube [rad], or across a plate [m]", "1")
    direction: Literal["axial", "hoop"] = field("axial", "direction: along the body (axial), around or across it (hoop)", "1")
    spacing: Magnitude | None = field(None, "largest distance of nodes along the slot; default: as elsewhere", "m")
    columns: int = field(
        3,
        "smallest number of columns of nodes across its width, made odd because one lies in the middle (2 becomes 3); with 1, "
        "a yielding ligament is too strong",
        "1",
        ge=1,
        le=_MOST_COLUMNS,
    )


def notched_lattice(
    notch: Notch, base_axes: tuple[Axis, Axis], inner: float, wall: float, layers: int, is_bent: bool
) -> Lattice:
    """Return a lattice with the same number of planes as the even axes, graded towards the notch.

    Args:
        notch: the slot.
        base_axes: the axes with planes at equal distances: along the body, and across or around it.
        inner: coordinate of the inner surface; for a tube its radius [m].
        wall: thickness of the wall [m].
        layers: number of planes through the wall.
        is_bent: whether the second axis is an angle.

    Raises:
        ParameterError: the notch lies outside the body, or the planes do not resolve it.
    """
    radius, (name, unit) = (inner + wall, ("around", "rad")) if is_bent else (1.0, ("across", "m"))
    (measure, length), (other, width) = notch_sizes(notch)
    position = 0.5 * base_axes[0].positions[-1] if notch.position is None else notch.position
    along = graded_axis(base_axes[0], position, length, notch_spacing(notch, "hoop", base_axes[0], 1.0), "along", "m")
    across = graded_axis(
        base_axes[1], notch.around, width / radius, notch_spacing(notch, "axial", base_axes[1], radius), name, unit
    )
    refuse_coinciding_planes(along, length, "notch", measure)
    refuse_coinciding_planes(across, width, "notch", other)
    through, bottom = thickness_planes(notch, inner, wall, layers)
    columns = planes_inside(along, position, length)[:, None] & planes_inside(across, notch.around, width / radius)
    return Lattice((along, across, through), is_bent, Hollow(columns, bottom))


def notch_edge(middle: float | None, length: float, start: str, end: str) -> str | None:
    """Return the edge at or beyond which the middle of a notch lies, or None if it lies inside a body of that length."""
    if middle is None or _ROUNDING * length < middle < (1.0 - _ROUNDING) * length:
        return None
    return start if middle < 0.5 * length else end


def notch_sizes(notch: Notch) -> tuple[tuple[str, float], tuple[str, float]]:
    """Return the names and values [m] of the parameters for the extent of the notch along the body, and across or around it."""
    length, width = ("length", notch.length), ("width", notch.width)
    return (length, width) if notch.direction == "axial" else (width, length)


def notch_spacing(notch: Notch, narrow_direction: str, axis: Axis, radius: float) -> float:
    """Return the largest distance of planes in the notch: that of the even axis or, across the notch, its width / columns."""
    even = float(axis.slope(np.zeros(1))[0])
    if notch.direction == narrow_direction:
        return min(even, notch.width / (notch.columns * radius))
    if notch.length * (1.0 + _ROUNDING) < _FEWEST_ALONG * min(even * radius, notch.spacing or np.inf):
        raise ParameterError(
            f"got a length of {notch.length:g} m with nodes {even * radius:.4g} m apart",
            expected=f"at least {_FEWEST_ALONG} nodes along the notch",
            hint="give notch.spacing, or more nodes",
            at=("body", "notch", "length"),
        )
    return even if notch.spacing is None else min(even, notch.spacing / radius)


def thickness_planes(notch: Notch, inner: float, wall: float, layers: int) -> tuple[Axis, int]:
    """Return the planes through a wall, one of them at the bottom of the notch, and the number of this plane.

    Raises:
        ParameterError: the notch is deeper than the wall, or so shallow that its planes would crowd; or too few layers.
    """
    if notch.depth >= wall:
        raise ParameterError(
            f"got {notch.depth:g} m", expected=f"less than the wall, {wall:g} m", at=("body", "notch", "depth")
        )
    if layers < 3:
        raise ParameterError(f"got {layers}", expected="at least 3 with a notch", at=("body", "layers"))
    left = wall - notch.depth
    below = min(max(round(left / wall * (layers - 1)), 1), layers - 2)
    above = layers - 1 - below
    shallowest = left / below * above / _CROWDED
    if notch.depth < shallowest:
        raise ParameterError(
            f"got {notch.depth:g} m: nodes above its bottom would be over {_CROWDED:g} times closer than below",
            expected=f"at least {shallowest:.2g} m with {layers} layers", hint="give more layers",
            at=("body", "notch", "depth"),
        )  # fmt: skip
    lower, upper = left * np.arange(below + 1) / below, left + notch.depth * np.arange(1, above + 1) / above
    through = Axis(inner + np.concatenate([lower, upper]))
    refuse_coinciding_planes(through, notch.depth, "notch", "depth")
    return through, below


def planes_inside(axis: Axis, middle: float, extent: float) -> npt.NDArray[np.bool_]:
    """Return which planes of an axis lie in an interval."""
    if axis.is_covered(middle, extent):
        return np.ones(axis.count, dtype=bool)
    distance = np.abs(axis.positions - middle)
    if axis.is_closed:
        distance = np.minimum(distance, axis.period - distance)
    return distance < 0.5 * extent * (1.0 + _ROUNDING)
