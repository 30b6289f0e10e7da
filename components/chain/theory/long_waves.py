"""The chain's equations of motion, (2.1) to (2.4), its units, and the soliton of long waves. SI units.

(2.1) is the lattice; (2.2) its anharmonic approximation, valid if overlaps change by much less than their rest value; (2.3)
describes long waves with small changes of strain, (2.4) long waves of any height. The soliton is that of Korteweg and de Vries,
whose equation follows from (2.3) for waves in one direction.

A = k/m [1/(m^0.5 s^2)] for equal grains, a = 2R is their diameter. The paper's c^2 = 2E/(pi rho (1 - nu^2)) is A a^(5/2).
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np

from ...support.float_arrays import FloatArray

# A number or an array of numbers, which broadcast.
Number: TypeAlias = Any


def time_scale(mass: Number, stiffness: Number, speed: Number) -> Number:
    """Return the unit of dimensionless time in (3.1), (A^2 v0)^(-1/5) with A = k/m [s]."""
    return ((stiffness / mass) ** 2 * speed) ** -0.2


def contact_constant(young: Number, poisson: float, density: Number, radius: Number) -> Number:
    """Return A = k/m of equal spheres, (2.1): E sqrt(2R) / (3 (1 - nu^2) m) [1/(m^0.5 s^2)].

    Args:
        young: E [Pa].
        poisson: nu, -1 to 0.5.
        density: [kg/m^3].
        radius: R [m].
    """
    return nesterenko_speed(young, poisson, density) ** 2 / (2.0 * radius) ** 2.5


def nesterenko_speed(young: Number, poisson: float, density: Number) -> Number:
    """Return the paper's c of (2.4), sqrt(2E / (pi rho (1 - nu^2))) [m/s]; it is not a speed of sound."""
    return (2.0 * young / (math.pi * density * (1.0 - poisson**2))) ** 0.5


def contact_speed(constant: Number, diameter: Number) -> Number:
    """Return the paper's c of (2.4) from A: sqrt(A a^(5/2)) [m/s]."""
    return constant**0.5 * diameter**1.25


def sound_speed(constant: Number, diameter: Number, overlap: Number) -> Number:
    """Return c0 of (2.3), the speed of long waves at the static overlap delta0: a sqrt(3/2 A delta0^(1/2)) [m/s].

    With a = 2R it is the paper's c0^2 = 6 A R^2 delta0^(1/2). It vanishes with delta0: an uncompressed chain has no sound.
    """
    return diameter * (1.5 * constant) ** 0.5 * overlap**0.25


def lattice_acceleration(displacement: FloatArray, constant: float, overlap: float) -> FloatArray:
    """Return the right-hand side of (2.1), exact; open contacts have no force.

    Args:
        displacement: u of at least three neighbouring grains from their compressed rest state, shape (n,) [m].
        constant: A = k/m [1/(m^0.5 s^2)].
        overlap: delta0 at rest, may be 0 [m].

    Returns:
        Accelerations of all grains except the first and the last, shape (n - 2,) [m/s^2].
    """
    return -constant * np.diff(np.maximum(-np.diff(displacement) + overlap, 0.0) ** 1.5)


def anharmonic_acceleration(displacement: FloatArray, constant: float, overlap: float) -> FloatArray:
    """Return the right-hand side of (2.2); arguments and result as for (2.1). The error is A delta0^1.5 O(|du|/delta0)^3."""
    u = displacement
    alpha, beta = 1.5 * constant * overlap**0.5, 0.375 * constant * overlap**-0.5
    return (u[2:] - 2.0 * u[1:-1] + u[:-2]) * (alpha + beta * (u[:-2] - u[2:]))


def long_wave_acceleration(derivatives: FloatArray, constant: float, diameter: float, overlap: float) -> FloatArray:
    """Return the right-hand side of (2.3) from (u_x, u_xx, u_xxx, u_xxxx), shape (4,) or (4, n); shape () or (n,) [m/s^2].

    c0^2 = 6 A R^2 delta0^(1/2), gamma = c0 R^2/6, epsilon = c0^2 R/delta0, with 2R = diameter.
    """
    slope, curvature, _, fourth = derivatives
    speed, radius = sound_speed(constant, diameter, overlap), 0.5 * diameter
    dispersion, nonlinearity = speed * radius**2 / 6.0, speed**2 * radius / overlap
    return speed**2 * curvature + 2.0 * speed * dispersion * fourth - nonlinearity * slope * curvature


def nesterenko_acceleration(derivatives: FloatArray, constant: float, diameter: float) -> FloatArray:
    """Return the right-hand side of (2.4) from (u_x, u_xx, u_xxx, u_xxxx), shape (4,) or (4, n); shape () or (n,) [m/s^2].

    u includes the displacement by precompression, so that -u_x is the total strain and must be > 0. Valid for waves much longer
    than a diameter a, of any height: the omitted terms are (a/L)^4 of the first.
    """
    slope, curvature, third, fourth = derivatives
    strain = -slope
    square = diameter**2
    root = strain**0.5
    scale = constant * diameter**2.5
    return scale * (
        1.5 * root * curvature
        + square / 8.0 * (root * fourth - curvature * third / root)
        - square / 64.0 * curvature**3 / (strain * root)
    )


def korteweg_de_vries_speed_ratio(rise: Number) -> Number:
    """Return V/c0 = sqrt(1 + e/6) of the soliton whose strain rises by e times the strain at rest.

    Exact for (2.3). Compared with the closed form of (2.4) it is too fast by 1.0e-6 at e = 0.01, 1.0e-4 at 0.1, 7.1e-3 at 1;
    compared with the wave of the lattice (`lattice_wave`) by 8.3e-7, 8.1e-5, 6.1e-3.
    """
    return (1.0 + rise / 6.0) ** 0.5


def korteweg_de_vries_shape(position: Number, rise: float) -> Number:
    """Return (xi - xi0)/(xi_m - xi0) = sech^2(sqrt(e/2) x/a) of the same soliton, e = `rise`, x = `position` in diameters."""
    rate = (0.5 * rise) ** 0.5
    # In terms of the decaying exponential of -|x|, which cannot overflow.
    decay = np.exp(-np.abs(position) * rate)
    return (2.0 * decay / (1.0 + decay**2)) ** 2
