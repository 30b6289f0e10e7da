"""A matched end: a virtual chain goes on where the real one ends, so that waves pass into it and none comes back.

The virtual chain is a component like the real one. It is driven by what the sensors at the end read, and it looks one control
step ahead, because what is decided now holds until then.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from granular_env.components.chain import Chain
from granular_env.envs.task import Task

# What a matched end reads: the end grain's displacement, velocity of the last but one and of the last, the force between them.
SENSORS = {"displacement": [-1], "velocity": [-2, -1], "contact_force": [-2]}

# A wave needs this many grains' time to come back from the virtual chain's own end: as long as the real one is.
_VIRTUAL_GRAINS = 96


@dataclass(frozen=True)
class Sensors:
    """The scales of `SENSORS`: displacement [m], velocity [m/s] and force [N] that are observed as 1."""

    displacement: float
    velocity: float
    force: float

    @classmethod
    def of(cls, task: Task) -> Self:
        """Return the scales of a task."""
        return cls(task.observations["displacement"], task.observations["velocity"], task.unit_scales["N"])

    def read(self, observation: npt.NDArray[np.float32]) -> tuple[float, float, float, float]:
        """Displacement of the end, velocity of the last but one and of the end, force between them; SI."""
        u, before, v, force = (float(x) for x in observation[:4])
        return u * self.displacement, before * self.velocity, v * self.velocity, force * self.force


class MatchedPiston:
    """A piston at the right end that moves as the next grain of an endless chain would.

    The virtual chain's first grain stands for the piston's and is pushed by the measured force. Over a control step that has
    passed, the mean of the two readings is taken; over the next one, the force goes on as it went. The command is the way from
    where the piston is to where that grain will be.

    Args:
        mass: of a grain [kg].
        stiffness: k of a contact [N/m^1.5].
        step_size: internal step of the virtual chain [s].
        duration: of a control step [s].
        scale: velocity at action 1 [m/s].
        sensors: scales of the observation.
    """

    def __init__(
        self, mass: float, stiffness: float, step_size: float, duration: float, scale: float, sensors: Sensors
    ) -> None:
        self.duration, self.scale, self.sensors, self.mass = duration, scale, sensors, mass
        self.chain = self._virtual(mass, stiffness, step_size)
        self.reset()

    def _virtual(self, mass: float, stiffness: float, step_size: float) -> Chain:
        return _chain("free", mass, stiffness, step_size)

    def reset(self) -> None:
        """Put the virtual chain at rest."""
        self.chain.reset()
        self.force, self.begun = 0.0, False

    def __call__(self, observation: npt.NDArray[np.float32], info: Mapping[str, Any]) -> npt.NDArray[np.float64]:
        """Return the piston's velocity over the next control step."""
        place, _, _, force = self.sensors.read(observation)
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
    """A force on the right end grain: what the next grain of an endless chain would push back with.

    The virtual chain's first grain is the real end grain, moved as it moves. For the next control step its velocity goes on as
    its acceleration says; what that step hands to the virtual grains behind it is the impulse that it gets back.

    Args:
        mass: of a grain [kg].
        stiffness: k of a contact [N/m^1.5].
        step_size: internal step of the virtual chain [s].
        duration: of a control step [s].
        scale: force at action 1 [N].
        sensors: scales of the observation.
    """

    def __init__(
        self, mass: float, stiffness: float, step_size: float, duration: float, scale: float, sensors: Sensors
    ) -> None:
        self.duration, self.scale, self.sensors, self.mass = duration, scale, sensors, mass
        self.chain = _chain("piston", mass, stiffness, step_size)
        self.reset()

    def reset(self) -> None:
        """Put the virtual chain at rest."""
        self.chain.reset()
        self.pushed, self.force, self.begun = 0.0, 0.0, False

    def __call__(self, observation: npt.NDArray[np.float32], info: Mapping[str, Any]) -> npt.NDArray[np.float64]:
        """Return the force on the end grain over the next control step."""
        place, _, speed, force = self.sensors.read(observation)
        if self.begun:
            # The grain's own way, so that the virtual contact is as deep as a real one would be.
            self.chain.step(self.duration, left_velocity=(place - float(self.chain.get("displacement")[0])) / self.duration)
        coming = force + 0.5 * (force - self.force) if self.begun else force
        self.force, self.begun = force, True
        now, pushed = self.chain.save(), self.pushed
        for _ in range(3):  # the push and the motion that it belongs to, in turn
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
    """A passive end for comparison: the end grain is braked by c |v|^p, v half a control step ahead of the last reading.

    p = 1.2 with c = k ((5/4) sqrt(m / 1.5 k))^1.2 is the impedance of a simple wave, whose force goes with the overlap's power
    3/2 and its grain velocity with the power 5/4; a solitary wave is none, and another c does better.

    Args:
        coefficient: c [N / (m/s)^p].
        exponent: p.
        duration: of a control step [s].
        scale: force at action 1 [N].
        sensors: scales of the observation.
    """

    def __init__(self, coefficient: float, exponent: float, duration: float, scale: float, sensors: Sensors) -> None:
        self.coefficient, self.exponent, self.duration, self.scale = coefficient, exponent, duration, scale
        self.sensors = sensors
        self.reset()

    def reset(self) -> None:
        """Forget the last reading."""
        self.before: float | None = None

    def __call__(self, observation: npt.NDArray[np.float32], info: Mapping[str, Any]) -> npt.NDArray[np.float64]:
        """Return the force on the end grain over the next control step."""
        speed = self.sensors.read(observation)[2]
        coming = speed + (0.5 * (speed - self.before) if self.before is not None else 0.0)
        self.before = speed
        return np.array([np.clip(-np.sign(coming) * self.coefficient * abs(coming) ** self.exponent / self.scale, -1.0, 1.0)])


def _chain(left: str, mass: float, stiffness: float, step_size: float) -> Chain:
    return Chain(
        grains=_VIRTUAL_GRAINS, mass=mass, contact_stiffness=stiffness, step_size=step_size, left=left, velocity_scale=10.0
    )
