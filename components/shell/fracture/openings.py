"""The length of cracks, and their open area."""

from __future__ import annotations

import numpy as np

from ...support.arrays import FloatArray, norms
from ..assembly import Assembly
from ..geometry.lattice import Lattice
from ..layout import IntArray
from .cracks import Cracks
from .pieces import ACROSS, ALONG, Marks


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

    It is how far the distance of the columns on both sides has grown, times the width of the edge. Columns that are cut off
    from both neighbours, or that nothing bears, close no gap: it is measured over them, and shared evenly by the cracks
    through the wall there.
    """
    n, m, layers = lattice.shape
    inner = (lattice.nodes + displacement)[::layers].reshape(n, m, 3)
    rest = lattice.nodes[::layers].reshape(n, m, 3)
    along, across, _ = lattice.axes
    cut, severed = _marks(cracks, (n, m), ACROSS)
    areas = _openings(cut, severed, inner, rest, across.closed).sum(axis=1) * along.widths
    cut, severed = _marks(cracks, (n, m), ALONG)
    opening = _openings(cut.T, severed.T, inner.swapaxes(0, 1), rest.swapaxes(0, 1), along.closed).T
    radius = lattice.axes[2].positions[0] if lattice.bent else 1.0
    half = 0.5 * (opening * (across.widths * radius)).sum(axis=1)
    return areas + half + np.roll(half, 1)


def _marks(cracks: Cracks, shape: tuple[int, int], way: int) -> tuple[Marks, Marks]:
    """Return which columns are cut from the next one that way, or border on what nothing bears, and which through the wall."""
    borne = cracks.borne.reshape(shape)
    cut = np.any(cracks.links[:, way] > 0, axis=1).reshape(shape)
    return cut | ~borne | ~np.roll(borne, -1, axis=way), cracks.severed[:, way].reshape(shape)


def _openings(cut: Marks, severed: Marks, inner: FloatArray, rest: FloatArray, closed: bool) -> FloatArray:
    """Return how far each severed link has opened, of rows of columns one after the other, shape (rows, k) [m].

    Args:
        cut: whether each column is cut from the next one, the last one from the first, shape (rows, k).
        severed: whether it is so through the whole wall.
        inner: where the columns are now, shape (rows, k, 3) [m].
        rest: where they were at rest.
        closed: the first column follows the last one; otherwise a row has ends.
    """
    rows, count = cut.shape
    cut, severed = cut.copy(), severed.copy()
    if not closed:
        cut[:, -1] = severed[:, -1] = False
    opening, own = np.zeros((rows, count)), np.arange(count)
    for row in np.flatnonzero(severed.any(axis=1)):
        whole = np.flatnonzero(~cut[row])
        if not len(whole):  # nothing of a ring holds: each gap by itself
            grown = _growth(inner[row], rest[row], own, (own + 1) % count)
            opening[row] = np.where(severed[row], np.maximum(grown, 0.0), 0.0)
            continue
        # From a link that holds to the next one that does: the columns on both sides of what is cut between them.
        first, last = (whole + 1) % count, np.roll(whole, -1)
        grown = _growth(inner[row], rest[row], first, last)
        # Lips that hang on a few points swing back: then the columns beyond them tell how wide the gap is.
        if closed:
            beyond = (first - 1) % count, (last + 1) % count
        else:
            beyond = np.maximum(first - 1, 0), np.minimum(last + 1, count - 1)
        grown = np.maximum(np.minimum(grown, _growth(inner[row], rest[row], *beyond)), 0.0)
        run = (np.cumsum(~cut[row]) - 1) % len(whole)
        shares = np.bincount(run[severed[row]], minlength=len(whole))
        opening[row] = np.where(severed[row], (grown / np.maximum(shares, 1))[run], 0.0)
    return opening


def _growth(places: FloatArray, rest: FloatArray, first: IntArray, last: IntArray) -> FloatArray:
    """Return how far distances of columns have grown [m]."""
    return norms(places[last] - places[first]) - norms(rest[last] - rest[first])
