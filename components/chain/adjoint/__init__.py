"""Exact gradients of driven chains: the discrete adjoint of the compositions that integrate them.

A control step is a sequence of drifts and kicks, which are linear in velocities and displacements except for the contact
forces. Their transposes, applied in reverse order, propagate the derivative of a final number to everything that it depends on:
the inputs, the start, and the constants of the chain's table (`layout`). The states of the forward run are recomputed from
one level of checkpoints: memory grows with the square root of the steps (A. Griewank, Optim. Methods Softw. 1 (1992) 35).
"""

from __future__ import annotations

from .gradient import Adjoints, compiled_objective, evaluate_objective, validate_drive, value_and_adjoint, value_and_slopes
from .parameter_gradient import KNOWN, has_computed_mass, parameter_gradient

__all__ = [
    "KNOWN",
    "Adjoints",
    "compiled_objective",
    "validate_drive",
    "evaluate_objective",
    "has_computed_mass",
    "parameter_gradient",
    "value_and_adjoint",
    "value_and_slopes",
]
