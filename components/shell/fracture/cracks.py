"""The cracks of a body: facets in the state, and the tables of kernels that follow from them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...support.float_arrays import FloatArray
from ..column_means import make_column_means
from ..geometry.lattice import Lattice
from ..kernel_arrays import ColumnArray, IntArray, Solid, State
from ..quadrature import IntegrationPoints
from ..shape_functions import write_hold
from ..stencils import Stencils
from .facets import mark_links
from .judgement import Judgement, index_normal, judge
from .law import FractureLaw
from .pieces import Marks, crack_lips, detached_columns, label_columns, severed_links
from .visibility import Visibility

# A facet runs beside its point: half way to the next nodes where points lie at nodes, otherwise next to the point.
_BESIDE_NODES, _BESIDE_POINTS = 0.45, 0.05
# Sides are taken as equal where the sums of what decides on them differ by less than this part.
_EQUAL = 1e-9
# A point whose share of the squared frequency would exceed this multiple of the largest one at the start is eroded.
_STIFFEST = 2.0
# A node that points see less than this part as much as before any crack is loosened: nothing sees it any more.
_LOOSE = 0.2
# Points whose stiffness is computed at a time.
_AT_A_TIME = 4096
# Time for a point that has parted to unload: that of sound over so many of the longest spacings.
_SPACINGS_TO_UNLOAD = 4.0
# More ticks than any run has.
_ENDLESS = 2.0**62


class Parting(NamedTuple):
    """The new cracks at the end of a tick.

    Attributes:
        facets: new ones, rows of `facets.facet_rows`.
        values: what decided at the point of each, and its limit.
        spent: points that have passed their limit again, long after they had parted.
        spent_values: what decided at these, and the limits.
        eroded: points that bear nothing any more, the spent ones and those that are left with too few neighbours.
        loosened: nodes that hardly any point saw any more.
        changed: points with other neighbours than before, the eroded ones among them.
        torn: points, some of the eroded ones, that were distorted beyond measure: what told so, and its limit.
    """

    facets: list[FloatArray]
    values: list[tuple[float, float]]
    spent: list[int]
    spent_values: list[tuple[float, float]]
    eroded: IntArray
    loosened: IntArray
    changed: IntArray
    torn: dict[int, tuple[float, float]]

    def joined(self, other: Parting, torn: dict[int, tuple[float, float]]) -> Parting:
        """Return this one with the points and nodes of another one that followed from it, and why they were torn."""
        return self._replace(
            eroded=np.concatenate([self.eroded, other.eroded]),
            loosened=np.concatenate([self.loosened, other.loosened]),
            changed=np.union1d(self.changed, other.changed),
            torn={**self.torn, **torn},
        )


class Cracks:
    """The cracks, and the tables that follow from them; they are made anew where the state has other ones."""

    def __init__(
        self, lattice: Lattice, points: IntegrationPoints, stencils: Stencils, solid: Solid, law: FractureLaw, radius: float,
        basis: object,
    ) -> None:  # fmt: skip
        """Take a body without cracks."""
        self._lattice, self._points, self._stencils, self._whole = lattice, points, stencils, solid
        self._through = len(points.lines[2].at)
        at_nodes = len(points.lines[0].at) == lattice.shape[0]
        self._shift = _BESIDE_NODES if at_nodes else _BESIDE_POINTS
        self.visibility = Visibility(lattice, points.places, stencils, radius, basis)  # type: ignore[arg-type]
        columns = len(points.volume) // self._through
        along, across, thickness = lattice.axes
        lines = points.lines
        limits = law.limits(solid.law, columns, self._through)
        self.judged = Judgement(
            law.constants(solid.law), limits, along.slope(lines[0].at), across.slope(lines[1].at),
            thickness.slope(lines[2].at), thickness.at(lines[2].at) if lattice.bent else np.ones(self._through),
            np.zeros((len(points.volume), 3)), np.zeros(len(points.volume), dtype=np.int64),
            np.zeros(len(points.volume), dtype=np.int64), self._ticks_to_unload(solid), make_column_means(lattice, points),
        )  # fmt: skip
        self._hold = np.zeros(lattice.node_count)
        even = self.visibility
        write_hold(solid.body, even.seen, np.arange(lattice.node_count), self._hold)
        self._stiffest = _STIFFEST * self._largest_stiffness()
        self.clear()

    def _ticks_to_unload(self, solid: Solid) -> int:
        """Return the ticks in which sound runs over a few spacings of the lattice."""
        axes, density = self._lattice.axes, float(solid.body.mass[0] / self._lattice.volumes[0])
        radius = axes[2].positions[-1] if self._lattice.bent else 1.0
        longest = max(float(np.diff(axes[0].positions).max()), float(np.diff(axes[1].positions).max()) * radius)
        ticks = _SPACINGS_TO_UNLOAD * longest / math.sqrt(solid.law.young / density) / solid.step
        return math.ceil(min(max(ticks, 1.0), _ENDLESS))

    def clear(self) -> None:
        """Go back to a body without cracks."""
        self.facets, self.eroded, self.loosened = np.zeros((0, 9)), np.zeros(0), np.zeros(0)
        self.links = np.zeros((self._lattice.shape[0] * self._lattice.shape[1], 4, self._lattice.shape[2]), dtype=np.uint8)
        self.severed: Marks = severed_links(self.links)
        self.visibility.clear()
        self.judged.normal[:] = 0.0
        self.judged.cracks[:] = self.judged.since[:] = 0
        self.judged.means.sound[:] = True
        self._update_tables()

    def follow(self, facets: FloatArray, eroded: FloatArray, loosened: FloatArray) -> None:
        """Make the tables those of the facets, eroded points and loosened nodes of the state, where they are not."""
        given, known = (facets, eroded, loosened), (self.facets, self.eroded, self.loosened)
        if all(np.array_equal(one, other) for one, other in zip(given, known, strict=True)):
            return
        self.clear()
        changed = [self._add(facet) for facet in facets] + [self._hide_node(int(node)) for node in loosened]
        blind = eroded.astype(np.int64)
        if changed:
            points = np.unique(np.concatenate(changed))
            self.visibility.rebuild(points[~np.isin(points, blind)])
        self.visibility.blind(blind)
        self.facets, self.eroded, self.loosened = facets.copy(), eroded.copy(), loosened.copy()
        self._update_tables()

    # -- parting ----------------------------------------------------------------------------------------------------

    def part(self, state: State, found: IntArray, tick: int) -> Parting:
        """Part the body at points that have passed their limit: the one whose own stress is farthest beyond it first.

        Means of neighbouring columns may pass it together. A point that loses neighbours to a crack of this tick waits for the
        next one. One that has parted and has had time to unload bears nothing any more: what it still holds together is a
        bridge that the lattice leaves between cracks.
        """
        means, limit = self.judged.means, self.judged.limit
        decided = {int(p): float(judge(means.stress, state, self.judged, p)[0]) for p in found}
        own = {p: float(judge(state.stress, state, self.judged, p)[0]) / limit[p] for p in decided}
        order = sorted(decided, key=lambda p: (-own[p], p))
        facets: list[FloatArray] = []
        values: list[tuple[float, float]] = []
        changed = set[int]()
        spent = [p for p in order if self.judged.cracks[p] > 0 and tick >= self.judged.since[p] + self.judged.wait]
        for p in order:
            if p not in changed and p not in spent:
                facets.append(np.append(self._choose_facet(state, p), float(tick)))
                values.append((decided[p], float(limit[p])))
                changed |= set(self._add(facets[-1]).tolist())
        self.facets = np.concatenate([self.facets, np.array(facets).reshape(-1, 9)])
        spent_values = [(decided[p], float(limit[p])) for p in spent]
        eroded, loosened, points = self._settle(changed, spent)
        return Parting(facets, values, spent, spent_values, eroded, loosened, points, {})

    def erode(self, points: list[int]) -> Parting:
        """Let some points bear nothing any more."""
        return Parting([], [], [], [], *self._settle(set(), points), {})

    def _settle(self, changed: set[int], spent: list[int]) -> tuple[IntArray, IntArray, IntArray]:
        """Rebuild what points see; erode those that see too little, and loosen nodes that are hardly seen, until all is sound.

        Args:
            changed: points that have lost neighbours.
            spent: points that bear nothing from now on.

        Returns:
            The points that are eroded, the spent ones among them, the nodes that are loosened, and all points concerned.
        """
        seen, gone = self.visibility, {int(p) for p in self.eroded}
        eroded, loosened = list(spent), list[int]()
        seen.blind(np.array(spent, dtype=np.int64))
        fresh = changed - gone - set(spent)
        if spent:
            fresh |= self._loosen(np.array(spent, dtype=np.int64), loosened) - gone - set(spent)
        concerned = {*fresh, *spent}
        while fresh:
            points = np.array(sorted(fresh), dtype=np.int64)
            poor = ~seen.rebuild(points) | (self._stiffness(points) > self._stiffest)
            seen.blind(points[poor])
            eroded += points[poor].tolist()
            losing = self._loosen(points, loosened)
            fresh = losing - gone - set(eroded)
            concerned |= fresh
        self.eroded = np.concatenate([self.eroded, np.array(eroded, dtype=np.float64)])
        self.loosened = np.concatenate([self.loosened, np.array(loosened, dtype=np.float64)])
        self._update_tables()
        return np.array(eroded, dtype=np.int64), np.array(loosened, dtype=np.int64), np.array(sorted(concerned), dtype=np.int64)

    def _loosen(self, points: IntArray, loosened: list[int]) -> set[int]:
        """Hide the nodes near some points that hardly any point sees any more; return the points that lose them."""
        seen, body = self.visibility, self._whole.body
        nodes = np.unique(np.concatenate([self._stencils.neighbours(p) for p in points])).astype(np.int64)
        hold = np.zeros(len(nodes))
        write_hold(body, seen.seen, nodes, hold)
        losing = set[int]()
        known = {int(j) for j in self.loosened} | set(loosened)
        for node in nodes[hold < _LOOSE * self._hold[nodes]].tolist():
            if node not in known:
                loosened.append(node)
                losing |= set(self._hide_node(node).tolist())
        return losing

    def _hide_node(self, node: int) -> IntArray:
        """Hide a node from all points; return those that saw it."""
        body, seen = self._whole.body, self.visibility
        entries = slice(int(body.seen_begin[node]), int(body.seen_begin[node + 1]))
        points = body.seen_lowest[node].astype(np.int64) + body.seen_offsets[entries]
        places = seen.begin[points].astype(np.int64) + body.seen_slot[entries]
        saw = ~seen.hidden[places]
        seen.hidden[places] = True
        return points[saw]

    def is_beside_crack(self, point: int) -> bool:
        """Return whether cracks hide neighbours of a point that bears stress."""
        begin, end = (int(one) for one in self._stencils.begin[point : point + 2])
        return bool(self.visibility.hidden[begin:end].any()) and float(point) not in self.eroded

    def _add(self, facet: FloatArray) -> IntArray:
        """Take a facet; return the points that lose neighbours."""
        p = int(facet[0])
        if self.judged.cracks[p] == 0:
            self.judged.normal[p] = facet[4:7]
        self.judged.cracks[p] += 1
        self.judged.means.sound[p] = False
        self.judged.since[p] = int(facet[8])
        ring = self._lattice.axes[1]
        near = self._columns_near(facet, ring.count)
        mark_links(facet, self.visibility.table, near, self.links)
        self.severed[near] = severed_links(self.links[near])
        return self.visibility.hide(facet)

    def _columns_near(self, facet: FloatArray, around: int) -> IntArray:
        along = np.arange(max(int(facet[1]) - 2, 0), min(int(facet[1]) + 3, self._lattice.shape[0]))
        across = np.arange(int(facet[2]) - 2, int(facet[2]) + 4)
        across = np.unique(across % around) if self._lattice.axes[1].closed else across[(across >= 0) & (across < around)]
        return (along[:, None] * around + across).ravel()

    def _choose_facet(self, state: State, p: int) -> FloatArray:
        """Return the facet of a point: on the side where a crack is already, otherwise where more is loaded."""
        _, nx, ny, nz = judge(self.judged.means.stress, state, self.judged, p)
        normal = np.array(index_normal(self._whole, state, self.judged, p, nx, ny, nz))
        side = self._open_side(p, normal) or self._loaded_side(state, p, normal) or 1
        first = self._facet(p, normal, side)
        if self.visibility.is_sound_behind(first, p):
            return first
        second = self._facet(p, normal, -side)
        return second if self.visibility.is_sound_behind(second, p) else first

    def _facet(self, p: int, normal: FloatArray, side: int) -> FloatArray:
        beside = self._shift * max(abs(normal[0]), abs(normal[1])) if normal[2] == 0.0 else _BESIDE_POINTS
        middle, cell = self._place(p), self._thickness_cell(p)
        middle[2] = cell[0] if normal[2] == 0.0 else middle[2]
        return np.concatenate([[p], middle + side * beside * normal, normal, [cell[1]]])

    def _place(self, p: int) -> FloatArray:
        """Return the fractional indices of a point."""
        return self._points.places(np.array([p]))[0]

    def _thickness_cell(self, p: int) -> tuple[float, float]:
        """Return the middle and half the extent of a point's part of the thickness, in index space.

        The outermost parts reach beyond the surface, below a notch through all that it leaves out.
        """
        column, layer = divmod(p, self._through)
        heights = self._points.heights[column * self._through : (column + 1) * self._through]
        bounds = [-0.5, *(0.5 * (heights[1:] + heights[:-1])), self._lattice.shape[2] - 0.5]
        low, high = bounds[layer : layer + 2]
        return 0.5 * (high + low), 0.5 * (high - low)

    def _open_side(self, p: int, normal: FloatArray) -> int:
        """Return the side on which a point has lost more neighbours; 0 for none."""
        begin, end = (int(one) for one in self._stencils.begin[p : p + 2])
        lost = self._stencils.neighbours(p)[self.visibility.hidden[begin:end]].astype(np.int64)
        _, m, layers = self._lattice.shape
        offsets = np.stack([lost // (m * layers), lost // layers % m, self._lattice.heights(lost)], axis=-1) - self._place(p)
        if self._lattice.axes[1].closed:
            offsets[:, 1] -= m * np.floor(offsets[:, 1] / m + 0.5)
        return int(np.sign(np.sign((offsets * normal).sum(axis=1)).sum()))

    def _loaded_side(self, state: State, p: int, normal: FloatArray) -> int:
        """Return the side on which the points next to one are nearer to their limits; 0 where both are alike."""
        sums, around = [0.0, 0.0], self._points_around(p)
        for q, offset in zip(around, self._points.places(np.array(around, dtype=np.int64)) - self._place(p), strict=True):
            if self._lattice.axes[1].closed:
                m = self._lattice.shape[1]
                offset[1] -= m * np.floor(offset[1] / m + 0.5)
            beyond = float((offset * normal).sum())
            if abs(beyond) > 0.3:
                sums[int(beyond > 0.0)] += (
                    float(judge(self.judged.means.stress, state, self.judged, q)[0]) / self.judged.limit[q]
                )
        difference = sums[1] - sums[0]
        return 0 if abs(difference) <= _EQUAL * (abs(sums[0]) + abs(sums[1])) else (1 if difference > 0.0 else -1)

    def _points_around(self, p: int) -> list[int]:
        """Return the points of the same layer in the columns of points around that of a point."""
        across, k = len(self.judged.across), self._through
        along = len(self.judged.along)
        a, b, layer = p // (across * k), p // k % across, p % k
        found = []
        for x in range(max(a - 1, 0), min(a + 2, along)):
            for y in range(b - 1, b + 2):
                if (x, y) != (a, b) and (self._lattice.axes[1].closed or 0 <= y < across):
                    found.append((x * across + y % across) * k + layer)
        return found

    def _largest_stiffness(self) -> float:
        """Return the largest one of all points, some at a time: all at once would double the memory of the body."""
        every = np.arange(len(self._points.volume))
        return max(
            float(self._stiffness(every[begin : begin + _AT_A_TIME]).max()) for begin in range(0, len(every), _AT_A_TIME)
        )

    def _stiffness(self, points: IntArray) -> FloatArray:
        """Return V sum |grad N_J|^2 / m_J of points: their share of the squared frequency, over that of sound."""
        some, body = self._stencils, self._whole.body
        counts = some.counts(points)
        entry = np.repeat(some.begin[points].astype(np.int64) - np.cumsum(counts) + counts, counts) + np.arange(counts.sum())
        row = np.repeat(
            self.visibility.first[self.visibility.kind[points]].astype(np.int64) - np.cumsum(counts) + counts, counts
        )
        gradients = self.visibility.gradients[row + np.arange(counts.sum())]
        owner = np.repeat(np.arange(len(points)), counts)
        gradients[:, 0] *= self.visibility.along[points][owner]
        nodes = np.repeat(some.lowest[points], counts) + some.offsets[entry]
        terms = (gradients * gradients).sum(axis=1) / body.mass[nodes]
        return body.volume[points] * np.bincount(owner, weights=terms, minlength=len(points))

    # -- tables -----------------------------------------------------------------------------------------------------

    def _update_tables(self) -> None:
        """Make the tables of the kernels: rows, ties and the surface under pressure."""
        lattice, seen, whole = self._lattice, self.visibility, self._whole
        self.judged.means.sound[self.eroded.astype(np.int64)] = False
        self.labels, self.borne = self._label_pieces()
        self.detached: Marks = detached_columns(lattice, self.severed, self.labels) | self._loose_columns()
        self.released: Marks = crack_lips(lattice, self.severed) | self.detached
        body = whole.body._replace(kind=seen.kind, first=seen.first, gradients=seen.gradients, along=seen.along)
        around = self._loaded_neighbours()
        self.solid = whole._replace(
            body=body, hourglass=whole.hourglass._replace(partner=self._ties()), surface=whole.surface._replace(around=around)
        )

    def _label_pieces(self) -> tuple[IntArray, Marks]:
        """Return the number of the piece of each column, that of its first column, and whether anything bears it."""
        n, m, layers = self._lattice.shape
        labels, borne = np.zeros(n * m, dtype=np.int64), np.zeros(n * m, dtype=bool)
        if not len(self.facets):
            return labels, ~borne
        blind = np.zeros(len(self._points.volume), dtype=bool)
        blind[self.eroded.astype(np.int64)] = True
        label_columns(self.visibility.seen, blind, layers, labels, borne)
        return labels, borne

    @property
    def piece_count(self) -> int:
        """Number of pieces; columns that nothing bears are none."""
        return len(np.unique(self.labels[self.borne]))

    def _cut_sides(self, cut: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
        """Return whether each column is cut from the ones before and after it along and across, shape (columns, 4)."""
        n, m, _ = self._lattice.shape
        along, across = cut[:, 0].reshape(n, m), cut[:, 1].reshape(n, m)
        sides = (np.roll(along, 1, axis=0), along, np.roll(across, 1, axis=1), across)
        return np.stack([one.ravel() for one in sides], axis=1)

    def _ties(self) -> ColumnArray:
        """Return the partners of the hourglass control: none across a crack, and none of a column with an eroded point."""
        partner = self._whole.hourglass.partner
        if len(partner) == 0:
            return partner
        lost = np.zeros(len(partner) + 1, dtype=bool)
        lost[self.eroded.astype(np.int64) // self._through] = True
        cut = self._cut_sides(np.any(self.links[:, :2] > 0, axis=2))
        return np.where(cut | lost[:-1, None] | lost[partner], -1, partner)

    def _loaded_neighbours(self) -> ColumnArray:
        """Return the neighbours that span the area of each node of the inner surface: itself across a crack.

        A node that flies on by itself spans no area with those that it has left, which would grow without bound.
        """
        around = self._whole.surface.around
        own = np.broadcast_to(np.arange(len(around), dtype=np.int32)[:, None], around.shape)
        cut = self._cut_sides(self.links[:, :2, 0] > 0) & (around != own)
        return np.where(cut | self.released[:, None] | self.detached[around], own, around)

    def _loose_columns(self) -> Marks:
        """Return the columns whose node on the inner surface nothing holds."""
        found = np.zeros(len(self.labels), dtype=bool)
        loosened = self.loosened.astype(np.int64)
        layers = self._lattice.shape[2]
        found[loosened[loosened % layers == 0] // layers] = True
        return found
