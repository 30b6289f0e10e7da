"""PulseForming-v0: at the deadline a wanted set of solitary waves stands in the chain, and nothing else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ...components.chain import Chain
from ...components.chain.objective import Objective
from ...components.chain.wanted_waves import COLUMNS, distance, follow, pull_distance, shape_energies, wave_shapes
from ...components.errors import ParameterError
from ...components.jit import jit
from ..chain_task import ChainTask, Policy
from .making import hertz_chain, numbers_of

from .theory_drives import passing_waves

FloatArray = npt.NDArray[np.float64]

# Layout of the constants: time from the start to the deadline [s], energy of the wanted waves [J], half width of what counts
# as a wave [grains], number of waves, then the goal's rows and the shapes.
_HORIZON, _ENERGY, _WINDOW, _WAVES, _GOAL = range(5)


@jit
def _begin(a, counters, constants):
    waves, left = int(constants[_WAVES]), constants[_HORIZON]
    shapes = constants[_GOAL + COLUMNS * waves :]
    follow(a, shapes, constants[_GOAL:], waves, left, constants[_WINDOW], constants[_ENERGY], counters)


@jit
def _judge(a, inputs, counters, constants, duration, elapsed, steps):
    waves, left = int(constants[_WAVES]), constants[_HORIZON] - elapsed * duration
    shapes = constants[_GOAL + COLUMNS * waves :]
    gain = follow(a, shapes, constants[_GOAL:], waves, left, constants[_WINDOW], constants[_ENERGY], counters)
    return gain, False


@jit
def _note(a, step, steps, inputs, constants, sums):
    if step == steps - 1:
        waves = int(constants[_WAVES])
        shapes = constants[_GOAL + COLUMNS * waves :]
        sums[0] += distance(a, shapes, constants[_GOAL:], waves, 0.0) / constants[_ENERGY]


@jit
def _value(sums, constants, slopes):
    slopes[0] = 1.0
    return sums[0]


@jit
def _pull(a, bar, step, steps, inputs, input_bar, constants, slopes):
    if step == steps - 1:
        waves = int(constants[_WAVES])
        shapes = constants[_GOAL + COLUMNS * waves :]
        pull_distance(a, bar, shapes, constants[_GOAL:], waves, 0.0, slopes[0] / constants[_ENERGY])


class PulseFormingTask(ChainTask):
    """Wanted solitary waves shall stand in the chain at the deadline. See `PulseFormingEnv`.

    Args:
        chain: what is driven; Hertz contacts.
        amplitudes: largest grain velocity of each wave [m/s].
        places: grain at which each wave's crest shall be at the deadline, 0 is the first.
        horizon: time from the start to the deadline [s].
        window: half width of what counts as a wave [grains].
        actions: input -> its value at action 1.
        observations: output -> its value observed as 1.
    """

    name = "pulse_forming"
    counter_names = ("distance", "energy_outside", "amplitude_error")
    begin_kernel = _begin
    judge_kernel = _judge

    def __init__(
        self,
        chain: Chain,
        amplitudes: Sequence[float],
        places: Sequence[float],
        horizon: float,
        window: float,
        actions: Mapping[str, float],
        observations: Mapping[str, float],
    ) -> None:
        super().__init__()
        self.actions, self.observations = actions, observations
        mass, stiffness, rest = hertz_chain(self.name, chain)
        height, place = np.asarray(amplitudes), np.asarray(places)
        if len(height) != len(place) or not np.all((place >= 0.0) & (place <= chain.parameters.grains - 1)):
            raise ParameterError(
                f"place: got {place.tolist()}, expected {len(height)} grains from 0 to {chain.parameters.grains - 1}, "
                "one for each amplitude"
            )
        shapes, speeds = wave_shapes(mass, stiffness, rest, height)
        self.goal = np.column_stack([height, place, speeds])
        self.energy = float(shape_energies(shapes, height).sum())
        head = [horizon, self.energy, window, float(len(height))]
        self.shapes, self.horizon = shapes, horizon
        self.constants = np.concatenate([np.array(head), self.goal.reshape(-1), shapes])

    def objective(self, chain: Chain, steps: int) -> Objective:
        """The distance at the end of the last control step, in units of the wanted waves' energy: minus the return."""
        text = "square of the distance to the wanted waves at the end, in the energy norm, over their energy"
        return Objective(_note, _value, _pull, self.constants, description=text)

    def baselines(self) -> Mapping[str, Policy]:
        """See `PulseFormingEnv`."""
        raise NotImplementedError
