"""Gradients of the objective of a driven chain with respect to its drive and parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Protocol

import numpy as np
import numpy.typing as npt

from granular_env.components.chain import Chain
from granular_env.components.chain.adjoint import parameter_gradient, validate_drive, value_and_adjoint
from granular_env.components.chain.objective import Objective
from granular_env.components.errors import ParameterError, one_line
from granular_env.components.support.float_arrays import FloatArray
from granular_env.domains import gradient_domains


def refuse_without_gradients(component: object) -> None:
    """Raise `ParameterError` unless the component is a chain; the message lists the components that have gradients."""
    if not isinstance(component, Chain):
        raise ParameterError(
            f"got {one_line(component)}",
            expected="a Chain",
            hint=f"components with gradients: {gradient_domains()}; for an environment, pass env.unwrapped.component",
            at="chain",
        )


class ObjectiveSource(Protocol):
    """A task, or another object whose method `objective` makes an objective for a chain."""

    objective: Callable[[Chain, int], Objective]
    """objective(chain, steps): the quantity to minimise over an episode of `steps` control steps."""


def value_and_grad(
    objective: Objective | ObjectiveSource,
    chain: Chain,
    drive: npt.ArrayLike,
    *,
    ticks: int,
    with_respect_to: str | Iterable[str] = ("drive",),
) -> tuple[float, dict[str, FloatArray]]:
    """Return the objective of a driven run and its exact derivatives.

    The run starts from the chain's present state; the chain is not changed. The derivatives are those of the discrete run at a
    fixed internal step, up to rounding. They exist for the integrators pefrl and leapfrog and the laws hertz, power, viscous,
    kuwabara_kono and linear.

    Args:
        objective: an `Objective`, or a task with a smooth objective.
        chain: the driven chain.
        drive: inputs at the left and right end, held in each control step, shape (steps, 2); 0 for an end without an input.
        ticks: number of internal steps in a control step.
        with_respect_to: "drive", "radius", "mass", "contact_stiffness", "precompression", "dissipation", "gap", "gravity",
            "velocity" and "displacement" (at the start), one or more of them.

    Returns:
        The objective, and its derivatives by name, each in the shape of its variable: (steps, 2) for the drive, () for a
        parameter given as one number for all grains or contacts, otherwise one number for each.

    Raises:
        ParameterError: an unsupported gradient, a drive of the wrong shape, or an objective that is not a number.
        StepError: the state leaves the range of the physics; the message names the control step.
    """
    refuse_without_gradients(chain)
    if not isinstance(with_respect_to, Iterable):
        raise ParameterError(
            f"got {one_line(with_respect_to)}", expected="names, such as ('drive', 'radius')", at="with_respect_to"
        )
    names = (with_respect_to,) if isinstance(with_respect_to, str) else tuple(with_respect_to)
    held = validate_drive(chain, drive)
    adjoints = value_and_adjoint(chain, held, ticks, make_objective(objective, chain, len(held)))
    return adjoints.value, {name: np.array(parameter_gradient(chain, adjoints, name)) for name in names}


def make_objective(objective: Objective | ObjectiveSource, chain: Chain, steps: int) -> Objective:
    """Return `objective` itself or, if it is a task, its objective for this chain and this number of control steps."""
    if isinstance(objective, Objective):
        return objective
    build = getattr(objective, "objective", None)
    found = build(chain, steps) if callable(build) else None
    if not isinstance(found, Objective):
        raise ParameterError(f"got {one_line(objective)}", expected="an Objective, or a task with an objective", at="objective")
    return found
