"""Reflection of plane waves from dashpots with the impedance of the medium: Lysmer and Kuhlemeyer (1969).

The edge has the tractions sigma_nn = -rho c_p v_n, sigma_nt = -rho c_s v_t. A plane wave at oblique incidence reflects as a P
and an S wave with the same slowness along the edge. Beyond the critical angle of S the reflected P wave is evanescent.
"""

from __future__ import annotations

import cmath
import math

import numpy as np

from ...materials.elastic import Material

Vector = tuple[complex, complex]


def reflected_energy(material: Material, angle: float, *, shear: bool = False) -> float:
    """Return the fraction of a plane wave's energy that dashpots reflect.

    Args:
        material: of the medium.
        angle: of incidence, between the incident wave and the normal of the edge [rad].
        shear: whether the incident wave is an S wave.
    """
    p, s = material.longitudinal_speed, material.shear_speed
    sine, cosine, speed = math.sin(angle), math.cos(angle), s if shear else p
    along = sine / speed
    p_cosine, s_cosine = (cmath.sqrt(1.0 - (along * one) ** 2) for one in (p, s))
    # The waves, by slowness and direction of motion, normal to the edge and along it.
    coming = _excess_traction(material, (cosine / speed, along), (-sine, cosine) if shear else (cosine, sine))
    p_goes = _excess_traction(material, (-p_cosine / p, along), (-p_cosine, along * p))
    s_goes = _excess_traction(material, (-s_cosine / s, along), (along * s, s_cosine))
    amplitudes = np.linalg.solve(np.array([p_goes, s_goes]).T, -np.array(coming))
    # Beyond the critical angle the cosine of the P wave is imaginary, so this wave carries no energy away from the edge.
    energies = abs(amplitudes) ** 2 * (p * p_cosine.real, s * s_cosine.real)
    return float(energies.sum()) / (speed * cosine)


def _excess_traction(material: Material, slowness: Vector, motion: Vector) -> Vector:
    """Return the traction of a wave of unit amplitude minus that of the dashpots, divided by i omega: normal, tangential."""
    (sx, sy), (dx, dy) = slowness, motion
    first, shear = material.first_lame, material.shear_modulus
    normal = first * (sx * dx + sy * dy) + 2.0 * shear * sx * dx - material.density * material.longitudinal_speed * dx
    tangential = shear * (sx * dy + sy * dx) - material.density * material.shear_speed * dy
    return normal, tangential
