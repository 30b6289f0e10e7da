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
from .driven_end import (
    DrivenEnd,
    DrivenEndTask,
    DrivenOptions,
    hertz_constants,
    make_driven_end,
    parse_range,
    refuse_unreachable_deadline,
    single_sum_value,
)
from .matched_end import SENSORS, MatchedForce, MatchedPiston, SensorScales


@jit
def _add_to_sums(chain, step, steps, inputs, constants, sums):
    if step == steps - 1:
        sums[0] += excess_energy(chain, 1, chain.settings.grains) / constants[0]


@jit
def _pullback(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
    if step == steps - 1:
        excess_energy_pullback(chain, adjoint, 1, chain.settings.grains, slopes[0] / constants[0])


class AbsorptionTask(DrivenEndTask):
    """Absorb an unknown wave at an active end. See `make_absorption`.

    Args:
        chain: the chain, struck at its left end and driven at its right end; Hertz contacts.
        end: the driven right end.
        impact: smallest and largest speed of the strikers [m/s].
        strikers: largest number of grains that move at the start.
        has_sensors: whether the observation contains `SENSORS`, which the "theory" baseline needs.
    """

    name = "absorption"
    counter_names = ("incoming_energy", "energy", "returned")

    def __init__(self, chain: Chain, end: DrivenEnd, impact: tuple[float, float], strikers: int, has_sensors: bool) -> None:
        super().__init__(chain, end)
        mass, stiffness, _ = hertz_constants(self.name, chain)
        self.impact, self.strikers, self._has_sensors = impact, strikers, has_sensors
        self._grain = mass, stiffness, chain.step_size

    def start(self, random: Generator) -> Mapping[str, Any]:
        """Return start velocities: the first 1 to `strikers` grains move at one speed; both are sampled uniformly."""
        count = int(random.integers(1, self.strikers + 1))
        speed = float(random.uniform(*self.impact))
        return {"velocity": dict.fromkeys(range(count), speed)}

    def begin_rows(self, rows: ChainRows, constants: None, counters: dict[str, Any]) -> None:
        """Store the energy of the chain at the start, which is that of the incoming wave."""
        energy = rows.tail_energy(0)
        counters.update(incoming_energy=energy, energy=energy, returned=1.0 * (energy > 0.0))

    def evaluate_rows(
        self, rows: ChainRows, constants: None, counters: dict[str, Any], elapsed: Any
    ) -> tuple[FloatArray, bool]:
        """Return the decrease, in this step, of the energy in the chain as a fraction of the incoming energy."""
        before, incoming, energy = counters["returned"], counters["incoming_energy"], rows.tail_energy(0)
        # Without an incoming wave, divide by 1 J, so that energy supplied by the driven end counts in joules.
        returned = energy / np.where(incoming > 0.0, incoming, 1.0)
        counters.update(energy=energy, returned=returned)
        return before - returned, False

    def objective(self, component: Chain, steps: int) -> Objective:
        """Return the final energy of the grains divided by the present energy of the chain (1 J if that is 0)."""
        incoming = float(ChainRows([component]).tail_energy(0))
        text = "final energy of the chain divided by its initial energy"
        return Objective(
            _add_to_sums, single_sum_value, _pullback, np.array([incoming if incoming > 0.0 else 1.0]), description=text
        )

    def baselines(self) -> Mapping[str, Policy]:
        """Return the policies "nothing" and, with the default sensors, a matched end."""
        policies: dict[str, Policy] = {"nothing": Constant(0.0)}
        if self._has_sensors:
            name, scale = next(iter(self.actions.items()))
            matched = MatchedPiston if name.endswith("velocity") else MatchedForce
            policies["theory"] = matched(*self._grain, self.hold * self.end.duration, scale, SensorScales.from_task(self))
        return policies


@environment_factory
def make_absorption(
    grains: int = 64,
    *,
    impact: tuple[float, float] = (3.0, 8.0),
    strikers: int = 2,
    **options: Unpack[DrivenOptions],
) -> ComponentEnv:
    """Control the right end of a chain so that it reflects as little as possible of an unknown wave.

    One or two grains strike the left end of the chain. Their number and velocity are sampled and not observed. The impact
    sends one or more solitary waves to the right end. An end at rest reflects them as a rigid wall does. An end that moves
    as the next grain of a longer chain absorbs them.

    ## Observation space
    Sensors near the driven end only; `observe` selects others, or "full". Counters: "incoming_energy" (of the start) and
    "energy" (present) [J], and their ratio "returned".

    ## Rewards
    "returned" is the present energy of the chain over that at the start: kinetic energy of the grains (without a piston's)
    plus elastic energy above that at rest. The reward of a step is the decrease of "returned", and the return is 1 minus
    its final value. A zero input gives the return 0, an end that adds energy less. One striker rebounds with 0.6 % of the
    energy, two with 0.8 %, which no end can absorb.

    ## Start state
    The first one to `strikers` grains move at a velocity sampled from `impact`; the others are at rest.

    ## End of the episode
    Truncated after `deadline` control steps: even the slowest wave has reached the end by then and is on its way back.

    ## Arguments
    * `impact` ((3.0, 8.0) m/s), `strikers` (2): range of the velocity, and largest number of strikers.
    * `action` ("piston"): "piston" or "force". `clock` (0): number of time readings in the observation.

    ## Baselines
    "theory" is a matched end. A virtual chain continues the real one and is driven by the sensor readings. It predicts the
    motion of the end (`matched_end.MatchedPiston`) or the force on it (`matched_end.MatchedForce`) one control step ahead,
    from mass and stiffness of the grains, without knowledge of the wave. Over 240 seeds it returns 0.9914 to 0.9935 with a
    piston (mean 0.9924), 0.9918 to 0.9937 with a force (mean 0.9927). No better policy that uses the sensors only is known.
    """
    chain, end, rest = make_driven_end(
        make_absorption, locals(), "right", action="piston", internal_steps=4, deadline=300, clock=0, observe=SENSORS
    )
    speeds, most = parse_range("impact", impact), whole_number("strikers", strikers, 1, chain.parameters.grains - 1)
    has_sensors = rest["observe"] == SENSORS
    task = partial(AbsorptionTask, end=end, impact=speeds, strikers=most, has_sensors=has_sensors)
    env = ComponentEnv(chain, task, **rest)
    start = {"velocity": dict.fromkeys(range(most), speeds[1])}
    refuse_unreachable_deadline(chain, end, speeds[1], "", lambda struck: float(struck.get("velocity")[-2:].max()), start)
    return env
