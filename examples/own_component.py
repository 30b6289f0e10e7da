"""A custom component: a bouncing ball, recorded, replayed and branched like any other component.

Run it with `python examples/own_component.py`; it writes a log to the current folder.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from pydantic import Field

import granular_env as ge
from granular_env.components.balances import Balance
from granular_env.components.errors import StepError
from granular_env.components.support.validation import Parameters

GRAVITY = 9.81  # m/s^2


class BallParameters(Parameters):
    """Parameters of the ball."""

    mass: float = Field(0.1, gt=0.0, description="mass", json_schema_extra={"unit": "kg"})
    restitution: float = Field(0.8, ge=0.0, le=1.0, description="speed after / before", json_schema_extra={"unit": "1"})
    step_size: float = Field(1e-3, gt=0.0, description="internal step", json_schema_extra={"unit": "s"})


class Ball(ge.Component):
    """Ball in free fall; a bounce keeps a fraction of its speed."""

    name = "ball"
    Parameters = BallParameters
    parameters: BallParameters

    def _build_system(self) -> None:
        self.step_size = self.parameters.step_size
        self._define_state(height=("f8", ()), velocity=("f8", ()), lost=("f8", ()), start=("f8", (2,)), impulse=("f8", ()))

    def _declare_variables(self) -> Iterable[ge.Variable]:
        yield ge.Variable("height", "output", "m", (), "height above the floor", state=True)
        yield ge.Variable("velocity", "output", "m/s", (), "velocity, positive upwards", state=True)

    def _output_readers(self) -> dict[str, Callable[[], float]]:
        return {name: (lambda view=self._block[name]: float(view)) for name in ("height", "velocity")}

    def _write_start_state(self, seed: int | None, values: Mapping[str, Any]) -> Mapping[str, float]:
        for name, value in values.items():
            self._block[name][...] = value
        self._block["start"][:] = sum(self._energies()), self._momentum()
        return {}

    def _advance_state(self, ticks: int) -> int:
        height, velocity, h = self._block["height"], self._block["velocity"], self.step_size
        for _ in range(ticks):
            height += h * velocity - 0.5 * h * h * GRAVITY  # exact in free fall
            velocity -= h * GRAVITY
            self._block["impulse"][...] -= self.parameters.mass * GRAVITY * h
            if height < 0.0 and velocity < 0.0:
                self._bounce()
        return 0

    def _bounce(self) -> None:
        before, momentum = sum(self._energies()), self._momentum()
        self._block["velocity"][...] *= -self.parameters.restitution
        self._block["lost"][...] += before - sum(self._energies())
        self._block["impulse"][...] += self._momentum() - momentum

    def _step_error(self, status: int) -> StepError:
        return StepError("the ball never fails", time=self.time, variable="height", index=None, value=0.0, limit=0.0)

    def _energies(self) -> tuple[float, float]:
        mass = self.parameters.mass
        return 0.5 * mass * float(self._block["velocity"]) ** 2, mass * GRAVITY * float(self._block["height"])

    def _momentum(self) -> float:
        return self.parameters.mass * float(self._block["velocity"])

    def balances(self) -> tuple[Balance, ...]:
        """Energy is lost in bounces only; gravity and the floor give the impulse."""
        (kinetic, potential), lost, impulse = self._energies(), float(self._block["lost"]), float(self._block["impulse"])
        energy, momentum = self._block["start"].tolist()
        stored = {"kinetic_energy": kinetic, "potential_energy": potential}
        return (
            Balance("energy", "J", stored=stored, lost={"dissipated_energy": lost}, initial=energy),
            Balance("momentum", "kg m/s", {"momentum": self._momentum()}, {"impulse": impulse}, initial=momentum),
        )


def main() -> dict[str, float]:
    ball = Ball(restitution=0.5)
    with ge.record(ball, "ball.mcap", overwrite=True):
        ball.reset(height=1.0)
        ball.step(1.0)
    verification = ge.verify("ball.mcap", components={"ball": Ball})
    return {
        "energy lost / energy at the start": ball.get("dissipated_energy") / (ball.parameters.mass * GRAVITY),
        "energy residual": ball.get("energy_residual"),
        "identical": verification.identical,
    }


if __name__ == "__main__":
    for name, value in main().items():
        print(f"{name}: {value}")
