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


def platen_stress(strain: float, pressure: float, young: float, poisson: float) -> float:
    """Return the axial pressure on a specimen that is compressed in plane strain, E e / (1 - nu^2) + nu / (1 - nu) p [Pa].

    Args:
        strain: e, axial compression, positive.
        pressure: p on the sides [Pa].
        young: E [Pa].
        poisson: nu.
    """
    return young * strain / (1.0 - poisson * poisson) + poisson / (1.0 - poisson) * pressure


def confined_strength(pressure: float, cohesion: float, friction: float) -> float:
    """Return the axial pressure at which pairs of a hexagonal packing slide by Mohr and Coulomb [Pa].

    The normals of the pairs that slide lie at 60 degrees to the rows. With q along the axis and p on the sides their tractions
    are tau = sqrt(3) / 4 (q - p) and sigma_n = -(p + 3 q) / 4, so that they slide at

        q = (cohesion + (sqrt(3) + friction) / 4 p) / ((sqrt(3) - 3 friction) / 4).

    Args:
        pressure: p [Pa].
        cohesion: shear traction that breaks a pair without pressure [Pa].
        friction: tan(phi), below 1 / sqrt(3): beyond, no axial pressure makes them slide.
    """
    axial = _axial_part(friction)
    return math.inf if axial == 0.0 else (cohesion + 0.25 * (math.sqrt(3.0) + friction) * pressure) / axial


def confining_pressure(strain: float, young: float, poisson: float, friction: float, cohesion: float = 0.0) -> float:
    """Return the pressure on the sides at which a specimen compressed so far just does not slide [Pa].

    That is where `platen_stress` is `confined_strength`; 0 where none is needed. Arguments as there.
    """
    axial = _axial_part(friction)
    needed = platen_stress(strain, 0.0, young, poisson) * axial - cohesion
    return max(needed / (0.25 * (math.sqrt(3.0) + friction) - poisson / (1.0 - poisson) * axial), 0.0)


def _axial_part(friction: float) -> float:
    return max(0.25 * (math.sqrt(3.0) - 3.0 * friction), 0.0)
