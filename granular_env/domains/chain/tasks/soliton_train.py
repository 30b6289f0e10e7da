"""SolitonTrain-v1: form solitary waves whose number, amplitudes and places are sampled for each episode."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, Unpack

import numpy as np
from numpy.random import Generator

from granular_env.components.chain import Chain
from granular_env.components.chain.objective import Objective
from granular_env.components.errors import ParameterError, one_line
from granular_env.components.support.elementary_functions import root
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.validation import positive_number, whole_number
from granular_env.envs.environment import ComponentEnv
from granular_env.envs.factory import environment_factory
from granular_env.envs.policies import Constant, Policy

from .driven_end import DrivenEnd, DrivenOptions, action_means, hertz_constants, make_driven_end, parse_range
from .pulse_forming import WaveTarget, WaveTask
from .waves import (
    AMPLITUDE,
    COLUMNS,
    PLACE,
    SPEED,
    distance_objective,
    half_width,
    refuse_crowded_waves,
    refuse_early_waves,
    shape_energies,
    wave_shapes,
)  # fmt: skip

Limits = tuple[float, float]


class SolitonTrainTask(WaveTask):
    """Produce a train of solitary waves, sampled for each episode, by the deadline. See `make_soliton_train`.

    Args:
        chain: the driven chain; Hertz contacts, no precompression.
        end: the driven left end.
        waves: largest number of waves.
        amplitude: range of their heights [m/s].
        spacing: range of the distances between neighbours [grains].
        front: range of the grain at which the foremost wave shall be at the deadline.
        window: half width of a wave [grains].
    """

    name = "soliton_train"

    def __init__(
        self, chain: Chain, end: DrivenEnd, waves: int, amplitude: Limits, spacing: Limits, front: Limits, window: float
    ) -> None:
        super().__init__(chain, end)
        self.waves, self.amplitude, self.spacing, self.front = waves, amplitude, spacing, front
        mass, stiffness, rest = hertz_constants(self.name, chain)
        if rest > 0.0:
            came = "waves of different heights share one shape only without precompression"
            raise ParameterError(came, hint="use PulseForming-v1", at="precompression")
        shapes, speeds = wave_shapes(mass, stiffness, 0.0, np.ones(1))
        self.speed = float(speeds[0])
        names = [f"{what}_{w + 1}" for w in range(waves) for what in ("amplitude", "place", "speed")]
        self.counter_names = (*names, "distance", "energy_outside", "amplitude_error")
        self.goal_scales = (self.observations["velocity"], float(self.grains), self.speed) * waves
        unit, horizon = float(shape_energies(shapes, np.ones(1))[0]), end.duration * end.steps
        self.constants = WaveTarget(horizon, end.duration, unit, positive_number("window", window), np.zeros(0), shapes)
        least = 2.0 * half_width(shapes, 0)
        if waves > 1 and spacing[0] < least:
            hint = "waves at smaller distances overlap"
            raise ParameterError(f"got {spacing}", expected=f"{least:g} grains or more", hint=hint, at="spacing")
        for place in (front[0] - (waves - 1) * spacing[1], front[1]):
            refuse_crowded_waves(shapes, np.array([[amplitude[0], place, 0.0]]), self.grains, "front")
        slowest = self._goal_rows(np.array([[amplitude[0], front[1]]]))
        refuse_early_waves(shapes, slowest.reshape(-1, COLUMNS), end.duration, end.steps)

    def goals(self, constants: Any, counters: dict[str, Any]) -> tuple[FloatArray, FloatArray]:
        """Return the goal of each episode, and the energy of its waves [J] (of a wave of 1 m/s if the goal is empty)."""
        goals = np.stack([counters[name] for name in self.counter_names[: COLUMNS * self.waves]], axis=-1)
        squares = np.sum(goals[..., AMPLITUDE::COLUMNS] ** 2, axis=-1)
        return goals, constants.unit * np.where(squares > 0.0, squares, 1.0)

    def present_goal(self) -> FloatArray:
        """Return the rows (amplitude, place, speed) of the present goal, shape (waves, 3)."""
        return np.array([self.counters[name] for name in self.goal_names]).reshape(-1, COLUMNS)

    def sample_goal(self, random: Generator) -> FloatArray:
        """Return a goal of 1 to `waves` waves, foremost first; amplitudes, distances, first place are uniform samples."""
        count = int(random.integers(1, self.waves + 1))
        heights = random.uniform(*self.amplitude, self.waves)[:count]
        gaps = random.uniform(*self.spacing, self.waves)[: count - 1]
        places = float(random.uniform(*self.front)) - np.concatenate([[0.0], np.cumsum(gaps)])
        return self._goal_rows(np.column_stack([heights, places]))

    def parse_goal(self, given: Any) -> FloatArray:
        """Return a goal from rows (amplitude [m/s], place), foremost first; `ParameterError` if they are invalid."""
        try:
            rows = np.atleast_2d(np.asarray(given, dtype=np.float64))
        except (TypeError, ValueError):
            rows = np.zeros((0, 0))
        if rows.ndim != 2 or rows.shape[1] != 2 or not 1 <= len(rows) <= self.waves or not np.all(np.isfinite(rows)):
            expected = f"1 to {self.waves} rows (amplitude, place)"
            raise ParameterError(f"got {one_line(given)}", expected=expected, at="options.goal")
        if np.any(rows[:, 0] <= 0.0) or np.any((rows[:, 1] < 0.0) | (rows[:, 1] > self.grains - 1)):
            expected = f"amplitudes above 0 m/s and places from 0 to {self.grains - 1}"
            raise ParameterError(f"got {rows.tolist()}", expected=expected, at="options.goal")
        goal = self._goal_rows(rows)
        refuse_crowded_waves(self.constants.shapes, goal.reshape(-1, COLUMNS), self.grains, "options.goal")
        refuse_early_waves(self.constants.shapes, goal.reshape(-1, COLUMNS), self.end.duration, self.end.steps, "options.goal")
        return goal

    def _goal_rows(self, rows: FloatArray) -> FloatArray:
        goal = np.zeros((self.waves, COLUMNS))
        goal[: len(rows), [AMPLITUDE, PLACE]] = rows
        goal[: len(rows), SPEED] = self.speed * root(rows[:, 0], 5)
        return goal.reshape(-1)

    def objective(self, component: Chain, steps: int, *, goal: FloatArray | None = None) -> Objective:
        """Return the distance from the requested waves after the last control step, which is minus the return.

        Args:
            component: the driven chain.
            steps: number of control steps.
            goal: the requested waves, as returned by `sample_goal` or `parse_goal`; default: the goal of seed 0.
        """
        demanded = self.sample_goal(np.random.default_rng(0)) if goal is None else goal
        squares = float(np.sum(demanded[AMPLITUDE::COLUMNS] ** 2))
        energy = self.constants.unit * (squares if squares > 0.0 else 1.0)
        return distance_objective(demanded, self.constants.shapes, energy, self.end.duration)

    def baselines(self) -> Mapping[str, Policy]:
        """Return "nothing", and "theory": the drive with which the requested waves would enter at the left end."""
        return {"nothing": Constant(0.0), "theory": PassingTrain(self)}


class PassingTrain:
    """Policy "theory": the drive with which the goal's waves would enter at the left end; the goal is read from ``info``.

    Args:
        task: the task, which computes the drive.
    """

    def __init__(self, task: SolitonTrainTask) -> None:
        self.task = task
        self.reset()

    def reset(self) -> None:
        """Forget the goal of the last episode."""
        self.step, self.drive = 0, np.zeros(0)

    def __call__(self, observation: Any, info: Mapping[str, Any]) -> FloatArray:
        """Return the action of the next control step."""
        if self.step == 0:
            names = self.task.counter_names[: COLUMNS * self.task.waves]
            goal = np.array([info[name] for name in names]).reshape(-1, COLUMNS)
            drive = self.task.passing_waves(goal)
            self.drive = action_means(drive, self.task.hold) / next(iter(self.task.actions.values()))
        self.step += 1
        return np.array([self.drive[self.step - 1]])


@environment_factory
def make_soliton_train(
    grains: int = 64,
    *,
    waves: int = 3,
    amplitude: Limits = (3.0, 6.0),
    spacing: Limits = (11.0, 14.0),
    front: Limits = (36.0, 40.0),
    window: float = 5.0,
    **options: Unpack[DrivenOptions],
) -> ComponentEnv:
    """Drive the left end so that the chain carries the requested solitary waves at the deadline.

    This is `PulseForming-v1` with a goal: number, heights and positions of the waves are sampled for each episode and
    observed.

    ## Observation space
    The goal precedes the clock, without noise. For each wave, the foremost first, it contains the height, the position of
    the crest at the deadline, and the speed; zeros mean that a wave is not requested. Counters: the goal
    ("amplitude_1" [m/s], "place_1", "speed_1" [grains/s] and so on) and those of `PulseForming-v1`.

    ## Rewards
    As in `PulseForming-v1`.

    ## Start state
    All grains at rest and in contact. The goal is sampled uniformly: 1 to `waves` waves, heights from `amplitude`, the
    position of the foremost from `front`, distances between neighbours from `spacing`.
    `reset(options={"goal": [[5.0, 40.0], [3.0, 20.0]]})` requests these (amplitude, place) instead.

    ## Arguments
    * `waves` (3): largest number of waves. `amplitude` ((3.0, 6.0) m/s), `spacing` ((11.0, 14.0) grains), `front` ((36.0,
      40.0) grains): see the start state. `window` (5.0 grains): half width of a wave. `chain`: without precompression.

    ## Baselines
    "theory" is that of `PulseForming-v1`, for the requested waves. Over seeds 0 to 59 it returns -1.4e-4 to -7.8e-4 with a
    force, -3.4e-4 to -1.45e-3 with a piston. One fixed drive cannot serve every goal; the gradient of `objective` reaches
    -1e-9 or better for each.
    """
    chain, end, rest = make_driven_end(make_soliton_train, locals(), internal_steps=3, deadline=200)
    count, gaps, first = whole_number("waves", waves, 1, 16), parse_range("spacing", spacing), parse_range("front", front)
    last = chain.parameters.grains - 1
    if first[0] - (count - 1) * gaps[1] < 0.0 or first[1] > last:
        expected = f"places up to {last} that leave space for {count} waves at distances of up to {gaps[1]:g} grains"
        raise ParameterError(f"got {one_line(front)}", expected=expected, at="front")
    heights = parse_range("amplitude", amplitude)
    task = partial(SolitonTrainTask, end=end, waves=count, amplitude=heights, spacing=gaps, front=first, window=window)
    return ComponentEnv(chain, task, **rest)
