from .derivative_check import check_objective
from .finite_differences import Difference, central_differences
from .gradient import value_and_grad
from .objective_terms import (
    Objective,
    Quantity,
    Term,
    contact_force,
    displacement,
    end_input,
    energy,
    kinetic_energy,
    momentum,
    total,
    velocity,
)

__all__ = [
    "Difference",
    "Objective",
    "Quantity",
    "Term",
    "end_input",
    "central_differences",
    "check_objective",
    "contact_force",
    "displacement",
    "energy",
    "kinetic_energy",
    "momentum",
    "total",
    "value_and_grad",
    "velocity",
]
