"""Piston-v1: a piston launches the last grain at a wanted speed with little work."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, NamedTuple, Unpack

import numpy as np

from granular_env.components.chain import Chain
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.validation import finite_number, positive_number, whole_number
from granular_env.envs.environment import ComponentEnv
from granular_env.envs.factory import Options, environment_factory
from granular_env.envs.task import RowTask

from ..rows import ChainRows
from .driven_end import DrivenEnd, make_chain, refuse_unreachable_deadline

# The last grain has detached once its gap exceeds this fraction of its radius.
_FREE_FLIGHT = 0.01


class SpeedTarget(NamedTuple):
    """Constants of the task: wanted speed [m/s], price of `energy` [J] of work, distance of free flight at the end [m]."""

    target: float
    price: float
    energy: float
    clearance: float


class PistonTask(RowTask):
    """The last grain's speed shall be right when it leaves; the piston's work costs. See `make_piston`.

    Args:
        chain: the driven chain.
        target: wanted speed of the last grain [m/s].
        price: of as much work as the kinetic energy of the last grain at that speed.
        velocity_scale: piston velocity at action 1, and velocity observed as 1 [m/s].
    """

    name = "piston"
    counter_names = ("closeness", "work")
    unit_scales = {"N": 1000.0}  # noqa: RUF012

    def __init__(self, chain: Chain, target: float, price: float, velocity_scale: float) -> None:
        self.actions = {"left_velocity": velocity_scale}
        self.observations = {"displacement": 1e-3, "velocity": velocity_scale}
        energy = 0.5 * float(chain.geometry.mass[-1]) * target**2
        self.constants = SpeedTarget(target, price, energy, _FREE_FLIGHT * float(chain.geometry.radius[-1]))

    def begin_rows(self, rows: ChainRows, constants: SpeedTarget, counters: dict[str, Any]) -> None:
        """Store the motion of the last grain; work done before the episode (in a continued log) is not charged."""
        counters.update(closeness=_closeness(rows, constants), work=rows.input_work)

    def judge_rows(self, rows: ChainRows, constants: SpeedTarget, counters: dict[str, Any], elapsed: Any) -> tuple[Any, Any]:
        """Return the gain in closeness minus the cost of this step's work; the episode ends when the last grain detaches."""
        closeness, work = _closeness(rows, constants), rows.input_work
        cost = constants.price * (work - counters["work"]) / constants.energy
        rewards = closeness - counters["closeness"] - cost
        counters.update(closeness=closeness, work=work)
        return rewards, rows.displacement[..., -1] - rows.displacement[..., -2] > constants.clearance


def _closeness(rows: ChainRows, constants: SpeedTarget) -> FloatArray:
    return 1.0 - np.minimum(np.abs(rows.velocity[..., -1] / constants.target - 1.0), 1.0)


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
    chain: Mapping[str, Any] | None = None,
    **options: Unpack[Options],
) -> ComponentEnv:
    """Shape a pulse with a piston so that the last grain of a chain flies off at a wanted speed.

    A row of equal elastic spheres touches a piston at its left end; the right end is free (Nesterenko 1983, section 3.4). The
    piston's motion travels through the chain as solitary waves; the grain at the far end leaves at about 1.45 times the
    velocity of the first wave that reaches it.

    ## Action space
    `Box(-1, 1, (1,), float32)`: the piston's velocity over the next control step, in units of `velocity_scale` (10 m/s).

    ## Observation space
    `Box(-10, 10, (2 grains,), float32)`: the displacement of every grain, in mm, then the velocity of every grain, in units of
    `velocity_scale`. The counters are "closeness" and "work" [J].

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
    own = {"grains": grains, "radius": radius, "material": material, "step_size": step_size, "left": "piston"}
    component = make_chain({**own, "velocity_scale": velocity_scale}, chain)
    target, price = positive_number("target_velocity", target_velocity), finite_number("work_price", work_price)
    task = partial(PistonTask, target=target, price=price, velocity_scale=velocity_scale)
    env = ComponentEnv(component, task, **{"deadline": 600, **options})
    if options.get("deadline", 600) is not None:
        end = DrivenEnd(env.task.actions, {}, env.duration, whole_number("deadline", env.deadline), False)
        refuse_unreachable_deadline(component, end, abs(target), "", lambda driven: abs(float(driven.get("velocity")[-1])))
    return env
