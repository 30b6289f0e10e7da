"""A body that breaks: ticks one by one, the cracks after each, their energies and events, and outputs on them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from ...drawables import Drawable, Links, Points
from ...errors import ParameterError
from ...events import MOST_INDEX, EventDetail
from ...materials.elastic import Material, rayleigh_speed
from ...state_block import LARGEST, Block, Layout
from ...support.float_arrays import FloatArray
from ...variables import Variable
from .. import kernels
from ..column_means import write_column_means
from ..kernel_arrays import ColumnArray, IntArray, Scratch, Solid, State
from ..kernel_setup import Assembly, station_means, surface_quads
from ..parameters import ShellParameters
from ..ticks import Failure, Inputs, advance_tick, finish_tick, note_failure
from .cracks import Cracks, Parting
from .facets import facet_rows
from .force_recalculation import (
    erode,
    leapfrog_energy,
    new_gradients,
    refresh_forces,
    tie_energy,
    volume_ratios,
    work_of_half_kick,
    write_pull,
)
from .judgement import UNBREAKABLE, find_parting, points_in_grips, write_ratios
from .law import FractureLaw
from .open_area import crack_length, open_areas
from .outcome import (
    AXIAL,
    OUTCOMES,
    CutSides,
    connects_ends,
    crack_along,
    crack_around,
    growth,
    outcome,
    part_faster,
    tip_speed,
)
from .pieces import ACROSS, ALONG, Marks
from .visibility import Visibility

PARTED, ERODED, SPENT, TORN = "point_parted", "point_eroded", "point_spent", "point_torn"
# After these a point bears nothing any more.
LOST_KINDS = (ERODED, SPENT, TORN)
LOOSENED = "node_loosened"
KINDS = {
    PARTED: "a point passed the limit of the fracture law: a crack normal to the largest principal stress begins there",
    SPENT: "a point that has parted, and has had time to unload, passed the limit again: it bears nothing any more",
    TORN: "a point beside cracks was inverted or strained beyond measure: it bears nothing any more",
    LOOSENED: "hardly any point sees a node any more: it flies on, and nothing holds it",
    ERODED: "the nodes that cracks have left to a point do not span its functions: it bears nothing any more",
}
_FRACTURE, _ERODED = 0, 1
# Values of events are at most this one.
_LARGEST = 1e300
# Volumes over that at the start outside of which a point beside a crack sees displacements that are no strain of its own.
_VOLUMES = (0.5, 2.0)
_FEWEST = {"linear": 4, "quadratic": 10}
AddEvent = Callable[[int, str, int, float, float], None]


class BreakingBody:
    """The cracks of a component, in its state and in the tables of its kernels."""

    def __init__(self, parameters: ShellParameters, law: FractureLaw, assembly: Assembly, whole: Solid) -> None:
        """Take the body without cracks.

        Raises:
            ParameterError: the law wants a material that flows.
        """
        if law.needs_flow and not whole.plastic:
            raise ParameterError(
                f"got the law {law.name!r} with an elastic material", expected="one that flows",
                hint="choose material = 'thermoviscoplastic', or fracture = {name = 'principal_stress', stress = ...}",
                at="fracture",
            )  # fmt: skip
        self.law = law
        self._parameters, self._assembly = parameters, assembly
        self.details = {
            PARTED: EventDetail(law.unit, "points", "fracture_ratio"), ERODED: EventDetail("1", "points"),
            SPENT: EventDetail(law.unit, "points"), TORN: EventDetail("1", "points"),
            LOOSENED: EventDetail("", "nodes"),
        }  # fmt: skip
        self.cracks = Cracks(
            assembly.lattice, assembly.points, assembly.stencils, whole, law, parameters.chosen_radius, parameters.basis
        )
        self.cracks.judged.limit[points_in_grips(parameters, assembly, law.grip_length)] = UNBREAKABLE
        points, nodes = len(assembly.points.volume), assembly.lattice.node_count
        self.growing: Layout = {
            "facets": facet_rows(points, assembly.lattice.shape),
            "eroded": ("f8", (), 0, points - 1, points), "loosened": ("f8", (), 0, nodes - 1, nodes),
        }  # fmt: skip
        self.fields: Layout = {"losses": ("f8", (2,)), "nearest": ("f8", (3,), 0, (LARGEST, points - 1, MOST_INDEX))}
        self._found = np.zeros(points, dtype=np.int64)
        self._seen_facets = np.zeros((0, 9))

    def contradiction(self, state: Mapping[str, np.ndarray]) -> str:
        """Return which list of the state has another length than its events; "" where none has."""
        names, numbers = list(KINDS), state["events"][:, 1].astype(np.int64)
        for name, kinds in (("facets", (PARTED,)), ("eroded", LOST_KINDS), ("loosened", (LOOSENED,))):
            noted = np.count_nonzero(np.isin(numbers, [names.index(kind) for kind in kinds]))
            if noted != len(state[name]):
                return f"got {len(state[name])} {name}, and {noted} events of them"
        return ""

    def solid(self, block: Block) -> Solid:
        """Return the tables of the kernels with the cracks of the state."""
        self.cracks.follow(block["facets"], block["eroded"], block["loosened"])
        return self.cracks.solid

    # -- ticks ------------------------------------------------------------------------------------------------------

    def advance(
        self, block: Block, state: State, scratch: Scratch, signals: FloatArray, pressures: FloatArray, first_tick: int,
        failed: IntArray, add_event: AddEvent,
    ) -> int:  # fmt: skip
        """Advance as `ticks.advance` does, and part at the end of each tick the points beyond their limit."""
        solid = self.solid(block)
        for row in range(len(signals)):
            tick = first_tick + row
            inputs = Inputs(signals[row], pressures, block["tally"])
            failures = advance_tick(solid, state, scratch, inputs, tick, self.cracks.is_beside_crack)
            for failure in failures:
                if not self.cracks.is_beside_crack(failure.point):
                    return note_failure(failure, scratch, tick, failed)
            if failures:
                solid = self._tear(block, state, scratch, failures, tick + 1, add_event)
                finish_tick(solid, state, scratch, inputs)
            count = find_parting(solid, state, self.cracks.judged, self._found, block["nearest"], tick + 1)
            if count:
                solid = self._part(block, state, scratch, self._found[:count].copy(), tick + 1, add_event)
        return 0

    def _part(
        self, block: Block, state: State, scratch: Scratch, found: IntArray, tick: int, add_event: AddEvent
    ) -> Solid:  # fmt: skip
        """Part the body at some points; return its tables."""
        before = self.cracks.solid
        parting = self._without_distorted(self.cracks.part(state, found, tick), state)
        after = self.cracks.solid
        points, columns, nodes = self._surroundings(parting.changed)
        losses = block["losses"]
        losses[_FRACTURE] += tie_energy(before, state, columns) + leapfrog_energy(before, state, nodes)
        losses[_ERODED] += erode(after, state, parting.eroded)
        state.gradient[parting.changed] = new_gradients(after, state, parting.changed)
        refresh_forces(after, state, scratch, points, columns, nodes)
        kernels.write_areas(after, state)
        losses[_FRACTURE] -= tie_energy(after, state, columns) + leapfrog_energy(after, state, nodes)
        self._note(block, parting, tick, add_event)
        return after

    def _without_distorted(self, parting: Parting, state: State) -> Parting:
        """Let points bear nothing that see, with the neighbours that are left to them, a volume that no metal has.

        Their stress would be turned into forces beyond measure.
        """
        while True:
            left = np.setdiff1d(parting.changed, parting.eroded)
            ratios = volume_ratios(new_gradients(self.cracks.solid, state, left))
            wild = ~((ratios > _VOLUMES[0]) & (ratios < _VOLUMES[1]))
            if not wild.any():
                return parting
            found = dict(zip(left[wild].tolist(), ratios[wild].tolist(), strict=True))
            more = self.cracks.erode(list(found))
            parting = parting.joined(more, {point: (ratio, _VOLUMES[ratio > 1.0]) for point, ratio in found.items()})

    def _tear(
        self, block: Block, state: State, scratch: Scratch, failures: list[Failure], tick: int, add_event: AddEvent
    ) -> Solid:
        """Erode the points at which a tick failed; return the tables with which it is finished."""
        whole = self.cracks.solid
        torn = {failure.point: (failure.value, failure.limit) for failure in failures}
        losses = block["losses"]
        losses[_ERODED] += sum(work_of_half_kick(whole, state, point) for point in torn)
        parting = self._without_distorted(self.cracks.erode(list(torn))._replace(torn=torn), state)
        solid = self.cracks.solid
        losses[_ERODED] += erode(solid, state, parting.eroded)
        state.gradient[parting.changed] = new_gradients(solid, state, parting.changed)
        write_pull(solid, state, scratch, parting.changed)
        self._note(block, parting, tick, add_event)
        return solid

    def _surroundings(self, changed: IntArray) -> tuple[IntArray, IntArray, IntArray]:
        """Return the points, columns with ties, and nodes whose forces change with some points."""
        some, tied = self._assembly.stencils, self._assembly.solid.hourglass
        points, columns = changed, np.zeros(0, dtype=np.int64)
        if len(tied.partner):
            own = np.unique(changed // tied.points)
            columns = np.unique(np.concatenate([own, tied.partner[own].ravel()])).astype(np.int64)
            columns = columns[columns >= 0]
            points = (columns[:, None] * tied.points + np.arange(tied.points)).ravel()
        seen = [some.neighbours(p) for p in points.tolist()]
        return points, columns, np.unique(np.concatenate([*seen, np.zeros(0, np.uint32)])).astype(np.int64)

    def _note(self, block: Block, parting: Parting, tick: int, add_event: AddEvent) -> None:
        """Put the cracks of a tick into the state, and their events."""
        for facet, (value, limit) in zip(parting.facets, parting.values, strict=True):
            block.append("facets", facet)
            add_event(tick, PARTED, int(facet[0]), value, limit)
        begin, hidden = self._assembly.stencils.begin, self.cracks.visibility.hidden
        for point, (value, limit) in zip(parting.spent, parting.spent_values, strict=False):
            add_event(tick, SPENT, point, value, limit)
        for point, (value, limit) in parting.torn.items():
            add_event(tick, TORN, point, value if abs(value) < _LARGEST else _LARGEST, limit)
        for point in parting.eroded:
            block.append("eroded", float(point))
            if int(point) in parting.spent or int(point) in parting.torn:
                continue
            left = int((~hidden[begin[point] : begin[point + 1]]).sum())
            add_event(tick, ERODED, int(point), float(left), float(_FEWEST[self._parameters.basis]))
        for node in parting.loosened:
            block.append("loosened", float(node))
            add_event(tick, LOOSENED, int(node), 0.0, 0.0)

    # -- reading ----------------------------------------------------------------------------------------------------

    @property
    def values(self) -> FloatArray:
        """Shape functions at the points, by the rows of the tables."""
        return self.cracks.visibility.values

    @cached_property
    def _nodes(self) -> Visibility:
        """Stencils of the nodes themselves, at which displacements are reported."""
        lattice, p = self._assembly.lattice, self._parameters
        self._seen_facets = np.zeros((0, 9))
        stencils = self._assembly.node_stencils
        return Visibility(lattice, lattice.places, stencils, p.chosen_radius, p.basis, has_gradients=False)

    def node_field(self, block: Block, parameters: FloatArray) -> FloatArray:
        """Return a field where the nodes are; a node that cracks have left alone has its parameter."""
        self.solid(block)
        seen, facets = self._nodes, self.cracks.facets
        known = len(self._seen_facets)
        if known > len(facets) or not np.array_equal(facets[:known], self._seen_facets):
            seen.clear()
            known = 0
        if len(facets) > known:
            changed = np.unique(np.concatenate([seen.hide(facet) for facet in facets[known:]]))
            for node in changed[~seen.rebuild(changed)]:
                neighbours, row = self._assembly.node_stencils.neighbours(node), int(seen.first[seen.kind[node]])
                seen.values[row : row + len(neighbours)] = neighbours == node
        self._seen_facets = facets
        out = np.zeros_like(parameters)
        kernels.interpolate(seen.seen, parameters, out)
        return out

    def point_field(self, parameters: FloatArray) -> FloatArray:
        """Return a field at the points; 0 at eroded ones."""
        out = np.zeros((self.point_count, 3))
        kernels.interpolate(self.cracks.visibility.seen, parameters, out)
        return out

    @property
    def point_count(self) -> int:
        """Number of integration points."""
        return len(self._found)

    def mean_stress(self, block: Block, state: State) -> FloatArray:
        """Return the stress that is judged, shape (m, 6)."""
        self.solid(block)
        write_column_means(state.stress, self.cracks.judged.means)
        return self.cracks.judged.means.stress

    def ratios(self, block: Block, state: State) -> FloatArray:
        """Return what decides at each point over its limit."""
        self.mean_stress(block, state)
        out = np.zeros(self.point_count)
        write_ratios(state, self.cracks.judged, out)
        return out

    def losses(self, block: Block) -> dict[str, float]:
        """Return the energies that cracks have taken [J]: of ties that were cut, and of eroded points."""
        return {"fracture_energy": float(block["losses"][_FRACTURE]), "eroded_energy": float(block["losses"][_ERODED])}

    def report(self, block: Block, step_size: float) -> dict[str, float]:
        """Return how near the body came to parting, where and when, and what cracks have done."""
        self.solid(block)
        ratio, point, tick = (float(one) for one in block["nearest"])
        found = {
            "points that have parted": float(np.count_nonzero(self.cracks.judged.cracks)),
            "eroded points": float(len(self.cracks.eroded)), "pieces": float(self.cracks.piece_count),
            "crack length, m": crack_length(self._assembly, self.cracks),
        }  # fmt: skip
        if ratio > 0.0:
            lattice = self._assembly.lattice
            along, across = self._surface_place(int(point))
            found |= {
                "largest fracture ratio so far, above 0.5": ratio, "at, s": tick * step_size, "along the body, m": along,
                ("angle around, rad" if lattice.bent else "across the body, m"): across,
            }  # fmt: skip
        return found

    def drawables(self, nodes: FloatArray, size: float) -> tuple[Drawable, ...]:
        """Return the points, coloured by how near they are to parting, and the links of the surface that cracks have left."""
        lattice = self._assembly.lattice
        indices = self._assembly.points.all_places().T
        places = lattice.place(*(axis.at(one) for axis, one in zip(lattice.axes, indices, strict=True)))
        top = lattice.top_nodes
        return (
            Points("points", places, np.full(len(places), size), "point_displacement", "fracture_ratio"),
            Links("surface links", "nodes", top[self.surface_pairs], "surface_links"),
        )

    def declare(self) -> Iterable[Variable]:
        """Declare the outputs on cracks."""
        m, stations = self.point_count, self._assembly.lattice.shape[0]
        links = len(self.surface_pairs)
        yield Variable(
            "fracture_limit", "output", self.law.unit, (m,), "limit of the fracture law at each point", axes=("point",)
        )
        yield Variable("cracks", "output", "1", (m,), "number of cracks of each point", minimum=0.0, axes=("point",))
        yield Variable("point_displacement", "output", "m", (m, 3), "displacement of the points", axes=("point", "direction"))
        yield Variable(
            "surface_links", "output", "1", (links,), "0 where a crack lies between two neighbouring columns, at the outer "
            "surface, or nothing bears one of them, otherwise 1", minimum=0.0, maximum=1.0, axes=("link",),
        )  # fmt: skip
        yield Variable(
            "surface_cells", "output", "1", (len(self._cell_links),), "0 where a crack crosses an edge of a cell of the outer "
            "surface, or nothing bears a corner of it, otherwise 1", minimum=0.0, maximum=1.0, axes=("cell",),
        )  # fmt: skip
        yield Variable(
            "pieces", "output", "1", (), "pieces of the body that hang together, of such as bear stress", minimum=0.0
        )
        yield Variable(
            "outcome", "output", "1", (), "what has become of the body: 0 whole, 1 bulged, 2 axial crack, 3 hoop crack (around "
            "it), by the cracks through the wall where there are any, 4 severed: no piece reaches from one end to the other",
            minimum=0.0, maximum=4.0,
        )  # fmt: skip
        yield Variable(
            "crack_along", "output", "m", (), "how far cracks reach along the body, at whatever depth of the wall, from the "
            "first place to the last", minimum=0.0,
        )  # fmt: skip
        yield Variable(
            "crack_around", "output", "1", (), "largest part of the circumference, or of the width, that one crack takes at "
            "one place along the body, at whatever depth of the wall", minimum=0.0, maximum=1.0,
        )  # fmt: skip
        yield Variable("crack_length", "output", "m", (), "length of all cracks in the surface", minimum=0.0)
        yield Variable(
            "crack_area", "output", "m^2", (stations,), "open area of the cracks through the wall, at each plane of nodes "
            "along the body", minimum=0.0, axes=("station",),
        )  # fmt: skip
        yield Variable("eroded_mass", "output", "kg", (), "mass of the points that bear nothing any more", minimum=0.0)

    def outputs(self, block: Block, state: State) -> dict[str, Callable[[], Any]]:
        """Return how to read them."""

        def following(read: Callable[[], Any]) -> Callable[[], Any]:
            def follow() -> Any:
                self.solid(block)
                return read()

            return follow

        readers: dict[str, Callable[[], Any]] = {
            "fracture_limit": self.cracks.judged.limit.copy,
            "cracks": lambda: self.cracks.judged.cracks.astype(np.float64),
            "point_displacement": lambda: self.point_field(state.displacement),
            "surface_links": self._surface_links,
            "surface_cells": lambda: self._surface_links()[self._cell_links].min(axis=1),
            "pieces": lambda: float(self.cracks.piece_count),
            "outcome": lambda: float(self.outcome(state)),
            "crack_along": lambda: crack_along(self._assembly.lattice, self._cut_sides()),
            "crack_around": lambda: crack_around(self._assembly.lattice, self._cut_sides()),
            "crack_length": lambda: crack_length(self._assembly, self.cracks),
            "crack_area": lambda: open_areas(self._assembly.lattice, self.cracks, self.node_field(block, state.displacement)),
            "eroded_mass": self._eroded_mass,
        }
        return {name: following(read) for name, read in readers.items()}

    @cached_property
    def surface_pairs(self) -> ColumnArray:
        """Columns that lie next to each other, along and across, shape (links, 2)."""
        around = self._assembly.solid.surface.around.astype(np.int64)
        own = np.arange(len(around))
        ahead = [np.stack([own, around[:, side]], axis=1)[around[:, side] != own] for side in (1, 3)]
        return np.concatenate(ahead).astype(np.int32)

    @cached_property
    def _cell_links(self) -> ColumnArray:
        """Links that are the edges of each cell of the surface, shape (cells, 4)."""
        links = np.sort(self.surface_pairs.astype(np.int64), axis=1)
        cells = surface_quads(self._assembly.lattice)
        edges = np.sort(np.stack([cells, np.roll(cells, -1, axis=1)], axis=2), axis=2)
        columns = len(self._assembly.solid.surface.around)
        keys, wanted = links[:, 0] * columns + links[:, 1], edges[..., 0] * columns + edges[..., 1]
        order = np.argsort(keys)
        return order[np.searchsorted(keys[order], wanted)].astype(np.int32)

    def _surface_links(self) -> FloatArray:
        """Return 1 for each of `surface_pairs` that hold together, 0 with a crack between, or where nothing bears one."""
        at_surface = self._sides_of(self.cracks.links[:, :, -1] > 0)
        cut, (first, second) = np.concatenate([sides.ravel() for sides in at_surface]), self.surface_pairs.T
        around, borne = self._assembly.solid.surface.around, self.cracks.borne
        there = np.concatenate([around[:, side] != np.arange(len(around)) for side in (1, 3)])
        return np.asarray(~cut[there] & borne[first] & borne[second], np.float64)

    def _cut_sides(self) -> CutSides:
        """Return where a crack lies between neighbouring columns, at whatever depth of the wall.

        Columns that nothing bears any more say nothing of which way it runs.
        """
        return self._sides_of(np.any(self.cracks.links > 0, axis=2))

    def _leaking_sides(self) -> CutSides:
        """Return where a crack goes through the whole wall."""
        return self._sides_of(self.cracks.severed)

    def _sides_of(self, cut: Marks) -> CutSides:
        """Return which of the links that are cut, shape (columns, 4), lie between neighbouring columns."""
        around, (n, m, _) = self._assembly.solid.surface.around, self._assembly.lattice.shape
        own = np.arange(len(around))
        return CutSides(*((cut[:, way] & (around[:, side] != own)).reshape(n, m) for way, side in ((ALONG, 1), (ACROSS, 3))))

    def outcome(self, state: State) -> int:
        """Return the number of the outcome in `OUTCOMES`."""
        lattice, cracks = self._assembly.lattice, self.cracks
        is_severed = not connects_ends(cracks.labels, cracks.borne, lattice.shape[:2])
        strain = station_means(self._assembly, state.plastic_strain) if cracks.solid.plastic else np.zeros(1)
        through = self._leaking_sides()
        return outcome(lattice, through if through.is_cut else self._cut_sides(), is_severed, strain)

    def conclusions(self, block: Block, state: State, step_size: float) -> list[str]:
        """Return sentences on what has become of the body, and why it did or did not break."""
        self.solid(block)
        cut, facets = self._cut_sides(), self.cracks.facets
        number = self.outcome(state)
        found = [f"outcome: {OUTCOMES[number]}"]
        if number >= AXIAL:
            found[0] += f": {self._crack_words(cut)}; {self._piece_words()}"
        elif len(facets):
            found[0] += ": no crack lies between columns of nodes, some lie within the wall or at its edges"
        if len(facets):
            first, (speeds, rayleigh) = facets[0], self._crack_speeds(step_size)
            found.append(
                f"the first of {np.count_nonzero(self.cracks.judged.cracks)} points that parted did so at "
                f"{1e6 * first[8] * step_size:.4g} us, {self.place_words(int(first[0]))}"
                + "".join(
                    f"; its crack ran {way} at {speed:.0f} m/s, {part:.0%} of its steps from plane to plane faster than "
                    f"Rayleigh waves ({rayleigh:.0f} m/s)"
                    for way, (speed, part) in speeds.items() if speed > 0.0
                )
            )  # fmt: skip
            return found
        ratio, point, tick = (float(one) for one in block["nearest"])
        near = f"reached {ratio:.3g} of its limit at {1e6 * tick * step_size:.4g} us, {self.place_words(int(point))}"
        return [*found, f"{self.law.quantity} {near if ratio > 0.0 else 'stayed below half of its limit everywhere'}"]

    def _crack_words(self, cut: CutSides) -> str:
        """Return in words how far cracks reach, at any depth and through the wall."""
        lattice, through = self._assembly.lattice, self._leaking_sides()
        part = "of the circumference" if lattice.bent else "of the width"
        (along, around), (leaking_along, leaking_around) = (
            (1e3 * crack_along(lattice, sides), 100.0 * crack_around(lattice, sides)) for sides in (cut, through)
        )
        leaks = f"cracks through the wall reach {leaking_along:.3g} mm and take up to {leaking_around:.3g} %"
        return (
            f"cracks reach {along:.3g} mm along the body and take up to {around:.3g} % {part}, "
            f"{leaks if through.is_cut else 'none of them through the wall'}"
        )

    def _piece_words(self) -> str:
        """Return in words how many pieces there are, and what belongs to none."""
        pieces, lost = self.cracks.piece_count, np.count_nonzero(~self.cracks.borne)
        words = f"{pieces} {'piece' if pieces == 1 else 'pieces'}"
        return f"{words}, and {lost} fully detached {'column' if lost == 1 else 'columns'} of nodes" if lost else words

    def place_words(self, point: int) -> str:
        """Return where a point lies in the body, in words."""
        lattice = self._assembly.lattice
        along, across = self._surface_place(point)
        if not lattice.bent:
            return f"{1e3 * along:.4g} mm along the body and {1e3 * across:.4g} mm across it"
        angle = math.degrees(math.remainder(across, math.tau))
        return f"{1e3 * along:.4g} mm along the body and {angle:.3g} degrees around it"

    def _crack_speeds(self, step_size: float) -> tuple[dict[str, tuple[float, float]], float]:
        """Return how fast the crack that began first ran along the body and around it, or across a plate, and Rayleigh waves.

        With each speed comes the part of the crack's steps that were faster than those waves [m/s, 1].
        """
        lattice, facets = self._assembly.lattice, self.cracks.facets
        axis, ring, times = lattice.axes[0], lattice.axes[1], facets[:, 8] * step_size
        indices = facets[:, 1:3].copy()
        if ring.closed:  # the crack's own side of the body in one piece
            count = lattice.shape[1]
            indices[:, 1] = np.remainder(indices[:, 1] - indices[0, 1] + 0.5 * count, count)
            around = np.remainder(ring.at(facets[:, 2]) - ring.at(facets[:1, 2]) + 0.5 * ring.period, ring.period)
        else:
            around = ring.at(facets[:, 2])
        radius = float(lattice.axes[2].positions[-1]) if lattice.bent else 1.0
        places = np.stack([axis.at(facets[:, 1]), radius * around], axis=1)
        metal, grown = self._parameters.material, growth(indices)
        rayleigh = rayleigh_speed(Material(density=metal.density, young=metal.young, poisson=metal.poisson))
        spacings = float(np.diff(axis.positions).max()), radius * float(np.diff(ring.positions).max())
        ways = "along the body", "around it" if lattice.bent else "across it"
        indices, places, times = indices[grown], places[grown], times[grown]
        speeds = {
            way: (
                tip_speed(places[:, k], times, 3.0 * spacing),
                part_faster(indices[:, k], places[:, k], times, rayleigh),
            )
            for k, (way, spacing) in enumerate(zip(ways, spacings, strict=True))
        }
        return speeds, rayleigh

    def _eroded_mass(self) -> float:
        volume = self._assembly.points.volume[self.cracks.eroded.astype(np.int64)]
        return float(self._parameters.material.density * volume.sum())

    def _surface_place(self, point: int) -> tuple[float, float]:
        """Return the coordinates of a point along the body and across, or around, it."""
        (place,) = self._assembly.points.places(np.array([point]))
        along, across, _ = self._assembly.lattice.axes
        return float(along.at(place[0])), float(across.at(place[1]))
