"""The four edges of a specimen: their automata, and the inputs that act on them as forces (`Load`) or velocities (`Grip`)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from ..boundaries import Boundary, Symmetry, Traction, edge_variable, prescribed_components
from ..errors import ParameterError
from ..inputs import Held, input_mean
from ..support.float_arrays import FloatArray
from ..variables import Variable
from .lattice import Layout
from .loads import HOLDS_ROTATION, HOLDS_X, HOLDS_Y, Grip, Load
from .packing import Packing
from .parameters import AutomataParameters, Fixed, Place, PrescribedVelocity
from .shapes import ON_THE_OUTLINE, Rectangle

# Name of an edge -> the axis normal to it (0 or 1), and whether the edge lies at the upper end of this axis.
EDGES = {"left": (0, False), "right": (0, True), "bottom": (1, False), "top": (1, True)}


def edge_automata(packing: Packing, name: str, depth: float = 0.0) -> npt.NDArray[np.int64]:
    """Return the automata within `depth` [m] of the outermost automaton of an edge, shape (m,); on a zigzag edge both rows."""
    axis, far = EDGES[name]
    place = packing.reference[:, axis] * (1.0 if far else -1.0)
    zigzag = 0.5 * packing.diameter if packing.lattice.name == "hexagonal" and axis == 0 else 0.0
    return np.flatnonzero(place >= place.max() - (max(depth, zigzag) + ON_THE_OUTLINE * packing.diameter)).astype(np.int64)


def area_shares(packing: Packing, name: str, automata: npt.NDArray[np.int64], area: float) -> FloatArray:
    """Return the part of the area of a straight edge that each of its automata represents, shape (m,) [m^2].

    On a zigzag edge the outer row consists of half cells, which take twice the length of the whole cells between them.
    """
    part = packing.volume[automata]
    if packing.lattice.name == "hexagonal" and EDGES[name][0] == 0:
        part[packing.missing[automata] == 0.0] *= 4.0
    return area * part / part.sum()


def traction_lever_arms(packing: Packing, name: str, automata: npt.NDArray[np.int64]) -> FloatArray:
    """Return the distance from the centres of an edge's automata at which a traction acts, shape (m, 2) [m]; see `loads.Load`.

    A quarter cell is loaded on one side of its centre only, at a mean distance of D / 4 along a row. Along a zigzag the
    distance is sqrt(3) D / 8, not that of the middle of the side, because the halved face of the row also acts at the height of
    the centre. Without this torque the quarter cells of a hexagonal packing would rotate under a homogeneous stress. In a
    square packing the two halved faces cancel it.
    """
    levers, axis = np.zeros((len(automata), 2)), EDGES[name][0]
    if packing.lattice.name == "hexagonal":
        volume = packing.volume[automata]
        quarter = volume < (0.25 + ON_THE_OUTLINE) * packing.lattice.volume * packing.diameter**2
        place = packing.reference[automata, 1 - axis]
        inward = np.sign(0.5 * (place.min() + place.max()) - place)
        levers[:, 1 - axis] = np.where(
            quarter, 0.25 * packing.diameter * (1.0 if axis == 1 else packing.lattice.volume) * inward, 0.0
        )
    return levers


class Conditions:
    """The inputs of a specimen, and the loads and grips that they fill.

    Attributes:
        load: the automata with forces, and the forces by the last applied inputs.
        grip: the automata with prescribed velocities, and these velocities, likewise.
        held_edges: name of an edge that prescribes motion -> its automata, shape (m,), and a mask of the components that it
            prescribes, shape (m, 2).
    """

    def __init__(self, parameters: AutomataParameters, packing: Packing, layout: Layout) -> None:
        """Find the automata on which inputs act; raise `ParameterError` if one does not exist or cannot move."""
        self._parameters, self._packing, self._place = parameters, packing, layout.place
        # Edges in a fixed order, independent of the order in the table of boundaries, so that sums are bitwise reproducible.
        self._boundaries = {name: parameters.boundaries[name] for name in EDGES if name in parameters.boundaries}
        self._forced = _forced_automata(parameters.forced_automata, packing)
        self._edges = {
            name: edge_automata(packing, name, getattr(boundary, "depth", 0.0)) for name, boundary in self._boundaries.items()
        }
        self._fill_load()
        self._fill_grip()
        self._refuse_ineffective_forces()

    def _fill_load(self) -> None:
        p, start = self._parameters, len(self._forced)
        groups, levers = [self._forced], [np.zeros((start, 2))]
        # For each traction: its input, the rows of `load` on which it acts, and the area of each row [m^2].
        self._pulls: list[tuple[str, slice, FloatArray]] = []
        for name in self._edges_with_boundary(Traction):
            assert isinstance(p.shape, Rectangle)
            automata = self._edges[name]
            area = p.thickness * (p.shape.height if EDGES[name][0] == 0 else p.shape.width)
            areas = area_shares(self._packing, name, automata, area)
            self._pulls.append((f"{name}_traction", slice(start, start + len(automata)), areas))
            groups.append(automata)
            levers.append(traction_lever_arms(self._packing, name, automata))
            start += len(automata)
        automata = np.concatenate(groups).astype(np.int64)
        count = len(automata)
        self.load = Load(automata, self._place[automata], np.zeros((count, 2)), np.concatenate(levers), np.zeros((count, 3)))

    def _fill_grip(self) -> None:
        boundaries = self._boundaries
        owners = prescribed_components(boundaries, self._edges.__getitem__, _prescribed_axes)
        automata = np.array(sorted(owners), np.int64)
        turning = {
            i for name, boundary in boundaries.items() if _is_rotation_held(name, boundary) for i in self._edges[name].tolist()
        }
        held = [
            HOLDS_X * (0 in owners[i]) | HOLDS_Y * (1 in owners[i]) | HOLDS_ROTATION * (i in turning) for i in automata.tolist()
        ]
        count = len(automata)
        self.grip = Grip(automata, self._place[automata], np.array(held, np.int64), np.zeros((count, 2)), np.zeros((count, 3)))
        self.held_edges: dict[str, tuple[npt.NDArray[np.int64], npt.NDArray[np.bool_]]] = {}
        for name in boundaries:
            own = np.array([[owners[i].get(axis) == name for axis in (0, 1)] for i in automata.tolist()]).reshape(-1, 2)
            if own.any():
                there = own.any(axis=1)
                self.held_edges[name] = automata[there], own[there]
        # For each prescribed velocity component: its input, the component, and the rows of `grip` on which it acts.
        self._drives: list[tuple[str, int, list[int]]] = []
        for name in self._edges_with_boundary(PrescribedVelocity):
            for axis in (0, 1):
                rows = [row for row, i in enumerate(automata.tolist()) if owners[i].get(axis) == name]
                if rows:
                    self._drives.append((f"{name}_velocity", axis, rows))

    def _refuse_ineffective_forces(self) -> None:
        """Refuse forces on single automata whose motion is prescribed along both axes: they would have no effect."""
        if self._parameters.forced_automata == "all":
            return
        both = HOLDS_X | HOLDS_Y
        held = set(self.grip.automata[(self.grip.held & both) == both].tolist())
        for index, automaton in enumerate(self._forced.tolist()):
            if automaton in held:
                raise ParameterError(
                    f"the motion of automaton {automaton} is prescribed along x and y, so a force on it has no effect",
                    hint="leave it out, or free its edge",
                    at=("forced_automata", index),
                )

    def _edges_with_boundary(self, kind: type[Boundary]) -> list[str]:
        return [name for name, boundary in self._boundaries.items() if isinstance(boundary, kind)]

    def inputs(self) -> Iterable[Variable]:
        """Declare the inputs."""
        if self._forced.size:
            shape, axes = (len(self._forced), 2), ("forced_automaton", "direction")
            text = "force on each of the `forced_automata` along x and y"
            yield Variable("force", "input", "N", shape, text, start=0.0, axes=axes)
        for name, boundary in self._boundaries.items():
            if isinstance(boundary, (PrescribedVelocity, Traction)):
                yield edge_variable(name, boundary)

    def apply_inputs(self, inputs: Mapping[str, Held], tick: int, *, has_central_kick: bool = True) -> None:
        """Fill loads and grips for the internal step that begins at a tick, with the mean of each input over its duration.

        Forces act over the step. Prescribed velocities are constant between kicks, i.e. between the middles or ends of steps.
        """
        velocity = _mid_tick_mean if has_central_kick else input_mean
        if self._forced.size:
            self.load.force[: len(self._forced)] = input_mean(inputs["force"], tick)
        for name, rows, areas in self._pulls:
            self.load.force[rows] = areas[:, np.newaxis] * input_mean(inputs[name], tick)
        for name, axis, rows in self._drives:
            self.grip.velocity[rows, axis] = velocity(inputs[name], tick)[axis]


def _mid_tick_mean(velocity: Held, tick: int) -> FloatArray:
    """Return the mean of a velocity from the middle of a tick to the middle of the next one, shape (2,) [m/s]."""
    return 0.5 * (input_mean(velocity, tick, 1, 2) + input_mean(velocity, tick + 1, 0, 2))


def _prescribed_axes(edge: str, boundary: Boundary) -> tuple[int, ...]:
    """Return the velocity components that a boundary prescribes on an edge."""
    if isinstance(boundary, Symmetry):
        return (EDGES[edge][0],)
    return boundary.prescribed_axes if isinstance(boundary, PrescribedVelocity) else (0, 1)


def _is_rotation_held(edge: str, boundary: Boundary) -> bool:
    """Return whether an edge prevents rotation: smooth plates do, as planes of symmetry, and glued plates too."""
    plate = isinstance(boundary, PrescribedVelocity) and EDGES[edge][0] in boundary.prescribed_axes
    return plate or isinstance(boundary, (Fixed, Symmetry))


def _forced_automata(places: list[Place] | str, packing: Packing) -> npt.NDArray[np.int64]:
    """Return the numbers of the automata that `places` selects by numbers, by points, or by "all"."""
    count = len(packing.places)
    if isinstance(places, str):
        return np.arange(count)
    found: list[int] = []
    for index, place in enumerate(places):
        if isinstance(place, int) and place >= count:
            raise ParameterError(f"got automaton {place}", expected=f"0 to {count - 1}", at=f"forced_automata[{index}]")
        found.append(place if isinstance(place, int) else _nearest_automaton(f"forced_automata[{index}]", place, packing))
    return np.array(found, np.int64)


def _nearest_automaton(where: str, point: Sequence[float], packing: Packing) -> int:
    """Return the automaton nearest to a point; raise an error if it is more than a diameter away."""
    automaton = packing.nearest_automaton(point[0], point[1])
    x, y = packing.reference[automaton].tolist()
    if math.hypot(point[0] - x, point[1] - y) > packing.diameter:
        raise ParameterError(
            f"got the point {list(point)} m",
            expected="a point of the body, in the coordinates of `shape`",
            hint=f"the nearest automaton, {automaton}, is at ({x:.6g}, {y:.6g}) m",
            at=where,
        )
    return automaton
