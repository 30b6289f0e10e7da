"""From the numbers of a figure to places in its drawing: limits, ticks, coordinates."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from .model import Axis, Figure

_TICKS = 6
_MARGIN = 0.04


@dataclasses.dataclass(frozen=True)
class Scale:
    """A linear map of an axis.

    Attributes:
        low: the number at its begin.
        high: the number at its end.
        start: the place of `low`.
        end: the place of `high`.
        ticks: (number, name).
    """

    low: float
    high: float
    start: float
    end: float
    ticks: Sequence[tuple[float, str]]

    def place(self, value: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Where numbers lie."""
        share = (np.asarray(value, dtype=np.float64) - self.low) / (self.high - self.low)
        return self.start + share * (self.end - self.start)

    def holds(self, value: float) -> bool:
        """Whether a number is inside of the drawing."""
        return self.low <= value <= self.high


def horizontal(figure: Figure, start: float, end: float) -> Scale:
    """The map of a figure's horizontal axis, which its curves fill."""
    numbers = [curve.points()[0] for curve in figure.curves]
    return _scale(figure.x, numbers, [mark.x for mark in figure.marks], start, end, 0.0)


def vertical(figure: Figure, start: float, end: float) -> Scale:
    """The map of a figure's vertical axis, with some air above and below."""
    numbers = [curve.points()[1] for curve in figure.curves]
    return _scale(figure.y, numbers, [mark.y for mark in figure.marks], start, end, _MARGIN)


def _scale(
    axis: Axis, numbers: Iterable[npt.NDArray[np.float64]], marks: Iterable[float | None], start: float, end: float, air: float
) -> Scale:
    known = [values[np.isfinite(values)] for values in numbers]
    seen = np.concatenate([*known, np.array([mark for mark in marks if mark is not None], dtype=np.float64)])
    first, last = (float(seen.min()), float(seen.max())) if seen.size else (0.0, 1.0)
    if first == last:
        first, last = first - (abs(first) or 1.0), last + (abs(last) or 1.0)
    wide = last - first
    low = axis.low if axis.low is not None else first - air * wide
    high = axis.high if axis.high is not None else last + air * wide
    return Scale(low, high, start, end, list(axis.names) or ticks(low, high))


def ticks(low: float, high: float) -> list[tuple[float, str]]:
    """Round numbers between two limits, with their names."""
    rough = (high - low) / _TICKS
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * factor for factor in (1.0, 2.0, 5.0, 10.0) if power * factor >= rough * (1.0 - 1e-9))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    digits = max(0, -math.floor(math.log10(step) + 1e-9))
    return [(number * step, _name(number * step, digits, step)) for number in range(first, last + 1)]


def _name(value: float, digits: int, step: float) -> str:
    if digits > 4 or step >= 1e5:
        return f"{value:.3g}".replace("-", "−")
    return f"{value + 0.0:.{digits}f}".replace("-", "−")
