"""Confinement-v3: hold a brittle specimen that is compressed together by as little pressure on its sides as is needed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt
from numpy.random import Generator

from granular_env.components.automata import Automata
from granular_env.components.automata.theory import confining_pressure
from granular_env.components.component import Component
from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.validation import finite_number, positive_number, whole_number
from granular_env.envs.environment import ComponentEnv
from granular_env.envs.factory import Options, environment_factory
from granular_env.envs.policies import Constant, OpenLoop, Policy
from granular_env.envs.task import Seen, Task

# The specimen: hexagonal packing, 22 row distances high; its lowest and highest rows are held.
_DIAMETER, _WIDTH, _ROWS = 2e-3, 0.02, 22
_ROCK = {"density": 2600.0, "young": 5e10, "poisson": 0.25}
_CRITERION = {"name": "mohr_coulomb", "cohesion": 1.5e7, "internal_friction": 0.4, "tensile": 1e7}
# Depth of the held ends in row distances: two rows are held.
_GRIP = 1.04
# Best known pressures for the default arguments, in units of `pressure`, at evenly spaced instants from the start to the
# deadline, with linear interpolation. Found by random search over 8 numbers, maximising the mean return of six samples of
# strengths.
_BEST = (0.037, 0.0, 0.0, 0.148, 0.298, 0.474, 0.627, 0.837)
# The best known constant pressure, found likewise.
_CONSTANT = 0.5
# Largest seed for the strengths of an episode.
_LARGEST_SEED = 2**16 - 1


class ConfinementTask(Task):
    """A specimen shall stay whole under a growing load. See `make_confinement`.

    Args:
        specimen: with tractions on its left and right sides, and an upper side that moves.
        pressure: on the sides at action 1 [Pa].
        strain: axial, at the deadline.
        control_step: its length [s].
        deadline: control steps.
        grip: how deep the held ends are [m].
        price: what the largest pressure costs, held from the start to the deadline.
        lost: part of the pairs that may break before the specimen counts as lost.
    """

    name = "confinement"
    # The sides cannot be pulled.
    lowest_action = 0.0

    def __init__(
        self,
        specimen: Automata,
        pressure: float,
        strain: float,
        control_step: float,
        deadline: int,
        grip: float,
        price: float,
        lost: float,
    ) -> None:
        self.actions = {"left_traction[0]": pressure}
        self.observations = {"stress": 1e8, "damage": 1.0}
        self.strain, self.deadline, self.price, self.lost = strain, deadline, price, lost
        self._pairs = len(specimen.get("linked"))
        height = specimen.packing.reference[:, 1]
        # The held rows move rigidly; between them the start velocity is linear (uniform compression).
        part = np.clip((height - height.min() - grip) / (np.ptp(height) - 2.0 * grip), 0.0, 1.0)
        self.speed = strain * (float(np.ptp(height)) - 2.0 * grip) / (deadline * control_step)
        self._start = {"velocity": np.stack([np.zeros_like(part), -self.speed * part], axis=1)}
        solid, criterion = specimen.parameters.material, specimen.parameters.criterion
        strains = strain * (np.arange(deadline) + 1.0) / deadline
        friction = criterion.internal_friction  # type: ignore[union-attr] - Mohr and Coulomb's
        self.theory = np.array([confining_pressure(one, solid.young, solid.poisson, friction) for one in strains])  # type: ignore[union-attr]

    def start(self, random: Generator) -> Mapping[str, Any]:
        """Return the velocities of a uniform compression, so that no wave starts from the moving side."""
        return self._start

    def begin(self, component: Component, outputs: Seen) -> None:
        """Start with all pairs linked."""
        self.counters = {"broken_part": 0.0}

    def inputs(self, component: Component, driven: dict[str, Any]) -> dict[str, Any]:
        """Return the tractions on the left and right sides and the velocity of the upper side."""
        left = driven["left_traction"]
        return {"left_traction": left, "right_traction": -left, "top_velocity": np.array([0.0, -self.speed])}

    def judge(self, component: Component, outputs: Seen, duration: float) -> tuple[float, bool]:
        """Return minus the newly broken fraction minus the cost of the pressure; a lost specimen counts as wholly broken."""
        before, broken = self.counters["broken_part"], float(component.get("broken_links")) / self._pairs
        self.counters["broken_part"] = broken
        pressed = float(component.get("left_traction")[0]) / self.actions["left_traction[0]"]
        is_lost = broken > self.lost
        return before - (1.0 if is_lost else broken) - self.price * pressed / self.deadline, is_lost

    def baselines(self) -> Mapping[str, Policy]:
        """Return the policies "nothing", "constant" (pressure), "theory" and "best" (best known drive).

        "theory" is the Mohr-Coulomb pressure for a specimen without cohesion, at which even the weakest pair does not slide.
        """
        return {
            "nothing": Constant([0.0]),
            "constant": Constant([_CONSTANT]),
            "theory": OpenLoop(np.minimum(self.theory / self.actions["left_traction[0]"], 1.0)),
            "best": OpenLoop(interpolate_drive(_BEST, self.deadline)),
        }


def interpolate_drive(knots: npt.ArrayLike, steps: int) -> FloatArray:
    """Return the drive that interpolates evenly spaced knots linearly, shape (steps,)."""
    numbers = np.asarray(knots, dtype=np.float64)
    return np.interp((np.arange(steps) + 0.5) / steps, np.linspace(0.0, 1.0, len(numbers)), numbers)


@environment_factory
def make_confinement(
    *,
    pressure: float = 6e7,
    strain: float = 3.5e-3,
    price: float = 0.2,
    lost: float = 0.3,
    strength_seed: int | None = None,
    **options: Unpack[Options],
) -> ComponentEnv:
    """Hold a brittle specimen together by a pressure on its sides while it is compressed, with as little as is needed.

    A sample of rock, 20 mm x 38 mm, is compressed along its axis at a constant rate between two ends that hold it. Its pairs
    break by the criterion of Mohr and Coulomb, with strengths that scatter by 20 %. Alone it bursts at a third of the way;
    under pressure from the sides it carries more. Too much pressure, too early, crushes it across.

    ## Action space
    `Box(-1, 1, (1,), float32)`: the pressure on both sides, in units of `pressure` (6e7 Pa). Sides cannot be pulled: below 0
    counts as 0. The pressure changes by at most `action_rate` of `pressure` between two actions, because a jump sends waves
    through the specimen that break it.

    ## Observation space
    `Box(-10, 10, (4 n + clock,), float32)` for n automata (242): the stress of each (xx, yy, xy), in units of 1e8 Pa; the part
    of the faces of each that is broken; then the clock. The counter is "broken_part", the part of all pairs that is broken.

    ## Rewards
    Minus the part of all pairs that broke in the step, minus `price` x p / `deadline`, where p is the pressure in units of
    `pressure`. A specimen of which more than `lost` is broken counts as wholly broken. So the return is
    -(part that is broken) - price x (mean of p): -1 for doing nothing. Medians and ranges over the seeds 100 to 199: theory
    -0.089 (-0.103 to -0.086), the best that is known -0.063 (-0.092 to -0.060); over the seeds 100 to 119 a constant action of
    0.5 returns -0.30 (-0.33 to -0.27). An agent that looks at the damage may do better.

    ## Start state
    All pairs linked, no stress, and the velocities of an even compression: no wave runs from the ends. Each episode has a
    specimen with other strengths, drawn from the seed of `reset`.

    ## End of the episode
    Terminated when the specimen is lost, and at the deadline, which the clock shows (with `clock=0` that is truncated).

    ## Arguments
    * `pressure` (6e7 Pa): at action 1. `price` (0.2): see the rewards. `lost` (0.3).
    * `strain` (3.5e-3): axial, at the deadline: 1.9e8 Pa and more on the ends; the strength without pressure is some 6e7 Pa.
    * `action_rate` (0.05): largest change of the pressure between two actions, in units of `pressure`; None for no limit.
    * `strength_seed` (None): one draw of strengths for all episodes; None draws for each.
    * `internal_steps` (50) of 1e-7 s make a control step; `deadline` (50): control steps of an episode.
    * `clock` (2), `hold`, `step_error_reward`, `render_mode`: of `ComponentEnv`.

    ## Version history
    * v3: the pressure has a largest change between two actions; before, any noise in the actions broke the specimen.
    * v2: each episode draws its strengths; contacts press from the distance at which their links would rest.
    * v1: one draw of strengths for all.
    """
    row = 0.5 * math.sqrt(3.0) * _DIAMETER
    grip = _GRIP * row
    specimen = Automata(
        shape={"name": "rectangle", "width": _WIDTH, "height": _ROWS * row}, diameter=_DIAMETER, packing="hexagonal",
        material=_ROCK, criterion=_CRITERION, strength_scatter=0.2, strength_seed=strength_seed or 0, friction=0.4,
        boundaries={"left": "traction", "right": "traction", "bottom": {"name": "fixed", "depth": grip},
                    "top": {"name": "velocity", "depth": grip}}, step_size=1e-7,
    )  # fmt: skip
    settings: dict[str, Any] = {"internal_steps": 50, "deadline": 50, "clock": 2, "action_rate": 0.05, **options}
    if strength_seed is None:
        settings["randomise"] = {"strength_seed": (0, _LARGEST_SEED), **(settings.get("randomise") or {})}
    internal_steps, deadline = (whole_number(name, settings[name]) for name in ("internal_steps", "deadline"))
    price, lost = finite_number("price", price), positive_number("lost", lost)
    if price < 0.0:
        raise ParameterError(f"got {price:g}", expected="0 or more", at="price")
    if lost > 1.0:
        raise ParameterError(f"got {lost:g}", expected="at most 1, all pairs", at="lost")
    task = ConfinementTask(
        specimen, positive_number("pressure", pressure), positive_number("strain", strain),
        internal_steps * specimen.step_size, deadline, grip, price, lost,
    )  # fmt: skip
    return ComponentEnv(specimen, task, **settings)
