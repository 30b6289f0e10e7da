"""Small oscillations of a pressed chain: frequencies, speeds and band edges. SI units.

Exact for infinitely small waves, K = (3/2) k d0^(1/2) the tangent stiffness of every contact. Wave numbers lie within the first
zone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...errors import ParameterError
from .arguments import Number, above, at_least, finite


class BandEdges(NamedTuple):
    """Angular frequencies between which waves travel: up to the first, and from the second to the third [rad/s]."""

    acoustic: float
    optical_low: float
    optical_high: float


def tangent_stiffness(stiffness: Number, force: Number, exponent: float = 1.5) -> Number:
    """Return K = dF/dd = p k^(1/p) F0^(1 - 1/p) of a contact F = k d^p under the static force F0 [N/m]; p = 1.5 for spheres."""
    stiffness, force = above("stiffness", stiffness, 0.0, "N/m^p"), above("force", force, 0.0, "N")
    return exponent * stiffness ** (1.0 / exponent) * force ** (1.0 - 1.0 / exponent)


def monatomic_frequency(wave_number: Number, tangent: float, mass: float, diameter: float) -> Number:
    """Omega = 2 sqrt(K/m) |sin(kappa a/2)| [rad/s].

    Args:
        wave_number: kappa [rad/m], |kappa| <= pi/a.
        tangent: K [N/m].
        mass: [kg].
        diameter: a, the distance of neighbours [m].
    """
    phase = _phase(wave_number, diameter)
    return monatomic_edge(tangent, mass) * np.abs(np.sin(0.5 * phase))


def monatomic_edge(tangent: float, mass: float) -> float:
    """Return the largest angular frequency of equal grains, 2 sqrt(K/m) [rad/s]; above it waves decay."""
    return 2.0 * (above("tangent", tangent, 0.0, "N/m") / above("mass", mass, 0.0, "kg")) ** 0.5


def monatomic_phase_speed(wave_number: Number, tangent: float, mass: float, diameter: float) -> Number:
    """omega/kappa [m/s]; c0 = a sqrt(K/m) at kappa = 0."""
    phase = _phase(wave_number, diameter)
    return 0.5 * diameter * monatomic_edge(tangent, mass) * np.sinc(0.5 * phase / np.pi)


def monatomic_group_speed(wave_number: Number, tangent: float, mass: float, diameter: float) -> Number:
    """|d omega/d kappa| = a sqrt(K/m) cos(kappa a/2) [m/s]; 0 at the edge of the band."""
    phase = _phase(wave_number, diameter)
    return 0.5 * diameter * monatomic_edge(tangent, mass) * np.cos(0.5 * phase)


def long_wave_frequency(wave_number: Number, sound_speed: float, diameter: float) -> Number:
    """Return c0 kappa sqrt(1 - (kappa a)^2/12) [rad/s] for long waves: of (2.3), and of (2.4) about a state at rest."""
    phase = np.abs(finite("wave_number", wave_number)) * above("diameter", diameter, 0.0, "m")
    at_least("wave_number: 12 - (wave_number x diameter)^2", 12.0 - phase**2, 0.0)
    return above("sound_speed", sound_speed, 0.0, "m/s") / diameter * phase * (1.0 - phase**2 / 12.0) ** 0.5


def diatomic_frequencies(wave_number: Number, tangent: float, light: float, heavy: float, cell: float) -> tuple[Number, Number]:
    """Both branches, acoustic and optical, of a chain of two masses in turn [rad/s].

    omega^2 = K (1/m1 + 1/m2) -+ K sqrt((1/m1 + 1/m2)^2 - 4 sin^2(kappa L/2)/(m1 m2)).

    Args:
        wave_number: kappa [rad/m], |kappa| <= pi/L.
        tangent: K [N/m], the same in all contacts.
        light: one mass, either [kg].
        heavy: the other [kg].
        cell: L, the distance between equal grains [m].
    """
    tangent, light, heavy = _diatomic(tangent, light, heavy)
    half = 0.5 * _phase(wave_number, cell, "cell")
    # As (1/m1 - 1/m2)^2 + 4 cos^2/(m1 m2), and the acoustic branch as a quotient: neither loses digits where it is small.
    root = ((1.0 / light - 1.0 / heavy) ** 2 + 4.0 * np.cos(half) ** 2 / (light * heavy)) ** 0.5
    high = 1.0 / light + 1.0 / heavy + root
    return 2.0 * np.abs(np.sin(half)) * (tangent / (light * heavy * high)) ** 0.5, (tangent * high) ** 0.5


def diatomic_group_speeds(
    wave_number: Number, tangent: float, light: float, heavy: float, cell: float
) -> tuple[Number, Number]:
    """|d omega/d kappa| of both branches [m/s]; for unlike masses and kappa not 0 (there `diatomic_sound_speed`, and 0)."""
    acoustic, optical = diatomic_frequencies(wave_number, tangent, light, heavy, cell)
    if light == heavy:
        raise ParameterError(
            "got the same mass as light", hint="expected unlike masses, or take monatomic_group_speed", at="heavy"
        )
    above("wave_number: its magnitude", np.abs(wave_number), 0.0, "rad/m")
    # d(omega^2)/d kappa = -+ K/2 (-product')/root.
    slope = tangent * cell * np.abs(np.sin(_phase(wave_number, cell, "cell"))) / (light * heavy)
    root = (optical**2 - acoustic**2) / (2.0 * tangent)
    return slope / (2.0 * acoustic * root), slope / (2.0 * optical * root)


def diatomic_sound_speed(tangent: float, light: float, heavy: float, cell: float) -> float:
    """Return the speed of long waves: L sqrt(K / (2 (m1 + m2))) [m/s]."""
    tangent, light, heavy = _diatomic(tangent, light, heavy)
    return above("cell", cell, 0.0, "m") * (tangent / (2.0 * (light + heavy))) ** 0.5


def diatomic_edges(tangent: float, light: float, heavy: float) -> BandEdges:
    """sqrt(2K/m_heavy), sqrt(2K/m_light), sqrt(2K (1/m1 + 1/m2)) [rad/s]; between the first two lies the gap."""
    tangent, light, heavy = _diatomic(tangent, light, heavy)
    light, heavy = min(light, heavy), max(light, heavy)
    return BandEdges(
        math.sqrt(2.0 * tangent / heavy),
        math.sqrt(2.0 * tangent / light),
        math.sqrt(2.0 * tangent * (1.0 / light + 1.0 / heavy)),
    )


def _diatomic(tangent: float, light: float, heavy: float) -> tuple[float, float, float]:
    return above("tangent", tangent, 0.0, "N/m"), above("light", light, 0.0, "kg"), above("heavy", heavy, 0.0, "kg")


def _phase(wave_number: Number, length: float, name: str = "diameter") -> Number:
    """Kappa a, within the first zone."""
    phase = finite("wave_number", wave_number) * above(name, length, 0.0, "m")
    at_least(f"wave_number: pi - |wave_number x {name}|", np.pi - np.abs(phase), -1e-9)
    return phase
