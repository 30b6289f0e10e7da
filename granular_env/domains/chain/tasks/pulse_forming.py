"""PulseForming-v1: at the deadline, the chain shall carry given solitary waves, and no other motion."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, NamedTuple, Unpack

import numpy as np

from granular_env.components.chain import Chain
from granular_env.components.chain.objective import Objective
from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.validation import positive_number
from granular_env.envs.environment import ComponentEnv
from granular_env.envs.factory import environment_factory
from granular_env.envs.policies import Policy

from ..rows import ChainRows
from .driven_end import DrivenEnd, DrivenEndTask, DrivenOptions, hertz_constants, make_driven_end, parse_numbers
from .waves import (
    AMPLITUDE,
    COLUMNS,
    compare_with_goals,
    distance_objective,
    passing_waves,
    refuse_crowded_waves,
    refuse_early_waves,
    shape_energies,
    wave_shapes,
    wave_velocities,
)  # fmt: skip


class WaveTarget(NamedTuple):
    """Constants of the tasks with target waves: the goal, and the quantities that define the distance from it.

    Attributes:
        horizon: time from the start to the deadline [s].
        duration: length of a control step [s].
        unit: energy by which the distance is divided: that of the target waves, or of a wave of 1 m/s for a sampled goal [J].
        window: half width of a wave [grains].
        goal: rows (amplitude, place, speed), one per wave, see `waves`; empty if the goal is sampled.
        shapes: tables of the wave shapes, see `waves`.
    """

    horizon: float
    duration: float
    unit: float
    window: float
    goal: FloatArray
    shapes: FloatArray


class WaveTask(DrivenEndTask):
    """Base of the tasks whose goal is a set of solitary waves at given places at the deadline."""

    constants: WaveTarget

    def goals(self, constants: Any, counters: dict[str, Any]) -> tuple[FloatArray, FloatArray]:
        """Return the goal of each episode, shape (episodes, 3 x waves), and the energies of the goals' waves [J]."""
        return constants.goal, constants.unit

    def _compare_with_goals(self, rows: ChainRows, constants: Any, counters: dict[str, Any], time_left: FloatArray) -> None:
        goals, energies = self.goals(constants, counters)
        found = rows.call_kernel(compare_with_goals, 3, constants.shapes, goals, time_left, constants.window, energies)
        counters.update(zip(("distance", "energy_outside", "amplitude_error"), found.T, strict=True))

    def begin_rows(self, rows: ChainRows, constants: Any, counters: dict[str, Any]) -> None:
        """Store the distance of the chain's state from the goal's waves, which travel to their places at the deadline."""
        self._compare_with_goals(rows, constants, counters, constants.horizon)

    def evaluate_rows(self, rows: ChainRows, constants: Any, counters: dict[str, Any], elapsed: Any) -> tuple[FloatArray, bool]:
        """Return the decrease of the distance from the goal's waves in this step."""
        before = counters["distance"]
        self._compare_with_goals(rows, constants, counters, constants.horizon - elapsed * constants.duration)
        return before - counters["distance"], False

    def present_goal(self) -> FloatArray:
        """Return the rows (amplitude, place, speed) of the present goal, shape (waves, 3)."""
        return self.constants.goal.reshape(-1, COLUMNS)

    def target_profile(self, elapsed: int) -> FloatArray:
        """Return the grain velocities [m/s] that the goal's waves have after `elapsed` control steps."""
        left = self.end.duration * (self.end.steps - elapsed)
        return wave_velocities(self.constants.shapes, self.present_goal(), left, self.grains)

    def passing_waves(self, goal: FloatArray) -> FloatArray:
        """Return the drive with which the goal's waves would enter at the left end, shape (steps,) [N or m/s]."""
        return passing_waves(self.constants.shapes, goal, self.end.duration, self.end.steps, next(iter(self.actions)))


class PulseFormingTask(WaveTask):
    """Produce given solitary waves in the chain by the deadline. See `make_pulse_forming`.

    Args:
        chain: the driven chain; Hertz contacts.
        end: the driven left end.
        amplitudes: largest grain velocity of each wave, shape (waves,) [m/s].
        places: grain at which each wave's crest shall be at the deadline (the first is 0), shape (waves,).
        window: half width of a wave [grains].
    """

    name = "pulse_forming"
    counter_names = ("distance", "energy_outside", "amplitude_error")

    def __init__(self, chain: Chain, end: DrivenEnd, amplitudes: FloatArray, places: FloatArray, window: float) -> None:
        super().__init__(chain, end)
        grains, (mass, stiffness, rest) = self.grains, hertz_constants(self.name, chain)
        if np.any(amplitudes <= 0.0):
            raise ParameterError(f"got {amplitudes.tolist()} m/s", expected="more than 0", at="amplitude")
        if len(amplitudes) != len(places) or not np.all((places >= 0.0) & (places <= grains - 1)):
            expected = f"one grain number from 0 to {grains - 1} for each of {len(amplitudes)} waves"
            raise ParameterError(f"got {places.tolist()}", expected=expected, at="place")
        shapes, speeds = wave_shapes(mass, stiffness, rest, amplitudes)
        waves = np.column_stack([amplitudes, places, speeds])
        refuse_crowded_waves(shapes, waves, grains)
        refuse_early_waves(shapes, waves, end.duration, end.steps)
        energy, horizon = float(shape_energies(shapes, waves[:, AMPLITUDE]).sum()), end.duration * end.steps
        self.constants = WaveTarget(horizon, end.duration, energy, positive_number("window", window), waves.reshape(-1), shapes)

    def objective(self, component: Chain, steps: int, *, way: float = 0.0) -> Objective:
        """Return the distance from the goal's waves after the last control step: minus the return, if the chain starts at rest.

        Args:
            component: the driven chain.
            steps: number of control steps.
            way: weight of the mean distance over all control steps, see `distance_objective`.
        """
        waves = self.constants
        return distance_objective(waves.goal, waves.shapes, waves.unit, waves.duration, way)

    def baselines(self) -> Mapping[str, Policy]:
        """Return "nothing", "theory" (the drive `passing_waves`) and the best known drive."""
        return self.open_loop_policies(self.passing_waves(self.present_goal()))


@environment_factory
def make_pulse_forming(
    grains: int = 64,
    *,
    amplitude: Any = 5.0,
    place: Any = 40.0,
    window: float = 5.0,
    **options: Unpack[DrivenOptions],
) -> ComponentEnv:
    r"""Drive the left end so that the chain carries given solitary waves at the deadline, and nothing else moves.

    A chain of equal elastic spheres carries solitary waves: pulses some five grains long whose speed grows with the fifth
    root of their height (Nesterenko 1983). A push of the left end becomes one or several of them, followed by small waves
    and rebounding grains. The task prescribes number, height, position and shape of the waves at one instant.

    ## Observation space
    Counters: "distance" (D below); "energy_outside", the fraction of the input energy that is more than `window` grains
    away from every target crest; "amplitude_error", the largest relative error of a crest's height.

    ## Rewards
    The squared distance from the target waves, in the energy norm, is

    $$D = \frac{1}{E^*}\left(\sum_i \tfrac12 m_i (v_i - v_i^*)^2 + \sum_j (q_j - q_j^*)^2\right).$$

    Stars denote the exact solitary waves of the lattice, $E^*$ is their energy, and $q = \sqrt{0.4\,k}\,d^{5/4}$ is the
    root of the energy of a contact with stiffness k and overlap d. Under precompression $q^2$ is the energy above that at
    rest. Each reward is the decrease of D in the step. The return is therefore -D at the deadline: 0 is perfect, a chain at
    rest returns -1, and an exact wave has D below 3e-10.

    Before the deadline a target crest is behind its final position by its speed times the remaining time. Waves that have
    not entered the chain yet do not count. In a disordered chain the target waves are those of its mean grain. In a dimer
    or a tapered chain they are no waves of that chain: in a dimer of 3 and 1.5 mm a zero input returns -1.286 and theory
    -1.955.

    ## Arguments
    * `amplitude` (5.0 m/s), `place` (40): height and grain of the crest at the deadline (the first grain is 0); lists for
      several waves. Waves that overlap, or extend beyond an end of the chain, are rejected.
    * `window` (5.0 grains): half width of a wave.

    ## Baselines
    "theory" replaces the grains that are missing to the left of the chain while the exact waves pass: the force
    $F = \frac{d}{dt}\sum_i m v_i^*$, or the velocity $v_0^*$ of a piston, averaged over each control step. "best" was found
    by gradient. They return -7.3e-4 and -1.5e-13 with a force, -1.4e-3 and -1.5e-13 with a piston. The error of theory
    comes from holding the input over a control step, that of the best drive from the tabulated wave shape.
    """
    chain, end, rest = make_driven_end(make_pulse_forming, locals(), internal_steps=3, deadline=180)
    heights, places = parse_numbers("amplitude", amplitude), parse_numbers("place", place)
    task = partial(PulseFormingTask, end=end, amplitudes=heights, places=places, window=window)
    return ComponentEnv(chain, task, **rest)
