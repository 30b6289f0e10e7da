"""The open area of cracks through the wall at each station, and the length of all cracks."""

from __future__ import annotations

import numpy as np

from ...support.float_arrays import FloatArray, norms
from ..geometry.lattice import Lattice
from ..kernel_arrays import IntArray
from ..kernel_setup import Assembly
from .cracks import Cracks
from .pieces import ACROSS, ALONG, Marks

# A gap is measured over at most this many links at once: on a ring, longer chords become inaccurate.
_LONGEST = 4


def crack_length(assembly: Assembly, cracks: Cracks) -> float:
    """Return the length of all facets along the surface, each times its share of the thickness [m]."""
    if not len(cracks.facets):
        return 0.0
    check, through = cracks.check, len(assembly.points.lines[2].at)
    point = cracks.facets[:, 0].astype(np.int64)
    a, b, layer = point // through // len(check.across), point // through % len(check.across), point % through
    # The part inside the cell of the point, along both axes, of the line in which the facet cuts the surface.
    line = np.stack([-cracks.facets[:, 5], cracks.facets[:, 4]], axis=1)
    line = line / np.maximum(np.abs(line).max(axis=1), 1e-300)[:, None]
    x, y = line[:, 0] * check.along[a], line[:, 1] * check.across[b] * check.radius[layer]
    straight = cracks.facets[:, 6] == 0.0
    return float((np.sqrt(x * x + y * y) * straight).sum() / through)


def open_areas(lattice: Lattice, cracks: Cracks, displacement: FloatArray) -> FloatArray:
    """Return the open area of the cracks through the wall at each station, on the inner surface, shape (stations,) [m^2].

    It is the increase of the distance between the columns on both sides, times the width of a column. Columns severed from both
    neighbours, or in no point's support, do not bound a gap: it is measured across them and shared by the cracks there.
    """
    n, m, layers = lattice.shape
    inner = (lattice.nodes + displacement)[::layers].reshape(n, m, 3)
    rest = lattice.nodes[::layers].reshape(n, m, 3)
    along, across, _ = lattice.axes
    cut, severed = _cut_masks(cracks, (n, m), ACROSS)
    areas = crack_openings(cut, severed, inner, rest, across.is_closed).sum(axis=1) * along.widths
    cut, severed = _cut_masks(cracks, (n, m), ALONG)
    opening = crack_openings(cut.T, severed.T, inner.swapaxes(0, 1), rest.swapaxes(0, 1), along.is_closed).T
    radius = lattice.axes[2].positions[0] if lattice.bent else 1.0
    half = 0.5 * (opening * (across.widths * radius)).sum(axis=1)
    return areas + half + np.roll(half, 1)


def _cut_masks(cracks: Cracks, shape: tuple[int, int], direction: int) -> tuple[Marks, Marks]:
    """Return which columns are not linked to the next one in a direction, and which are separated from it through the wall."""
    borne, severed = cracks.borne.reshape(shape), cracks.severed[:, direction].reshape(shape)
    return severed | ~borne | ~np.roll(borne, -1, axis=direction), severed


def crack_openings(
    is_cut: Marks, is_severed: Marks, present_positions: FloatArray, initial_positions: FloatArray, is_closed: bool
) -> FloatArray:
    """Return the crack opening at each link that is cut through the wall, for rows of successive columns, shape (rows, k) [m].

    Args:
        is_cut: whether each column is not linked to the next one (the last to the first), shape (rows, k).
        is_severed: whether a crack through the wall lies between them; these links are cut.
        present_positions: present positions of the columns, shape (rows, k, 3) [m].
        initial_positions: initial positions of the columns.
        is_closed: whether the first column follows the last one; otherwise a row has ends.
    """
    is_cut, is_severed = is_cut.copy(), is_severed.copy()
    if not is_closed:
        is_cut[:, -1] = is_severed[:, -1] = False
    runs = [(int(row), run) for row in np.flatnonzero(is_severed.any(axis=1)) for run in _cut_runs(is_cut[row])]
    runs = [(row, run) for row, run in runs if is_severed[row, run].any()]
    ends = [(int(run[0]), int(run[0]) + len(run)) for _, run in runs]
    opening = np.zeros(is_cut.shape)
    for (row, run), gap in zip(
        runs, _gap_widths(present_positions, initial_positions, [row for row, _ in runs], ends, is_closed), strict=True
    ):
        links = run[is_severed[row, run]]
        opening[row, links] = gap / len(links)
    return opening


def _cut_runs(is_cut: Marks) -> list[IntArray]:
    """Return the cut links as runs of successive links; a run has at most a few links."""
    count = len(is_cut)
    # Rows are read from an intact link on, so that no run is divided at the beginning of the row.
    start = int(np.argmin(is_cut)) if not is_cut.all() else 0
    links = start + np.flatnonzero(np.roll(is_cut, -start))
    runs = np.split(links, np.flatnonzero(np.diff(links) > 1) + 1) if len(links) else []
    return [run[begin : begin + _LONGEST] % count for run in runs for begin in range(0, len(run), _LONGEST)]


def _gap_widths(
    present_positions: FloatArray, initial_positions: FloatArray, rows: list[int], ends: list[tuple[int, int]], is_closed: bool
) -> FloatArray:
    """Return the increase of the distance between pairs of columns, at least 0 [m].

    Crack edges supported by few points may swing back: if the columns beyond them have moved apart less, these are used.
    """
    count, row = present_positions.shape[1], np.array(rows, dtype=np.int64)
    first, last = np.array(ends, dtype=np.int64).reshape(-1, 2).T
    before, after = (first - 1, last + 1) if is_closed else (np.maximum(first - 1, 0), np.minimum(last + 1, count - 1))
    grown = [
        norms(present_positions[row, b % count] - present_positions[row, a % count])
        - norms(initial_positions[row, b % count] - initial_positions[row, a % count])
        for a, b in ((first, last), (before, after))
    ]
    return np.maximum(np.minimum(*grown), 0.0)
