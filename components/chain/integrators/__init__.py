"""Integrators of the chain by name, with their coefficients, costs and memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from . import compositions, hamming, runge_kutta
from .compositions import Composition, DampedComposition
from .scheme import UNSOUND, EntryPoints, make_entry_points

__all__ = ["SCHEMES", "UNSOUND", "Composition", "DampedComposition", "EntryPoints", "Scheme", "make_entry_points"]


@dataclass(frozen=True)
class Scheme:
    """An integrator with its properties.

    Attributes:
        numbers: coefficients, a tuple for whose class `advance_tick` is registered.
        damped: coefficients for contacts with dissipation.
        evaluations: force evaluations per step.
        history_rows: rows of state in addition to displacement, velocity and peak.
        scratch_rows: rows of the table for intermediate results of a step.
        step_factor: step for the default accuracy, divided by the step that PEFRL needs for it.
        pressed_angle: largest product of step and highest angular frequency of the lattice under a static load [rad].
        minimum_evaluations: force evaluations during one contact for a relative velocity error of about 1e-3.
    """

    numbers: Any
    damped: Any
    evaluations: int
    history_rows: int = 0
    scratch_rows: int = 0
    step_factor: float = 1.0
    pressed_angle: float = 0.5
    minimum_evaluations: float = 60.0

    @property
    def is_explicit(self) -> bool:
        """Return whether dissipation is treated explicitly, like any other force; strong dissipation is then unstable."""
        return not isinstance(self.numbers, Composition)


SCHEMES = {
    "pefrl": Scheme(compositions.PEFRL, compositions.DAMPED_PEFRL, 4),
    # Because it is of second order, leapfrog needs an eighth of the step of the other schemes for the same error.
    "leapfrog": Scheme(
        compositions.LEAPFROG,
        compositions.DAMPED_LEAPFROG,
        1,
        step_factor=0.125,
        pressed_angle=0.0625,
        minimum_evaluations=120.0,
    ),
    "rk4": Scheme(runge_kutta.RK4, runge_kutta.RK4, 4, scratch_rows=runge_kutta.SCRATCH_ROWS, pressed_angle=0.2),
    "hamming": Scheme(
        hamming.HAMMING,
        hamming.HAMMING,
        2,
        hamming.HISTORY_ROWS,
        hamming.SCRATCH_ROWS,
        pressed_angle=0.2,
        minimum_evaluations=30.0,
    ),
}
