"""Force-v0: hand a wall its impulse in time, and gently."""

from __future__ import annotations

from typing import Any, Unpack

import numpy as np

from ...components.chain.readings import right_wall_force
from ...components.jit import jit
from ...components.profiles import positive_number
from ..chain_environment import ChainEnv, ChainOptions
from ..chain_task import ChainTask
from ..randomising import make_chain

# Counters and constants.
_DELIVERED, _FORCE, _PEAK = range(3)
_IMPULSE, _PEAK_SCALE = range(2)


@jit
def _begin(a, counters, constants):
    """The wall has felt nothing yet but its present load."""
    counters[_FORCE] = counters[_PEAK] = right_wall_force(a)


@jit
def _judge(a, inputs, counters, constants, duration, elapsed, steps):
    """Gain in the delivered part, less the rise of the peak; the end is a full delivery."""
    impulse, force = constants[_IMPULSE], right_wall_force(a)
    delivered = counters[_DELIVERED] + 0.5 * duration * (counters[_FORCE] + force)
    peak = max(counters[_PEAK], force)
    reward = (
        min(delivered / impulse, 1.0)
        - min(counters[_DELIVERED] / impulse, 1.0)
        - (peak - counters[_PEAK]) / constants[_PEAK_SCALE]
    )
    counters[_DELIVERED], counters[_FORCE], counters[_PEAK] = delivered, force, peak
    return reward, delivered >= impulse


class ForceTask(ChainTask):
    """A wall shall receive an impulse; its peak force costs. See `ForceEnv`.

    Args:
        impulse: what the wall shall receive [N s].
        peak_scale: peak force of the wall that costs 1 [N].
        force_scale: force on the first grain at action 1 [N].
        velocity_scale: velocity observed as 1 [m/s].
        displacement_scale: displacement observed as 1 [m].
    """

    name = "force"
    counter_names = ("delivered_impulse", "wall_force", "peak_wall_force")
    begin_kernel = staticmethod(_begin)
    judge_kernel = staticmethod(_judge)

    def __init__(
        self, impulse: float, peak_scale: float, force_scale: float, velocity_scale: float, displacement_scale: float
    ) -> None:
        super().__init__()
        self.actions = {"left_force": force_scale}
        self.observations = {"displacement": displacement_scale, "velocity": velocity_scale}
        self.observed_force = force_scale
        self.constants = np.array([impulse, peak_scale])


class ForceEnv(ChainEnv):
    """Push the first grain of a chain so that the wall behind the last one gets its impulse in time, and gently.

    A row of equal elastic spheres lies against a rigid wall at its right end; a force acts on the first grain. A hard push
    arrives as a train of tall solitary waves, a soft one spreads its load and travels slower: the deadline and the peak force
    pull against each other, as in the design of a shock absorber.

    ## Action space
    `Box(-1, 1, (1,), float32)`: the force on the first grain over the next control step, positive to the right, in units of
    `force_scale` (500 N); clipped. NaN, infinity and wrong shapes raise `ParameterError`. Pulling moves the first grain alone:
    contacts carry no tension.

    ## Observation space
    `Box(-10, 10, (2 grains,), float32)`: the displacement of every grain, in mm, then the velocity of every grain, in units of
    `velocity_scale`, clipped to +-10. `info` has both in SI units and float64 ("displacement", "velocity"), with "time" [s],
    "delivered_impulse" [N s], "wall_force" and "peak_wall_force" [N].

    ## Rewards
    A step's reward is its gain in min(delivered_impulse / impulse, 1), less the rise of the wall's peak force / `peak_scale`.
    So the return is the delivered part of the impulse less peak force / peak_scale. The impulse is the trapezoid sum of the
    wall's force at the ends of the control steps, the peak is the largest of these. Doing nothing returns 0; a constant push of
    300 N delivers all and returns -.5, one of 50 N returns .75, one of 25 N is late and returns .37. A step that would break
    the physics gives -10 and ends the episode.

    ## Start state
    Everything at rest, all grains in touch. `reset(options={"velocity": {0: 5.0}})` starts otherwise.

    ## End of the episode
    Terminated when the impulse is delivered. Truncated after `deadline` control steps.

    ## Arguments
    * `grains` (64), `radius` (3e-3 m), `material` ("steel"): the chain.
    * `step_size` (5e-7 s): internal step. `internal_steps` (3) make a control step; a wave crosses 64 grains in some 450 us.
    * `deadline` (700): control steps, 1.05 ms.
    * `impulse` (.05 N s), `peak_scale` (1000.0 N), `force_scale` (500.0 N), `velocity_scale` (10.0 m/s).
    * `chain`: further parameters of the chain component, e.g. `{"right": "plane", "precompression": 10.0}`.
    * Further: sensors, noise, action rate, control delay, infos, randomisation, `render_mode`: see `ChainEnv`.

    ## Version history
    * v0: first version.
    """

    def __init__(
        self,
        grains: int = 64,
        radius: float = 3e-3,
        material: Any = "steel",
        *,
        step_size: float = 5e-7,
        impulse: float = 0.05,
        peak_scale: float = 1000.0,
        force_scale: float = 500.0,
        velocity_scale: float = 10.0,
        chain: dict[str, Any] | None = None,
        **options: Unpack[ChainOptions],
    ) -> None:
        parameters = {"grains": grains, "radius": radius, "material": material, "step_size": step_size, "right": "rigid_plane"}
        component = make_chain(
            {**parameters, "velocity_scale": velocity_scale}, chain, options.get("randomise"), options.get("index", 0)
        )
        task = ForceTask(
            positive_number("impulse", impulse),
            positive_number("peak_scale", peak_scale),
            force_scale=force_scale,
            velocity_scale=velocity_scale,
            displacement_scale=1e-3,
        )
        super().__init__(component, task, **{"deadline": 700, **options})
