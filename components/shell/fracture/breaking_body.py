"""A body that breaks: it advances by single ticks and adds cracks after each; energies, events and outputs of the cracks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cached_property, partial
from typing import Any

import numpy as np

from ...drawables import Drawable, Links, Points
from ...errors import ParameterError
from ...events import MOST_INDEX, Event, EventDetail
from ...state_block import LARGEST, Block, Layout
from ...support.float_arrays import FloatArray, ordered_sum
from .. import kernels
from ..column_means import write_column_means
from ..energies import elastic_energy, leapfrog_energy
from ..geometry.lattice import Lattice
from ..kernel_arrays import ColumnArray, IntArray, Solid, Tables, support_entries
from ..kernel_setup import Assembly, station_means
from ..outputs import Output, make_output
from ..parameters import ShellParameters
from ..ticks import Failure, advance_tick, finish_tick, record_failure, write_forces
from .cracks import ERODED, KINDS, LOOSENED, LOST_KINDS, PARTED, SPENT, TORN, Cause, Cracks, NewCracks
from .facets import facet_declaration
from .force_recalculation import displacement_gradients, half_kick_work, volume_ratios, write_pull
from .fracture_check import find_cracking_points
from .laws.fracture_law import FractureLaw
from .open_area import crack_length, open_areas
from .outcome import AXIAL, OUTCOMES, CutSides, axial_crack_extent, circumferential_crack_part, connects_ends, outcome
from .pieces import ACROSS, ALONG, Marks
from .visibility import Visibility

_FRACTURE, _ERODED = 0, 1
# Largest value that an event records.
_LARGEST = 1e300
# A point at a crack with a relative volume outside this range has neighbours on other pieces.
_VOLUMES = (0.5, 2.0)
_FEWEST = {"linear": 4, "quadratic": 10}
# A caution is issued if a larger fraction of the mass is eroded.
_ERODED_PART = 0.1
AddEvent = Callable[[int, str, int, float, float], None]


class BreakingBody:
    """The cracks of a body, kept in the state of its component and in the tables of the kernels."""

    def __init__(self, parameters: ShellParameters, law: FractureLaw, assembly: Assembly, intact_solid: Solid) -> None:
        """Build from the tables of the intact body.

        Raises:
            ParameterError: the law requires a material with plastic flow.
        """
        if law.needs_flow and not intact_solid.plastic:
            raise ParameterError(
                f"got the law {law.name!r} with an elastic material", expected="a material that flows",
                hint="choose material = 'thermoviscoplastic', or fracture = {name = 'principal_stress', stress = ...}",
                at="fracture",
            )  # fmt: skip
        self.law, self._parameters, self._assembly = law, parameters, assembly
        self.details = {
            PARTED: EventDetail(law.unit, "points", "fracture_ratio"), ERODED: EventDetail("1", "points"),
            SPENT: EventDetail(law.unit, "points"), TORN: EventDetail("1", "points"),
            LOOSENED: EventDetail("", "nodes"),
        }  # fmt: skip
        self.cracks = Cracks(parameters, law, assembly, intact_solid)
        points, nodes = len(assembly.points.volume), assembly.lattice.node_count
        self.growing: Layout = {
            "facets": facet_declaration(points, assembly.lattice.shape),
            "eroded": ("f8", (), 0, points - 1, points), "loosened": ("f8", (), 0, nodes - 1, nodes),
        }  # fmt: skip
        self.fields: Layout = {"losses": ("f8", (2,)), "nearest": ("f8", (3,), 0, (LARGEST, points - 1, MOST_INDEX))}
        self._found = np.zeros(points, dtype=np.int64)
        self._seen_facets = np.zeros((0, 9))

    def attach_state(self, block: Block, tables: Tables, add_event: AddEvent) -> None:
        """Attach the state, whose layout has `growing` and `fields`, and the tables of the whole body that refer to it."""
        self._block, self._tables, self._add_event = block, tables, add_event

    def contradiction(self, state: Mapping[str, np.ndarray]) -> str:
        """Return which list of the state has another length than its events require, or ""."""
        names, numbers = list(KINDS), state["events"][:, 1].astype(np.int64)
        for name, kinds in (("facets", (PARTED,)), ("eroded", LOST_KINDS), ("loosened", (LOOSENED,))):
            noted = np.count_nonzero(np.isin(numbers, [names.index(kind) for kind in kinds]))
            if noted != len(state[name]):
                return f"got {len(state[name])} {name}, but {noted} events of them"
        return ""

    def tables(self) -> Tables:
        """Return the tables of the kernels with the cracks of the state."""
        self.cracks.load_state(self._block["facets"], self._block["eroded"], self._block["loosened"])
        return self._tables._replace(solid=self.cracks.solid)

    # -- ticks ------------------------------------------------------------------------------------------------------

    def advance(self, signals: FloatArray, pressures: FloatArray, first_tick: int, failure_out: IntArray) -> int:
        """Advance like `ticks.advance`; at the end of each tick add cracks at the points beyond their limit."""
        tables, cracks, block = self.tables(), self.cracks, self._block
        state = tables.state
        for row in range(len(signals)):
            tick = first_tick + row
            failures = advance_tick(tables, signals[row], pressures, cracks.is_beside_crack)
            for failure in failures:
                if not cracks.is_beside_crack(failure.point):
                    return record_failure(failure, tables.scratch, tick, failure_out)
            if failures:
                tables = self._erode_failed_points(failures, tick + 1)
                finish_tick(tables, signals[row], pressures)
            write_column_means(state.stress, cracks.means)
            check = (cracks.check, cracks.means.stress, state.gradient, state.plastic_strain)
            count = find_cracking_points(*check, self._found, block["nearest"], tick + 1)
            if count:
                tables = self._add_cracks(self._found[:count].copy(), tick + 1)
        return 0

    def _add_cracks(self, cracking_points: IntArray, tick: int) -> Tables:
        """Add cracks at `cracking_points` at the end of a tick; return the new tables of the body."""
        state, scratch, losses = self._tables.state, self._tables.scratch, self._block["losses"]
        before = self.cracks.solid
        new_cracks = self._erode_distorted_points(self.cracks.add_cracks(state, cracking_points, tick))
        after = self.cracks.solid
        points, columns, nodes = self._affected_parts(new_cracks.changed)
        losses[_FRACTURE] += ordered_sum(scratch.tie_energy[columns]) + leapfrog_energy(before, state, nodes)
        self._remove_eroded_stress(new_cracks)
        write_pull(after, state, scratch, points)
        write_forces(after, state, scratch, columns, nodes)
        kernels.write_areas(after.surface, state.displacement, state.area)
        losses[_FRACTURE] -= ordered_sum(scratch.tie_energy[columns]) + leapfrog_energy(after, state, nodes)
        self._record_cracks(new_cracks, tick)
        return self._tables._replace(solid=after)

    def _erode_failed_points(self, failures: list[Failure], tick: int) -> Tables:
        """Erode the points at which a tick failed; return the tables with which to finish the tick."""
        state, scratch = self._tables.state, self._tables.scratch
        torn = {failure.point: Cause(TORN, failure.value, failure.limit) for failure in failures}
        self._block["losses"][_ERODED] += ordered_sum(*(half_kick_work(self.cracks.solid, state, point) for point in torn))
        new_cracks = self._erode_distorted_points(self.cracks.erode_points(torn))
        self._remove_eroded_stress(new_cracks)
        write_pull(self.cracks.solid, state, scratch, new_cracks.changed)
        self._record_cracks(new_cracks, tick)
        return self._tables._replace(solid=self.cracks.solid)

    def _erode_distorted_points(self, new_cracks: NewCracks) -> NewCracks:
        """Erode points whose remaining neighbours give a volume that no metal has.

        Their stress would produce extremely large forces.
        """
        while True:
            left = np.setdiff1d(new_cracks.changed, np.array(list(new_cracks.eroded), dtype=np.int64))
            ratios = volume_ratios(displacement_gradients(self.cracks.points, self._tables.state.displacement, left))
            wild = ~((ratios > _VOLUMES[0]) & (ratios < _VOLUMES[1]))
            if not wild.any():
                return new_cracks
            found = zip(left[wild].tolist(), ratios[wild].tolist(), strict=True)
            new_cracks = new_cracks.merged_with(
                self.cracks.erode_points({p: Cause(TORN, ratio, _VOLUMES[ratio > 1.0]) for p, ratio in found})
            )

    def _remove_eroded_stress(self, new_cracks: NewCracks) -> None:
        """Set the stress of eroded points to 0, and update the displacement gradients of points with changed neighbours."""
        state, points = self._tables.state, np.array(list(new_cracks.eroded), dtype=np.int64)
        self._block["losses"][_ERODED] += elastic_energy(self.cracks.solid, state, points)
        state.stress[points] = state.gradient[points] = 0.0
        state.gradient[new_cracks.changed] = displacement_gradients(self.cracks.points, state.displacement, new_cracks.changed)

    def _affected_parts(self, changed_points: IntArray) -> tuple[IntArray, IntArray, IntArray]:
        """Return the points, the columns with ties, and the nodes whose forces change if some points change."""
        tied, points, columns = self._assembly.solid.hourglass, changed_points, np.zeros(0, dtype=np.int64)
        if len(tied.partner):
            own = np.unique(changed_points // tied.points)
            columns = np.unique(np.concatenate([own, tied.partner[own].ravel()])).astype(np.int64)
            columns = columns[columns >= 0]
            points = (columns[:, None] * tied.points + np.arange(tied.points)).ravel()
        return points, columns, np.unique(support_entries(self._assembly.solid.points, points)[1]).astype(np.int64)

    def _record_cracks(self, new_cracks: NewCracks, tick: int) -> None:
        """Append the cracks of a tick to the state, and record their events."""
        for facet, cause in new_cracks.facets:
            self._block.append("facets", facet)
            self._add_event(tick, PARTED, int(facet[0]), cause.value, cause.limit)
        for kind in (SPENT, TORN):
            for point, cause in new_cracks.eroded.items():
                if cause is not None and cause.kind == kind:
                    value = cause.value if abs(cause.value) < _LARGEST else _LARGEST
                    self._add_event(tick, kind, point, value, cause.limit)
        begin, hidden = self._assembly.stencils.begin, self.cracks.visibility.hidden
        for point, cause in new_cracks.eroded.items():
            self._block.append("eroded", float(point))
            if cause is None:
                left = np.count_nonzero(~hidden[begin[point] : begin[point + 1]])
                self._add_event(tick, ERODED, point, float(left), float(_FEWEST[self._parameters.basis]))
        for node in new_cracks.loosened:
            self._block.append("loosened", float(node))
            self._add_event(tick, LOOSENED, node, 0.0, 0.0)

    # -- reading ----------------------------------------------------------------------------------------------------

    @property
    def cracked_stencils(self) -> Any:
        """The stencils (neighbours and shape functions) of the points with the cracks of the state."""
        self.tables()
        return self.cracks.visibility.seen

    @cached_property
    def _node_stencils(self) -> Visibility:
        """Stencils (neighbours and shape functions) at the nodes, for the output of displacements."""
        lattice, p = self._assembly.lattice, self._parameters
        self._seen_facets = np.zeros((0, 9))
        return Visibility(lattice, lattice.indices, self._assembly.node_stencils, p.chosen_radius, p.basis)

    def node_values(self, parameters: FloatArray) -> FloatArray:
        """Return the values of a field at the nodes from its parameters; at a node isolated by cracks, its own parameter."""
        self.tables()
        nodes, facets, known = self._node_stencils, self.cracks.facets, len(self._seen_facets)
        if known > len(facets) or not np.array_equal(facets[:known], self._seen_facets):
            nodes.clear()
            known = 0
        if len(facets) > known:
            changed = np.unique(np.concatenate([nodes.hide_neighbours(facet) for facet in facets[known:]]))
            for node in changed[~nodes.rebuild_stencils(changed)]:
                neighbours, row = nodes.seen.neighbours(node), int(nodes.seen.first[nodes.seen.kind[node]])
                nodes.seen.values[row : row + len(neighbours)] = neighbours == node
        self._seen_facets = facets
        out = np.zeros_like(parameters)
        kernels.interpolate_field(nodes.seen, parameters, out)
        return out

    def mean_stress(self) -> FloatArray:
        """Return the stress averaged over columns that the fracture law uses, shape (m, 6); see `column_means`."""
        write_column_means(self.tables().state.stress, self.cracks.means)
        return self.cracks.means.stress

    def fracture_ratios(self) -> FloatArray:
        """Return the fracture ratio of each point: the value that the fracture law tests, over its limit."""
        self.mean_stress()
        return self.cracks.fracture_ratios(self._tables.state)

    def dissipated_energies(self) -> dict[str, float]:
        """Return the energies dissipated by cracks [J]: those of cut hourglass ties, and those of eroded points."""
        fracture, eroded = self._block["losses"].tolist()
        return {"fracture_energy": fracture, "eroded_energy": eroded}

    def report(self, step_size: float) -> dict[str, float]:
        """Return figures for the report: the largest fracture ratio with its place and time, and numbers on the cracks."""
        self.tables()
        ratio, point, tick = self._block["nearest"].tolist()
        found = {
            "points that have parted": float(np.count_nonzero(self.cracks.check.cracks)),
            "eroded points": float(len(self.cracks.eroded)), "pieces": float(self.cracks.piece_count),
            "crack length, m": crack_length(self._assembly, self.cracks),
        }  # fmt: skip
        if ratio > 0.0:
            along, across, _ = self._assembly.coordinates(int(point))
            found |= {
                "largest fracture ratio so far, above 0.5": ratio, "at, s": tick * step_size, "along the body, m": along,
                ("angle around, rad" if self._assembly.lattice.bent else "across the body, m"): across,
            }  # fmt: skip
        return found

    def drawables(self, size: float) -> tuple[Drawable, ...]:
        """Return the points, coloured by their fracture ratio, and the surface links that no crack has cut."""
        lattice = self._assembly.lattice
        indices = self._assembly.points.all_indices().T
        places = lattice.positions(*(axis.coordinates(one) for axis, one in zip(lattice.axes, indices, strict=True)))
        return (
            Points("points", places, np.full(len(places), size), "point_displacement", "fracture_ratio"),
            Links("surface links", "nodes", lattice.top_nodes[self.surface_pairs], "surface_links"),
        )

    def outputs(self) -> Iterator[Output]:
        """Yield the outputs on cracks; each one updates the cracks from the state before it is read."""

        def read_with_tables(read: Callable[[], Any]) -> Any:
            self.tables()
            return read()

        for variable, read in self._output_readers():
            yield Output(variable, partial(read_with_tables, read))

    def _output_readers(self) -> Iterator[Output]:
        cracks, lattice, m = self.cracks, self._assembly.lattice, len(self._found)
        limit, text = cracks.check.limit, "limit of the fracture law at each point"
        yield make_output("fracture_limit", self.law.unit, (m,), text, limit.copy, "point")
        text = "displacement of the points, 0 at eroded points"
        yield make_output("point_displacement", "m", (m, 3), text, self._point_displacement, "point", "direction")
        text = "0 if a crack cuts this link of two columns of the outer surface or a column is in no point's support, else 1"
        yield make_output(
            "surface_links", "1", (len(self.surface_pairs),), text, self._surface_links, "link", minimum=0.0, maximum=1.0
        )
        text = "0 if a crack cuts an edge of this cell of the outer surface or a corner is in no point's support, else 1"
        yield make_output(
            "surface_cells",
            "1",
            ((lattice.shape[0] - 1) * self._cells_across,),
            text,
            self._surface_cells,
            "cell",
            minimum=0.0,
            maximum=1.0,
        )
        text = (
            "0 whole, 1 bulged, 2 axial crack, 3 hoop crack (around the body), 4 severed (no piece reaches from one end to the "
            "other); 2 and 3 are decided by the cracks through the wall if there are any"
        )
        yield make_output("outcome", "1", (), text, lambda: float(self.outcome()), minimum=0.0, maximum=4.0)
        amounts: list[tuple[str, str, tuple[int, ...], str, Callable[[], Any], *tuple[str, ...]]] = [
            ("cracks", "1", (m,), "number of cracks of each point", lambda: cracks.check.cracks.astype(float), "point"),
            ("pieces", "1", (), "number of pieces of the body that carry stress", lambda: float(cracks.piece_count)),
            ("crack_along", "m", (), "extent of all cracks along the body, at any depth of the wall",
             lambda: axial_crack_extent(lattice, self._cut_sides())),
            ("crack_around", "1", (), "largest fraction of the circumference, or of the width, that one crack spans",
             lambda: circumferential_crack_part(lattice, self._cut_sides())),
            ("crack_length", "m", (), "total length of cracks in the surface", lambda: crack_length(self._assembly, cracks)),
            ("crack_area", "m^2", lattice.shape[:1], "open area of the cracks through the wall, at each plane of nodes",
             lambda: open_areas(lattice, cracks, self.node_values(self._tables.state.displacement)), "station"),
            ("eroded_mass", "kg", (), "mass of the points that no longer carry stress", self.eroded_mass),
        ]  # fmt: skip
        for name, unit, shape, text, read, *axes in amounts:
            yield make_output(name, unit, shape, text, read, *axes, minimum=0.0)

    def _point_displacement(self) -> FloatArray:
        out = np.zeros((len(self._found), 3))
        kernels.interpolate_field(self.cracks.visibility.seen, self._tables.state.displacement, out)
        return out

    def eroded_mass(self) -> float:
        """Return the mass of the eroded points [kg]."""
        volume = self._assembly.points.volume[self.cracks.eroded.astype(np.int64)]
        return float(self._parameters.material.density * volume.sum())

    @property
    def surface_pairs(self) -> ColumnArray:
        """The pairs of neighbouring columns, first along the body, then across, shape (links, 2)."""
        n, m, _ = self._assembly.lattice.shape
        columns = np.arange(n * m, dtype=np.int32).reshape(n, m)
        pairs = (
            (columns[:-1], columns[1:]),
            (columns[:, : self._cells_across], np.roll(columns, -1, axis=1)[:, : self._cells_across]),
        )
        return np.concatenate([np.stack([one.ravel(), other.ravel()], axis=1) for one, other in pairs])

    @property
    def _cells_across(self) -> int:
        """Number of surface cells across the body, or around it."""
        across = self._assembly.lattice.axes[1]
        return across.count if across.is_closed else across.count - 1

    def _intact_sides(self) -> tuple[Marks, Marks]:
        """Return whether columns are linked at the outer surface to the next one along, (n - 1, m), and across, (n, rows)."""
        cut, borne = (
            self._neighbour_sides(self.cracks.links[:, :, -1] > 0),
            self.cracks.borne.reshape(self._assembly.lattice.shape[:2]),
        )
        across = ~cut.across & borne & np.roll(borne, -1, axis=1)
        return ~cut.along[:-1] & borne[:-1] & borne[1:], across[:, : self._cells_across]

    def _surface_links(self) -> FloatArray:
        """Return 1 for each intact link of `surface_pairs`, 0 for one cut by a crack, or at a column in no point's support."""
        return np.concatenate([sides.ravel() for sides in self._intact_sides()]).astype(np.float64)

    def _surface_cells(self) -> FloatArray:
        """Return 1 for each cell of the surface whose edges are all intact, otherwise 0."""
        along, across = self._intact_sides()
        sides = (along & np.roll(along, -1, axis=1))[:, : self._cells_across]
        return (sides & across[:-1] & across[1:]).ravel().astype(np.float64)

    def _cut_sides(self) -> CutSides:
        """Return the sides between neighbouring columns that a crack cuts at any depth of the wall, as `CutSides`.

        Columns in no point's support do not count.
        """
        return self._neighbour_sides(np.any(self.cracks.links > 0, axis=2))

    def _severed_sides(self) -> CutSides:
        """Return the sides between columns that a crack cuts through the whole wall, as `CutSides`."""
        return self._neighbour_sides(self.cracks.severed)

    def _neighbour_sides(self, is_cut: Marks) -> CutSides:
        """Return as `CutSides` the cut links, shape (columns, 4), along and across, where there is a next column."""
        around, (n, m, _) = self._assembly.solid.surface.around, self._assembly.lattice.shape
        own = np.arange(len(around))
        return CutSides(*((is_cut[:, way] & (around[:, side] != own)).reshape(n, m) for way, side in ((ALONG, 1), (ACROSS, 3))))

    def outcome(self) -> int:
        """Return the number of the present outcome in `OUTCOMES`."""
        lattice, cracks, state = self._assembly.lattice, self.cracks, self._tables.state
        is_severed = not connects_ends(cracks.labels, cracks.borne, lattice.shape[:2])
        strain = station_means(self._assembly, state.plastic_strain) if cracks.solid.plastic else np.zeros(1)
        through = self._severed_sides()
        return outcome(lattice, through if through.is_cut else self._cut_sides(), is_severed, strain)

    def conclusions(self, step_size: float) -> list[str]:
        """Return sentences on what has become of the body, and why it did or did not break."""
        self.tables()
        facets, number = self.cracks.facets, self.outcome()
        found = [f"outcome: {OUTCOMES[number]}"]
        if number >= AXIAL:
            found[0] += f": {self._describe_cracks()}; {self._describe_pieces()}"
        elif len(facets):
            found[0] += ": no crack separates columns of nodes; some lie within the wall or at its edges"
        if len(facets):
            parted, place = np.count_nonzero(self.cracks.check.cracks), self._assembly.describe_position(int(facets[0, 0]))
            time = 1e6 * facets[0, 8] * step_size
            return [*found, f"the first of {parted} parted points parted at {time:.4g} us, at {place}"]
        ratio, point, tick = self._block["nearest"].tolist()
        place = self._assembly.describe_position(int(point))
        near = f"reached at most {ratio:.3g} of its limit, at {1e6 * tick * step_size:.4g} us, at {place}"
        return [*found, f"{self.law.quantity} {near if ratio > 0.0 else 'stayed below half of its limit everywhere'}"]

    def _describe_cracks(self) -> str:
        """Return a text on the extent of cracks at any depth, and through the whole wall."""
        lattice, through = self._assembly.lattice, self._severed_sides()
        whole, leaks = "circumference" if lattice.bent else "width", "none of them passes through the wall"
        if through.is_cut:
            leaks = f"those through the wall {_describe_extent(lattice, through)}"
        return f"cracks {_describe_extent(lattice, self._cut_sides())} of the {whole}, {leaks}"

    def _describe_pieces(self) -> str:
        """Return a text with the number of pieces, and the number of columns in detached pieces."""
        pieces, lost = self.cracks.piece_count, np.count_nonzero(~self.cracks.borne)
        words = f"{pieces} {'piece' if pieces == 1 else 'pieces'}"
        return f"{words}, and {lost} fully detached {'column' if lost == 1 else 'columns'} of nodes" if lost else words

    def cautions(self, events: list[Event], step_size: float, mass: float) -> list[str]:
        """Return a caution if a large part of the body has been eroded, which is irreversible."""
        self.tables()
        part = self.eroded_mass() / mass
        if part <= _ERODED_PART:
            return []
        first = next(event for event in events if event.kind in LOST_KINDS)
        assert first.index is not None
        place = self._assembly.describe_position(first.index)
        return [
            f"{part:.0%} of the mass no longer carries stress (first eroded point at {1e6 * first.tick * step_size:.4g} us, "
            f"{place}): the remaining points do not represent the body; load it less, or give more nodes"
        ]


def _describe_extent(lattice: Lattice, sides: CutSides) -> str:
    along, around = 1e3 * axial_crack_extent(lattice, sides), 100.0 * circumferential_crack_part(lattice, sides)
    return f"reach {along:.3g} mm along the body and take up to {around:.3g} %"
