"""SolitonTrain-v1: solitary waves on demand, whose number, heights and places are drawn for each episode and told."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Unpack

import numpy as np
from numpy.random import Generator

from granular_env.components.chain import Chain
from granular_env.components.chain.objective import Objective
from granular_env.components.errors import ParameterError, one_line
from granular_env.components.support.elementary_functions import root
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.jit import jit
from granular_env.components.support.validation import positive_number, whole_number
from granular_env.envs.environment import environment_factory
from granular_env.envs.policies import Constant, Policy

from ..envs.environment import ChainEnv, ChainOptions
from .analytic_drives import passing_waves, wave_velocities
from .arguments import between
from .baselines import hold_mean
from .driven_end import DrivenEnd, DrivenEndTask, driven_end, hertz_chain, sum_value
from .feasibility import half_width, refuse_crowded, refuse_early_waves
from .target_waves import (
    AMPLITUDE,
    COLUMNS,
    PLACE,
    distance,
    distance_pullback,
    follow,
    shape_energies,
    wave_shapes,
)

# Layout of the constants: time from the start to the deadline [s], energy of a wave of 1 m/s [J], half width of what counts as
# a wave [grains], number of rows of a goal, then the shapes. The objective's has its goal before the shapes.
_HORIZON, _ENERGY, _WINDOW, _WAVES, _SHAPES = range(5)


@jit
def _energy(goal, waves, one):
    """Energy of the waves of a goal; that of one where none is wanted."""
    total = 0.0
    for w in range(waves):
        total += goal[COLUMNS * w + AMPLITUDE] * goal[COLUMNS * w + AMPLITUDE]
    return one * total if total > 0.0 else one


@jit
def _follow(a, counters, constants, left):
    waves = int(constants[_WAVES])
    energy, kept = _energy(counters, waves, constants[_ENERGY]), counters[COLUMNS * waves :]
    return follow(a, constants[_SHAPES:], counters, waves, left, constants[_WINDOW], energy, kept)


@jit
def _begin(a, counters, constants):
    _follow(a, counters, constants, constants[_HORIZON])


@jit
def _judge(a, inputs, counters, constants, duration, elapsed, steps):
    return _follow(a, counters, constants, constants[_HORIZON] - elapsed * duration), False


@jit
def _note(a, step, steps, inputs, constants, sums):
    if step == steps - 1:
        waves, goal = int(constants[_WAVES]), constants[_SHAPES:]
        energy = _energy(goal, waves, constants[_ENERGY])
        sums[0] += distance(a, goal[COLUMNS * waves :], goal, waves, 0.0) / energy


@jit
def _pullback(a, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
    if step == steps - 1:
        waves, goal = int(constants[_WAVES]), constants[_SHAPES:]
        energy = _energy(goal, waves, constants[_ENERGY])
        distance_pullback(a, adjoint, goal[COLUMNS * waves :], goal, waves, 0.0, slopes[0] / energy)


class SolitonTrainTask(DrivenEndTask):
    """A train of solitary waves, drawn for each episode, shall stand in the chain at the deadline. See `make_soliton_train`.

    Args:
        chain: what is driven; Hertz contacts, no precompression.
        end: its left end.
        waves: largest number of waves.
        amplitude: limits of their heights [m/s].
        spacing: limits of the distance of neighbours [grains].
        front: limits of the foremost wave's place.
        window: half width of what counts as a wave [grains].
    """

    name = "soliton_train"
    begin_kernel = staticmethod(_begin)
    judge_kernel = staticmethod(_judge)

    def __init__(
        self,
        chain: Chain,
        end: DrivenEnd,
        waves: int,
        amplitude: tuple[float, float],
        spacing: tuple[float, float],
        front: tuple[float, float],
        window: float,
    ) -> None:
        super().__init__(chain, end)
        self.waves, self.amplitude, self.spacing, self.front = waves, amplitude, spacing, front
        mass, stiffness, rest = hertz_chain(self.name, chain)
        if rest > 0.0:
            raise ParameterError(
                "waves of many heights have one shape only in a chain without it",
                hint="take PulseForming-v1",
                at="precompression",
            )
        self.shapes, speeds = wave_shapes(mass, stiffness, 0.0, np.ones(1))
        self.speed = float(speeds[0])
        names = [f"{what}_{w + 1}" for w in range(waves) for what in ("amplitude", "place", "speed")]
        self.counter_names = (*names, "distance", "energy_outside", "amplitude_error")
        self.goal_scales = (self.observations["velocity"], float(self.grains), float(speeds[0])) * waves
        unit = float(shape_energies(self.shapes, np.ones(1))[0])
        head = [end.duration * end.steps, unit, positive_number("window", window), float(waves)]
        self.head, self.constants = head, np.concatenate([head, self.shapes])
        slowest, farthest = amplitude[0], front[1]
        if waves > 1 and spacing[0] < 2.0 * half_width(self.shapes, 0):
            least = 2.0 * half_width(self.shapes, 0)
            raise ParameterError(
                f"got {spacing}", expected=f"{least:g} grains or more", hint="nearer waves lie over each other", at="spacing"
            )
        for place in (front[0] - (waves - 1) * spacing[1], front[1]):
            refuse_crowded(self.shapes, np.array([[slowest, place, 0.0]]), self.grains, "front")
        refuse_early_waves(self.shapes, self._rows(np.array([[slowest, farthest]]))[None, :COLUMNS], end.duration, end.steps)

    def goal(self, random: Generator) -> FloatArray:
        """One to `waves` waves, foremost first: heights, the foremost one's place, distances, each drawn evenly."""
        count = int(random.integers(1, self.waves + 1))
        heights = random.uniform(*self.amplitude, self.waves)[:count]
        gaps = random.uniform(*self.spacing, self.waves)[: count - 1]
        places = float(random.uniform(*self.front)) - np.concatenate([[0.0], np.cumsum(gaps)])
        return self._rows(np.column_stack([heights, places]))

    def given_goal(self, given: Any) -> FloatArray:
        """Rows (amplitude [m/s], place), foremost first, as many as there may be waves or fewer.

        Raises:
            ParameterError: these are none.
        """
        try:
            rows = np.atleast_2d(np.asarray(given, dtype=np.float64))
        except (TypeError, ValueError):
            rows = np.zeros((0, 0))
        if rows.ndim != 2 or rows.shape[1] != 2 or not 1 <= len(rows) <= self.waves or not np.all(np.isfinite(rows)):
            raise ParameterError(
                f"got {one_line(given)}", expected=f"1 to {self.waves} rows (amplitude, place)", at="options.goal"
            )
        if np.any(rows[:, 0] <= 0.0) or np.any((rows[:, 1] < 0.0) | (rows[:, 1] > self.grains - 1)):
            raise ParameterError(
                f"got {rows.tolist()}",
                expected=f"amplitudes above 0 m/s and places from 0 to {self.grains - 1}",
                at="options.goal",
            )
        goal = self._rows(rows)
        refuse_crowded(self.shapes, goal.reshape(-1, COLUMNS), self.grains, "options.goal")
        refuse_early_waves(self.shapes, goal.reshape(-1, COLUMNS), self.duration, self.steps, "options.goal")
        return goal

    def _rows(self, rows: FloatArray) -> FloatArray:
        goal = np.zeros((self.waves, COLUMNS))
        goal[: len(rows), [AMPLITUDE, PLACE]] = rows
        goal[: len(rows), 2] = self.speed * root(rows[:, 0], 5)
        return goal.reshape(-1)

    def objective(self, chain: Chain, steps: int, *, goal: FloatArray | None = None) -> Objective:
        """Return the distance at the end of the last control step to the demanded waves: minus the return.

        Args:
            chain: what is driven.
            steps: control steps.
            goal: the demanded waves, as `goal` and `given_goal` make them; default: those of seed 0.
        """
        demanded = self.goal(np.random.default_rng(0)) if goal is None else goal
        text = "square of the distance to the demanded waves at the end, in the energy norm, over their energy"
        return Objective(_note, sum_value, _pullback, np.concatenate([self.head, demanded, self.shapes]), description=text)

    def wanted_velocity(self, elapsed: int, counters: FloatArray) -> FloatArray:
        """Return that of the demanded waves on their way."""
        goal = counters[: COLUMNS * self.waves].reshape(-1, COLUMNS)
        return wave_velocities(self.shapes, goal, self.duration * (self.steps - elapsed), self.grains)

    def baselines(self) -> Mapping[str, Policy]:
        """Doing nothing, and what the demanded waves would do to the left end as they pass."""
        return {"nothing": Constant(0.0), "theory": PassingTrain(self)}


class PassingTrain:
    """The motion that missing grains would give the left end while the demanded waves pass: read from ``info``, then open-loop.

    Args:
        task: whose demand is served.
    """

    def __init__(self, task: SolitonTrainTask) -> None:
        self.task = task
        self.reset()

    def reset(self) -> None:
        """Forget the last demand: the next one is read."""
        self.step, self.drive = 0, np.zeros(0)

    def __call__(self, observation: Any, info: Mapping[str, Any]) -> FloatArray:
        """Return the next row of the drive."""
        task, (name, scale) = self.task, next(iter(self.task.actions.items()))
        if self.step == 0:
            numbers = [info[one] for one in task.counter_names[: COLUMNS * task.waves]]
            goal = np.array(numbers).reshape(-1, COLUMNS)
            horizon = task.duration * task.steps
            drive = passing_waves(task.shapes, goal, horizon, task.duration, task.steps, name)
            self.drive = hold_mean(drive, task.hold) / scale
        self.step += 1
        return np.array([self.drive[self.step - 1]])


@environment_factory
def make_soliton_train(
    grains: int = 64,
    radius: Any = None,
    material: Any = None,
    *,
    action: str = "force",
    action_scale: float | None = None,
    waves: int = 3,
    amplitude: tuple[float, float] = (3.0, 6.0),
    spacing: tuple[float, float] = (11.0, 14.0),
    front: tuple[float, float] = (36.0, 40.0),
    window: float = 5.0,
    step_size: float = 5e-7,
    chain: dict[str, Any] | None = None,
    **options: Unpack[ChainOptions],
) -> ChainEnv:
    """Drive the left end so that at the deadline the solitary waves that were asked for stand in the chain.

    `PulseForming-v1` on demand: how many waves, how high and where, is drawn for each episode, and the agent is told.

    ## Action space
    `Box(-1, 1, (1,), float32)`: what is held over the next control step, in units of `action_scale`; clipped. `action="force"`:
    the force on the first grain, positive to the right; pulling moves the first grain alone. `action="piston"`: the velocity of
    the first grain.

    ## Observation space
    `Box((2 grains + 3 waves + clock,), float32)`: the displacement of every grain, in mm, then the velocity of every grain, in
    units of 10 m/s (`observe` chooses sensors instead), then the goal, without noise: of each wave, foremost first, its height
    in units of 10 m/s, the place of its crest at the deadline over the number of grains, and its speed in units of that of a
    wave of 1 m/s; zeros for waves that are not asked for; all clipped to +-10. Last comes the clock, cos(pi k t / T) with k = 1
    to `clock` and T the time of the deadline, in [-1, 1]. `info` has "time" [s], the input, the goal as "amplitude_1" [m/s],
    "place_1", "speed_1" [grains/s] and so on, and the counters "distance", "energy_outside" and "amplitude_error" of
    `PulseForming-v1`.

    ## Rewards
    As in `PulseForming-v1`: the return is minus the square of the distance to the demanded waves at the deadline, in the energy
    norm, over their energy. In a chain of equal grains doing nothing returns -1, and 0 is perfect. In a dimer or a tapered
    chain the demanded waves are none of that chain: neither number holds, nor does the baseline of theory.

    ## Start state
    Everything at rest, all grains in touch. The goal is drawn: 1 to `waves` waves, heights from `amplitude`, the foremost one's
    place from `front`, distances of neighbours from `spacing`, all evenly. `reset(options={"goal": [[5.0, 40.0], [3.0,
    20.0]]})` asks for these (amplitude, place), clear of each other and of the chain's ends; other options give start values,
    as `Component.reset` takes them.

    ## End of the episode
    Terminated after `deadline` control steps, at which the waves are due; the agent sees the time. With `clock=0` it does not,
    and the episode is truncated.

    ## Arguments
    * `grains` (64), `radius` (3e-3 m), `material` ("steel"): the chain, its right end free.
    * `action` ("force"): "force" or "piston". `action_scale` (None): 1000 N or 10 m/s.
    * `waves` (3): the largest number. `amplitude` ((3.0, 6.0) m/s), `spacing` ((11.0, 14.0) grains), `front` ((36.0, 40.0)).
    * `window` (5.0 grains): half width of what counts as a wave.
    * `step_size` (5e-7 s): internal step. `internal_steps` (3) make a control step, `deadline` (200) control steps an episode
      of 300 us. A deadline that the slowest wave cannot meet is refused.
    * `clock` (8): readings of the clock.
    * `chain`: further parameters of the chain component; Hertz contacts, no precompression.

    ## Baselines
    `env.unwrapped.task.baselines()`: "nothing"; "theory", what the missing grains would do to the first one while the demanded
    waves pass, averaged over each control step. They return -1, and (seeds 0 to 59) -1.4e-4 to -7.8e-4 with a force,
    -3.4e-4 to -1.45e-3 with a piston. A drive for one demand is no policy for all of them:
    "best" is missing; the gradient of `objective` finds it for each goal (-1e-9 or better).

    ## Version history
    * v1: the observation ends with a clock and the deadline terminates; `hold`; `randomise` draws a chain for each episode.
    * v0: first version.
    """
    end = driven_end(make_soliton_train, locals(), "left", internal_steps=3, deadline=200)
    count, gaps, first = whole_number("waves", waves, 1, 16), between("spacing", spacing), between("front", front)
    last = end.chain.parameters.grains - 1
    if first[0] - (count - 1) * gaps[1] < 0.0 or first[1] > last:
        raise ParameterError(
            f"got {one_line(front)}",
            expected=f"places up to {last} that leave room for {count} waves with up to {gaps[1]:g} grains between them",
            at="front",
        )
    heights = between("amplitude", amplitude)
    return end.environment(lambda chain: SolitonTrainTask(chain, end, count, heights, gaps, first, window))
