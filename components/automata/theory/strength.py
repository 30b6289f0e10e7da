"""Stresses at which a homogeneous specimen breaks or yields, and the toughness of a packing with a crack."""

from __future__ import annotations

import math

from ...errors import ParameterError
from ...materials.elastic import Material
from ...support.parameter_fields import MOST
from ..breaking import Criterion, DruckerPrager, MohrCoulomb, Strain, Unbreakable, VonMises
from ..packing import LATTICES


def uniaxial_strength(
    packing: str, criterion: Criterion, material: Material, *, angle: float = 0.0, compression: bool = False
) -> float:
    """Return the uniaxial stress in plane strain at which the first links of a homogeneous specimen break [Pa].

    With s = +1 or -1 along the load and a the angle between the load and the direction of a link, a unit stress gives the link

        sigma_n = s cos^2 a,        tau = s sin a cos a,        sigma_zz = nu s,
        eps = ((1 - nu^2) cos^2 a - nu (1 + nu) sin^2 a) s / E,        gamma = (1 + nu) tau / E.

    The strength is the reciprocal of the largest ratio of value to limit among the links. It does not depend on the direction
    for criteria of the stress, `von_mises` and `drucker_prager`.

    Args:
        packing: "square" or "hexagonal".
        criterion: of the links.
        material: of the automata.
        angle: of the load to the x axis [rad].
        compression: whether the load presses.

    Returns:
        A positive stress; infinite where no load of this kind breaks a link.
    """
    if packing not in LATTICES:
        raise ParameterError(f"got {packing!r}", expected=f"one of {', '.join(LATTICES)}", at="packing")
    unit, nu = -1.0 if compression else 1.0, material.poisson
    equivalent, mean = equivalent_stress(unit, 0.0, nu * unit, 0.0), unit * (1.0 + nu) / 3.0
    largest = 0.0
    for x, y in LATTICES[packing].directions:
        # Rounded, so that a link along the load has no shear at all.
        along, across = (round(one, 12) for one in _components(x, y, angle))
        normal, tangential = unit * along * along, unit * along * across
        eps = (1.0 + nu) * ((1.0 - nu) * along * along - nu * across * across) * unit / material.young
        gamma = (1.0 + nu) * abs(tangential) / material.young
        match criterion:
            case VonMises():
                ratios = [equivalent / criterion.strength]
            case DruckerPrager():
                tension, pressure = criterion.tensile, criterion.compressive
                ratios = [drucker_prager_stress(equivalent, mean, pressure, tension) / pressure]
            case MohrCoulomb():
                shear = abs(tangential) + criterion.internal_friction * normal
                ratios = [shear / criterion.cohesion, normal / criterion.tensile]
            case Strain():
                ratios = [eps / criterion.tensile, gamma / criterion.shear]
            case Unbreakable():
                ratios = []
            case _:
                raise ParameterError(f"no closed form for {criterion.name!r}", at="criterion")
        largest = max(largest, *ratios)
    return 1.0 / largest if largest > 1.0 / MOST else math.inf


def _components(x: float, y: float, angle: float) -> tuple[float, float]:
    """Return the components of a direction along and across another one."""
    return x * math.cos(angle) + y * math.sin(angle), y * math.cos(angle) - x * math.sin(angle)


def fracture_toughness(tensile: float, diameter: float) -> float:
    """Return the stress intensity at which a sharp crack in mode I starts, sigma_t sqrt(pi D / 2) [Pa m^(1/2)].

    The mean of K / sqrt(2 pi r) over the face of the first link ahead of the tip, 0 < r < D, is its tensile strength. Cracks
    that cut links along x start at 1.02 to 1.08 times this in a square packing and 0.92 to 0.97 times this in a hexagonal one,
    at 0.85 to 0.89 times this along y there (static lattices, nu from 0 to 0.4).

    Args:
        tensile: sigma_t, traction along a link that breaks it [Pa].
        diameter: D [m].
    """
    return tensile * math.sqrt(0.5 * math.pi * diameter)


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
