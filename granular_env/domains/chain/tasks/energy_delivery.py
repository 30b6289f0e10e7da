"""EnergyDelivery-v1: by the deadline a wanted energy is in the last grains; work costs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Unpack

import numpy as np

from granular_env.components.chain import Chain
from granular_env.components.chain.differentiable_quantities import energy_between, energy_between_pullback, input_work
from granular_env.components.chain.layout import GRAINS, SCALARS
from granular_env.components.chain.objective import Objective
from granular_env.components.chain.theory import SOLITARY_ENERGY
from granular_env.components.support.jit import jit
from granular_env.components.support.validation import finite_number, positive_number, whole_number
from granular_env.envs.environment import environment_factory
from granular_env.envs.policies import Policy

from ..envs.environment import ChainEnv, ChainOptions
from .analytic_drives import passing_waves
from .baselines import open_loops
from .driven_end import DrivenEnd, DrivenEndTask, driven_end, hertz_chain
from .feasibility import caution_late
from .target_waves import shape_energies, wave_shapes

# Layout of the constants: the wanted energy [J], price of that much work, first grain of the target region (its column).
_ENERGY, _PRICE, _FIRST = range(3)
# Layout of the counters.
_DELIVERED, _WORK, _CLOSENESS = range(3)

# At the start the crest of a wave has to be so far before the first grain, or it has begun already [grains].
_ENTRY = 4.0
_ITERATIONS = 20


@jit
def _count(a, counters, constants):
    counters[_DELIVERED] = energy_between(a, int(constants[_FIRST]), int(a[SCALARS, GRAINS]))
    counters[_WORK] = input_work(a)
    off = counters[_DELIVERED] / constants[_ENERGY] - 1.0
    counters[_CLOSENESS] = 1.0 - off * off


@jit
def _begin(a, counters, constants):
    _count(a, counters, constants)


@jit
def _judge(a, inputs, counters, constants, duration, elapsed, steps):
    closeness, work = counters[_CLOSENESS], counters[_WORK]
    _count(a, counters, constants)
    cost = constants[_PRICE] * (counters[_WORK] - work) / constants[_ENERGY]
    return counters[_CLOSENESS] - closeness - cost, False


@jit
def _note(a, step, steps, inputs, constants, sums):
    if step == steps - 1:
        n = int(a[SCALARS, GRAINS])
        sums[0] += energy_between(a, int(constants[_FIRST]), n) / constants[_ENERGY]
        sums[1] += energy_between(a, 1, n) / constants[_ENERGY]


@jit
def _value(sums, constants, slopes):
    off = sums[0] - 1.0
    slopes[0], slopes[1] = 2.0 * off, constants[_PRICE]
    return off * off + constants[_PRICE] * sums[1]


@jit
def _pullback(a, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
    if step == steps - 1:
        n = int(a[SCALARS, GRAINS])
        energy_between_pullback(a, adjoint, int(constants[_FIRST]), n, slopes[0] / constants[_ENERGY])
        energy_between_pullback(a, adjoint, 1, n, slopes[1] / constants[_ENERGY])


class EnergyDeliveryTask(DrivenEndTask):
    """The last grains shall hold an energy at the deadline; work costs. See `make_energy_delivery`.

    Args:
        chain: what is driven; Hertz contacts.
        end: its left end.
        energy: wanted in the target region [J].
        region: number of grains of the target region.
        price: what work as great as `energy` costs.
    """

    name = "energy_delivery"
    counter_names = ("delivered_energy", "work", "closeness")
    begin_kernel = staticmethod(_begin)
    judge_kernel = staticmethod(_judge)

    def __init__(self, chain: Chain, end: DrivenEnd, energy: float, region: int, price: float) -> None:
        super().__init__(chain, end)
        self.grain = hertz_chain(self.name, chain)
        self.energy, self.price, self.region = positive_number("energy", energy), finite_number("work_price", price), region
        self.constants = np.array([self.energy, self.price, float(self.grains - region + 1)])

    def objective(self, chain: Chain, steps: int) -> Objective:
        """(delivered / wanted - 1)^2 + price x energy of the chain at the end / wanted.

        The energy that is in the chain at the end is the work done, where nothing dissipates and the chain starts at rest: then
        this is 1 less the return. What a piston's own grain has is not counted.
        """
        text = "squared relative error of the energy delivered, and the price of the energy in the chain"
        return Objective(_note, _value, _pullback, self.constants, count=2, description=text)

    def baselines(self) -> Mapping[str, Policy]:
        """One solitary wave, which is just in the region at the deadline; and the best known drive."""
        mass, stiffness, rest = self.grain
        wanted = self.energy * (1.0 - 0.5 * self.price)
        height = np.sqrt([wanted / (SOLITARY_ENERGY * mass)])
        shapes, speeds = wave_shapes(mass, stiffness, rest, height)
        for _ in range(_ITERATIONS if rest > 0.0 else 0):  # under precompression a wave's energy is no power of its height
            height *= np.sqrt(wanted / shape_energies(shapes, height))
            shapes, speeds = wave_shapes(mass, stiffness, rest, height)
        horizon = self.duration * self.steps
        # As deep in the region as the deadline allows, its middle at most.
        place = min(self.grains - 0.5 * self.region - 0.5, float(speeds[0]) * horizon - _ENTRY)
        waves = np.array([[height[0], place, speeds[0]]])
        drive = passing_waves(shapes, waves, horizon, self.duration, self.steps, next(iter(self.actions)))
        return open_loops(self, "granular_env/EnergyDelivery-v1", drive)


@environment_factory
def make_energy_delivery(
    grains: int = 64,
    radius: Any = None,
    material: Any = None,
    *,
    action: str = "force",
    action_scale: float | None = None,
    energy: float = 0.015,
    region: int = 8,
    work_price: float = 0.2,
    step_size: float = 5e-7,
    chain: dict[str, Any] | None = None,
    **options: Unpack[ChainOptions],
) -> ChainEnv:
    """Drive the left end so that by the deadline a wanted energy is in the last grains, at little work.

    A row of equal elastic spheres carries energy in solitary waves. One wave of the right height, sent off in time, holds all
    the energy that it was given; a push that is too short, too long or too late leaves part of it behind.

    ## Action space
    `Box(-1, 1, (1,), float32)`: what is held over the next control step, in units of `action_scale`; clipped. `action="force"`:
    the force on the first grain, positive to the right; pulling moves the first grain alone. `action="piston"`: the velocity of
    the first grain.

    ## Observation space
    `Box((2 grains + clock,), float32)`: displacement and velocity of every grain, in units of 1 mm and 10 m/s, then the clock.
    `info` has "time" [s], the input, and the counters "delivered_energy" and "work" [J] and "closeness".

    ## Rewards
    closeness = 1 - (E / `energy` - 1)^2, E being the energy of the last `region` grains and of the contacts from the first of
    them on, above that at rest. A step's reward is its gain in closeness, less `work_price` x the input's work in that step /
    `energy`. So the return is the closeness at the end less the price of the work. Doing nothing returns 0. All work arriving,
    1 - 0.1 of the wanted energy is best (the price's half), and the return is 0.81: no drive can do better.

    ## Start state
    Everything at rest, all grains in touch.

    ## End of the episode
    Terminated after `deadline` control steps; the agent sees the time. With `clock=0` it does not, and the episode is
    truncated.

    ## Arguments
    * `grains` (64), `radius` (3e-3 m), `material` ("steel"): the chain, its right end free.
    * `action` ("force"): "force" or "piston". `action_scale` (None): 1000 N or 10 m/s.
    * `energy` (0.015 J), `region` (8 grains), `work_price` (0.2).
    * `step_size` (5e-7 s): internal step. `internal_steps` (3) make a control step, `deadline` (280) control steps an episode
      of 420 us; a wave of that energy (4 m/s) crosses 60 grains in 380 us.
    * `clock` (8): readings of the clock.
    * `chain`: further parameters of the chain component, e.g. `{"right": "plane", "precompression": 10.0}`; Hertz contacts.

    ## Baselines
    `env.unwrapped.task.baselines()`: "nothing"; "theory", what the missing grains would do to the first one while an exact
    solitary wave passes, whose energy 1.0693 m v^2 is that which is best and which is in the region's middle at the deadline;
    "best", the best drive known, where these arguments have one. They return 0, 0.809965 and 0.810000 with a force, 0,
    0.809942 and 0.810000 with a piston: nothing is left to gain beyond theory but the holding of the input over a control step.
    Theory's wave is that of a chain of equal grains; in a dimer or a tapered chain it is none of that chain, and returns less.

    ## Version history
    * v1: the observation ends with a clock and the deadline terminates; `hold`; `randomise` draws a chain for each episode.
    * v0: first version.
    """
    end = driven_end(make_energy_delivery, locals(), "left", internal_steps=3, deadline=280)
    region = whole_number("region", region, 1, end.chain.parameters.grains)
    env = end.environment(lambda chain: EnergyDeliveryTask(chain, end, energy, region, work_price))
    if end.arguments:
        first = end.chain.parameters.grains - region + 1
        caution_late(
            env.component, end, energy, "J",
            lambda driven: driven.specialise(energy_between)(driven.table, first, driven.parameters.grains),
        )  # fmt: skip
    return env
