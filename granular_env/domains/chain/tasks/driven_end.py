"""Common part of the tasks that drive one end of a chain until a deadline: all chain tasks except Piston-v1."""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Mapping
from importlib.resources import files
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from granular_env.components.chain import Chain
from granular_env.components.chain.laws.functions import ENERGY_ROOT
from granular_env.components.chain.laws.law import missing_functions
from granular_env.components.errors import ParameterError, StepError, issue_warning, one_line, spelling_hint
from granular_env.components.support.jit import jit
from granular_env.components.support.validation import positive_number, whole_number
from granular_env.envs.factory import Options, refuse_early_deadline
from granular_env.envs.policies import Constant, OpenLoop, Policy
from granular_env.envs.task import RowTask

# For each `action`: boundary that the driven end needs, its input, and the value of the input at action 1 [N or m/s].
ACTIONS = {"force": ("free", "force", 1000.0), "piston": ("piston", "velocity", 10.0)}
# Values observed as 1 [m, m/s, N]; that of the velocity is also the chain's `velocity_scale`.
_DISPLACEMENT, _VELOCITY, _FORCE = 1e-3, 10.0, 1000.0
CLOCK = 8
# Arguments of an environment that do not change which drive is best.
_SEEN = {"action", "observe", "noise", "info", "clock", "render_mode", "step_error_reward", "action_scale"}
# `refuse_unreachable_deadline` simulates at most this many steps or to the deadline; this part of the target is an arrival.
_LONGEST, _PART = 10_000, 1e-3


class DrivenOptions(Options, total=False):
    """Options of the tasks at a driven end of a chain, in addition to their own arguments and those of `ComponentEnv`.

    ## Action space
    One input at one end, held over the next control step, in units of `action_scale`. With `action="force"` it is the force
    on the end grain, positive to the right. A pull moves this grain only, because contacts carry no tension. With
    `action="piston"` it is the velocity of the end grain.

    ## Start state
    All grains at rest and in contact.

    ## End of the episode
    Terminated at the deadline. A deadline before the first possible arrival is rejected.

    ## Arguments
    * `grains` (64), `radius` (3e-3 m), `material` ("steel"), `step_size` (5e-7 s, the internal step): the chain.
    * `action` ("force"): "force" or "piston". `action_scale` (None): input at action 1; None means 1000 N or 10 m/s.
    * `clock` (8): number of time readings in the observation.
    * `chain`: further parameters of the chain, with Hertz contacts, e.g. `{"precompression": 10.0}`.

    ## Baselines
    `env.unwrapped.task.baselines()` contains "nothing", "theory" and, if all arguments but `action` are the defaults,
    "best", the best known drive.

    ## Observation space
    Displacement and velocity of every grain, then the clock.
    """

    radius: Any
    material: Any
    action: str
    action_scale: float | None
    step_size: float
    chain: Mapping[str, Any] | None


class DrivenEnd(NamedTuple):
    """The driven end of a chain: the inputs, observations and control steps of its environment.

    Attributes:
        actions: name of the input -> its value at action 1 [N or m/s].
        observations: name of an output -> its value observed as 1 [m or m/s].
        duration: length of a control step [s].
        steps: number of control steps until the deadline; 0 for no deadline.
        best: whether the best known drive applies, i.e. all arguments but `action` have their defaults.
    """

    actions: Mapping[str, float]
    observations: Mapping[str, float]
    duration: float
    steps: int
    best: bool


class DrivenEndTask(RowTask):
    """Base of the tasks in which one end of a chain is driven.

    Args:
        chain: the driven chain of this episode.
        end: its driven end.

    Attributes:
        grains: number of grains.
        end: the driven end.
    """

    unit_scales = {"N": _FORCE}  # noqa: RUF012

    def __init__(self, chain: Chain, end: DrivenEnd) -> None:
        self.grains, self.end = chain.parameters.grains, end
        self.actions, self.observations = end.actions, end.observations

    def open_loop_policies(self, theory: npt.NDArray[np.float64]) -> dict[str, Policy]:
        """Return the policies "nothing", "theory" and, if the best drive is known and within the action scale, "best".

        Args:
            theory: input of the policy "theory" in each control step [N or m/s], shape (steps,).
        """
        (name, scale), best = next(iter(self.actions.items())), None
        policies: dict[str, Policy] = {"nothing": Constant(0.0), "theory": OpenLoop(action_means(theory, self.hold) / scale)}
        if self.end.best and self.hold == 1:
            best = np.array(best_drive(self.name, "force" if name.endswith("force") else "piston")["drive"])
        return policies if best is None or np.abs(best).max() > scale else {**policies, "best": OpenLoop(best / scale)}


def best_drive(task: str, action: str) -> dict[str, Any]:
    """Return the best known drive of a task with its default arguments.

    The entry "drive" is the input in each control step; in later steps it is 0. The other entries are "unit", "control_step"
    [s], "return" and "made" (how the drive was found).
    """
    file = files(__name__.rpartition(".")[0]).joinpath("best", f"{task.replace('_', '-')}-{action}.json")
    return json.loads(file.read_text("utf-8"))


def action_means(drive: npt.NDArray[np.float64], hold: int) -> npt.NDArray[np.float64]:
    """Return the mean of a drive over each action, which is held for `hold` control steps, shape (actions,)."""
    if hold == 1:
        return drive
    places = np.arange(0, len(drive), hold)
    return np.add.reduceat(drive, places) / np.diff(np.append(places, len(drive)))


def make_driven_end(
    make: Callable[..., Any],
    arguments: Mapping[str, Any],
    side: str = "left",
    scales: Mapping[str, float] | None = None,
    parameters: Mapping[str, Any] | None = None,
    allow_endless: bool = False,
    **defaults: Any,
) -> tuple[Chain, DrivenEnd, dict[str, Any]]:
    """Return the chain of an environment, its driven end, and the options of the environment.

    Args:
        make: the function that makes the environment.
        arguments: arguments of this function (its local variables on entry).
        side: "left" or "right".
        scales: "force" or "piston" -> force [N] or velocity [m/s] at action 1 if `action_scale` is None.
        parameters: parameters of the chain that the task sets.
        allow_endless: whether there may be no deadline.
        **defaults: options of the environment that differ from those of `ComponentEnv`, and "action" if it is not "force".

    Raises:
        ParameterError: an invalid action, count or argument of the chain.
    """
    usual = {"radius": None, "material": None, "action": "force", "action_scale": None, "step_size": 5e-7, "chain": None}
    options: dict[str, Any] = {**usual, "clock": CLOCK, **defaults, **arguments["options"]}
    radius, material, action, scale, step_size, chain = (options.pop(name) for name in usual)
    if not isinstance(action, str) or action not in ACTIONS:
        raise ParameterError(f"got {one_line(action)}", hint=spelling_hint(str(action), ACTIONS), at="action")
    boundary, quantity, largest = ACTIONS[action]
    scale = (scales or {}).get(action, largest) if scale is None else positive_number("action_scale", scale)
    own = {"grains": arguments["grains"], "radius": radius, "material": material, "step_size": step_size, side: boundary}
    made = make_chain({"velocity_scale": _VELOCITY, **own, **(parameters or {})}, chain)
    duration = whole_number("internal_steps", options["internal_steps"]) * made.step_size
    if allow_endless and options["deadline"] is None:
        options["clock"], steps = arguments["options"].get("clock", 0), 0
    else:
        steps = whole_number("deadline", options["deadline"])
    seen = {"displacement": _DISPLACEMENT, "velocity": made.parameters.velocity_scale or _VELOCITY}
    return (
        made,
        DrivenEnd({f"{side}_{quantity}": scale}, seen, duration, steps, _has_default_arguments(make, arguments)),
        options,
    )


def make_chain(parameters: Mapping[str, Any], overrides: Any) -> Chain:
    """Return a chain with those parameters that are not None; parameters in `overrides` take precedence."""
    return Chain(**{name: one for name, one in parameters.items() if one is not None} | dict(overrides or {}))


def _has_default_arguments(make: Callable[..., Any], arguments: Mapping[str, Any]) -> bool:
    """Return whether all arguments of the function `make` are its defaults, except those named in `_SEEN`."""
    own = {name: one.default for name, one in inspect.signature(make).parameters.items() if name != "options"}
    return set(arguments["options"]) <= _SEEN and all(repr(arguments[name]) == repr(default) for name, default in own.items())


def hertz_constants(task: str, chain: Chain) -> tuple[float, float, float]:
    """Return the mean mass of the grains [kg], and the mean stiffness [N/m^1.5] and rest overlap [m] of the inner contacts.

    Raises:
        ParameterError: the contacts are not Hertz contacts (with or without dissipation), or there are fewer than 2 grains.
    """
    law, geometry = chain.parameters.law, chain.geometry
    if chain.parameters.grains < 2:
        raise ParameterError(f"got {chain.parameters.grains}", expected="at least 2", at="grains", source=f"task {task!r}")
    if missing_functions(type(law), ENERGY_ROOT):
        raise ParameterError(f"got {law.name!r}", expected="Hertz contacts", at="chain.law", source=f"task {task!r}")
    inner = slice(1, chain.parameters.grains)
    # Rest overlaps may differ between contacts (gravity, gaps); their mean is used for all.
    rest = max(float(geometry.rest_overlap[inner].mean()), 0.0)
    return float(geometry.mass.mean()), float(geometry.stiffness[inner].mean()), rest


def refuse_unreachable_deadline(
    chain: Chain,
    end: DrivenEnd,
    target: float,
    unit: str,
    arrived_amount: Callable[[Chain], float],
    start: Mapping[str, Any] | None = None,
) -> None:
    """Refuse a deadline that is too early: even the input at action 1 from the first step on has no effect at the target.

    Args:
        chain: the driven chain; a clone of it is stepped.
        end: inputs at action 1, and number of control steps; the inputs are not applied if `start` is given.
        target: amount (energy, impulse, ...) that the task wants to arrive; if less arrives, a warning is issued.
        unit: unit of this amount for the warning; "" for no warning.
        arrived_amount: called after each control step; returns the amount that has arrived.
        start: start values of the chain, if they and not the inputs make the wave.

    Raises:
        ParameterError: less than a thousandth of `target` arrives by the deadline.
    """
    driven, inputs = chain.clone(), {} if start else end.actions
    driven.reset(**(start or {}))
    most, step = 0.0, 0
    for step in range(1, max(end.steps, _LONGEST) + 1):
        try:
            driven.step(end.duration, **inputs)
        except StepError:  # action 1 takes the state outside the range of the physics, so a wave cannot be too slow
            return
        most = max(most, arrived_amount(driven))
        if most >= target or (step >= end.steps and most > _PART * target):
            break
    drive = " and ".join(f"{name} = {value:g}" for name, value in inputs.items())
    reason = f"{drive} from the first step on is no faster" if drive else "the fastest wave arrives no earlier"
    refuse_early_deadline(end.steps, step, end.duration, reason)
    if most < target and unit:
        issue_warning(
            f"deadline: {end.steps} control steps of {end.duration:g} s are too few: with {drive} from the first step on, only "
            f"{most:.3g} {unit} of the required {target:g} {unit} arrive; give a later deadline, or a larger action_scale"
        )


@jit
def single_sum_value(sums, constants, slopes):
    """Return the value of an objective that is a single sum, and set the derivative with respect to this sum to 1."""
    slopes[0] = 1.0
    return sums[0]


def parse_range(name: str, value: Any) -> tuple[float, float]:
    """Return a range (low, high) after validation; `ParameterError` unless 0 < low <= high."""
    pair = parse_numbers(name, value)
    if len(pair) != 2 or not 0.0 < pair[0] <= pair[1]:
        raise ParameterError(f"got {one_line(value)}", expected="(low, high) with 0 < low <= high", at=name)
    return float(pair[0]), float(pair[1])


def parse_numbers(name: str, value: Any) -> npt.NDArray[np.float64]:
    """Return one or several numbers as an array; `ParameterError` if there is none or one is not finite."""
    try:
        array = np.atleast_1d(np.asarray(value, dtype=np.float64))
    except (TypeError, ValueError):
        array = np.full(1, np.nan)
    if isinstance(value, str) or array.ndim != 1 or not len(array) or not np.all(np.isfinite(array)):
        raise ParameterError(f"got {one_line(value)}", expected="a number or a list of numbers", at=name)
    return array
