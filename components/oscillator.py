"""A toy component: a mass on a spring, driven by a force. The worked example of a component.

m x'' = -k x + F, advanced by leapfrog (second order, symplectic).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
from pydantic import Field

from .balances import Balance
from .component import Component
from .errors import StepError
from .inputs import input_mean
from .support.float_arrays import FloatArray
from .support.validation import Parameters
from .variables import Variable


class OscillatorParameters(Parameters):
    """A mass on a spring."""

    mass: float = Field(1.0, gt=0.0, description="mass of the body", json_schema_extra={"unit": "kg"})
    stiffness: float = Field(1.0, ge=0.0, description="stiffness of the spring", json_schema_extra={"unit": "N/m"})
    step_size: float = Field(0.01, gt=0.0, description="internal step", json_schema_extra={"unit": "s"})


class Oscillator(Component):
    """A mass on a spring, driven by a force."""

    name = "oscillator"
    version = 2
    Parameters = OscillatorParameters

    def _build_system(self) -> None:
        p: OscillatorParameters = self.parameters  # type: ignore[assignment]
        self.mass, self.stiffness, self.step_size = p.mass, p.stiffness, p.step_size
        self._define_state(position=("f8", ()), velocity=("f8", ()), tally=("f8", (4,)))

    def _declare_variables(self) -> Iterable[Variable]:
        yield Variable("force", "input", "N", (), "force on the body", start=0.0)
        yield Variable("position", "output", "m", (), "position of the body; 0 if the spring is relaxed", state=True)
        yield Variable("velocity", "output", "m/s", (), "velocity of the body", state=True)

    def _write_start_state(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, float]:
        given = super()._write_start_state(seed, values)
        self._block["tally"][:2] = self._energy(), self.mass * float(self._block["velocity"])
        return given

    @np.errstate(over="ignore", invalid="ignore")  # the returned status reports overflow
    def _advance_state(self, ticks: int) -> int:
        given = self._held["force"]
        x, v, tally, h = self._block["position"], self._block["velocity"], self._block["tally"], self.step_size
        for tick in range(self._tick, self._tick + ticks):
            force = input_mean(given, tick)
            x += 0.5 * h * v
            kick = h / self.mass * (force - self.stiffness * x)
            tally[2] += h * force * (v + 0.5 * kick)
            tally[3] += h * (force - self.stiffness * x)
            v += kick
            x += 0.5 * h * v
        return 0 if np.isfinite(self._energy()) else 1

    def _step_error(self, status: int) -> StepError:
        # The energy has become infinite because the square of a variable overflowed.
        name = max(("velocity", "position"), key=lambda one: np.nan_to_num(abs(self._block[one]), nan=np.inf))
        value, unit = float(self._block[name]), self.variables[name].unit
        return StepError(
            f"became {value} {unit} soon after {self.time:g} s; take a smaller step_size",
            time=self.time, at=name, variable=name, index=None, value=value, limit=math.sqrt(np.finfo(float).max),
        )  # fmt: skip

    def _energy(self) -> float:
        x, v = float(self._block["position"]), float(self._block["velocity"])
        return 0.5 * self.mass * v * v + 0.5 * self.stiffness * x * x

    def balances(self) -> tuple[Balance, ...]:
        """Return the balances of energy and momentum since the reset."""
        energy, momentum, work, impulse = (float(entry) for entry in self._block["tally"])
        x = float(self._block["position"])
        potential = 0.5 * self.stiffness * x * x
        stored = {"kinetic_energy": self._energy() - potential, "potential_energy": potential}
        now = self.mass * float(self._block["velocity"])
        return (
            Balance("energy", "J", stored=stored, supplied={"input_work": work}, initial=energy),
            Balance("momentum", "kg m/s", stored={"momentum": now}, supplied={"impulse": impulse}, initial=momentum),
        )
