"""A toy component: discs in a plane box, tied by breakable links; the worked example of arrays and events.

m x'' = F + contacts + links + walls: linear springs along the line of centres, advanced by leapfrog (second order, symplectic).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from .balances import Balance
from .component import Component
from .drawables import Drawable, Links, Points
from .errors import ParameterError, StepError
from .events import EventDetail
from .inputs import input_mean
from .support.float_arrays import FloatArray, norms, ordered_sum
from .support.parameter_fields import field
from .support.validation import Parameters
from .variables import Variable


class DiscsParameters(Parameters):
    """A block of equal discs, each linked to its neighbours along x and y, in the middle of a box."""

    rows: int = field(2, "number of discs along y", "1", ge=1)
    columns: int = field(4, "number of discs along x", "1", ge=1)
    radius: float = field(0.01, "radius of each disc", "m", gt=0.0)
    mass: float = field(0.01, "mass of each disc", "kg", gt=0.0)
    clearance: float = field(0.02, "distance from the block to each wall", "m", ge=0.0)
    stiffness: float = field(1e4, "stiffness of contacts, links and walls", "N/m", gt=0.0)
    breaking_strain: float = field(0.01, "strain at which a link breaks", "1", gt=0.0)
    step_size: float = field(1e-5, "internal step", "s", gt=0.0)


class Discs(Component):
    """Discs in a box, tied together by links that break."""

    name = "discs"
    version = 2
    Parameters = DiscsParameters
    parameters: DiscsParameters
    event_kinds = {"link_broken": "the strain of a link exceeded the breaking strain"}
    event_details = {"link_broken": EventDetail("1", counts="links")}

    @classmethod
    def memory_needed(cls, parameters: DiscsParameters) -> int:
        """Return the memory for all pairs during a force evaluation, in bytes."""
        return (parameters.rows * parameters.columns) ** 2 // 2 * 15 * 8

    def _build_system(self) -> None:
        p = self.parameters
        self.step_size, self.diameter, n = p.step_size, 2.0 * p.radius, p.rows * p.columns
        places = np.array([(column, row) for row in range(p.rows) for column in range(p.columns)])
        self.mass, self.reference = np.full((n, 1), p.mass), p.clearance + p.radius + self.diameter * places
        self.box = 2.0 * p.clearance + self.diameter * np.array([p.columns, p.rows])
        # Any pair can touch; neighbours come first and are linked.
        apart = np.abs(places[:, np.newaxis] - places).sum(axis=2)
        linked, others = np.argwhere(np.triu(apart == 1)), np.argwhere(np.triu(apart > 1))
        self.pairs, self.links = np.concatenate([linked, others]), len(linked)
        sums = {"work": ("f8", ()), "fracture": ("f8", ()), "impulses": ("f8", (2, 2)), "start": ("f8", (3,))}
        # The list of broken links grows like the list of events.
        broken = ("i8", (), 0, self.links - 1, self.links)
        self._define_state({"broken": broken}, displacement=("f8", (n, 2)), velocity=("f8", (n, 2)), **sums)

    def _declare_variables(self) -> Iterable[Variable]:
        n, axes = len(self.reference), ("disc", "direction")
        yield Variable("force", "input", "N", (n, 2), "force on each disc", start=0.0, axes=axes)
        yield Variable("displacement", "output", "m", (n, 2), "displacement of each disc", state=True, axes=axes)
        yield Variable("velocity", "output", "m/s", (n, 2), "velocity of each disc", state=True, axes=axes)
        yield Variable("speed", "output", "m/s", (n,), "speed of each disc", minimum=0.0, axes=("disc",))
        yield Variable("linked", "output", "1", (self.links,), "1 for an intact link, 0 for a broken one", axes=("link",))
        text = "force along the line of centres of each linked or broken pair, compression positive"
        yield Variable("link_force", "output", "N", (self.links,), text, axes=("link",))
        yield Variable("broken_links", "output", "1", (), "number of broken links")

    def _output_readers(self) -> dict[str, Callable[[], Any]]:
        return {
            "speed": lambda: norms(self._block["velocity"]),
            "linked": lambda: 1.0 * self._linked_pairs()[: self.links],
            "link_force": self._link_forces,
            "broken_links": lambda: float(self.event_count),
        }

    def _write_start_state(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        super()._write_start_state(seed, values)
        for i, j in self.pairs[self._pair_geometry()[1] < 1e-9 * self.diameter].tolist():
            raise ParameterError(f"puts disc {j} on top of disc {i}", hint="move one of them", at=("start", "displacement", j))
        energies, momentum = self._energies_and_momentum()
        self._block["start"] = ordered_sum(*energies.values()), *momentum
        return {}

    @np.errstate(all="ignore")  # the returned status reports overflow
    def _advance_state(self, ticks: int) -> int:
        u, v, h, p = self._block["displacement"], self._block["velocity"], self.step_size, self.parameters
        for tick in range(self._tick, self._tick + ticks):
            # Links break and forces act at the step's middle, where leapfrog kicks.
            u += 0.5 * h * v
            directions, distance, overlap = self._pair_geometry()
            self._break_links(tick + 1, distance)
            force, walls = input_mean(self._held["force"], tick), -p.stiffness * overlap
            kick = h / self.mass * (force + walls + self._pair_forces(directions, distance))
            self._block["work"] += h * (force * (v + 0.5 * kick)).sum()
            self._block["impulses"] += h * force.sum(axis=0), h * walls.sum(axis=0)
            v += kick
            u += 0.5 * h * v
            if not h * norms(v).max() <= p.radius:
                return 1
        return 0

    def _step_error(self, status: int) -> StepError:
        speed, limit = norms(self._block["velocity"]), self.parameters.radius / self.step_size
        return self._excess_error("velocity", "m/s", speed, limit, "one radius per step; take a smaller step_size")

    def _pair_geometry(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the vector between the centres of each pair, its length, and the overlap of each disc with the walls [m]."""
        centres, radius = self.reference + self._block["displacement"], self.parameters.radius
        first, second = centres[self.pairs.T]
        overlap = np.minimum(centres - radius, 0.0) + np.maximum(centres + radius - self.box, 0.0)
        return second - first, norms(second - first), overlap

    def _linked_pairs(self) -> np.ndarray:
        """Return which pairs are linked."""
        holding = np.arange(len(self.pairs)) < self.links
        holding[self._block["broken"]] = False
        return holding

    def _break_links(self, tick: int, distance: FloatArray) -> None:
        strain, p = distance / self.diameter - 1.0, self.parameters
        for link in np.flatnonzero(self._linked_pairs() & (strain > p.breaking_strain)).tolist():
            self._block["fracture"] += 0.5 * p.stiffness * (strain[link] * self.diameter) ** 2
            self._block.append("broken", link)
            self._add_event(tick, "link_broken", link, float(strain[link]), p.breaking_strain)

    def _spring_extensions(self, distance: FloatArray) -> FloatArray:
        """Return the extension of each pair's spring; 0 for a pair without link or contact."""
        return np.where(self._linked_pairs(), distance - self.diameter, np.minimum(distance - self.diameter, 0.0))

    def _link_forces(self) -> FloatArray:
        _, distance, _ = self._pair_geometry()
        return 0.0 - self.parameters.stiffness * self._spring_extensions(distance)[: self.links]

    def _pair_forces(self, directions: FloatArray, distance: FloatArray) -> FloatArray:
        tension = (self.parameters.stiffness * self._spring_extensions(distance) / distance)[:, np.newaxis] * directions
        forces = np.zeros_like(self.reference)
        np.add.at(forces, self.pairs[:, 0], tension)
        np.subtract.at(forces, self.pairs[:, 1], tension)
        return forces

    def _energies_and_momentum(self) -> tuple[dict[str, float], FloatArray]:
        """Return the present energies [J] and momentum [kg m/s]."""
        p, v, (_, distance, overlap) = self.parameters, self._block["velocity"], self._pair_geometry()
        kinetic = 0.5 * (self.mass * v**2).sum()
        potential = 0.5 * p.stiffness * ((self._spring_extensions(distance) ** 2).sum() + (overlap**2).sum())
        return {"kinetic_energy": float(kinetic), "potential_energy": float(potential)}, (self.mass * v).sum(axis=0)

    def balances(self) -> tuple[Balance, ...]:
        """Return the balances of energy and momentum since the reset."""
        (energies, momentum), start = self._energies_and_momentum(), self._block["start"].copy()
        work, fracture = float(self._block["work"]), float(self._block["fracture"])
        force, walls = self._block["impulses"].copy()
        return (
            Balance("energy", "J", energies, {"input_work": work}, {"fracture_energy": fracture}, float(start[0])),
            Balance("momentum", "kg m/s", {"momentum": momentum}, {"impulse": force, "wall_impulse": walls}, initial=start[1:]),
        )

    def drawables(self) -> tuple[Drawable, ...]:
        """Return the discs, coloured by speed, and the links."""
        discs = Points("discs", self.reference, np.full(len(self.reference), self.parameters.radius), "displacement", "speed")
        return discs, Links("links", "discs", self.pairs[: self.links], "linked", "link_force")
