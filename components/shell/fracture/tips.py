"""The tips of a crack: which facets are its growth, and how fast it ran."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

from ...support.float_arrays import FloatArray

# Facets next to each other, or but one, are no farther apart than this [spacings]; their middles lie in cells of the lattice.
_NEXT = 2.3
# The speed of a crack is that between these parts of its way.
_FROM, _TO = 0.1, 0.9


def growth(indices: FloatArray, places: FloatArray, times: FloatArray, fastest: float) -> npt.NDArray[np.int64]:
    """Return which facets are the growth of the crack that began with the first, ascending in time.

    Each lies next to one that is so much older that a shear wave could have come from there: no crack that opens runs faster.
    What parted by itself, ahead of the crack or elsewhere, is none of it: a fast load can part all points at once, and no tip
    has run then.

    Args:
        indices: middles in the index space of the lattice, shape (k, 2).
        places: middles, along the body and around it, shape (k, 2) [m].
        times: when, ascending, shape (k,) [s].
        fastest: speed of shear waves [m/s].
    """
    tree = KDTree(indices)
    grown = np.zeros(len(indices), dtype=bool)
    grown[0] = True
    for facet, nearby in enumerate(tree.query_ball_point(indices, _NEXT)):
        older = [one for one in nearby if one < facet and grown[one]]
        if older:
            distances = np.hypot(*(places[older] - places[facet]).T)
            grown[facet] = np.any(distances <= fastest * (times[facet] - times[older]))
    return np.flatnonzero(grown)


def tip_speed(places: FloatArray, times: FloatArray, shortest: float) -> float:
    """Return the speed of the faster one of the two tips of a crack, over the middle four fifths of its way [m/s].

    Args:
        places: where the crack grew, along its way, shape (k,) [m].
        times: when, ascending, shape (k,) [s].
        shortest: ways that are not longer have no speed [m].

    Returns:
        0 where no tip went so far.
    """
    speeds = [0.0]
    for sign in (1.0, -1.0):
        reach = np.maximum.accumulate(sign * (places - places[0])) if len(places) else np.zeros(0)
        if len(reach) and reach[-1] > shortest:
            begin, end = (int(np.searchsorted(reach, part * reach[-1])) for part in (_FROM, _TO))
            if times[end] > times[begin]:
                speeds.append(float((reach[end] - reach[begin]) / (times[end] - times[begin])))
    return max(speeds)
