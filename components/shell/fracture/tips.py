"""The tips of a crack: which facets belong to it, how fast it ran, and which of them came too soon for a crack."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

from ...support.float_arrays import FloatArray

# Facets next to each other, or but one, are no farther apart than this [spacings]; their middles lie in cells of the lattice.
_NEXT = 2.3
# The speed of a crack is that between these parts of its way.
_FROM, _TO = 0.1, 0.9


def growth(indices: FloatArray, places: FloatArray, times: FloatArray, fastest: float) -> tuple[npt.NDArray[np.int64], float]:
    """Return the facets of the crack that began with the first, ascending in time, and the part of them that came too soon.

    Each lies next to an older one of it. It came too soon where the fastest crack could not have come from any of those: a load
    parts all points that it overloads, however far the crack is, and no tip has run then.

    Args:
        indices: middles in the index space of the lattice, shape (k, 2).
        places: middles, along the body and around it, shape (k, 2) [m].
        times: when, ascending, shape (k,) [s].
        fastest: speed of Rayleigh waves, which a crack that opens does not pass [m/s].
    """
    tree = KDTree(indices)
    grown, soon = np.zeros(len(indices), dtype=bool), 0
    grown[0] = True
    for facet, nearby in enumerate(tree.query_ball_point(indices, _NEXT)):
        older = [one for one in nearby if one < facet and grown[one]]
        if older:
            grown[facet] = True
            along, around = (places[older] - places[facet]).T
            soon += int(np.all(np.sqrt(along * along + around * around) > fastest * (times[facet] - times[older])))
    return np.flatnonzero(grown), soon / max(int(grown.sum()) - 1, 1)


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
