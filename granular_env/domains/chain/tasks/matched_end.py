"""A matched end: a virtual chain continues the real chain, so that waves leave without reflection.

The virtual chain is a `Chain` component, driven by the readings of the sensors at the end of the real chain. It is simulated
one control step ahead of the real chain, because the action is held over that step.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from granular_env.components.chain import Chain
from granular_env.envs.task import Task

# Outputs that a matched end reads: displacement of the end grain, velocities of the last two grains, force between them.
SENSORS = {"displacement": [-1], "velocity": [-2, -1], "contact_force": [-2]}

# Number of grains in the virtual chain; a reflection from its far end returns only after a wave has crossed all of them twice.
_VIRTUAL_GRAINS = 96


@dataclass(frozen=True)
class SensorScales:
    """The scales of `SENSORS`: displacement [m], velocity [m/s] and force [N] that are observed as 1."""

    displacement: float
    velocity: float
    force: float

    @classmethod
    def from_task(cls, task: Task) -> Self:
        """Return the observation scales of a task."""
        return cls(task.observations["displacement"], task.observations["velocity"], task.unit_scales["N"])

    def parse_observation(self, observation: npt.NDArray[np.float32]) -> tuple[float, float, float, float]:
        """Return the readings in SI: end displacement, velocities of the last two grains, force between them."""
        u, before, v, force = (float(x) for x in observation[:4])
        return u * self.displacement, before * self.velocity, v * self.velocity, force * self.force


class MatchedPiston:
    """A piston at the right end that moves as the next grain of an endless chain would.

    The first grain of the virtual chain represents the piston's grain; the measured force drives it. For the past control step
    the force is the mean of two readings; for the next step it is extrapolated linearly. The command is the velocity that takes
    the piston to the predicted position of this grain.

    Args:
        mass: mass of a grain [kg].
        stiffness: k of a contact [N/m^1.5].
        step_size: internal step of the virtual chain [s].
        duration: duration of a control step [s].
        scale: velocity at action 1 [m/s].
        sensors: values of the sensor readings that are observed as 1.
    """

    def __init__(
        self, mass: float, stiffness: float, step_size: float, duration: float, scale: float, sensors: SensorScales
    ) -> None:
        self.duration, self.scale, self.sensors, self.mass = duration, scale, sensors, mass
        self.chain = self._make_virtual_chain(mass, stiffness, step_size)
        self.reset()

    def _make_virtual_chain(self, mass: float, stiffness: float, step_size: float) -> Chain:
        return _virtual_chain("free", mass, stiffness, step_size)

    def reset(self) -> None:
        """Put the virtual chain at rest."""
        self.chain.reset()
        self.force, self.begun = 0.0, False

    def __call__(self, observation: npt.NDArray[np.float32], info: Mapping[str, Any]) -> npt.NDArray[np.float64]:
        """Return the piston's velocity over the next control step, as an action."""
        place, _, _, force = self.sensors.parse_observation(observation)
        if self.begun:
            self.chain.step(self.duration, left_force=0.5 * (self.force + force))
        coming = max(force + 0.5 * (force - self.force), 0.0) if self.begun else force
        self.force, self.begun = force, True
        now = self.chain.save()
        self.chain.step(self.duration, left_force=coming)
        ahead = float(self.chain.get("displacement")[0])
        self.chain.restore(now)
        return np.array([np.clip((ahead - place) / (self.duration * self.scale), -1.0, 1.0)])


class MatchedForce:
    """A force on the right end grain, equal to the contact force from the next grain of an endless chain.

    The first grain of the virtual chain follows the real end grain. For the next control step its velocity is extrapolated with
    its acceleration; the impulse that the virtual grains behind it receive in this step is applied to the end grain in reverse.

    Args:
        mass: mass of a grain [kg].
        stiffness: k of a contact [N/m^1.5].
        step_size: internal step of the virtual chain [s].
        duration: duration of a control step [s].
        scale: force at action 1 [N].
        sensors: values of the sensor readings that are observed as 1.
    """

    def __init__(
        self, mass: float, stiffness: float, step_size: float, duration: float, scale: float, sensors: SensorScales
    ) -> None:
        self.duration, self.scale, self.sensors, self.mass = duration, scale, sensors, mass
        self.chain = _virtual_chain("piston", mass, stiffness, step_size)
        self.reset()

    def reset(self) -> None:
        """Put the virtual chain at rest."""
        self.chain.reset()
        self.pushed, self.force, self.begun = 0.0, 0.0, False

    def __call__(self, observation: npt.NDArray[np.float32], info: Mapping[str, Any]) -> npt.NDArray[np.float64]:
        """Return the force on the end grain over the next control step, as an action."""
        place, _, speed, force = self.sensors.parse_observation(observation)
        if self.begun:
            # Give the first virtual grain the real displacement, so that its contact has the overlap of a real contact.
            self.chain.step(self.duration, left_velocity=(place - float(self.chain.get("displacement")[0])) / self.duration)
        coming = force + 0.5 * (force - self.force) if self.begun else force
        self.force, self.begun = force, True
        now, pushed = self.chain.save(), self.pushed
        for _ in range(3):  # fixed-point iteration between force and motion
            mean = speed + 0.5 * self.duration * (coming - pushed) / self.mass
            before = self._momentum()
            self.chain.step(self.duration, left_velocity=mean)
            pushed = (self._momentum() - before) / self.duration
            self.chain.restore(now)
        self.pushed = pushed
        return np.array([np.clip(-pushed / self.scale, -1.0, 1.0)])

    def _momentum(self) -> float:
        return self.mass * float(self.chain.get("velocity")[1:].sum())


class Dashpot:
    """A passive end for comparison: a damping force c |v|^p on the end grain, with v extrapolated by half a control step.

    In a simple wave, force ~ overlap^(3/2) and grain velocity v ~ overlap^(5/4), so that the force is c |v|^p with
    p = 1.2 and c = k ((5/4) sqrt(m / 1.5 k))^1.2. A solitary wave is not a simple wave, and a different c absorbs it better.

    Args:
        coefficient: c of the damping force [N / (m/s)^p].
        exponent: p of the damping force.
        duration: duration of a control step [s].
        scale: force at action 1 [N].
        sensors: values of the sensor readings that are observed as 1.
    """

    def __init__(self, coefficient: float, exponent: float, duration: float, scale: float, sensors: SensorScales) -> None:
        self.coefficient, self.exponent, self.duration, self.scale = coefficient, exponent, duration, scale
        self.sensors = sensors
        self.reset()

    def reset(self) -> None:
        """Forget the last reading."""
        self.before: float | None = None

    def __call__(self, observation: npt.NDArray[np.float32], info: Mapping[str, Any]) -> npt.NDArray[np.float64]:
        """Return the force on the end grain over the next control step, as an action."""
        speed = self.sensors.parse_observation(observation)[2]
        coming = speed + (0.5 * (speed - self.before) if self.before is not None else 0.0)
        self.before = speed
        return np.array([np.clip(-np.sign(coming) * self.coefficient * abs(coming) ** self.exponent / self.scale, -1.0, 1.0)])


def _virtual_chain(left: str, mass: float, stiffness: float, step_size: float) -> Chain:
    return Chain(
        grains=_VIRTUAL_GRAINS, mass=mass, contact_stiffness=stiffness, step_size=step_size, left=left, velocity_scale=10.0
    )
