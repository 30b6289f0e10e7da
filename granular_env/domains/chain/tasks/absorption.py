"""Absorption-v1: an active right end minimises the reflection of an unknown incoming wave."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, Unpack

import numpy as np
from numpy.random import Generator

from granular_env.components.chain import Chain
from granular_env.components.chain.differentiable_quantities import excess_energy, excess_energy_pullback
from granular_env.components.chain.objective import Objective
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.jit import jit
from granular_env.components.support.validation import whole_number
from granular_env.envs.environment import ComponentEnv
from granular_env.envs.factory import environment_factory
from granular_env.envs.policies import Constant, Policy

from ..rows import ChainRows
from .driven_end import DrivenEnd, DrivenEndTask, DrivenOptions, driven_end, hertz_chain, limits, refuse_too_early, sum_value
from .matched_end import SENSORS, MatchedForce, MatchedPiston, Sensors


@jit
def _note(chain, step, steps, inputs, constants, sums):
    if step == steps - 1:
        sums[0] += excess_energy(chain, 1, chain.settings.grains) / constants[0]


@jit
def _pullback(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
    if step == steps - 1:
        excess_energy_pullback(chain, adjoint, 1, chain.settings.grains, slopes[0] / constants[0])


class AbsorptionTask(DrivenEndTask):
    """An active end that is to let little come back of an unknown wave. See `make_absorption`.

    Args:
        chain: the chain, struck at its left end and driven at its right one; Hertz contacts.
        end: its right end.
        impact: smallest and largest speed of the strikers [m/s].
        strikers: largest number of grains that strike.
        has_sensors: whether the agent sees `SENSORS`, which theory needs.
    """

    name = "absorption"
    counter_names = ("incoming_energy", "energy", "returned")

    def __init__(self, chain: Chain, end: DrivenEnd, impact: tuple[float, float], strikers: int, has_sensors: bool) -> None:
        super().__init__(chain, end)
        mass, stiffness, _ = hertz_chain(self.name, chain)
        self.impact, self.strikers, self._has_sensors = impact, strikers, has_sensors
        self._grain = mass, stiffness, chain.step_size

    def start(self, random: Generator) -> Mapping[str, Any]:
        """Return start velocities: the first 1 to `strikers` grains move at one speed; both are sampled uniformly."""
        count = int(random.integers(1, self.strikers + 1))
        speed = float(random.uniform(*self.impact))
        return {"velocity": dict.fromkeys(range(count), speed)}

    def begin_rows(self, rows: ChainRows, constants: None, counters: dict[str, Any]) -> None:
        """Store the incoming energy."""
        energy = rows.energy_from(0)
        counters.update(incoming_energy=energy, energy=energy, returned=1.0 * (energy > 0.0))

    def judge_rows(self, rows: ChainRows, constants: None, counters: dict[str, Any], elapsed: Any) -> tuple[FloatArray, bool]:
        """Return the decrease of the returned energy fraction in this step."""
        before, incoming, energy = counters["returned"], counters["incoming_energy"], rows.energy_from(0)
        # Without an incoming wave, the energy put in by the driven end counts in joules.
        returned = energy / np.where(incoming > 0.0, incoming, 1.0)
        counters.update(energy=energy, returned=returned)
        return before - returned, False

    def objective(self, component: Chain, steps: int) -> Objective:
        """Return the final energy of the grains divided by the present energy of the chain (1 J if that is 0)."""
        incoming = float(ChainRows([component]).energy_from(0))
        text = "energy left in the chain at the end over that at the start"
        return Objective(_note, sum_value, _pullback, np.array([incoming if incoming > 0.0 else 1.0]), description=text)

    def baselines(self) -> Mapping[str, Policy]:
        """Return the policies "nothing" and, with the default sensors, a matched end."""
        policies: dict[str, Policy] = {"nothing": Constant(0.0)}
        if self._has_sensors:
            name, scale = next(iter(self.actions.items()))
            matched = MatchedPiston if name.endswith("velocity") else MatchedForce
            policies["theory"] = matched(*self._grain, self.hold * self.end.duration, scale, Sensors.of(self))
        return policies


@environment_factory
def make_absorption(
    grains: int = 64,
    *,
    impact: tuple[float, float] = (3.0, 8.0),
    strikers: int = 2,
    **options: Unpack[DrivenOptions],
) -> ComponentEnv:
    """Hold the right end of a chain so that as little as possible of an unknown wave comes back.

    The first grains of a row of equal elastic spheres strike the others. Their number and speed are drawn and not observed. One
    to several solitary waves run to the right end, which the agent holds: at rest it is a rigid wall that throws everything
    back, and moved as the next grain of a longer chain would move it swallows the wave.

    ## Action space
    `Box(-1, 1, (1,), float32)`: the value held over the next control step, in units of `action_scale`. `action="piston"`: the
    velocity of the last grain, positive to the right. `action="force"`: the force on the last grain, which is free otherwise.

    ## Observation space
    `Box(-10, 10, (4,), float32)`: sensors at the end alone: displacement of the last grain, in mm, velocity of the last grain
    but one and of the last one, in units of 10 m/s, force between them, in units of 1000 N; `observe` chooses others, or
    "full". The counters are "incoming_energy" and "energy" [J] and "returned".

    ## Rewards
    returned = energy in the chain now over that at the start: kinetic energy of the grains (not of a piston, which belongs to
    the machine) and elastic energy of the contacts above that at rest. The rest has been absorbed by the end or dissipated in
    contacts. A step's reward is the decrease of `returned`. So the return is 1 minus `returned` at the deadline: doing nothing
    gives 0, pushing less than 0. The strikers rebound with 0.6 % (one) to 0.8 % (two) of the energy, which no end can
    absorb.

    ## Start state
    One to `strikers` first grains move at one speed from `impact`; the others are at rest, all in touch.

    ## End of the episode
    Truncated after `deadline` control steps: by then the slowest wave has been at the end and is on its way back.

    ## Arguments
    * `grains` (64), `radius` (3e-3 m), `material` ("steel"): the chain, its left end free.
    * `action` ("piston"): "piston" or "force". `action_scale` (None): 10 m/s or 1000 N.
    * `impact` ((3.0, 8.0) m/s), `strikers` (2): the limits of the draw.
    * `step_size` (5e-7 s): internal step. `internal_steps` (4) make a control step, `deadline` (300) control steps an episode
      of 600 us.
    * `chain`: further parameters of the chain component, e.g. `{"precompression": 10.0}`; Hertz contacts.

    ## Baselines
    `env.unwrapped.task.baselines()`: "nothing"; "theory", a matched end: a virtual chain continues the real one, is
    driven by what the sensors read, and says how the end would move (`matched_end.MatchedPiston`) or be pushed
    (`matched_end.MatchedForce`). They return 0 and, over 240 seeds, 0.9914 to 0.9935 with a piston (0.9924 in the mean),
    0.9918 to 0.9937 with a force (0.9927): all but the rebound and some 1e-4. No better policy that sees the sensors alone is
    known: "best" is missing.

    ## Version history
    * v1: `hold` and `clock`; `randomise` draws a chain for each episode, from the seed of the reset.
    * v0: first version.
    """
    chain, end, rest = driven_end(
        make_absorption, locals(), "right", action="piston", internal_steps=4, deadline=300, clock=0, observe=SENSORS
    )
    speeds, most = limits("impact", impact), whole_number("strikers", strikers, 1, chain.parameters.grains - 1)
    has_sensors = rest["observe"] == SENSORS
    task = partial(AbsorptionTask, end=end, impact=speeds, strikers=most, has_sensors=has_sensors)
    env = ComponentEnv(chain, task, **rest)
    start = {"velocity": dict.fromkeys(range(most), speeds[1])}
    refuse_too_early(chain, end, speeds[1], "", lambda struck: float(struck.get("velocity")[-2:].max()), start)
    return env
