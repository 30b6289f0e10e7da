"""Small disturbances of a pressed chain: (2.1) expanded to (2.2), its long waves (2.3), and their soliton (Korteweg-de Vries).

Valid while overlaps change by much less than their rest value, |u_(i-1) - u_i| << delta0; (2.3) also wants waves much longer
than a diameter a. SI units.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...errors import ParameterError
from .arguments import FloatArray, Number, above, at_least, finite, sequence
from .scales import sound_speed


class AnharmonicCoefficients(NamedTuple):
    """alpha [1/s^2] and beta [1/(m s^2)] of (2.2)."""

    alpha: float
    beta: float


class LongWaveCoefficients(NamedTuple):
    """c0 [m/s], gamma [m^3/s] and epsilon [m^2/s^2] of (2.3)."""

    sound_speed: float
    dispersion: float
    nonlinearity: float


def anharmonic_coefficients(constant: float, overlap: float) -> AnharmonicCoefficients:
    """Of (2.2): alpha = 3/2 A delta0^(1/2), beta = 3/8 A delta0^(-1/2)."""
    constant, overlap = above("constant", constant, 0.0, "1/(m^0.5 s^2)"), above("overlap", overlap, 0.0, "m")
    return AnharmonicCoefficients(1.5 * constant * overlap**0.5, 0.375 * constant * overlap**-0.5)


def long_wave_coefficients(constant: float, diameter: float, overlap: float) -> LongWaveCoefficients:
    """Of (2.3): c0^2 = 6 A R^2 delta0^(1/2), gamma = c0 R^2/6, epsilon = c0^2 R/delta0, with 2R = diameter."""
    speed, radius = sound_speed(constant, diameter, overlap), 0.5 * diameter
    return LongWaveCoefficients(speed, speed * radius**2 / 6.0, speed**2 * radius / overlap)


def lattice_acceleration(displacement: Any, constant: float, overlap: float) -> FloatArray:
    """The right-hand side of (2.1), exact; open contacts pull at nothing.

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
    """The right-hand side of (2.2); arguments and result as for (2.1). The error is A delta0^1.5 O(|du|/delta0)^3."""
    u = sequence("displacement", displacement, 3)
    alpha, beta = anharmonic_coefficients(constant, overlap)
    return (u[2:] - 2.0 * u[1:-1] + u[:-2]) * (alpha + beta * (u[:-2] - u[2:]))


def korteweg_de_vries_speed_ratio(rise: Number) -> Number:
    """V/c0 = sqrt(1 + e/6) of the soliton whose strain rises by e times the strain at rest.

    Exact for (2.3). Against the closed form of (2.4) it is fast by 1.0e-6 at e = .01, 1.0e-4 at .1, 7.1e-3 at 1.
    """
    return (1.0 + above("rise", rise, 0.0) / 6.0) ** 0.5


def korteweg_de_vries_shape(position: Number, rise: float) -> Number:
    """(xi - xi0)/(xi_m - xi0) = sech^2(sqrt(e/2) x/a) of that soliton, `position` x in diameters."""
    rate = (0.5 * above("rise", rise, 0.0)) ** 0.5
    # Twice the exponential of -|x|: no overflow far away.
    decay = np.exp(-np.abs(finite("position", position)) * rate)
    return (2.0 * decay / (1.0 + decay**2)) ** 2


def korteweg_de_vries_width(rise: Number) -> Number:
    """Full width at half height of that soliton, 2 arcosh(sqrt 2) sqrt(2/e), in diameters."""
    return 2.0 * float(np.arccosh(2.0**0.5)) * (2.0 / above("rise", rise, 0.0)) ** 0.5


def long_wave_acceleration(displacement_derivatives: Any, constant: float, diameter: float, overlap: float) -> FloatArray:
    """The right-hand side of (2.3) from (u_x, u_xx, u_xxx, u_xxxx), shape (4,) or (4, n); shape () or (n,) [m/s^2]."""
    slope, curvature, _, fourth = _four(displacement_derivatives)
    speed, dispersion, nonlinearity = long_wave_coefficients(constant, diameter, overlap)
    return speed**2 * curvature + 2.0 * speed * dispersion * fourth - nonlinearity * slope * curvature


def nesterenko_acceleration(displacement_derivatives: Any, constant: float, diameter: float) -> FloatArray:
    """The right-hand side of (2.4) from (u_x, u_xx, u_xxx, u_xxxx), shape (4,) or (4, n); shape () or (n,) [m/s^2].

    u includes the displacement that presses the chain, so that -u_x is the whole strain and has to be > 0. Valid for waves much
    longer than a diameter a, whatever their height: the terms left out are (a/L)^4 of the first.
    """
    slope, curvature, third, fourth = _four(displacement_derivatives)
    strain = above("displacement_derivatives: the strain -u_x", -slope, 0.0)
    square = above("diameter", diameter, 0.0, "m") ** 2
    root = strain**0.5
    scale = above("constant", constant, 0.0, "1/(m^0.5 s^2)") * diameter**2.5
    return scale * (
        1.5 * root * curvature
        + square / 8.0 * (root * fourth - curvature * third / root)
        - square / 64.0 * curvature**3 / (strain * root)
    )


def _four(derivatives: Any) -> FloatArray:
    array = np.asarray(finite("displacement_derivatives", derivatives))
    if array.ndim < 1 or len(array) != 4:
        raise ParameterError(f"displacement_derivatives: got shape {array.shape}, expected 4 rows: u_x, u_xx, u_xxx, u_xxxx")
    return array
