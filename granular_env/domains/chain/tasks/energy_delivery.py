"""EnergyDelivery-v1: deliver a wanted energy to the last grains by the deadline, at little work."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, NamedTuple, Unpack

import numpy as np

from granular_env.components.chain import Chain
from granular_env.components.chain.differentiable_quantities import excess_energy, excess_energy_pullback
from granular_env.components.chain.objective import Objective
from granular_env.components.chain.theory import SOLITARY_ENERGY
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.jit import jit
from granular_env.components.support.validation import finite_number, positive_number, whole_number
from granular_env.envs.environment import ComponentEnv
from granular_env.envs.factory import environment_factory
from granular_env.envs.policies import Policy

from ..rows import ChainRows
from .driven_end import DrivenEnd, DrivenEndTask, DrivenOptions, driven_end, hertz_chain, refuse_too_early
from .waves import passing_waves, shape_energies, wave_shapes

# Layout of the objective's constants: wanted energy [J], cost of that amount of work, column of the target region's first
# grain.
_ENERGY, _PRICE, _FIRST = range(3)
# Initial distance of the wave's crest from the first grain [grains]; a closer wave would already overlap the chain.
_ENTRY = 4.0
_ITERATIONS = 20


class Wanted(NamedTuple):
    """Constants of the task: the wanted energy [J], and the price of as much work."""

    energy: float
    price: float


@jit
def _note(chain, step, steps, inputs, constants, sums):
    if step == steps - 1:
        n = chain.settings.grains
        sums[0] += excess_energy(chain, int(constants[_FIRST]), n) / constants[_ENERGY]
        sums[1] += excess_energy(chain, 1, n) / constants[_ENERGY]


@jit
def _value(sums, constants, slopes):
    off = sums[0] - 1.0
    slopes[0], slopes[1] = 2.0 * off, constants[_PRICE]
    return off * off + constants[_PRICE] * sums[1]


@jit
def _pullback(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
    if step == steps - 1:
        n = chain.settings.grains
        excess_energy_pullback(chain, adjoint, int(constants[_FIRST]), n, slopes[0] / constants[_ENERGY])
        excess_energy_pullback(chain, adjoint, 1, n, slopes[1] / constants[_ENERGY])


class EnergyDeliveryTask(DrivenEndTask):
    """The last grains shall hold an energy at the deadline; work costs. See `make_energy_delivery`.

    Args:
        chain: the driven chain; Hertz contacts.
        end: its left end.
        energy: wanted in the target region [J].
        region: number of grains of the target region.
        price: of as much work as `energy`.
    """

    name = "energy_delivery"
    counter_names = ("delivered_energy", "work", "closeness")

    def __init__(self, chain: Chain, end: DrivenEnd, energy: float, region: int, price: float) -> None:
        super().__init__(chain, end)
        self._grain, self._first = hertz_chain(self.name, chain), self.grains - region
        self.constants = Wanted(positive_number("energy", energy), finite_number("work_price", price))

    def begin_rows(self, rows: ChainRows, constants: Wanted, counters: dict[str, Any]) -> None:
        """Store the delivered energy and the work at the start."""
        delivered = rows.energy_from(self._first)
        off = delivered / constants.energy - 1.0
        counters.update(delivered_energy=delivered, work=rows.input_work, closeness=1.0 - off * off)

    def judge_rows(self, rows: ChainRows, constants: Wanted, counters: dict[str, Any], elapsed: Any) -> tuple[FloatArray, bool]:
        """Return the gain in closeness minus the cost of this step's work."""
        closeness, work = counters["closeness"], counters["work"]
        self.begin_rows(rows, constants, counters)
        return counters["closeness"] - closeness - constants.price * (counters["work"] - work) / constants.energy, False

    def objective(self, component: Chain, steps: int) -> Objective:
        """Return (delivered / wanted - 1)^2 + price x energy of the chain at the end / wanted.

        Without dissipation and from rest, the final energy of the chain is the work done, and the objective is 1 minus the
        return. The energy of a piston's grain is not counted.
        """
        text = "squared relative error of the energy delivered, and the price of the energy in the chain"
        constants = np.array([*self.constants, self._first + 1.0])
        return Objective(_note, _value, _pullback, constants, count=2, description=text)

    def baselines(self) -> Mapping[str, Policy]:
        """Return a drive that sends one solitary wave into the region by the deadline, and the best known drive."""
        mass, stiffness, rest = self._grain
        wanted = self.constants.energy * (1.0 - 0.5 * self.constants.price)
        height = np.sqrt([wanted / (SOLITARY_ENERGY * mass)])
        shapes, speeds = wave_shapes(mass, stiffness, rest, height)
        for _ in range(_ITERATIONS if rest > 0.0 else 0):  # with precompression, energy is not a power of the amplitude
            height *= np.sqrt(wanted / shape_energies(shapes, height))
            shapes, speeds = wave_shapes(mass, stiffness, rest, height)
        # As deep in the region as the deadline allows, but not beyond its middle.
        middle = self.grains - 0.5 * (self.grains - self._first) - 0.5
        place = min(middle, float(speeds[0]) * self.end.duration * self.end.steps - _ENTRY)
        waves = np.array([[height[0], place, speeds[0]]])
        return self.open_loops(passing_waves(shapes, waves, self.end.duration, self.end.steps, next(iter(self.actions))))


@environment_factory
def make_energy_delivery(
    grains: int = 64,
    *,
    energy: float = 0.015,
    region: int = 8,
    work_price: float = 0.2,
    **options: Unpack[DrivenOptions],
) -> ComponentEnv:
    """Drive the left end so that by the deadline a wanted energy is in the last grains, at little work.

    A row of equal elastic spheres carries energy in solitary waves. One wave of the right height, sent off in time, holds all
    the energy that it was given; a push that is too short, too long or too late leaves part of it behind.

    ## Action space
    `Box(-1, 1, (1,), float32)`: the value held over the next control step, in units of `action_scale`. `action="force"`: the
    force on the first grain, positive to the right; pulling moves the first grain alone. `action="piston"`: the velocity of the
    first grain.

    ## Observation space
    `Box((2 grains + clock,), float32)`: displacement and velocity of every grain, in units of 1 mm and 10 m/s, then the clock.
    The counters are "delivered_energy" and "work" [J] and "closeness".

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
    "best", the best drive known, where all arguments but `action` are the defaults. They return 0, 0.809965 and 0.810000 with a
    force, 0, 0.809942 and 0.810000 with a piston: nothing is left to gain beyond theory but the holding of the input over a
    control step. Theory's wave is that of a chain of equal grains; in a dimer or a tapered chain it returns less.

    ## Version history
    * v1: the observation ends with a clock and the deadline terminates; `hold`; `randomise` draws a chain for each episode.
    * v0: first version.
    """
    chain, end, rest = driven_end(make_energy_delivery, locals(), internal_steps=3, deadline=280)
    region = whole_number("region", region, 1, chain.parameters.grains)
    env = ComponentEnv(chain, partial(EnergyDeliveryTask, end=end, energy=energy, region=region, price=work_price), **rest)
    first = chain.parameters.grains - region
    refuse_too_early(chain, end, energy, "J", lambda driven: float(ChainRows([driven]).energy_from(first)))
    return env
