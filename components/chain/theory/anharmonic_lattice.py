"""Equations of motion of a pressed chain: the exact lattice (2.1), and its anharmonic approximation (2.2). SI units.

(2.2) is valid while overlaps change by much less than their rest value, |u_(i-1) - u_i| << delta0.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .arguments import FloatArray, above, at_least, sequence


class AnharmonicCoefficients(NamedTuple):
    """alpha [1/s^2] and beta [1/(m s^2)] of (2.2)."""

    alpha: float
    beta: float


def anharmonic_coefficients(constant: float, overlap: float) -> AnharmonicCoefficients:
    """Return those of (2.2): alpha = 3/2 A delta0^(1/2), beta = 3/8 A delta0^(-1/2)."""
    constant, overlap = above("constant", constant, 0.0, "1/(m^0.5 s^2)"), above("overlap", overlap, 0.0, "m")
    return AnharmonicCoefficients(1.5 * constant * overlap**0.5, 0.375 * constant * overlap**-0.5)


def lattice_acceleration(displacement: Any, constant: float, overlap: float) -> FloatArray:
    """Return the right-hand side of (2.1), exact; open contacts pull at nothing.

    Args:
        displacement: u of at least three neighbouring grains from their pressed rest, shape (n,) [m].
        constant: A = k/m [1/(m^0.5 s^2)].
        overlap: delta0 at rest, may be 0 [m].

    Returns:
        Accelerations of all grains but the first and the last, shape (n - 2,) [m/s^2].
    """
    approach = -np.diff(sequence("displacement", displacement, 3)) + at_least("overlap", overlap, 0.0, "m")
    return -above("constant", constant, 0.0, "1/(m^0.5 s^2)") * np.diff(np.maximum(approach, 0.0) ** 1.5)


def anharmonic_acceleration(displacement: Any, constant: float, overlap: float) -> FloatArray:
    """Return the right-hand side of (2.2); arguments and result as for (2.1). The error is A delta0^1.5 O(|du|/delta0)^3."""
    u = sequence("displacement", displacement, 3)
    alpha, beta = anharmonic_coefficients(constant, overlap)
    return (u[2:] - 2.0 * u[1:-1] + u[:-2]) * (alpha + beta * (u[:-2] - u[2:]))
