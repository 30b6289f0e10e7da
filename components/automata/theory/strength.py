"""Stresses at which a homogeneous specimen breaks or yields."""

from __future__ import annotations

import math


def equivalent_stress(xx: float, yy: float, zz: float, xy: float) -> float:
    """Return von Mises' equivalent stress of a stress without components xz and yz [Pa]."""
    squares = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return math.sqrt(0.5 * squares + 3.0 * xy**2)


def drucker_prager_stress(equivalent: float, mean: float, compressive: float, tensile: float) -> float:
    """Return what breaks a pair when it reaches the compressive strength, ((a + 1) / 2) s_eq + (3 / 2) (a - 1) s_m [Pa].

    Args:
        equivalent: s_eq [Pa].
        mean: s_m, tension positive [Pa].
        compressive: strength in uniaxial compression [Pa].
        tensile: strength in uniaxial tension, a = compressive / tensile [Pa].
    """
    a = compressive / tensile
    return 0.5 * (a + 1.0) * equivalent + 1.5 * (a - 1.0) * mean


def splitting_tension(force: float, radius: float, thickness: float) -> float:
    """Return the tension in the centre of a disc that two opposite point forces press, P / (pi R t) [Pa].

    Hondros (1959), Aust. J. Appl. Sci. 10, 243.

    Args:
        force: P [N].
        radius: R [m].
        thickness: t [m].
    """
    return force / (math.pi * radius * thickness)
