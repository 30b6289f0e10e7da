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
from .events import EVENT_ROWS
from .inputs import input_value
from .support.arrays import FloatArray
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

    @classmethod
    def memory_needed(cls, parameters: DiscsParameters) -> int:
        """Return the bytes that all pairs take while the forces are computed."""
        discs = parameters.rows * parameters.columns
        return discs * (discs - 1) // 2 * 15 * 8

    def _build(self) -> None:
        p = self.parameters
        n, self.step_size, self.diameter = p.rows * p.columns, p.step_size, 2.0 * p.radius
        self.mass = np.full((n, 1), p.mass)
        places = np.array([(column, row) for row in range(p.rows) for column in range(p.columns)], dtype=np.float64)
        self.reference = p.clearance + p.radius + self.diameter * places
        self.box = 2.0 * p.clearance + self.diameter * np.array([p.columns, p.rows])
        first, second = np.triu_indices(n, 1)
        linked = np.abs(places[second] - places[first]).sum(axis=1) == 1.0
        order = np.argsort(~linked, kind="stable")  # all pairs can touch; those with a link come first
        self.first, self.second, self.links = first[order], second[order], int(linked.sum())
        self._lay_out(
            displacement=("f8", (n, 2)), velocity=("f8", (n, 2)), work=("f8", ()), fracture=("f8", ()), impulses=("f8", (2, 3)),
            start=("f8", (4,)), growing={"events": EVENT_ROWS, "broken": ("i8", ())},
        )  # fmt: skip

    def _declare(self) -> Iterable[Variable]:
        n, axes = len(self.reference), ("disc", "direction")
        yield Variable("force", "input", "N", (n, 2), "force on each disc", start=0.0, axes=axes)
        yield Variable("displacement", "output", "m", (n, 2), "displacement from the block", state=True, axes=axes)
        yield Variable("velocity", "output", "m/s", (n, 2), "velocity", state=True, axes=axes)
        yield Variable("speed", "output", "m/s", (n,), "magnitude of the velocity", minimum=0.0, axes=("disc",))
        yield Variable("linked", "output", "1", (self.links,), "1 for a link that holds, 0 for a broken one", axes=("link",))
        yield Variable("broken_links", "output", "1", (), "number of broken links")

    def _outputs(self) -> dict[str, Callable[[], Any]]:
        return {
            "speed": self._speed,
            "linked": lambda: self._holding()[: self.links].astype(np.float64),
            "broken_links": lambda: float(self._block.count("broken")),
        }

    def _start(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        given, close = super()._start(seed, values), np.flatnonzero(self._pairs()[1] < 1e-9 * self.diameter)
        if len(close):
            one, other = int(self.first[close[0]]), int(self.second[close[0]])
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
            self._break_links(tick + 1)
            walls = -p.stiffness * self._wall_overlap()
            kick = h / self.mass * (force + walls + self._pair_forces())
            block["work"][...] += h * (force * (v + 0.5 * kick)).sum()
            block["impulses"][:] += h * self._moments(force), h * self._moments(walls)
            v += kick
            u += 0.5 * h * v
            if not h * self._speed().max() <= p.radius:
                return 1
        return 0

    def _explain(self, status: int) -> StepError:
        speed, limit = self._speed(), self.parameters.radius / self.step_size
        disc = int(np.argmin(speed <= limit))
        came = f"reached {speed[disc]:g} m/s soon after {self.time:g} s, expected at most {limit:g} m/s, a radius in a step"
        return StepError(
            f"{came}; take a smaller step_size", at=("velocity", disc), time=self.time, variable="velocity", index=disc,
            value=float(speed[disc]), limit=limit,
        )  # fmt: skip

    def _pairs(self) -> tuple[FloatArray, FloatArray]:
        """Return the way from centre to centre of each pair, shape (pairs, 2), and its distance [m]."""
        centres = self.reference + self._block["displacement"]
        along = centres[self.second] - centres[self.first]
        return along, np.sqrt(along[:, 0] ** 2 + along[:, 1] ** 2)

    def _holding(self) -> np.ndarray:
        """Return which pairs are linked."""
        holding = np.arange(len(self.first)) < self.links
        holding[self._block["broken"]] = False
        return holding

    def _stretch(self, distance: FloatArray) -> FloatArray:
        """Return how much longer the spring of each pair is than at rest; 0 where there is neither a link nor a contact."""
        return np.where(self._holding(), distance - self.diameter, np.minimum(distance - self.diameter, 0.0))

    def _wall_overlap(self) -> FloatArray:
        centres, radius = self.reference + self._block["displacement"], self.parameters.radius
        return np.minimum(centres - radius, 0.0) + np.maximum(centres + radius - self.box, 0.0)

    def _pair_forces(self) -> FloatArray:
        along, distance = self._pairs()
        tension = (self.parameters.stiffness * self._stretch(distance) / distance)[:, np.newaxis] * along
        forces = np.zeros_like(self.reference)
        np.add.at(forces, self.first, tension)
        np.subtract.at(forces, self.second, tension)
        return forces

    def _break_links(self, tick: int) -> None:
        strain, limit = self._pairs()[1] / self.diameter - 1.0, self.parameters.breaking_strain
        for link in np.flatnonzero(self._holding() & (strain > limit)):
            self._block["fracture"][...] += 0.5 * self.parameters.stiffness * (strain[link] * self.diameter) ** 2
            self._block.append("broken", link)
            self._add_event(tick, "link_broken", int(link), float(strain[link]), limit)

    @np.errstate(over="ignore")
    def _speed(self) -> FloatArray:
        return np.sqrt((self._block["velocity"] ** 2).sum(axis=1))

    def _moments(self, vectors: FloatArray) -> FloatArray:
        """Return the sum of the discs' vectors, x and y, and their moment about the corner of the box."""
        centres = self.reference + self._block["displacement"]
        moments = centres[:, 0] * vectors[:, 1] - centres[:, 1] * vectors[:, 0]
        return np.array([*vectors.sum(axis=0), moments.sum()])

    def _energies(self) -> tuple[float, float]:
        stretched = (self._stretch(self._pairs()[1]) ** 2).sum() + (self._wall_overlap() ** 2).sum()
        kinetic = 0.5 * (self.mass * self._block["velocity"] ** 2).sum()
        return float(kinetic), float(0.5 * self.parameters.stiffness * stretched)

    def balances(self) -> tuple[Balance, ...]:
        """Return energy, momentum, and angular momentum about the corner of the box, since the reset."""
        (kinetic, potential), block = self._energies(), self._block
        now, start = self._moments(self.mass * block["velocity"]), block["start"].copy()
        force, walls = block["impulses"].copy()
        stored, supplied = {"kinetic_energy": kinetic, "potential_energy": potential}, {"input_work": float(block["work"])}
        lost, impulse = {"fracture_energy": float(block["fracture"])}, {"impulse": force[:2], "wall_impulse": walls[:2]}
        turning = {"angular_impulse": float(force[2]), "wall_angular_impulse": float(walls[2])}
        return (
            Balance("energy", "J", stored, supplied, lost, float(start[0])),
            Balance("momentum", "kg m/s", {"momentum": now[:2]}, impulse, initial=start[1:3]),
            Balance("angular_momentum", "kg m2/s", {"angular_momentum": float(now[2])}, turning, initial=float(start[3])),
        )

    def drawables(self) -> tuple[Drawable, ...]:
        """Return the discs, coloured by speed, and the links."""
        discs = Points("discs", self.reference, np.full(len(self.reference), self.parameters.radius), "displacement", "speed")
        return discs, Links("links", "discs", np.stack([self.first, self.second], axis=1)[: self.links], "linked")
