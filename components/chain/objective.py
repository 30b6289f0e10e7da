"""An objective of a driven chain: a number with its derivatives with respect to each state of the run.

J = value(sums), sums_k = the sum over control steps of feature_k(state after that step). Peaks, time averages and terminal
costs all have this form, and the slopes of all features are known before the backward sweep begins.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..errors import ParameterError, one_line
from ..support.float_arrays import FloatArray
from ..support.validation import whole_number


@dataclass(frozen=True, eq=False)
class Objective:
    """A scalar objective J of a driven chain, to be minimised: three jitted functions and their constants.

    `chain` is a `ChainState` with the rows of `layout.py`; grain i (from 0) has column i + 1, contact j lies between columns j
    and j + 1. `adjoint` is a `ChainState` with the derivatives of J with respect to `chain`. A feature of the velocity
    of column 5 adds to `adjoint.rows[V, 5]`; if weighted by the mass, it also adds to `adjoint.rows[MASS, 5]`.

    Attributes:
        note: note(chain, step, steps, inputs, constants, sums): after control step `step` (0 to steps - 1) add the features to
            sums, shape (count,). `inputs`, shape (2,), are the inputs held in that step, left and right (0 without one).
        value: value(sums, constants, slopes) -> J, and dJ/dsums into slopes, shape (count,).
        pullback: pullback(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes): adjoint += sum_k slopes_k
            dfeature_k/dchain, and input_adjoint, shape (2,), += the same for the inputs.
        constants: numbers passed to all three functions, a vector.
        count: number of features.
        smooth: whether the features are differentiable at every state that can occur.
        description: one line of text for users.
        grains: required number of grains; None if the functions accept any number.
        fewest_steps: smallest number of control steps of a run.
    """

    note: Callable[..., Any]
    value: Callable[..., Any]
    pullback: Callable[..., Any]
    constants: FloatArray = field(default_factory=lambda: np.zeros(1))
    count: int = 1
    smooth: bool = True
    description: str = ""
    grains: int | None = None
    fewest_steps: int = 1

    def __post_init__(self) -> None:
        """Convert the constants to the form that compiled code requires.

        Raises:
            ParameterError: the constants are not numbers, a function is not callable, or there is no feature.
        """
        try:
            constants = np.ascontiguousarray(self.constants, dtype=np.float64).reshape(-1)
        except (TypeError, ValueError):
            raise ParameterError(
                f"got {one_line(self.constants)}", expected="an array of numbers", at="objective.constants"
            ) from None
        object.__setattr__(self, "constants", constants)
        for name in ("note", "value", "pullback"):
            if not callable(getattr(self, name)):
                raise ParameterError(
                    f"got {one_line(getattr(self, name))}", expected="a jitted function", at=f"objective.{name}"
                )
        whole_number("objective.count", self.count)

    def require_grain_count(self, grains: int, steps: int) -> None:
        """Check that the objective can evaluate a run of `steps` control steps of a chain of `grains` grains.

        Raises:
            ParameterError: it cannot, because compiled code would read out of bounds.
        """
        if self.grains not in (None, grains):
            raise ParameterError(
                f"it requires a chain of {self.grains} grains, but this chain has {grains}",
                hint="build it again for this chain",
                at="objective",
            )
        if steps < self.fewest_steps:
            text = f"the objective reads control step {self.fewest_steps - 1}, but the drive has {steps} steps, counted from 0"
            raise ParameterError(text, hint="give a longer drive", at="objective")
