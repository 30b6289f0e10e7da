"""Closed forms for movable cellular automata; no step calls them. SI units."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError
from ..materials.elastic import Material
from ..support.parameter_fields import MOST
from .laws import Criterion
from .laws.criterion import LinkStress, failure_measure
from .packing import LATTICES

# -- waves ------------------------------------------------------------------------------------------------------------------


def lattice_frequencies(
    packing: str, wave_vector: Any, *, density: float, shear: float, lame: float, diameter: float
) -> npt.NDArray[np.float64]:
    """Return the three angular frequencies of plane waves in an infinite packing, in increasing order, shape (3,) [rad/s].

    For the wave q exp(i k.x) with q = (u_x, u_y, w), w being the rotation, the strains of the pair along N are

        eps = N.u (e - 1) / D,   gamma = T.u (e - 1) / D - w (1 + e) / 2,   e = exp(i D k.N),

    and the energy of a cell is (1/2) q* K q with K = sum over pairs S D G (eps* eps + gamma* gamma) + V lambda theta* theta.

    Args:
        packing: "square" or "hexagonal".
        wave_vector: shape (2,) [rad/m].
        density: [kg/m^3].
        shear: G [Pa].
        lame: lambda [Pa].
        diameter: of the automata [m].
    """
    if packing not in LATTICES:
        raise ParameterError(f"got {packing!r}", expected=f"one of {', '.join(LATTICES)}", at="packing")
    lattice, k = LATTICES[packing], np.asarray(wave_vector, dtype=np.float64)
    face, volume = lattice.face * diameter, lattice.volume * diameter**2
    stiffness, dilation = np.zeros((3, 3), complex), np.zeros(3, complex)
    for nx, ny in lattice.directions:
        phase = np.exp(1j * diameter * (k[0] * nx + k[1] * ny))
        eps = np.array([nx, ny, 0.0]) * (phase - 1.0) / diameter
        gamma = np.array([-ny, nx, 0.0]) * (phase - 1.0) / diameter - np.array([0.0, 0.0, 0.5]) * (1.0 + phase)
        stiffness += face * diameter * shear * (np.outer(eps.conj(), eps) + np.outer(gamma.conj(), gamma))
        dilation += face * diameter / (2.0 * volume) * eps
    stiffness += volume * lame * np.outer(dilation.conj(), dilation)
    mass = density * volume * np.array([1.0, 1.0, diameter**2 / 8.0])
    return np.sqrt(np.maximum(np.linalg.eigvalsh(stiffness / np.sqrt(np.outer(mass, mass))), 0.0))


# -- collisions and strength ---------------------------------------------------------------------------------------------------


def restitution(damping_ratio: float) -> float:
    """Return the ratio of rebound to approach speed for a spring and a dashpot without attraction.

    e = exp(-(pi - 2 a) tan a), sin a = zeta. Schwager & Poeschel (2007), Granular Matter 9, 465, equation 20.

    Args:
        damping_ratio: zeta, from 0 to less than 1; `contact_damping` of a specimen.
    """
    if not 0.0 <= damping_ratio < 1.0:
        raise ValueError(f"damping_ratio: got {damping_ratio:g}, expected at least 0 and less than 1")
    angle = math.asin(damping_ratio)
    return math.exp(-(math.pi - 2.0 * angle) * math.tan(angle))


def uniaxial_strength(
    packing: str, criterion: Criterion, material: Material, *, angle: float = 0.0, compression: bool = False
) -> float:
    """Return the uniaxial stress in plane strain at which the first links of a homogeneous specimen break [Pa].

    With s = +1 or -1 along the load and a the angle between load and link direction, a unit stress produces in the link

        sigma_n = s cos^2 a,        tau = s sin a cos a,        sigma_zz = nu s,
        eps = ((1 - nu^2) cos^2 a - nu (1 + nu) sin^2 a) s / E,        gamma = (1 + nu) tau / E.

    The strength is the reciprocal of the largest ratio of value to limit among the links. For the stress criteria `von_mises`
    and `drucker_prager` it does not depend on the direction.

    Args:
        packing: "square" or "hexagonal".
        criterion: of the links.
        material: of the automata.
        angle: between the load and the x axis [rad].
        compression: whether the load is compressive.

    Returns:
        A positive stress; infinite if no load of this kind breaks a link.
    """
    if packing not in LATTICES:
        raise ParameterError(f"got {packing!r}", expected=f"one of {', '.join(LATTICES)}", at="packing")
    unit, nu = -1.0 if compression else 1.0, material.poisson
    equivalent, mean = math.sqrt(1.0 - nu + nu * nu), unit * (1.0 + nu) / 3.0
    largest, law = 0.0, criterion.constants()
    for x, y in LATTICES[packing].directions:
        # Rounded, so that a link along the load has exactly zero shear.
        along, across = (round(one, 12) for one in _load_components(x, y, angle))
        normal, tangential = unit * along * along, unit * along * across
        eps = (1.0 + nu) * ((1.0 - nu) * along * along - nu * across * across) * unit / material.young
        gamma = (1.0 + nu) * abs(tangential) / material.young
        value, limit, _ = failure_measure(law, LinkStress(eps, gamma, normal, tangential, equivalent, mean, 1.0, 0))
        largest = max(largest, value / limit)
    return 1.0 / largest if largest > 1.0 / MOST else math.inf


def _load_components(x: float, y: float, angle: float) -> tuple[float, float]:
    """Return the components of a direction along and across the load."""
    return x * math.cos(angle) + y * math.sin(angle), y * math.cos(angle) - x * math.sin(angle)


def fracture_toughness(tensile: float, diameter: float) -> float:
    """Return the stress intensity at which a sharp mode-I crack starts, sigma_t sqrt(pi D / 2) [Pa m^(1/2)].

    It is the K for which the mean of K / sqrt(2 pi r) over the face of the first link, 0 < r < D, equals the tensile strength.
    In static lattices (nu from 0 to 0.4), cracks that cut links along x start at 1.02 to 1.08 times this value in a square
    packing and at 0.92 to 0.97 times in a hexagonal one; cracks along y there start at 0.85 to 0.89 times this value.

    Args:
        tensile: sigma_t, traction along a link that breaks it [Pa].
        diameter: D [m].
    """
    return tensile * math.sqrt(0.5 * math.pi * diameter)


def platen_stress(strain: float, pressure: float, young: float, poisson: float) -> float:
    """Return the axial pressure on an elastic specimen compressed in plane strain, E e / (1 - nu^2) + nu / (1 - nu) p [Pa].

    Args:
        strain: e, axial compression, positive.
        pressure: p on the sides [Pa].
        young: E [Pa].
        poisson: nu.
    """
    return young * strain / (1.0 - poisson * poisson) + poisson / (1.0 - poisson) * pressure


def confined_strength(pressure: float, cohesion: float, friction: float) -> float:
    """Return the axial pressure at which pairs of a hexagonal packing slide according to Mohr-Coulomb [Pa].

    The normals of the sliding pairs lie at 60 degrees to the rows. With q along the axis and p on the sides their tractions
    are tau = sqrt(3) / 4 (q - p) and sigma_n = -(p + 3 q) / 4, so that they slide at

        q = (cohesion + (sqrt(3) + friction) / 4 p) / ((sqrt(3) - 3 friction) / 4).

    Args:
        pressure: p [Pa].
        cohesion: shear traction that breaks a pair without pressure [Pa].
        friction: tan(phi), below 1 / sqrt(3); above it, no axial pressure causes sliding.
    """
    axial = _axial_factor(friction)
    return math.inf if axial == 0.0 else (cohesion + 0.25 * (math.sqrt(3.0) + friction) * pressure) / axial


def confining_pressure(strain: float, young: float, poisson: float, friction: float, cohesion: float = 0.0) -> float:
    """Return the smallest pressure on the sides at which the pairs of a specimen at a given axial strain do not slide [Pa].

    At this pressure `platen_stress` equals `confined_strength`; it is 0 if none is needed. Arguments as in these functions.
    """
    axial = _axial_factor(friction)
    needed = platen_stress(strain, 0.0, young, poisson) * axial - cohesion
    return max(needed / (0.25 * (math.sqrt(3.0) + friction) - poisson / (1.0 - poisson) * axial), 0.0)


def _axial_factor(friction: float) -> float:
    return max(0.25 * (math.sqrt(3.0) - 3.0 * friction), 0.0)
