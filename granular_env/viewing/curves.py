"""Scalars in time, thinned so that no peak is lost."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from granular_env.components.support.float_arrays import FloatArray

MAXIMUM_CURVE_POINTS = 4_000


@dataclass(frozen=True)
class Curve:
    """A scalar in time.

    Attributes:
        times: shape (samples,) [s].
        ticks: shape (samples,).
        values: shape (samples,), in `unit`.
        cuts: indices of the first samples of later segments: no line leads there from the sample before.
    """

    name: str
    unit: str
    description: str
    times: FloatArray
    ticks: npt.NDArray[np.int64]
    values: FloatArray
    cuts: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))


def pick_with_extremes(values: FloatArray, most: int = MAXIMUM_CURVE_POINTS) -> npt.NDArray[np.int64]:
    """Return indices of at most `most` samples: of each stretch its first, its last, its least and its largest.

    So no peak is lost, and where samples lie closer than can be drawn, what is drawn is the band that they fill.
    """
    if len(values) <= most:
        return np.arange(len(values))
    stretches = np.array_split(np.arange(len(values)), most // 4)
    marks = [(part[0], part[np.argmin(values[part])], part[np.argmax(values[part])], part[-1]) for part in stretches]
    return np.unique(np.array(marks, dtype=np.int64))
