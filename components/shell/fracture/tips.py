"""The tips of a crack: which facets belong to it, how fast it ran, and how often faster than a crack can."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

from ...support.float_arrays import FloatArray

# Facets next to each other, or but one, are no farther apart than this [spacings]; their middles lie in cells of the lattice.
_NEXT = 2.3
# The speed of a crack is that between these parts of its way.
_FROM, _TO = 0.1, 0.9


def growth(indices: FloatArray) -> npt.NDArray[np.int64]:
    """Return which facets belong to the crack that began with the first: each lies next to an older one of it.

    Args:
        indices: middles in the index space of the lattice, in the order in which they came, shape (k, 2).
    """
    tree = KDTree(indices)
    grown = np.zeros(len(indices), dtype=bool)
    grown[0] = True
    for facet, nearby in enumerate(tree.query_ball_point(indices, _NEXT)):
        grown[facet] |= any(one < facet and grown[one] for one in nearby)
    return np.flatnonzero(grown)


def part_faster(planes: FloatArray, places: FloatArray, times: FloatArray, speed: float) -> float:
    """Return at which part of its steps from one plane of nodes to the next a crack was faster than a speed.

    A load parts all points that it overloads, however far the crack is: no tip has run then.

    Args:
        planes: index of the plane of each facet along the way, shape (k,).
        places: along the way, shape (k,) [m].
        times: when, ascending, shape (k,) [s].
        speed: [m/s].
    """
    _, first = np.unique(np.rint(planes), return_index=True)
    steps = np.abs(np.diff(places[first])) > speed * np.abs(np.diff(times[first]))
    return float(steps.mean()) if len(steps) else 0.0


def tip_speed(places: FloatArray, times: FloatArray, shortest: float) -> float:
    """Return the speed of the faster one of the two tips of a crack, over the middle four fifths of its way [m/s].

    Args:
        places: where the crack grew, along its way, shape (k,) [m].
        times: when, ascending, shape (k,) [s].
        shortest: ways that are not longer have no speed [m].

    Returns:
        0 where no tip went so far, or all of it at once.
    """
    speeds = [0.0]
    for sign in (1.0, -1.0):
        reach = np.maximum.accumulate(sign * (places - places[0])) if len(places) else np.zeros(0)
        if len(reach) and reach[-1] > shortest:
            begin, end = (int(np.searchsorted(reach, part * reach[-1])) for part in (_FROM, _TO))
            if times[end] > times[begin]:
                speeds.append(float((reach[end] - reach[begin]) / (times[end] - times[begin])))
    return max(speeds)
