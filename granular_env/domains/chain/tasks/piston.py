"""Piston-v1: launch the last grain at a target velocity with a piston, at little work."""

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

# The last grain counts as detached once the gap to its neighbour exceeds this fraction of its radius.
_FREE_FLIGHT = 0.01


class SpeedTarget(NamedTuple):
    """Constants of the task: target velocity [m/s], price of the work `energy` [J], gap that ends the episode [m]."""

    target: float
    price: float
    energy: float
    clearance: float


class PistonTask(RowTask):
    """Launch the last grain at a target velocity, at little work. See `make_piston`.

    Args:
        chain: the driven chain.
        target: target velocity of the last grain [m/s].
        price: cost of an amount of work equal to the kinetic energy of the last grain at this velocity.
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
        """Store closeness and work so far; work done before the episode (if it continues a log) costs nothing."""
        counters.update(closeness=_closeness(rows, constants), work=rows.input_work)

    def evaluate_rows(self, rows: ChainRows, constants: SpeedTarget, counters: dict[str, Any], elapsed: Any) -> tuple[Any, Any]:
        """Return the increase of "closeness" minus the cost of this step's work, and whether the last grain has detached."""
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
    """Drive a chain with a piston so that its last grain leaves at a target velocity, at little work.

    A row of equal elastic spheres touches a piston at its left end; its right end is free (Nesterenko 1983, section 3.4).
    The piston sends solitary waves through the row. The last grain leaves at about 1.45 times the crest velocity of the
    first wave that reaches it.

    ## Observation space
    Counters: "closeness" (see the rewards) and "work" of the piston [J].

    ## Rewards
    `closeness = 1 - min(abs(v / target_velocity - 1), 1)`, where v is the velocity of the last grain. The reward of a step
    is its gain in closeness minus `work_price` times the work of the piston over E, with $E = m v^2 / 2$ at the target
    velocity. The return is therefore the final closeness minus `work_price` times the total work over E. One solitary wave
    of the right height takes 1.02 E and would return 0.8; a push of 2.4 m/s for 18 us returns 0.77.

    ## Start state
    All grains at rest and in contact.

    ## End of the episode
    Terminated when the last grain has separated from its neighbour by 0.01 radius, at any velocity: a small wave that
    arrives first spoils the shot. Truncated after `deadline` control steps.

    ## Arguments
    * `grains` (64), `radius` (3e-3 m), `material` ("steel"), `step_size` (5e-7 s, the internal step): the chain. A wave
      crosses it in some 450 us.
    * `target_velocity` (5.0 m/s), `work_price` (0.2): see the rewards. `velocity_scale` (10.0 m/s): velocity at action 1.
    * `chain`: further parameters of the chain, e.g. `{"precompression": 10.0}`.
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
