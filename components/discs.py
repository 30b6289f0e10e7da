"""A toy component in the plane: discs in a box, tied together by links that break. The worked example for arrays and events.

m x'' = F + contacts + links + walls: linear springs along the line of centres, advanced by leapfrog (second order, symplectic).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from .balances import Balance
from .component import Component
from .contract import Variable
from .drawables import Drawable, Links, Points
from .errors import ParameterError, StepError
from .events import EVENT_ROWS, EventDetail
from .inputs import input_value
from .support.arrays import FloatArray
from .support.excess import excess_error
from .support.parameter_fields import field
from .support.validation import Parameters


class DiscsParameters(Parameters):
    """A block of equal discs, each linked to its neighbours along x and y, in the middle of a box."""

    rows: int = field(2, "discs along y", "1", ge=1)
    columns: int = field(4, "discs along x", "1", ge=1)
    radius: float = field(0.01, "radius of each disc", "m", gt=0.0)
    mass: float = field(0.01, "mass of each disc", "kg", gt=0.0)
    clearance: float = field(0.02, "from the block to each wall", "m", ge=0.0)
    stiffness: float = field(1e4, "of contacts, links and walls", "N/m", gt=0.0)
    breaking_strain: float = field(0.01, "strain that breaks a link", "1", gt=0.0)
    step_size: float = field(1e-5, "internal step", "s", gt=0.0)


class Discs(Component):
    """Discs in a box, tied together by links that break."""

    name = "discs"
    Parameters = DiscsParameters
    parameters: DiscsParameters
    event_kinds = {"link_broken": "the strain of a link exceeded the breaking strain"}
    event_details = {"link_broken": EventDetail("1", counts="links")}

    @classmethod
    def memory_needed(cls, parameters: DiscsParameters) -> int:
        """Return the bytes that all pairs take while the forces are computed."""
        return (parameters.rows * parameters.columns) ** 2 // 2 * 15 * 8

    def _build(self) -> None:
        p = self.parameters
        n, self.step_size, self.diameter = p.rows * p.columns, p.step_size, 2.0 * p.radius
        places = np.array([(column, row) for row in range(p.rows) for column in range(p.columns)], dtype=np.float64)
        self.mass = np.full((n, 1), p.mass)
        self.reference = p.clearance + p.radius + self.diameter * places
        self.box = 2.0 * p.clearance + self.diameter * np.array([p.columns, p.rows])
        pairs = np.stack(np.triu_indices(n, 1), axis=1)
        linked = np.abs(places[pairs[:, 1]] - places[pairs[:, 0]]).sum(axis=1) == 1.0
        # All pairs can touch; those with a link come first.
        self.pairs, self.links = pairs[np.argsort(~linked, kind="stable")], int(linked.sum())
        number, vectors = ("f8", ()), ("f8", (n, 2))
        state = {"displacement": vectors, "velocity": vectors, "work": number, "fracture": number}
        self._lay_out({"events": EVENT_ROWS, "broken": ("i8", ())}, **state, impulses=("f8", (2, 3)), start=("f8", (4,)))

    def _declare(self) -> Iterable[Variable]:
        n, axes = len(self.reference), ("disc", "direction")
        yield Variable("force", "input", "N", (n, 2), "force on each disc", start=0.0, axes=axes)
        yield Variable("displacement", "output", "m", (n, 2), "displacement from the block", state=True, axes=axes)
        yield Variable("velocity", "output", "m/s", (n, 2), "velocity", state=True, axes=axes)
        yield Variable("speed", "output", "m/s", (n,), "magnitude of the velocity", minimum=0.0, axes=("disc",))
        yield Variable("linked", "output", "1", (self.links,), "1 for a link that holds, 0 for a broken one", axes=("link",))
        yield Variable("broken_links", "output", "1", (), "number of broken links")

    def _outputs(self) -> dict[str, Callable[[], Any]]:
        linked = {"linked": lambda: 1.0 * self._holding()[: self.links], "broken_links": lambda: float(self.event_count)}
        return {"speed": self._speed, **linked}

    def _start(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        given = super()._start(seed, values)
        for pair in np.flatnonzero(self._pairs()[1] < 1e-9 * self.diameter):
            one, other = self.pairs[pair].tolist()
            at = ("start", "displacement", other)
            raise ParameterError(f"puts disc {other} where disc {one} is", hint="move one of them", at=at)
        self._block["start"][:] = sum(self._energies()), *self._moments(self.mass * self._block["velocity"])
        return given

    @np.errstate(all="ignore")  # the status tells
    def _advance(self, ticks: int) -> int:
        given, h, p, block = self._held["force"], self.step_size, self.parameters, self._block
        u, v = block["displacement"], block["velocity"]
        for tick in range(self._tick, self._tick + ticks):
            # Links break and forces act at the step's middle, where leapfrog kicks.
            force = input_value(given, tick, 0.5)
            u += 0.5 * h * v
            along, distance = self._pairs()
            self._break_links(tick + 1, distance)
            walls = -p.stiffness * self._wall_overlap()
            kick = h / self.mass * (force + walls + self._pair_forces(along, distance))
            block["work"][...] += h * (force * (v + 0.5 * kick)).sum()
            block["impulses"][:] += h * self._moments(force), h * self._moments(walls)
            v += kick
            u += 0.5 * h * v
            if not h * self._speed().max() <= p.radius:
                return 1
        return 0

    def _explain(self, status: int) -> StepError:
        limit, advice = self.parameters.radius / self.step_size, "a radius in a step; take a smaller step_size"
        return excess_error("velocity", "m/s", self._speed(), limit, self.time, advice)

    def _pairs(self) -> tuple[FloatArray, FloatArray]:
        """Return the way from centre to centre of each pair, shape (pairs, 2), and its distance [m]."""
        first, second = self._centres()[self.pairs.T]
        along = second - first
        return along, np.sqrt((along**2).sum(axis=1))

    def _holding(self) -> np.ndarray:
        """Return which pairs are linked."""
        holding = np.arange(len(self.pairs)) < self.links
        holding[self._block["broken"]] = False
        return holding

    def _stretch(self, distance: FloatArray) -> FloatArray:
        """Return how much longer the spring of each pair is than at rest; 0 where there is neither a link nor a contact."""
        return np.where(self._holding(), distance - self.diameter, np.minimum(distance - self.diameter, 0.0))

    def _wall_overlap(self) -> FloatArray:
        low, high = self._centres() - self.parameters.radius, self._centres() + self.parameters.radius
        return np.minimum(low, 0.0) + np.maximum(high - self.box, 0.0)

    def _pair_forces(self, along: FloatArray, distance: FloatArray) -> FloatArray:
        tension = (self.parameters.stiffness * self._stretch(distance) / distance)[:, np.newaxis] * along
        forces = np.zeros_like(self.reference)
        np.add.at(forces, self.pairs[:, 0], tension)
        np.subtract.at(forces, self.pairs[:, 1], tension)
        return forces

    def _break_links(self, tick: int, distance: FloatArray) -> None:
        strain, limit = distance / self.diameter - 1.0, self.parameters.breaking_strain
        for link in np.flatnonzero(self._holding() & (strain > limit)):
            self._block["fracture"][...] += 0.5 * self.parameters.stiffness * (strain[link] * self.diameter) ** 2
            self._block.append("broken", link)
            self._add_event(tick, "link_broken", int(link), float(strain[link]), limit)

    def _centres(self) -> FloatArray:
        return self.reference + self._block["displacement"]

    @np.errstate(over="ignore")
    def _speed(self) -> FloatArray:
        return np.sqrt((self._block["velocity"] ** 2).sum(axis=1))

    def _moments(self, vectors: FloatArray) -> FloatArray:
        """Return the sum of the discs' vectors, x and y, and their moment about the corner of the box."""
        x, y = self._centres().T
        return np.array([*vectors.sum(axis=0), (x * vectors[:, 1] - y * vectors[:, 0]).sum()])

    def _energies(self) -> tuple[float, float]:
        stretched = (self._stretch(self._pairs()[1]) ** 2).sum() + (self._wall_overlap() ** 2).sum()
        kinetic = 0.5 * (self.mass * self._block["velocity"] ** 2).sum()
        return float(kinetic), float(0.5 * self.parameters.stiffness * stretched)

    def balances(self) -> tuple[Balance, ...]:
        """Return energy, momentum, and angular momentum about the corner of the box, since the reset."""
        (kinetic, potential), now = self._energies(), self._moments(self.mass * self._block["velocity"])
        start, force, walls = self._block["start"].copy(), *self._block["impulses"].copy()
        work, fracture = float(self._block["work"]), float(self._block["fracture"])
        energies = {"kinetic_energy": kinetic, "potential_energy": potential}
        turning = {"angular_impulse": float(force[2]), "wall_angular_impulse": float(walls[2])}
        impulses = {"impulse": force[:2], "wall_impulse": walls[:2]}
        return (
            Balance("energy", "J", energies, {"input_work": work}, {"fracture_energy": fracture}, float(start[0])),
            Balance("momentum", "kg m/s", {"momentum": now[:2]}, impulses, initial=start[1:3]),
            Balance("angular_momentum", "kg m2/s", {"angular_momentum": float(now[2])}, turning, initial=float(start[3])),
        )

    def drawables(self) -> tuple[Drawable, ...]:
        """Return the discs, coloured by speed, and the links."""
        discs = Points("discs", self.reference, np.full(len(self.reference), self.parameters.radius), "displacement", "speed")
        return discs, Links("links", "discs", self.pairs[: self.links], "linked")
