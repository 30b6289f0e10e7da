"""Small oscillations of a precompressed chain: frequencies and band edges. SI units.

Exact for infinitesimal waves; K = (3/2) k d0^(1/2) is the tangent stiffness of every contact. Wave numbers lie within the first
Brillouin zone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .long_waves import Number


class BandEdges(NamedTuple):
    """Angular frequencies of the band edges [rad/s]: waves propagate up to acoustic, and from optical_low to optical_high."""

    acoustic: float
    optical_low: float
    optical_high: float


def tangent_stiffness(stiffness: Number, force: Number, exponent: float = 1.5) -> Number:
    """Return K = dF/dd = p k^(1/p) F0^(1 - 1/p) of a contact F = k d^p under the static force F0 [N/m]; p = 1.5 for spheres."""
    return exponent * stiffness ** (1.0 / exponent) * force ** (1.0 - 1.0 / exponent)


def monatomic_frequency(wave_number: Number, tangent: float, mass: float, diameter: float) -> Number:
    """Return omega = 2 sqrt(K/m) |sin(kappa a/2)| [rad/s].

    Args:
        wave_number: kappa [rad/m], |kappa| <= pi/a.
        tangent: K [N/m].
        mass: mass of a grain [kg].
        diameter: a, the distance of neighbours [m].
    """
    return monatomic_cutoff_frequency(tangent, mass) * np.abs(np.sin(0.5 * wave_number * diameter))


def monatomic_cutoff_frequency(tangent: float, mass: float) -> float:
    """Return the largest angular frequency of equal grains, 2 sqrt(K/m) [rad/s]; above it waves decay."""
    return 2.0 * (tangent / mass) ** 0.5


def diatomic_frequencies(wave_number: Number, tangent: float, light: float, heavy: float, cell: float) -> tuple[Number, Number]:
    """Return the acoustic and the optical frequency of a chain with two alternating masses [rad/s].

    omega^2 = K (1/m1 + 1/m2) -+ K sqrt((1/m1 + 1/m2)^2 - 4 sin^2(kappa L/2)/(m1 m2)).

    Args:
        wave_number: kappa [rad/m], |kappa| <= pi/L.
        tangent: K [N/m], the same in all contacts.
        light: one mass, either [kg].
        heavy: the other [kg].
        cell: L, the distance between equal grains [m].
    """
    half = 0.5 * wave_number * cell
    # The radicand as (1/m1 - 1/m2)^2 + 4 cos^2/(m1 m2), the acoustic branch as a quotient: small values keep all digits.
    root = ((1.0 / light - 1.0 / heavy) ** 2 + 4.0 * np.cos(half) ** 2 / (light * heavy)) ** 0.5
    high = 1.0 / light + 1.0 / heavy + root
    return 2.0 * np.abs(np.sin(half)) * (tangent / (light * heavy * high)) ** 0.5, (tangent * high) ** 0.5


def diatomic_band_edges(tangent: float, light: float, heavy: float) -> BandEdges:
    """Return sqrt(2K/m_heavy), sqrt(2K/m_light) and sqrt(2K (1/m1 + 1/m2)) [rad/s]; the band gap is between the first two."""
    light, heavy = min(light, heavy), max(light, heavy)
    return BandEdges(
        math.sqrt(2.0 * tangent / heavy),
        math.sqrt(2.0 * tangent / light),
        math.sqrt(2.0 * tangent * (1.0 / light + 1.0 / heavy)),
    )
