"""The length of cracks, and their open area."""

from __future__ import annotations

import numpy as np

from ...support.arrays import FloatArray, norms
from ..assembly import Assembly
from ..geometry.lattice import Lattice
from .cracks import Cracks
from .pieces import ACROSS, ALONG


def crack_length(assembly: Assembly, cracks: Cracks) -> float:
    """Return the length of all facets in the surface, each with its share of the thickness [m]."""
    if not len(cracks.facets):
        return 0.0
    judged, through = cracks.judged, len(assembly.points.lines[2].at)
    point = cracks.facets[:, 0].astype(np.int64)
    a, b, layer = point // through // len(judged.across), point // through % len(judged.across), point % through
    # The part of the line that lies in the cell of the point, along both axes.
    line = np.stack([-cracks.facets[:, 5], cracks.facets[:, 4]], axis=1)
    line = line / np.maximum(np.abs(line).max(axis=1), 1e-300)[:, None]
    x, y = line[:, 0] * judged.along[a], line[:, 1] * judged.across[b] * judged.radius[layer]
    straight = cracks.facets[:, 6] == 0.0
    return float((np.sqrt(x * x + y * y) * straight).sum() / through)


def open_areas(lattice: Lattice, cracks: Cracks, displacement: FloatArray) -> FloatArray:
    """Return the open area of the cracks through the wall at each station, on the inner surface, shape (stations,) [m^2].

    Between two columns that a crack severs it is how far their distance has grown, times the width of their edge.
    """
    n, m, layers = lattice.shape
    inner = (lattice.nodes + displacement)[::layers].reshape(n, m, 3)
    rest = lattice.nodes[::layers].reshape(n, m, 3)
    areas = np.zeros(n)
    radius = lattice.axes[2].positions[0] if lattice.bent else 1.0
    for way, axis in ((ALONG, 0), (ACROSS, 1)):
        cut = cracks.severed[:, way].reshape(n, m).copy()
        if not lattice.axes[axis].closed:
            cut[(-1,) if axis == 0 else (slice(None), -1)] = False
        grown = _distance(inner, axis) - _distance(rest, axis)
        opening = np.where(cut & (grown > 0.0), grown, 0.0)
        if way == ACROSS:
            areas += opening.sum(axis=1) * lattice.axes[0].widths
        else:
            sums = 0.5 * (opening * (lattice.axes[1].widths * radius)).sum(axis=1)
            areas += sums + np.roll(sums, 1)
    return areas


def _distance(places: FloatArray, axis: int) -> FloatArray:
    return norms(np.roll(places, -1, axis=axis) - places)
