"""Piston-v1: a piston launches the last grain at a wanted speed, at little cost."""

from __future__ import annotations

import copy
from typing import Any, Unpack

import numpy as np

from granular_env.components.chain import Chain
from granular_env.components.chain.differentiable_quantities import input_work
from granular_env.components.chain.layout import GRAINS, SCALARS, U, V
from granular_env.components.support.jit import jit
from granular_env.components.support.validation import finite_number, positive_number
from granular_env.envs.environment import environment_factory

from ..envs.domain_randomization import make_chain
from ..envs.environment import ChainEnv, ChainOptions
from ..envs.task import ChainTask
from .arguments import without_none
from .feasibility import arrived_by

# The last grain has left when it has flown free by this part of its radius.
_FREE_FLIGHT = 0.01


# Counters and constants.
_CLOSENESS, _WORK = range(2)
_TARGET, _PRICE, _ENERGY, _CLEARANCE = range(4)


@jit
def _closeness(a, target):
    return 1.0 - min(abs(a[V, int(a[SCALARS, GRAINS])] / target - 1.0), 1.0)


@jit
def _begin(a, counters, constants):
    """Start the last grain's motion; work done before, in a log that goes on, is not charged."""
    counters[_CLOSENESS], counters[_WORK] = _closeness(a, constants[_TARGET]), input_work(a)


@jit
def _judge(a, inputs, counters, constants, duration, elapsed, steps):
    """Gain in closeness, less the price of this step's work; the end is the last grain's free flight."""
    closeness, work, last = _closeness(a, constants[_TARGET]), input_work(a), int(a[SCALARS, GRAINS])
    reward = closeness - counters[_CLOSENESS] - constants[_PRICE] * (work - counters[_WORK]) / constants[_ENERGY]
    counters[_CLOSENESS], counters[_WORK] = closeness, work
    return reward, a[U, last] - a[U, last - 1] > constants[_CLEARANCE]


class PistonTask(ChainTask):
    """The last grain's speed shall be right when it leaves; the piston's work costs. See `make_piston`.

    Args:
        target_velocity: wanted speed of the last grain [m/s].
        price: what work as great as `energy` costs.
        energy: the work that is charged `price` [J].
        clearance: distance of free flight at which the last grain has left [m].
        velocity_scale: piston velocity at action 1, and velocity observed as 1 [m/s].
        displacement_scale: displacement observed as 1 [m].
    """

    name = "piston"
    counter_names = ("closeness", "work")
    begin_kernel = staticmethod(_begin)
    judge_kernel = staticmethod(_judge)

    def __init__(
        self,
        target_velocity: float,
        price: float,
        energy: float,
        clearance: float,
        velocity_scale: float,
        displacement_scale: float,
    ) -> None:
        self.actions = {"left_velocity": velocity_scale}
        self.observations = {"displacement": displacement_scale, "velocity": velocity_scale}
        self.constants = np.array([target_velocity, price, energy, clearance])


@environment_factory
def make_piston(
    grains: int = 64,
    radius: Any = None,
    material: Any = None,
    *,
    step_size: float = 5e-7,
    target_velocity: float = 5.0,
    work_price: float = 0.2,
    velocity_scale: float = 10.0,
    chain: dict[str, Any] | None = None,
    **options: Unpack[ChainOptions],
) -> ChainEnv:
    """Shape a pulse with a piston so that the last grain of a chain flies off at a wanted speed.

    A row of equal elastic spheres touches a piston at its left end; the right end is free (Nesterenko 1983, section 3.4). What
    the piston does travels through the chain as solitary waves; the grain at the far end leaves at about 1.45 times the
    velocity of the first wave that reaches it.

    ## Action space
    `Box(-1, 1, (1,), float32)`: the piston's velocity over the next control step, in units of `velocity_scale` (10 m/s);
    clipped.

    ## Observation space
    `Box(-10, 10, (2 grains,), float32)`: the displacement of every grain, in mm, then the velocity of every grain, in units of
    `velocity_scale`, clipped to +-10. `info` has both in SI units and float64 ("displacement", "velocity"), with "time" [s],
    "closeness" and "work" [J].

    ## Rewards
    closeness = 1 - min(|v_last / target_velocity - 1|, 1), v_last being the last grain's velocity. A step's reward is its gain
    in closeness, less `work_price` x the piston's work in that step / E, with E = m target_velocity^2 / 2. So the return is the
    closeness at the end less `work_price` x work / E. Doing nothing returns 0; one solitary wave of the right height carries
    1.02 E, and would return 0.8; 2.4 m/s for 18 us returns 0.77.

    ## Start state
    Everything at rest, all grains in touch.

    ## End of the episode
    Terminated when the last grain has flown free, 0.01 radius further than at the start from its neighbour, whatever its speed:
    a forerunner spoils the shot. Truncated after `deadline` control steps.

    ## Arguments
    * `grains` (64), `radius` (3e-3 m), `material` ("steel"): the chain.
    * `step_size` (5e-7 s): internal step. `internal_steps` (3) make a control step; a wave crosses 64 grains in some 450 us.
    * `deadline` (600): control steps, 0.9 ms.
    * `target_velocity` (5.0 m/s), `work_price` (0.2), `velocity_scale` (10.0 m/s).
    * `chain`: further parameters of the chain component, e.g. `{"right": "free", "precompression": 10.0}`.

    ## Version history
    * v1: `hold` and `clock`; `randomise` draws a chain for each episode, from the seed of the reset.
    * v0: first version.
    """
    parameters = {"grains": grains, "radius": radius, "material": material, "step_size": step_size, "left": "piston"}
    component = make_chain({**without_none(parameters), "velocity_scale": velocity_scale}, chain, options.get("randomise"))
    target, price = positive_number("target_velocity", target_velocity), finite_number("work_price", work_price)

    def task(made: Chain) -> PistonTask:
        energy = 0.5 * float(made.geometry.mass[-1]) * target**2
        clearance = _FREE_FLIGHT * float(made.geometry.radius[-1])
        return PistonTask(target, price, energy, clearance, velocity_scale, displacement_scale=1e-3)

    env = ChainEnv(component, task, **{"deadline": 600, **options})
    if env.control_steps:
        push = {"left_velocity": env.task.actions["left_velocity"]}
        driven, steps = copy.deepcopy(env.component), env.control_steps
        arrived_by(driven, push, env.duration, steps, lambda chain: abs(float(chain.get("velocity")[-1])), abs(target))
    return env
