"""The cracks of a body: facets (plane pieces of crack surface, see `facets`) in the state, and the kernel tables for them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...support.float_arrays import FloatArray, ordered_sum
from ..column_means import make_column_means
from ..kernel_arrays import ColumnArray, IntArray, Points, Solid, State, support_entries
from ..kernel_setup import Assembly
from ..kernels import weigh_points
from ..parameters import ShellParameters
from .facets import mark_cut_links
from .fracture_check import UNBREAKABLE, FractureCheck, points_in_grips, write_fracture_values
from .laws.fracture_law import FractureLaw
from .pieces import Marks, crack_lips, detached_columns, label_columns, severed_links
from .visibility import Visibility

# Distance of a facet from its point: about halfway to the next nodes if points lie at nodes, otherwise close to the point.
_BESIDE_NODES, _BESIDE_POINTS = 0.45, 0.05
# Two fracture ratios on the two sides of a point count as equal below this relative difference.
_EQUAL = 1e-9
# A point lies on one side of another point if it is farther than this from it, in index space (node numbers along the axes).
_ASIDE = 0.3
# A point at a crack is eroded if its part in the squared highest frequency exceeds this multiple of the largest initial part.
_STIFFEST = 2.0
# A node is loosened, i.e. removed from all supports, if its total weight at points falls below this part of the initial one.
_LOOSE = 0.2
# The stiffness is computed for this many points at a time, to limit memory.
_AT_A_TIME = 4096
# Unloading time of a cracked point: the time in which sound travels this multiple of the longest node distance.
_SPACINGS_TO_UNLOAD = 4.0
# More ticks than any run has.
_ENDLESS = 2.0**62


PARTED, ERODED, SPENT, TORN, LOOSENED = "point_parted", "point_eroded", "point_spent", "point_torn", "node_loosened"
KINDS = {
    PARTED: "a point passed the limit of the fracture law: a crack normal to the largest principal stress begins there",
    SPENT: "a parted point that has had time to unload passed the limit again: it no longer carries stress",
    TORN: "a point at cracks was inverted or strained beyond the limits: it no longer carries stress",
    LOOSENED: "cracks have removed a node from almost all supports of points: it moves on without forces",
    ERODED: "the neighbours that cracks have left to a point do not span its basis: it no longer carries stress",
}
# Kinds of events after which a point carries no stress.
LOST_KINDS = (SPENT, TORN, ERODED)


class Cause(NamedTuple):
    """Why a point cracks or is eroded: the kind of the event, the value tested, and its limit."""

    kind: str
    value: float
    limit: float


class NewCracks(NamedTuple):
    """The new cracks at the end of a tick.

    Attributes:
        facets: new facets, rows of `facets.facet_declaration`, with their causes.
        eroded: points that no longer carry stress, with their causes (None if cracks have left too few neighbours).
        loosened: nodes that had hardly any weight in points.
        changed: points with changed neighbours, including eroded points, shape (k,).
    """

    facets: list[tuple[FloatArray, Cause]]
    eroded: dict[int, Cause | None]
    loosened: list[int]
    changed: IntArray

    def merged_with(self, other: NewCracks) -> NewCracks:
        """Return these cracks together with the eroded points and loosened nodes that are their consequence."""
        eroded, loosened = {**self.eroded, **other.eroded}, self.loosened + other.loosened
        return NewCracks(self.facets, eroded, loosened, np.union1d(self.changed, other.changed))


class Cracks:
    """The cracks, and the kernel tables derived from them, which are rebuilt if the state contains other cracks."""

    def __init__(self, parameters: ShellParameters, law: FractureLaw, assembly: Assembly, intact_solid: Solid) -> None:
        """Build from the tables of a body without cracks."""
        self._lattice, self._points, self._whole = assembly.lattice, assembly.points, intact_solid
        lattice, points = self._lattice, self._points
        along, across, thickness = lattice.axes
        lines, count = points.lines, len(points.volume)
        self._through = len(lines[2].at)
        self._shift = _BESIDE_NODES if len(lines[0].at) == along.count else _BESIDE_POINTS
        self.visibility = Visibility(lattice, points.indices, assembly.stencils, parameters.chosen_radius, parameters.basis)
        limits = law.limits(intact_solid.law, count // self._through, self._through)
        limits[points_in_grips(parameters, assembly, law.grip_length)] = UNBREAKABLE
        self.check = FractureCheck(
            law.constants(intact_solid.law), limits, along.slope(lines[0].at), across.slope(lines[1].at),
            thickness.slope(lines[2].at),
            thickness.coordinates(lines[2].at) if lattice.bent else np.ones(self._through), points.sine, points.cosine,
            np.zeros((count, 3)), np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64),
            self._ticks_to_unload(intact_solid),
        )  # fmt: skip
        self.means = make_column_means(lattice, points)
        self._hold = self._node_weights(np.arange(lattice.node_count))
        every = np.array_split(np.arange(count), -(-count // _AT_A_TIME))
        self._stiffest = _STIFFEST * max(float(self._point_stiffness(some).max()) for some in every)
        self.clear()

    def _ticks_to_unload(self, solid: Solid) -> int:
        """Return the number of ticks in which sound travels `_SPACINGS_TO_UNLOAD` of the longest node distances."""
        axes, density = self._lattice.axes, float(solid.nodes.mass[0] / self._lattice.volumes[0])
        radius = axes[2].positions[-1] if self._lattice.bent else 1.0
        longest = max(float(np.diff(axes[0].positions).max()), float(np.diff(axes[1].positions).max()) * radius)
        ticks = _SPACINGS_TO_UNLOAD * longest / math.sqrt(solid.law.young / density) / solid.step
        return math.ceil(min(max(ticks, 1.0), _ENDLESS))

    def clear(self) -> None:
        """Return to a body without cracks."""
        self.facets, self.eroded, self.loosened = np.zeros((0, 9)), np.zeros(0), np.zeros(0)
        self.links = np.zeros((self._lattice.shape[0] * self._lattice.shape[1], 4, self._lattice.shape[2]), dtype=np.uint8)
        self.severed: Marks = severed_links(self.links)
        self.visibility.clear()
        self.check.normal[:] = 0.0
        self.check.cracks[:] = self.check.since[:] = 0
        self.means.sound[:] = True
        self._update_tables()

    def load_state(self, facets: FloatArray, eroded_points: FloatArray, loosened_nodes: FloatArray) -> None:
        """Make the tables those of the facets, eroded points and loosened nodes of the state, unless they are already."""
        given, known = (facets, eroded_points, loosened_nodes), (self.facets, self.eroded, self.loosened)
        if all(np.array_equal(one, other) for one, other in zip(given, known, strict=True)):
            return
        self.clear()
        changed = [self._add_facet(facet) for facet in facets] + [self._hide_node(int(node)) for node in loosened_nodes]
        blind = eroded_points.astype(np.int64)
        if changed:
            points = np.unique(np.concatenate(changed))
            self.visibility.rebuild_stencils(points[~np.isin(points, blind)])
        self.visibility.remove_neighbours(blind)
        self.facets, self.eroded, self.loosened = facets.copy(), eroded_points.copy(), loosened_nodes.copy()
        self._update_tables()

    # -- adding cracks ----------------------------------------------------------------------------------------------

    def add_cracks(self, state: State, points: IntArray, tick: int) -> NewCracks:
        """Add a facet at each of the points beyond their limit, beginning with the one whose own stress exceeds it most.

        Several points may pass it together, because stresses are means over columns. A point that loses neighbours by a crack
        of this tick waits for the next tick. A cracked point that has had time to unload is eroded: its remaining links are
        bridges that the lattice leaves between cracks.
        """
        limit, check = self.check.limit, self.check
        decided = dict(
            zip(points.tolist(), self._fracture_values(state, self.means.stress, points)[:, 0].tolist(), strict=True)
        )
        own = dict(zip(points.tolist(), self._fracture_values(state, state.stress, points)[:, 0] / limit[points], strict=True))
        facets, changed, spent = list[tuple[FloatArray, Cause]](), set[int](), dict[int, Cause]()
        order = sorted(decided, key=lambda p: (-own[p], p))
        for p in order:
            if check.cracks[p] > 0 and tick >= check.since[p] + check.wait:
                spent[p] = Cause(SPENT, decided[p], float(limit[p]))
        for p in order:
            if p not in changed and p not in spent:
                facet = np.append(self._choose_facet(state, p), float(tick))
                facets.append((facet, Cause(PARTED, decided[p], float(limit[p]))))
                changed |= set(self._add_facet(facet).tolist())
        self.facets = np.concatenate([self.facets, np.array([facet for facet, _ in facets]).reshape(-1, 9)])
        return self._rebuild_supports(changed, spent)._replace(facets=facets)

    def erode_points(self, points: dict[int, Cause]) -> NewCracks:
        """Erode some points, i.e. let them carry no stress from now on."""
        return self._rebuild_supports(set(), points)

    def _fracture_values(self, state: State, stress: FloatArray, points: IntArray) -> FloatArray:
        """Return for each point the value that its law tests, and the unit normal of a crack there in index space, (k, 4)."""
        out = np.zeros((len(points), 4))
        write_fracture_values(self.check, stress, state.gradient, state.plastic_strain, points, out)
        return out

    def fracture_ratios(self, state: State) -> FloatArray:
        """Return the fracture ratio (value over limit) of each point, from the stress means written last, shape (m,)."""
        return self._fracture_values(state, self.means.stress, np.arange(len(self.check.limit)))[:, 0] / self.check.limit

    def _rebuild_supports(self, changed_points: set[int], points_to_erode: dict[int, Cause]) -> NewCracks:
        """Rebuild supports; erode points with too few neighbours and loosen nodes of hardly any weight until none is left.

        `changed_points` have lost neighbours.
        """
        seen, loosened, gone = self.visibility, list[int](), {int(p) for p in self.eroded}
        eroded: dict[int, Cause | None] = {**points_to_erode}
        fresh = changed_points - gone - set(points_to_erode)
        if points_to_erode:
            points = np.array(list(points_to_erode), dtype=np.int64)
            seen.remove_neighbours(points)
            fresh |= self._loosen_nodes(points, loosened) - gone - set(points_to_erode)
        concerned = {*fresh, *points_to_erode}
        while fresh:
            points = np.array(sorted(fresh), dtype=np.int64)
            poor = points[~seen.rebuild_stencils(points) | (self._point_stiffness(points) > self._stiffest)]
            seen.remove_neighbours(poor)
            eroded |= dict.fromkeys(poor.tolist())
            fresh = self._loosen_nodes(points, loosened) - gone - set(eroded)
            concerned |= fresh
        self.eroded = np.concatenate([self.eroded, np.array(list(eroded), dtype=np.float64)])
        self.loosened = np.concatenate([self.loosened, np.array(loosened, dtype=np.float64)])
        self._update_tables()
        return NewCracks([], eroded, loosened, np.array(sorted(concerned), dtype=np.int64))

    def _loosen_nodes(self, points: IntArray, loosened_nodes: list[int]) -> set[int]:
        """Hide near some points the nodes with hardly any weight; return the points that lose these nodes as neighbours."""
        nodes = np.unique(support_entries(self.points, points)[1]).astype(np.int64)
        losing = set[int]()
        known = {int(j) for j in self.loosened} | set(loosened_nodes)
        for node in nodes[self._node_weights(nodes) < _LOOSE * self._hold[nodes]].tolist():
            if node not in known:
                loosened_nodes.append(node)
                losing |= set(self._hide_node(node).tolist())
        return losing

    def _node_weights(self, nodes: IntArray) -> FloatArray:
        """Return the total weight of nodes at points: the sum over points of shape function times volume, shape (k,) [m^3]."""
        found, volume = np.zeros((len(nodes), 2)), self._points.volume
        weigh_points(self.visibility.seen, self._whole.nodes, volume, nodes, volume, found)
        return found[:, 0]

    def _hide_node(self, node: int) -> IntArray:
        """Hide a node from all points; return the points of which it was a neighbour."""
        nodes, hidden = self._whole.nodes, self.visibility.hidden
        entries = slice(int(nodes.begin[node]), int(nodes.begin[node + 1]))
        points = nodes.points[entries].astype(np.int64)
        places = self._whole.points.begin[points].astype(np.int64) + nodes.slot[entries]
        saw = ~hidden[places]
        hidden[places] = True
        return points[saw]

    def is_beside_crack(self, point: int) -> bool:
        """Return whether a point carries stress and has neighbours that cracks hide."""
        begin, end = self._whole.points.begin[point : point + 2].tolist()
        return bool(self.visibility.hidden[begin:end].any()) and float(point) not in self.eroded

    def _add_facet(self, facet: FloatArray) -> IntArray:
        """Add a facet, and hide nodes behind it; return the points that lose neighbours."""
        p = int(facet[0])
        if self.check.cracks[p] == 0:
            self.check.normal[p] = facet[4:7]
        self.check.cracks[p] += 1
        self.means.sound[p] = False
        self.check.since[p] = int(facet[8])
        ring = self._lattice.axes[1]
        near = self._nearby_columns(facet, ring.count)
        mark_cut_links(facet, self._lattice, near, self.links)
        self.severed[near] = severed_links(self.links[near])
        return self.visibility.hide_neighbours(facet)

    def _nearby_columns(self, facet: FloatArray, around: int) -> IntArray:
        along = np.arange(max(int(facet[1]) - 2, 0), min(int(facet[1]) + 3, self._lattice.shape[0]))
        across = np.arange(int(facet[2]) - 2, int(facet[2]) + 4)
        across = np.unique(across % around) if self._lattice.axes[1].is_closed else across[(across >= 0) & (across < around)]
        return (along[:, None] * around + across).ravel()

    def _choose_facet(self, state: State, p: int) -> FloatArray:
        """Return the facet of a point: on the side where a crack already is, otherwise on the more loaded side."""
        normal = self._fracture_values(state, self.means.stress, np.array([p]))[0, 1:]
        side = self._open_side(p, normal) or self._loaded_side(state, p, normal) or 1
        first = self._make_facet(p, normal, side)
        if self.visibility.is_spanned_behind(first, p):
            return first
        second = self._make_facet(p, normal, -side)
        return second if self.visibility.is_spanned_behind(second, p) else first

    def _make_facet(self, p: int, normal: FloatArray, side: int) -> FloatArray:
        beside = self._shift * max(abs(normal[0]), abs(normal[1])) if normal[2] == 0.0 else _BESIDE_POINTS
        middle, cell = self._point_indices(p), self._thickness_cell(p)
        middle[2] = cell[0] if normal[2] == 0.0 else middle[2]
        return np.concatenate([[p], middle + side * beside * normal, normal, [cell[1]]])

    def _point_indices(self, p: int) -> FloatArray:
        """Return the position of a point in index space: its fractional node numbers along the axes."""
        return self._points.indices(np.array([p]))[0]

    def _thickness_cell(self, p: int) -> tuple[float, float]:
        """Return the middle and half the extent of a point's part of the thickness, in index space.

        The outermost parts extend beyond the surface, and below a notch through the whole notch.
        """
        column, layer = divmod(p, self._through)
        heights = self._points.heights[column * self._through : (column + 1) * self._through]
        bounds = [-0.5, *(0.5 * (heights[1:] + heights[:-1])), self._lattice.shape[2] - 0.5]
        low, high = bounds[layer : layer + 2]
        return 0.5 * (high + low), 0.5 * (high - low)

    def _index_offsets(self, places: FloatArray, p: int) -> FloatArray:
        """Return the vectors from a point to places, in index space, the shorter way around a ring, shape (k, 3)."""
        offsets, ring = places - self._point_indices(p), self._lattice.axes[1]
        if ring.is_closed:
            offsets[:, 1] -= ring.count * np.floor(offsets[:, 1] / ring.count + 0.5)
        return offsets

    def _open_side(self, p: int, normal: FloatArray) -> int:
        """Return the side (+1 or -1 along the normal) on which a point has lost more neighbours; 0 for none."""
        begin, end = self._whole.points.begin[p : p + 2].tolist()
        _, nodes, _ = support_entries(self._whole.points, np.array([p]))
        lost = nodes[self.visibility.hidden[begin:end]].astype(np.int64)
        return int(np.sign(np.sign((self._index_offsets(self._lattice.indices(lost), p) * normal).sum(axis=1)).sum()))

    def _loaded_side(self, state: State, p: int, normal: FloatArray) -> int:
        """Return the side whose neighbouring points have larger fracture ratios; 0 if both are equal."""
        around = self._neighbour_points(p)
        beyond = (self._index_offsets(self._points.indices(around), p) * normal).sum(axis=1)
        ratios = self._fracture_values(state, self.means.stress, around)[:, 0] / self.check.limit[around]
        low, high = (ordered_sum(ratios[side]) for side in (beyond < -_ASIDE, beyond > _ASIDE))
        return 0 if abs(high - low) <= _EQUAL * (abs(low) + abs(high)) else (1 if high > low else -1)

    def _neighbour_points(self, p: int) -> IntArray:
        """Return the points in the same layer of the neighbouring columns of points."""
        along, across = len(self.check.along), len(self.check.across)
        column, layer = divmod(p, self._through)
        x, y = (one.ravel() for one in np.meshgrid(*(np.arange(-1, 2) + one for one in divmod(column, across)), indexing="ij"))
        there = (x >= 0) & (x < along) & (self._lattice.axes[1].is_closed | ((y >= 0) & (y < across)))
        around = (x * across + y % across)[there]
        return around[around != column] * self._through + layer

    def _point_stiffness(self, points: IntArray) -> FloatArray:
        """Return V sum_J |grad N_J|^2 / m_J of points: their part in the squared frequency over the squared sound speed."""
        table = self.points
        owner, nodes, rows = support_entries(table, points)
        gradients = table.gradients[rows]
        gradients[:, 0] *= table.along[points][owner]
        terms = (gradients * gradients).sum(axis=1) / self._whole.nodes.mass[nodes]
        return table.volume[points] * np.bincount(owner, weights=terms, minlength=len(points))

    # -- tables -----------------------------------------------------------------------------------------------------

    @property
    def points(self) -> Points:
        """The integration points with the stencils that remain after cracks."""
        seen = self.visibility.seen
        return self._whole.points._replace(kind=seen.kind, first=seen.first, gradients=seen.gradients, along=seen.along)

    def _update_tables(self) -> None:
        """Update the tables of the kernels: neighbours of points, hourglass ties, and the surface under pressure."""
        lattice, whole = self._lattice, self._whole
        self.means.sound[self.eroded.astype(np.int64)] = False
        self.labels, self.borne = self._label_pieces()
        self.detached: Marks = detached_columns(lattice, self.severed, self.labels) | self._loose_columns()
        self.released: Marks = crack_lips(lattice, self.severed) | self.detached
        surface = whole.surface._replace(around=self._area_neighbours())
        self.solid = whole._replace(
            points=self.points, hourglass=whole.hourglass._replace(partner=self._uncut_ties()), surface=surface
        )

    def _label_pieces(self) -> tuple[IntArray, Marks]:
        """Return the piece number of each column, i.e. the piece's first column, and whether any point supports the column."""
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
        """Number of pieces; columns in no point's support do not count."""
        return len(np.unique(self.labels[self.borne]))

    def _cut_sides(self, is_cut: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
        """Return whether each column is cut from its neighbour before and after, along and across, shape (columns, 4)."""
        n, m, _ = self._lattice.shape
        along, across = is_cut[:, 0].reshape(n, m), is_cut[:, 1].reshape(n, m)
        sides = (np.roll(along, 1, axis=0), along, np.roll(across, 1, axis=1), across)
        return np.stack([one.ravel() for one in sides], axis=1)

    def _uncut_ties(self) -> ColumnArray:
        """Return the partners of each column in hourglass control: none across a crack or at a column with an eroded point."""
        partner = self._whole.hourglass.partner
        if len(partner) == 0:
            return partner
        lost = np.zeros(len(partner) + 1, dtype=bool)
        lost[self.eroded.astype(np.int64) // self._through] = True
        cut = self._cut_sides(np.any(self.links[:, :2] > 0, axis=2))
        return np.where(cut | lost[:-1, None] | lost[partner], -1, partner)

    def _area_neighbours(self) -> ColumnArray:
        """Return for each node of the inner surface the neighbours that span its area; across a crack, the node itself.

        A loosened node spans no area with the nodes from which it has separated, because this area would grow without bound.
        """
        around = self._whole.surface.around
        own = np.broadcast_to(np.arange(len(around), dtype=np.int32)[:, None], around.shape)
        cut = self._cut_sides(self.links[:, :2, 0] > 0) & (around != own)
        return np.where(cut | self.released[:, None] | self.detached[around], own, around)

    def _loose_columns(self) -> Marks:
        """Return the columns whose node on the inner surface has been loosened."""
        found = np.zeros(len(self.labels), dtype=bool)
        loosened = self.loosened.astype(np.int64)
        layers = self._lattice.shape[2]
        found[loosened[loosened % layers == 0] // layers] = True
        return found
