"""An objective of a driven chain: a number that can be differentiated, because it says how it depends on each state.

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
    """A number J of a driven chain, which is to become small: three jitted functions and what they need.

    `chain` is a `ChainState`: its rows are those of `layout.py`, grain i (from 0) in column i + 1, contact j between columns j
    and j + 1. `adjoint` is a `ChainState` too, with the derivative of J by each number in its place: a feature of the velocity
    of column 5 adds to `adjoint.rows[V, 5]`, and one that weighs it with the mass adds to `adjoint.rows[MASS, 5]` too.

    Attributes:
        note: note(chain, step, steps, inputs, constants, sums): after control step `step` (0 to steps - 1) add the features to
            sums, shape (count,). `inputs`, shape (2,), are what was held in that step left and right, 0 where an end has none.
        value: value(sums, constants, slopes) -> J, and dJ/dsums into slopes, shape (count,).
        pullback: pullback(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes): adjoint += sum_k slopes_k
            dfeature_k/dchain, and input_adjoint, shape (2,), += the same for the inputs.
        constants: numbers for all three, shape (any,).
        count: how many features there are.
        smooth: whether the features have derivatives everywhere the state goes.
        description: one line for people.
        grains: how many grains the chain must have; None where its functions suit any.
        fewest_steps: control steps that the run must have at least.
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
        """Bring the constants into the one form that compiled code takes.

        Raises:
            ParameterError: the constants are no numbers, a function is none, or there is no feature.
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

    def fit(self, grains: int, steps: int) -> None:
        """Check that it can judge a run of `steps` control steps of a chain of `grains` grains.

        Raises:
            ParameterError: it cannot: compiled code would read what is not there.
        """
        if self.grains not in (None, grains):
            raise ParameterError(
                f"it is for chains of {self.grains} grains, this one has {grains}",
                hint="build it again",
                at="objective",
            )
        if steps < self.fewest_steps:
            raise ParameterError(f"it looks at control step {self.fewest_steps - 1}, but the drive has {steps}", at="objective")
