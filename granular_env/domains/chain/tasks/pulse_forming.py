"""PulseForming-v1: form only a wanted set of solitary waves by the deadline."""

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
    """Constants of the tasks with wanted waves: the goal, and what turns it into a distance.

    Attributes:
        horizon: time from the start to the deadline [s].
        duration: of a control step [s].
        unit: energy of the wanted waves; where a goal is drawn, of a wave of 1 m/s [J].
        window: half width of what counts as a wave [grains].
        goal: rows (amplitude, place, speed); empty where it is drawn.
        shapes: of the waves, see `waves`.
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
        """Return the goals, shape (episodes, 3 waves), and the energies of the goals' waves."""
        return constants.goal, constants.unit

    def _compare_with_goals(self, rows: ChainRows, constants: Any, counters: dict[str, Any], time_left: FloatArray) -> None:
        goals, energies = self.goals(constants, counters)
        found = rows.call_kernel(compare_with_goals, 3, constants.shapes, goals, time_left, constants.window, energies)
        counters.update(zip(("distance", "energy_outside", "amplitude_error"), found.T, strict=True))

    def begin_rows(self, rows: ChainRows, constants: Any, counters: dict[str, Any]) -> None:
        """Store the distance from the travelling goal waves."""
        self._compare_with_goals(rows, constants, counters, constants.horizon)

    def judge_rows(self, rows: ChainRows, constants: Any, counters: dict[str, Any], elapsed: Any) -> tuple[FloatArray, bool]:
        """Return the decrease of the distance in this step."""
        before = counters["distance"]
        self._compare_with_goals(rows, constants, counters, constants.horizon - elapsed * constants.duration)
        return before - counters["distance"], False

    def present_goal(self) -> FloatArray:
        """Return the rows (amplitude, place, speed) of the present goal, shape (waves, 3)."""
        return self.constants.goal.reshape(-1, COLUMNS)

    def target_profile(self, elapsed: int) -> FloatArray:
        """Return the grain velocities of the wanted waves after `elapsed` control steps."""
        left = self.end.duration * (self.end.steps - elapsed)
        return wave_velocities(self.constants.shapes, self.present_goal(), left, self.grains)

    def passing_waves(self, goal: FloatArray) -> FloatArray:
        """Return the drive of the left end that the goal's waves exert as they pass, shape (steps,) [N or m/s]."""
        return passing_waves(self.constants.shapes, goal, self.end.duration, self.end.steps, next(iter(self.actions)))


class PulseFormingTask(WaveTask):
    """Produce given solitary waves in the chain by the deadline. See `make_pulse_forming`.

    Args:
        chain: the driven chain; Hertz contacts.
        end: its left end.
        amplitudes: largest grain velocity of each wave, shape (waves,) [m/s].
        places: grain at which each wave's crest shall be at the deadline, 0 is the first, shape (waves,).
        window: half width of what counts as a wave [grains].
    """

    name = "pulse_forming"
    counter_names = ("distance", "energy_outside", "amplitude_error")

    def __init__(self, chain: Chain, end: DrivenEnd, amplitudes: FloatArray, places: FloatArray, window: float) -> None:
        super().__init__(chain, end)
        grains, (mass, stiffness, rest) = self.grains, hertz_constants(self.name, chain)
        if np.any(amplitudes <= 0.0):
            raise ParameterError(f"got {amplitudes.tolist()} m/s", expected="more than 0", at="amplitude")
        if len(amplitudes) != len(places) or not np.all((places >= 0.0) & (places <= grains - 1)):
            expected = f"grains from 0 to {grains - 1}, one for each of {len(amplitudes)} waves"
            raise ParameterError(f"got {places.tolist()}", expected=expected, at="place")
        shapes, speeds = wave_shapes(mass, stiffness, rest, amplitudes)
        waves = np.column_stack([amplitudes, places, speeds])
        refuse_crowded_waves(shapes, waves, grains)
        refuse_early_waves(shapes, waves, end.duration, end.steps)
        energy, horizon = float(shape_energies(shapes, waves[:, AMPLITUDE]).sum()), end.duration * end.steps
        self.constants = WaveTarget(horizon, end.duration, energy, positive_number("window", window), waves.reshape(-1), shapes)

    def objective(self, component: Chain, steps: int, *, way: float = 0.0) -> Objective:
        """Return the distance after the last control step, which is minus the return if the chain starts at rest.

        Args:
            component: the driven chain.
            steps: control steps.
            way: weight of the mean distance over all control steps, see `distance_objective`.
        """
        waves = self.constants
        return distance_objective(waves.goal, waves.shapes, waves.unit, waves.duration, way)

    def baselines(self) -> Mapping[str, Policy]:
        """Return the drive of the passing waves, and the best known drive."""
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
    """Drive the left end so that the chain carries given solitary waves at the deadline, and nothing else moves.

    A row of equal elastic spheres in touch carries solitary waves: pulses some five grains long whose speed grows with the
    fifth root of their height (Nesterenko 1983). A push of the left end becomes one or several of them, with small ones behind
    and grains that rebound. The task asks for their number, height, place and shape at one instant.

    ## Action space
    `Box(-1, 1, (1,), float32)`: the value held over the next control step, in units of `action_scale`. `action="force"`: the
    force on the first grain, positive to the right; pulling moves the first grain alone. `action="piston"`: the velocity of the
    first grain.

    ## Observation space
    `Box((2 grains + clock,), float32)`: displacement and velocity of every grain, in units of 1 mm and 10 m/s, then the clock.
    The counters are "distance" (D below), "energy_outside" (energy further than `window` grains from every wanted crest, over
    the energy put in) and "amplitude_error" (relative error of the fastest grain about each crest, the largest over the waves).

    ## Rewards
    The distance of a state from the wanted waves is that of the energy norm, D = (sum_i m_i (v_i - v*_i)^2 / 2 + sum_j (q_j -
    q*_j)^2) / E*, with q = sqrt(0.4 k) d^1.25, the root of the energy stored in a contact of overlap d (above that at rest,
    where the chain is precompressed), * for the exact solitary waves of the lattice, E* their energy. In a disordered chain
    they are those of its mean grain. Before the deadline the wanted waves are on their way: each crest is behind its place by
    its speed times the time left, and a wave that has not entered the chain yet is not wanted. A step's reward is D before it
    less D after it. So the return is -D at the deadline. In a chain of equal grains doing nothing returns -1, and 0 is perfect.
    In a dimer or a tapered chain the wanted wave is not a wave of that chain: neither number holds, nor does the baseline of
    theory (a dimer of 3 and 1.5 mm: doing nothing -1.286, theory -1.955).

    ## Start state
    Everything at rest, all grains in touch.

    ## End of the episode
    Terminated after `deadline` control steps, at which the waves are due; the agent sees the time. With `clock=0` it does not,
    and the episode is truncated.

    ## Arguments
    * `grains` (64), `radius` (3e-3 m), `material` ("steel"): the chain, its right end free.
    * `action` ("force"): "force" or "piston". `action_scale` (None): 1000 N or 10 m/s.
    * `amplitude` (5.0 m/s), `place` (40): of the crest at the deadline, the first grain is 0; lists for several waves. Waves
      that lie over each other, or hang over an end of the chain, are refused.
    * `window` (5.0 grains): half width of what counts as a wave.
    * `step_size` (5e-7 s): internal step. `internal_steps` (3) make a control step, `deadline` (180) control steps an episode
      of 270 us, 26 us more than the wave takes from end to place. A deadline that no wave can meet is refused.
    * `clock` (8): readings of the clock.
    * `chain`: further parameters of the chain component, e.g. `{"precompression": 10.0}`; Hertz contacts.

    ## Baselines
    `env.unwrapped.task.baselines()`: "nothing"; "theory", what the missing grains would do to the first one while the exact
    waves pass, F = d(sum_i m v*_i)/dt or v*_0, averaged over each control step; "best", the best drive known, where all
    arguments but `action` are the defaults. They return -1, -7.3e-4 and -1.5e-13 with a force, -1, -1.4e-3 and -1.5e-13 with a
    piston: theory does not know that its input is held over a control step; the last is the error of the shape's table.

    ## Version history
    * v1: the observation ends with a clock and the deadline terminates; `hold`; `randomise` draws a chain for each episode.
    * v0: first version.
    """
    chain, end, rest = make_driven_end(make_pulse_forming, locals(), internal_steps=3, deadline=180)
    heights, places = parse_numbers("amplitude", amplitude), parse_numbers("place", place)
    task = partial(PulseFormingTask, end=end, amplitudes=heights, places=places, window=window)
    return ComponentEnv(chain, task, **rest)
