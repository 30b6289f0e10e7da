"""Protection-v1: deliver an impulse to the wall by the deadline, with a low peak force."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple, Unpack

import numpy as np

from granular_env.components.chain import Chain
from granular_env.components.chain.layout import REST_OVERLAP, STIFFNESS, U
from granular_env.components.chain.objective import Objective
from granular_env.components.support.elementary_functions import exponential, root
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.jit import inlined, jit
from granular_env.components.support.validation import positive_number
from granular_env.envs.environment import ComponentEnv
from granular_env.envs.factory import environment_factory
from granular_env.envs.policies import Constant, Policy

from ..rows import ChainRows
from .driven_end import DrivenEnd, DrivenEndTask, DrivenOptions, hertz_constants, make_driven_end, refuse_unreachable_deadline

# Force [N] or velocity [m/s] at action 1.
_SCALES = {"force": 500.0, "piston": 2.0}
# "theory" drive (`ramped_push`): rise time over the available time; force on the wall over the force of the front, 2^(6/5);
# smallest and largest force tried over the mean force needed, as the logarithms of 1e-3 and 1e6.
_RISE, _SHARE = 0.29, 2.2973967099940698
_LEAST, _MOST = -6.907755278982137, 13.815510557964274
# Indices of the objective's constants: those of `ImpulseTarget`, log2 of the p in the p-norm, and the width r over which the
# positive part is smoothed; see `ProtectionTask.objective`.
_IMPULSE, _PEAK_SCALE, _DURATION, _DOUBLINGS, _ROUNDING = range(5)


class ImpulseTarget(NamedTuple):
    """Constants of the task: target impulse [N s], peak force that costs 1 in reward [N], length of a control step [s]."""

    impulse: float
    peak_scale: float
    duration: float


# -- the smooth objective ----------------------------------------------------------------------------------------------


@jit
def _integer_power(x, constants):
    """Return x^p by repeated squaring."""
    for _ in range(int(constants[_DOUBLINGS])):
        x *= x
    return x


@inlined
def _elastic_force(chain):
    """Return the elastic force at the wall [N] and its derivative with respect to the overlap [N/m]."""
    n = chain.settings.grains
    d = max(chain.rows[U, n] - chain.rows[U, n + 1] + chain.rows[REST_OVERLAP, n], 0.0)
    return chain.rows[STIFFNESS, n] * d * math.sqrt(d), 1.5 * chain.rows[STIFFNESS, n] * math.sqrt(d)


@jit
def _add_to_sums(chain, step, steps, inputs, constants, sums):
    force, _ = _elastic_force(chain)
    # By the trapezoidal rule, the value at the last step counts half.
    part = 0.5 if step == steps - 1 else 1.0
    sums[0] += part * constants[_DURATION] * force / constants[_IMPULSE]
    sums[1] += _integer_power(force / constants[_PEAK_SCALE], constants)


@jit
def _objective_value(sums, constants, slopes):
    missing = 1.0 - sums[0]
    root = math.sqrt(missing * missing + constants[_ROUNDING] * constants[_ROUNDING])
    slopes[0] = -0.5 * (1.0 + missing / root)
    peak, p = sums[1], 1.0
    for _ in range(int(constants[_DOUBLINGS])):
        peak, p = math.sqrt(peak), 2.0 * p
    slopes[1] = peak / (p * sums[1]) if sums[1] > 0.0 else 0.0
    return 0.5 * (missing + root) + peak


@jit
def _pullback(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
    n, (force, tangent) = chain.settings.grains, _elastic_force(chain)
    if force <= 0.0:
        return
    part, ratio = 0.5 if step == steps - 1 else 1.0, force / constants[_PEAK_SCALE]
    slope = slopes[0] * part * constants[_DURATION] / constants[_IMPULSE]
    slope += slopes[1] * 2.0 ** int(constants[_DOUBLINGS]) * _integer_power(ratio, constants) / force
    adjoint.rows[U, n] += slope * tangent
    adjoint.rows[U, n + 1] -= slope * tangent
    adjoint.rows[REST_OVERLAP, n] += slope * tangent
    adjoint.rows[STIFFNESS, n] += slope * force / chain.rows[STIFFNESS, n]


class ProtectionTask(DrivenEndTask):
    """Deliver an impulse to a wall with a low peak force. See `make_protection`.

    Args:
        chain: the driven chain, with a wall at its right end.
        end: the driven left end.
        impulse: target impulse on the wall [N s].
        peak_scale: peak force on the wall that costs 1 in reward [N].
    """

    name = "protection"
    counter_names = ("delivered_impulse", "wall_force", "peak_wall_force")

    def __init__(self, chain: Chain, end: DrivenEnd, impulse: float, peak_scale: float) -> None:
        super().__init__(chain, end)
        self._chain = chain
        self.unit_scales = {"N": end.actions.get("left_force", self.unit_scales["N"])}
        impulse, peak_scale = positive_number("impulse", impulse), positive_number("peak_scale", peak_scale)
        self.constants = ImpulseTarget(impulse, peak_scale, end.duration)

    def begin_rows(self, rows: ChainRows, constants: ImpulseTarget, counters: dict[str, Any]) -> None:
        """Store the force on the wall at the start."""
        counters["wall_force"] = counters["peak_wall_force"] = -rows.right_wall_force

    def evaluate_rows(
        self, rows: ChainRows, constants: ImpulseTarget, counters: dict[str, Any], elapsed: Any
    ) -> tuple[FloatArray, Any]:
        """Return the increase of the delivered fraction minus that of peak / `peak_scale`, and whether all is delivered."""
        before, force = counters["delivered_impulse"], -rows.right_wall_force
        delivered = before + 0.5 * constants.duration * (counters["wall_force"] + force)
        peak = np.maximum(counters["peak_wall_force"], force)
        gain = np.minimum(delivered / constants.impulse, 1.0) - np.minimum(before / constants.impulse, 1.0)
        rewards = gain - (peak - counters["peak_wall_force"]) / constants.peak_scale
        counters.update(delivered_impulse=delivered, wall_force=force, peak_wall_force=peak)
        return rewards, delivered >= constants.impulse

    def objective(self, component: Chain, steps: int, *, sharpness: tuple[int, float] = (5, 0.01)) -> Objective:
        """Return h(1 - delivered / impulse) + smooth peak / peak_scale; all `steps` count, also after full delivery.

        h(x) = (x + sqrt(x^2 + r^2)) / 2 is the smoothed positive part, r = 0.01. The smooth peak is the p-norm of the wall's
        force over the control steps, (sum_t F_t^p)^(1/p), p = 32: up to 1.2 times the peak. Both use the elastic part of the
        force.

        Args:
            component: the driven chain.
            steps: number of control steps.
            sharpness: the pair log2(p), r.

        Raises:
            ParameterError: the contacts are not Hertz contacts.
        """
        hertz_constants(self.name, component)
        text = "smoothed undelivered fraction of the wall's impulse, plus the p-norm of the wall force / peak_scale"
        return Objective(
            _add_to_sums, _objective_value, _pullback, np.array([*self.constants, *sharpness]), count=2, description=text
        )

    def baselines(self) -> Mapping[str, Policy]:
        """Return "nothing", "theory" (`ramped_push`) and the best known drive; without a deadline only "nothing"."""
        if not self.end.steps:
            return {"nothing": Constant(0.0)}
        return self.open_loop_policies(ramped_push(self._chain, self.constants, self.end.steps, next(iter(self.actions))))


def ramped_push(chain: Chain, wanted: ImpulseTarget, steps: int, action: str) -> FloatArray:
    """Return a drive that rises linearly to a force F and delivers the impulse to the wall in time, shape (steps,).

    A front of force F runs at D = (F k^2)^(1/6) / sqrt(m) grains/s (`theory.shock_speed`), and grains in it at F/(m D). A rigid
    wall doubles the contribution of the particle velocity. In a simple wave v ~ overlap^(5/4) and F ~ overlap^(3/2), so that
    the wall force is 2^(6/5) F. With a rise time r = 0.29 T, where T is the available time, F is the smaller root of

        2^(6/5) F (T - n/D(F) - r/2) = impulse.

    If there is no root because T is too short, F maximises the delivered impulse.

    Args:
        chain: the driven chain, with Hertz contacts.
        wanted: target impulse on the wall, and length of a control step.
        steps: number of control steps.
        action: the input, "left_force" or "left_velocity".
    """
    mass, stiffness = float(chain.geometry.mass.mean()), float(chain.geometry.stiffness[1:-1].mean())
    horizon, grains = wanted.duration * steps, len(chain.geometry.mass)
    force = exponential(np.linspace(_LEAST, _MOST, 20_000)) * wanted.impulse / horizon
    speed = root(force * (stiffness * stiffness), 6) / math.sqrt(mass)
    rise = _RISE * horizon
    delivered = _SHARE * force * (horizon - grains / speed - 0.5 * rise)
    enough = np.flatnonzero(delivered >= wanted.impulse)
    chosen = enough[0] if len(enough) else int(np.argmax(delivered))
    level = force[chosen] if action.endswith("force") else force[chosen] / (mass * speed[chosen])
    return level * np.minimum((np.arange(steps) + 0.5) * wanted.duration / rise, 1.0)


def _make_impulse_sum(duration: float) -> Callable[[Chain], float]:
    """Return a function that adds up the impulse on the wall [N s], to be called after each control step of `duration` [s]."""
    total = 0.0

    def add_impulse(chain: Chain) -> float:
        nonlocal total
        total -= duration * float(chain.get("right_wall_force"))
        return total

    return add_impulse


@environment_factory
def make_protection(
    grains: int = 64,
    *,
    impulse: float = 0.05,
    peak_scale: float = 1000.0,
    velocity_scale: float = 10.0,
    **options: Unpack[DrivenOptions],
) -> ComponentEnv:
    r"""Push the left end so that the wall behind the last grain receives an impulse in time, with a low peak force.

    The chain lies against a rigid wall at its right end. A hard push arrives as a train of tall solitary waves. A soft push
    spreads its load but travels slower, so deadline and peak force conflict, as in the design of a shock absorber.

    ## Observation space
    Counters: "delivered_impulse" [N s], "wall_force" and "peak_wall_force" [N].

    ## Rewards
    The reward of a step is its gain in `min(delivered_impulse / impulse, 1)` minus the rise of the peak wall force over
    `peak_scale`. The impulse is the trapezoidal sum of the wall force at the ends of the control steps, and the peak is the
    largest of these values. A constant push of 300 N returns -0.5, one of 50 N returns 0.75, and one of 25 N arrives late
    and returns 0.37.

    ## End of the episode
    Terminated when the impulse is delivered, or at the deadline.

    ## Arguments
    * `impulse` (0.05 N s), `peak_scale` (1000.0 N): see the rewards. `velocity_scale` (10.0 m/s): velocity observed as 1.
    * `action_scale` (None): input at action 1; None means 500 N or 2 m/s. `deadline` may be None: no end, no clock.

    ## Baselines
    "theory" (`ramped_push`) rises linearly over $r = 0.29\,T$ to the force F at which $2^{6/5} F\,(T - n/D(F) - r/2)$
    equals the impulse. T is the available time, D the front speed in grains per second, n the number of grains. A rigid wall
    doubles the particle velocity, and hence multiplies the force by $2^{6/5}$. "best" was found by gradient (study
    `protection-best`): a sharp forerunner, a pause, and a slow rise. The wall force is then nearly constant at 154 N; with
    theory its peak is 208 N. They return 0.792 and 0.846 with a force, 0.784 and 0.841 with a piston.
    """
    further = {"right": "rigid_plane", "velocity_scale": velocity_scale}
    chain, end, rest = make_driven_end(
        make_protection, locals(), scales=_SCALES, parameters=further, allow_endless=True, internal_steps=3, deadline=700
    )
    env = ComponentEnv(chain, partial(ProtectionTask, end=end, impulse=impulse, peak_scale=peak_scale), **rest)
    if end.steps:
        refuse_unreachable_deadline(chain, end, impulse, "N s", _make_impulse_sum(end.duration))
    return env
