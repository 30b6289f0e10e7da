"""PulseForming-v1: at the deadline a wanted set of solitary waves stands in the chain, and nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Unpack

import numpy as np

from granular_env.components.chain import Chain
from granular_env.components.chain.objective import Objective
from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.jit import jit
from granular_env.components.support.validation import positive_number
from granular_env.envs.environment import environment_factory
from granular_env.envs.policies import Policy

from ..envs.environment import ChainEnv, ChainOptions
from .analytic_drives import passing_waves, wave_velocities
from .arguments import numbers
from .baselines import open_loops
from .driven_end import DrivenEnd, DrivenEndTask, driven_end, hertz_chain, sum_value
from .feasibility import refuse_crowded, refuse_early_waves
from .target_waves import COLUMNS, distance, distance_pullback, follow, shape_energies, wave_shapes

# Layout of the constants: time from the start to the deadline [s], energy of the wanted waves [J], half width of what counts
# as a wave [grains], number of waves, length of a control step [s], the objective's weight of the way there, then the goal's
# rows and the shapes.
_HORIZON, _ENERGY, _WINDOW, _WAVES, _DURATION, _WAY, _GOAL = range(7)


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
def _weight(step, steps, constants):
    """Return the weight of the distance after a control step: that of the last one, or one for all of them."""
    way = constants[_WAY]
    return way / steps + (1.0 - way if step == steps - 1 else 0.0)


@jit
def _note(a, step, steps, inputs, constants, sums):
    weight = _weight(step, steps, constants)
    if weight > 0.0:
        waves, left = int(constants[_WAVES]), (steps - 1 - step) * constants[_DURATION]
        shapes = constants[_GOAL + COLUMNS * waves :]
        sums[0] += weight * distance(a, shapes, constants[_GOAL:], waves, left) / constants[_ENERGY]


@jit
def _pullback(a, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
    weight = _weight(step, steps, constants)
    if weight > 0.0:
        waves, left = int(constants[_WAVES]), (steps - 1 - step) * constants[_DURATION]
        shapes = constants[_GOAL + COLUMNS * waves :]
        distance_pullback(a, adjoint, shapes, constants[_GOAL:], waves, left, slopes[0] * weight / constants[_ENERGY])


class PulseFormingTask(DrivenEndTask):
    """Wanted solitary waves shall stand in the chain at the deadline. See `make_pulse_forming`.

    Args:
        chain: what is driven; Hertz contacts.
        end: its left end.
        amplitudes: largest grain velocity of each wave, shape (waves,) [m/s].
        places: grain at which each wave's crest shall be at the deadline, 0 is the first, shape (waves,).
        window: half width of what counts as a wave [grains].
    """

    name = "pulse_forming"
    counter_names = ("distance", "energy_outside", "amplitude_error")
    begin_kernel = staticmethod(_begin)
    judge_kernel = staticmethod(_judge)

    def __init__(self, chain: Chain, end: DrivenEnd, amplitudes: FloatArray, places: FloatArray, window: float) -> None:
        super().__init__(chain, end)
        grains, (mass, stiffness, rest) = self.grains, hertz_chain(self.name, chain)
        if np.any(amplitudes <= 0.0):
            raise ParameterError(f"got {amplitudes.tolist()} m/s", expected="more than 0", at="amplitude")
        if len(amplitudes) != len(places) or not np.all((places >= 0.0) & (places <= grains - 1)):
            raise ParameterError(
                f"got {places.tolist()}",
                expected=f"grains from 0 to {grains - 1}, one for each of {len(amplitudes)} waves",
                at="place",
            )
        self.shapes, speeds = wave_shapes(mass, stiffness, rest, amplitudes)
        self.waves = np.column_stack([amplitudes, places, speeds])
        self.energy = float(shape_energies(self.shapes, amplitudes).sum())
        refuse_crowded(self.shapes, self.waves, grains)
        refuse_early_waves(self.shapes, self.waves, end.duration, end.steps)
        horizon, width = end.duration * end.steps, positive_number("window", window)
        head = [horizon, self.energy, width, float(len(self.waves)), end.duration, 0.0]
        self.constants = np.concatenate([head, self.waves.reshape(-1), self.shapes])

    def objective(self, chain: Chain, steps: int, *, way: float = 0.0) -> Objective:
        """Return the distance at the end of the last control step: minus the return, if nothing is in the chain at the start.

        Args:
            chain: what is driven.
            steps: control steps.
            way: from 0 to 1, weight of the mean distance over all control steps to the waves on their way: it has a slope far
                from any solution, where a wave in a wrong place has none.
        """
        text = "square of the distance to the wanted waves at the end, in the energy norm, over their energy"
        constants = self.constants.copy()
        constants[_WAY] = way
        return Objective(_note, sum_value, _pullback, constants, description=text)

    def wanted_velocity(self, elapsed: int, counters: FloatArray) -> FloatArray:
        """Return that of the wanted waves on their way."""
        return wave_velocities(self.shapes, self.waves, self.duration * (self.steps - elapsed), self.grains)

    def baselines(self) -> Mapping[str, Policy]:
        """Return what passing waves would do to the left end, and the best known drive."""
        drive = passing_waves(
            self.shapes, self.waves, self.duration * self.steps, self.duration, self.steps, next(iter(self.actions))
        )
        return open_loops(self, "granular_env/PulseForming-v1", drive)


@environment_factory
def make_pulse_forming(
    grains: int = 64,
    radius: Any = None,
    material: Any = None,
    *,
    action: str = "force",
    action_scale: float | None = None,
    amplitude: Any = 5.0,
    place: Any = 40.0,
    window: float = 5.0,
    step_size: float = 5e-7,
    chain: dict[str, Any] | None = None,
    **options: Unpack[ChainOptions],
) -> ChainEnv:
    """Drive the left end so that at the deadline given solitary waves stand in the chain, and nothing else moves.

    A row of equal elastic spheres in touch carries solitary waves: pulses some five grains long whose speed grows with the
    fifth root of their height (Nesterenko 1983). A push of the left end becomes one or several of them, with small ones behind
    and grains that rebound. Wanted is their number, height, place and shape at one instant.

    ## Action space
    `Box(-1, 1, (1,), float32)`: what is held over the next control step, in units of `action_scale`; clipped. `action="force"`:
    the force on the first grain, positive to the right; pulling moves the first grain alone. `action="piston"`: the velocity of
    the first grain.

    ## Observation space
    `Box((2 grains + clock,), float32)`: displacement and velocity of every grain, in units of 1 mm and 10 m/s, then the clock.
    `info` has "time" [s], the input, and the counters "distance" (D below), "energy_outside" (energy further than `window`
    grains from every wanted crest, over the energy put in) and "amplitude_error" (relative error of the fastest grain about
    each crest, the largest over the waves).

    ## Rewards
    The distance of a state from the wanted waves is that of the energy norm, D = (sum_i m_i (v_i - v*_i)^2 / 2 + sum_j (q_j -
    q*_j)^2) / E*, with q = sqrt(0.4 k) d^1.25, the root of the energy stored in a contact of overlap d (above that at rest,
    where the chain is precompressed), * for the exact solitary waves of the lattice, E* their energy. In a disordered chain
    they are those of its mean grain. Before the deadline the wanted waves are on their way: each crest is behind its place by
    its speed times the time left, and what has not come into the chain yet is not wanted. A step's reward is D before it less D
    after it. So the return is -D at the deadline. In a chain of equal grains doing nothing returns -1, and 0 is perfect. In a
    dimer or a tapered chain the wanted wave is none of that chain: neither number holds, nor does the baseline of theory (a
    dimer of 3 and 1.5 mm: doing nothing -1.286, theory -1.955).

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
    waves pass, F = d(sum_i m v*_i)/dt or v*_0, averaged over each control step; "best", the best drive known, where these
    arguments have one. They return -1, -7.3e-4 and -1.5e-13 with a force, -1, -1.4e-3 and -1.5e-13 with a
    piston: theory does not know that its input is held over a control step; the last is the error of the shape's table.

    ## Version history
    * v1: the observation ends with a clock and the deadline terminates; `hold`; `randomise` draws a chain for each episode.
    * v0: first version.
    """
    end = driven_end(make_pulse_forming, locals(), "left", internal_steps=3, deadline=180)
    heights, places = numbers("amplitude", amplitude), numbers("place", place)
    return end.environment(lambda chain: PulseFormingTask(chain, end, heights, places, window))
