"""Confinement-v3: keep a brittle specimen under axial compression intact with as little lateral pressure as possible."""

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

# The specimen: hexagonal packing of discs, 22 row distances high; its two lowest and two highest rows are held [m].
_DIAMETER, _WIDTH, _ROWS = 2e-3, 0.02, 22
_ROCK = {"density": 2600.0, "young": 5e10, "poisson": 0.25}
_CRITERION = {"name": "mohr_coulomb", "cohesion": 1.5e7, "internal_friction": 0.4, "tensile": 1e7}
# Depth of each held end, in row distances: 1.04 holds two rows.
_GRIP = 1.04
# The best known drive for the default arguments: pressures in units of `pressure`, at evenly spaced instants from the start
# to the deadline, with linear interpolation. These 8 numbers were found by random search, which maximised the mean return
# over six samples of the strengths.
_BEST = (0.037, 0.0, 0.0, 0.148, 0.298, 0.474, 0.627, 0.837)
# The best known constant pressure, in the same unit, found in the same way.
_CONSTANT = 0.5
# Upper limit of the seeds from which the strengths of an episode are sampled.
_LARGEST_SEED = 2**16 - 1


class ConfinementTask(Task):
    """Keep a specimen intact under a growing axial load. See `make_confinement`.

    Args:
        specimen: automata with tractions on the left and right sides, and a moving upper side.
        pressure: pressure on the sides at action 1 [Pa].
        strain: axial compressive strain at the deadline.
        control_step: length of a control step [s].
        deadline: number of control steps of an episode.
        grip: depth of the held ends [m].
        price: cost, in reward, of holding the pressure at action 1 from the start to the deadline.
        lost: fraction of broken pairs above which the specimen counts as lost.
    """

    name = "confinement"
    # Only pressure: the sides cannot be pulled.
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
        # At the start, the held rows move rigidly; between them the velocity varies linearly (uniform compression).
        part = np.clip((height - height.min() - grip) / (np.ptp(height) - 2.0 * grip), 0.0, 1.0)
        self.speed = strain * (float(np.ptp(height)) - 2.0 * grip) / (deadline * control_step)
        self._start = {"velocity": np.stack([np.zeros_like(part), -self.speed * part], axis=1)}
        solid, criterion = specimen.parameters.material, specimen.parameters.criterion
        strains = strain * (np.arange(deadline) + 1.0) / deadline
        friction = criterion.internal_friction  # type: ignore[union-attr] - Mohr and Coulomb's
        self.theory = np.array([confining_pressure(one, solid.young, solid.poisson, friction) for one in strains])  # type: ignore[union-attr]

    def start(self, random: Generator) -> Mapping[str, Any]:
        """Return the start velocities of a uniform compression, so that no wave starts from the moving upper side."""
        return self._start

    def begin_episode(self, component: Component, outputs: Seen) -> None:
        """Set the counter of broken pairs to 0."""
        self.counters = {"broken_part": 0.0}

    def inputs(self, component: Component, driven: dict[str, Any]) -> dict[str, Any]:
        """Return the tractions on the left and right sides and the velocity of the upper side."""
        left = driven["left_traction"]
        return {"left_traction": left, "right_traction": -left, "top_velocity": np.array([0.0, -self.speed])}

    def evaluate_step(self, component: Component, outputs: Seen, duration: float) -> tuple[float, bool]:
        """Return minus the fraction of pairs broken in this step minus the pressure's cost; if lost, all count as broken."""
        before, broken = self.counters["broken_part"], float(component.get("broken_links")) / self._pairs
        self.counters["broken_part"] = broken
        pressed = float(component.get("left_traction")[0]) / self.actions["left_traction[0]"]
        is_lost = broken > self.lost
        return before - (1.0 if is_lost else broken) - self.price * pressed / self.deadline, is_lost

    def colours(self, component: Component) -> Mapping[str, FloatArray]:
        """Return the axial compression of each automaton over the stress that its observation shows as 1."""
        return {"automata": -component.get("stress")[:, 1] / self.observations["stress"]}

    def baselines(self) -> Mapping[str, Policy]:
        """Return the policies "nothing", "constant" (pressure), "theory" and "best" (best known drive).

        "theory" applies the pressure at which, by Mohr and Coulomb, not even a pair without cohesion slides.
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
    r"""Keep a brittle specimen under axial compression intact with as little lateral pressure as possible.

    A sample of rock, 20 mm x 38 mm, is compressed along its axis at a constant rate between two ends that hold it. Its
    pairs break by the criterion of Mohr and Coulomb, with strengths that scatter by 20 %. Without lateral pressure it fails
    after a third of the episode. High pressure too early breaks it across.

    ## Action space
    The pressure on both sides; values below 0 count as 0. It changes by at most `action_rate` between two actions, because
    a jump sends waves through the specimen that break it.

    ## Observation space
    Of each automaton: stress (xx, yy, xy) and damage (broken part of its faces). Counter: "broken_part", that of all pairs.

    ## Rewards
    Minus the fraction of all pairs that broke in the step, minus `price` times p / `deadline`, where p is the pressure in
    units of `pressure`. A specimen with more than the fraction `lost` broken counts as entirely broken. The return is
    therefore minus the broken fraction minus `price` times the mean of p.

    ## Start state
    All pairs linked, no stress, and the velocities of uniform compression, so that no wave starts at the ends. The
    strengths are sampled for each episode.

    ## End of the episode
    Terminated when the specimen is lost, and at the deadline.

    ## Arguments
    * `pressure` (6e7 Pa): pressure at action 1. `price` (0.2), `lost` (0.3): see the rewards.
    * `strain` (3.5e-3): axial strain at the deadline; it needs a stress of at least 1.9e8 Pa on the ends. Without lateral
      pressure, the specimen breaks at some 6e7 Pa.
    * `action_rate` (0.05): largest change of the action between two actions; None for no limit.
    * `strength_seed` (None): seed of the strengths, if they shall be the same in all episodes; None samples them.
    * `clock` (2): number of time readings in the observation.

    ## Baselines
    In plane strain, the axial strain e and the lateral pressure p cause an axial pressure. Pairs at 60 degrees to the rows
    slide when it reaches the limit given by cohesion c and internal friction f:

    $$\frac{E e}{1 - \nu^2} + \frac{\nu p}{1 - \nu} = \frac{4 c + (\sqrt3 + f)\, p}{\sqrt3 - 3 f}.$$

    "theory" applies the p of this equation for c = 0. "best" was found by search: no pressure for a third of the episode,
    then a steep rise; a few pairs break. Their returns have the medians (and ranges) -0.089 (-0.103 to -0.086) and -0.063
    (-0.092 to -0.060) over the seeds 100 to 199. "constant" holds the action 0.5 and returns -0.30 (-0.33 to -0.27, seeds
    100 to 119). A policy that observes the damage may do better.

    ## Versions
    Since v3, the rate of change of the pressure is limited. Since v2, the strengths are sampled for each episode, and
    contacts press as soon as they are shorter than the rest distance of their links.
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
        raise ParameterError(f"got {lost:g}", expected="at most 1 (all pairs)", at="lost")
    task = ConfinementTask(
        specimen, positive_number("pressure", pressure), positive_number("strain", strain),
        internal_steps * specimen.step_size, deadline, grip, price, lost,
    )  # fmt: skip
    return ComponentEnv(specimen, task, **settings)
