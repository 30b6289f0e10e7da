"""BuriedTarget-v1: shape the loads on a surface to maximise the speed of a buried point at the deadline."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Unpack

import numpy as np

from granular_env.components.errors import ParameterError, one_line
from granular_env.components.grid import Grid
from granular_env.components.materials.elastic import Material
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.validation import finite_number, positive_number, whole_number
from granular_env.envs.environment import ComponentEnv
from granular_env.envs.factory import Options, environment_factory, refuse_early_deadline
from granular_env.envs.policies import Constant, OpenLoop, Policy
from granular_env.envs.task import Seen, Task

# The block: numbers of cells along x and y, size of a cell [m], and the rock.
_COLUMNS, _ROWS, _CELL = 60, 36, 5e-3
_ROCK = {"density": 2700.0, "young": 6e10, "poisson": 0.25}
# Distance of neighbouring loads in cells.
_SPACING = 4
# Number of directions of the target's velocity among which the fastest is searched.
_DIRECTIONS = 3600


class BuriedTargetTask(Task):
    """Maximise the speed of the last receiver at the deadline. See `make_buried_target`.

    Args:
        grid: grid with forced nodes; its last receiver is the target.
        force: force of each load at action 1 [N].
        internal_steps: internal steps in a control step.
        deadline: number of control steps of an episode.
        hold: number of control steps for which an action is held.
    """

    name = "buried_target"

    def __init__(self, grid: Grid, force: float, internal_steps: int, deadline: int, hold: int = 1) -> None:
        self.actions = {"force": positive_number("force", force)}
        steps = target_response(grid, internal_steps, deadline) * force
        self.response = np.add.reduceat(steps, np.arange(0, deadline, hold))
        self.drive, self.drive_gains = fastest_drive(self.response)
        self.best_speed = float(np.abs(self.drive_gains).sum())
        self.observations = {"receiver_velocity": self.best_speed}

    def begin_episode(self, component: Any, outputs: Seen) -> None:
        """Store the "energy" of the target at the start, see `_target_energy`."""
        self.counters = {"target_energy": self._target_energy(outputs)}

    def evaluate_step(self, component: Any, outputs: Seen, duration: float) -> tuple[float, bool]:
        """Return the increase of the target's "energy" in this step, see `_target_energy`."""
        before, self.counters["target_energy"] = self.counters["target_energy"], self._target_energy(outputs)
        return self.counters["target_energy"] - before, False

    def baselines(self) -> Mapping[str, Policy]:
        """Return "nothing", "one_push" (one push of each load, all meeting at the target) and "theory" (the best drive).

        "theory" is the time-reversed response of the target to each load; by reciprocity, this is the response of the loads
        to a source at the target.
        """
        pushes = np.zeros_like(self.drive)
        for entry, gains in enumerate(np.abs(self.drive_gains).T):
            row = int(np.argmax(gains))
            pushes[row, entry] = self.drive[row, entry]
        return {
            "nothing": Constant(np.zeros(self.drive.shape[1])),
            "one_push": OpenLoop(pushes),
            "theory": OpenLoop(self.drive),
        }

    def _target_energy(self, outputs: Seen) -> float:
        """Return the square of (the target's speed / the largest speed that is possible at the deadline)."""
        vx, vy = (float(number) for number in np.asarray(outputs["receiver_velocity"])[-1])
        return (vx * vx + vy * vy) / (self.best_speed * self.best_speed)


def target_response(grid: Grid, internal_steps: int, deadline: int) -> FloatArray:
    """Return the target's velocity at the deadline for a force of 1 N of each load along x or y, held for one control step.

    Shape (control steps of the force, 2 x loads: x and y of each, 2 velocity components) [m/s/N]. The grid is reset afterwards.
    """
    loads, duration = len(grid.get("force")), internal_steps * grid.step_size
    found = np.zeros((deadline, 2 * loads, 2))
    for entry in range(2 * loads):
        grid.reset()
        force = np.zeros((loads, 2))
        force[entry // 2, entry % 2] = 1.0
        for late in range(deadline):
            grid.step(duration, force=force if late == 0 else 0.0)
            # This velocity, `late` + 1 control steps after the start of the force, is that at the deadline for a later start.
            found[deadline - 1 - late, entry] = grid.get("receiver_velocity")[-1]
    grid.reset()
    return found


def fastest_drive(response: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the drive (-1 to 1) with the largest target speed at the deadline, and the speed that each entry adds [m/s].

    The velocity along a direction e is the sum over all entries of drive x (response . e). The best drive for e therefore has
    the sign of response . e, and the speed is the sum of the magnitudes. Both results have the shape (actions, 2 x loads).

    Args:
        response: result of `target_response` times the force at action 1.
    """
    angles = np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    along = np.cos(angles) * response[..., 0, None] + np.sin(angles) * response[..., 1, None]
    speeds = np.abs(along).sum(axis=(0, 1))
    best = int(np.argmax(speeds))
    return np.sign(along[..., best]), along[..., best]


@environment_factory
def make_buried_target(
    *,
    loads: int = 8,
    force: float = 1e4,
    target: Sequence[float] = (0.04, -0.1),
    **options: Unpack[Options],
) -> ComponentEnv:
    """Shape the loads on the surface of a block of rock so that a buried target moves as fast as possible at the deadline.

    The block of granite is 0.3 m wide and 0.18 m deep; its sides and bottom absorb waves. The loads form a row on the
    surface, 20 mm apart, centred at x = 0. Waves need some 20 us (P) or 34 us (S) to the target, so the last steps have no
    effect.

    ## Action space
    The force along x and along y of each load, on a slab one metre thick.

    ## Observation space
    The velocity (x, y) under each load, then that of the target, in units of the largest velocity of the target that is
    possible at the deadline. Counter: "target_energy".

    ## Rewards
    The increase of the squared velocity of the target in the step, in units of the largest that is possible at the
    deadline. The return is therefore the kinetic energy of the target at the deadline, at most 1.

    ## Start state
    Everything at rest.

    ## End of the episode
    Terminated at the deadline.

    ## Arguments
    * `loads` (8), `force` (1e4 N): number of loads, and force of each at action 1.
    * `target` ((0.04, -0.1) m): x and y of the target; y is negative below the surface.
    * `clock` (2): number of time readings in the observation.

    ## Baselines
    "theory" is the time-reversed response of the target to each load. The medium is linear, so the best drive is 1 or -1
    everywhere, with the sign of the response; it returns 1.000. "one_push" pushes each load once, timed so that the waves
    meet at the target; it returns 0.02.
    """
    loads = whole_number("loads", loads)
    if loads > (_COLUMNS - 2) // _SPACING:
        raise ParameterError(
            f"got {loads}", expected=f"at most {(_COLUMNS - 2) // _SPACING} loads, {_SPACING} cells apart", at="loads"
        )
    place = [finite_number(f"target[{axis}]", number) for axis, number in enumerate(_parse_pair(target))]
    if not (abs(place[0]) <= 0.5 * _COLUMNS * _CELL and -_ROWS * _CELL <= place[1] < 0.0):
        raise ParameterError(
            f"got {place}", expected="a point inside the block: |x| at most 0.15 m, y from -0.18 m to below 0", at="target"
        )
    settings: dict[str, Any] = {"internal_steps": 4, "deadline": 24, "hold": 1, "clock": 2, **options}
    internal_steps, deadline, hold = (whole_number(name, settings[name]) for name in ("internal_steps", "deadline", "hold"))
    places = [[_SPACING * _CELL * (number - 0.5 * (loads - 1)), 0.0] for number in range(loads)]
    middle = [0.0, -0.5 * _ROWS * _CELL]
    grid = Grid(
        mesh={"name": "rectangle", "columns": _COLUMNS, "rows": _ROWS, "cell_size": _CELL, "centre": middle},
        material=_ROCK, boundaries=dict.fromkeys(("left", "right", "bottom"), "absorbing"), forced_nodes=places,
        receivers=[*places, place],
    )  # fmt: skip
    way = min(math.dist(place, load) for load in places)
    duration = internal_steps * grid.step_size
    arrival = way / Material(**_ROCK).longitudinal_speed
    why = f"a P wave takes {arrival:.3g} s from the nearest load to the target"
    refuse_early_deadline(deadline, math.ceil(arrival / duration), duration, why)
    task = BuriedTargetTask(grid, force, internal_steps, deadline, hold)
    return ComponentEnv(grid, task, **settings)


def _parse_pair(value: Any) -> list[Any]:
    """Return the two entries of a pair; `ParameterError` for any other length."""
    entries = list(value) if isinstance(value, (list, tuple, np.ndarray)) else []
    if len(entries) != 2:
        raise ParameterError(f"got {one_line(value)}", expected="two numbers, x and y", at="target")
    return entries
