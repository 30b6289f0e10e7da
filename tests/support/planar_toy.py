"""A component of the tests: bodies in a plane, in a ring of springs that break. It uses all of the contract."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from pydantic import Field

from granular_env.components.component import Component
from granular_env.components.contract import Balance, Variable
from granular_env.components.drawables import Drawable, Links, Points
from granular_env.components.errors import StepError
from granular_env.components.profiles import CompiledProfile
from granular_env.components.snapshot import EVENT_ROWS, FloatArray
from granular_env.components.support.validation import Parameters


class RingParameters(Parameters):
    """A ring of bodies."""

    bodies: int = Field(4, ge=3, description="how many bodies", json_schema_extra={"unit": "1"})
    mass: float = Field(2.0, gt=0.0, description="mass of each body", json_schema_extra={"unit": "kg"})
    stiffness: float = Field(3.0, gt=0.0, description="stiffness of each spring", json_schema_extra={"unit": "N/m"})
    strength: float = Field(0.2, gt=0.0, description="lengthening at which a spring breaks", json_schema_extra={"unit": "m"})
    step_size: float = Field(0.02, gt=0.0, description="internal step", json_schema_extra={"unit": "s"})


class Ring(Component):
    """Bodies on a circle, each tied to the next by a spring that breaks."""

    name = "ring"
    Parameters = RingParameters
    parameters: RingParameters
    event_kinds = {"spring_broke": "a spring was lengthened beyond its strength"}

    def _build(self) -> None:
        n = self.parameters.bodies
        self.step_size, self.mass = self.parameters.step_size, np.full(n, self.parameters.mass)
        # A square, pentagon, ... with corners of decimal fractions: no sine enters the state.
        self.reference = np.round(np.array([(np.cos(2 * np.pi * i / n), np.sin(2 * np.pi * i / n)) for i in range(n)]), 3)
        self.pairs = np.array([(i, (i + 1) % n) for i in range(n)])
        self.length = np.sqrt(((self.reference[self.pairs[:, 1]] - self.reference[self.pairs[:, 0]]) ** 2).sum(axis=1))
        self._lay_out(
            displacement=("f8", (n, 2)), velocity=("f8", (n, 2)), linked=("f8", (n,)),
            work=("f8", (3,)), impulse=("f8", (2,)), start=("f8", (3,)), growing={"events": EVENT_ROWS},
        )  # fmt: skip

    def _declare(self) -> Iterable[Variable]:
        n = self.parameters.bodies
        yield Variable("pull", "input", "N", (n, 2), "force on each body", minimum=-1e6, maximum=1e6, axes=("body", "axis"))
        yield Variable("displacement", "output", "m", (n, 2), "displacement", state=True, axes=("body", "axis"))
        yield Variable("velocity", "output", "m/s", (n, 2), "velocity", state=True, axes=("body", "axis"))
        yield Variable("speed", "output", "m/s", (n,), "magnitude of the velocity", axes=("body",))
        yield Variable("linked", "output", "1", (n,), "1 where the spring to the next body holds, else 0", axes=("spring",))

    def _outputs(self) -> dict[str, Callable[[], Any]]:
        views = {name: (lambda name=name: self._block[name]) for name in ("displacement", "velocity", "linked")}
        return {**views, "speed": lambda: np.sqrt((self._block["velocity"] ** 2).sum(axis=1))}

    def _start(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        self._block["linked"][:] = 1.0
        for name, value in values.items():
            self._block[name][...] = value
        self._block["start"][:] = self._energies().sum(), *self._momentum()
        return {}

    @np.errstate(over="ignore", invalid="ignore", divide="ignore")  # the status tells
    def _advance(self, ticks: int) -> int:
        given, h = self._held["pull"], self.step_size
        u, v, work, impulse = (self._block[name] for name in ("displacement", "velocity", "work", "impulse"))
        for tick in range(self._tick, self._tick + ticks):
            pull = given.value(tick, 0.5) if isinstance(given, CompiledProfile) else given
            u += 0.5 * h * v
            kick = h / self.mass[:, np.newaxis] * (pull + self._spring_forces())
            work[0] += h * (pull * (v + 0.5 * kick)).sum()
            impulse += h * pull.sum(axis=0)
            v += kick
            u += 0.5 * h * v
            self._break(tick + 1)
        return 0 if np.isfinite(v).all() else 1

    def _extensions(self) -> tuple[FloatArray, FloatArray]:
        ends = (self.reference + self._block["displacement"])[self.pairs]
        along = ends[:, 1] - ends[:, 0]
        length = np.sqrt((along**2).sum(axis=1))
        return length - self.length, along / length[:, np.newaxis]

    def _spring_forces(self) -> FloatArray:
        extension, direction = self._extensions()
        tension = (self.parameters.stiffness * extension * self._block["linked"])[:, np.newaxis] * direction
        # Each body gathers the springs on its two sides.
        return tension - np.roll(tension, 1, axis=0)

    def _break(self, tick: int) -> None:
        extension, strength = self._extensions()[0], self.parameters.strength
        for spring in np.flatnonzero((extension > strength) & (self._block["linked"] > 0.0)):
            self._block["linked"][spring] = 0.0
            self._block["work"][1] += 0.5 * self.parameters.stiffness * extension[spring] ** 2
            self._add_event(tick, "spring_broke", int(spring), float(extension[spring]), strength)

    def _explain(self, status: int) -> StepError:
        return StepError("too fast", time=self.time, variable="velocity", index=0, value=float("inf"), limit=1e308)

    def _energies(self) -> FloatArray:
        kinetic = 0.5 * self.parameters.mass * (self._block["velocity"] ** 2).sum()
        elastic = 0.5 * self.parameters.stiffness * (self._extensions()[0] ** 2 * self._block["linked"]).sum()
        return np.array([kinetic, elastic])

    def _momentum(self) -> FloatArray:
        return self.parameters.mass * self._block["velocity"].sum(axis=0)

    def balances(self) -> tuple[Balance, ...]:
        kinetic, elastic = self._energies().tolist()
        work, fracture, _ = self._block["work"].tolist()
        stored = {"kinetic_energy": kinetic, "elastic_energy": elastic}
        start = self._block["start"]
        return (
            Balance("energy", "J", stored, {"input_work": work}, {"fracture_energy": fracture}, float(start[0])),
            Balance("momentum", "kg m/s", {"momentum": self._momentum()}, {"impulse": self._block["impulse"].copy()},
                    initial=start[1:].copy()),
        )  # fmt: skip

    def drawables(self) -> tuple[Drawable, ...]:
        bodies = Points("bodies", self.reference, np.full(len(self.mass), 0.1), "displacement", "speed")
        return bodies, Links("springs", "bodies", self.pairs, "linked")
