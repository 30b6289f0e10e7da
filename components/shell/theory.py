"""Exact and classical solutions for thin walls: tubes under pressure, pieces of a ring, travelling loads."""

from __future__ import annotations

import math

# A long elastic tube under inner pressure, of fixed length.
#
# Source: S. P. Timoshenko, J. N. Goodier, Theory of Elasticity (1951), 28; for the critical speed W. M. Beltman,
# J. E. Shepherd, J. Sound Vib. 252 (2002) 617.


def breathing_frequency(young: float, poisson: float, density: float, radius: float) -> float:
    """Return the breathing frequency [Hz] of a thin tube with this mean radius, in plane strain along the tube."""
    return math.sqrt(young / (density * (1.0 - poisson * poisson))) / (2.0 * math.pi * radius)


def lame_displacement(young: float, poisson: float, inner: float, wall: float, pressure: float, radius: float) -> float:
    """Return the radial displacement [m] at a radius, in plane strain."""
    outer = inner + wall
    scale = pressure * inner * inner / (outer * outer - inner * inner)
    return (1.0 + poisson) / young * scale * ((1.0 - 2.0 * poisson) * radius + outer * outer / radius)


def static_hoop_stress(inner: float, wall: float, pressure: float) -> float:
    """Return the mean hoop stress [Pa] of a static pressure."""
    return pressure * inner / wall


def critical_speed(young: float, poisson: float, density: float, radius: float, wall: float) -> float:
    """Return the speed [m/s] at which a load travelling along a thin tube resonates with its flexural waves."""
    squared = young * wall / (density * radius) / math.sqrt(3.0 * (1.0 - poisson * poisson))
    return math.sqrt(squared)


# The number of pieces of an expanding ring, after N. F. Mott.
#
# A fracture sends out a release wave, behind which the ring does not part any more. In a rigid, perfectly plastic ring the wave
# has travelled c sqrt(e) when the strain has grown by e, with c = sqrt(2 Y / rho) / rate. Fractures start at random, k of them
# per length and strain. After e a fraction exp(-4/3 k c e^(3/2)) of the ring is not yet released, and the number of fractures
# per length is
#
#     n = k int_0^inf exp(-4/3 k c e^(3/2)) de = Gamma(5/3) k (4 k c / 3)^(-2/3).
#
# Source: N. F. Mott, Proc. R. Soc. London A 189 (1947) 300; D. Grady, Fragmentation of Rings and Shells (2006), chapter 3.


def mott_fragments(radius: float, rate: float, flow_stress: float, density: float, frequency: float) -> float:
    """Return the mean number of pieces of a ring.

    Args:
        radius: of the ring when it parts [m].
        rate: of the hoop strain [1/s].
        flow_stress: Y [Pa].
        density: [kg/m^3].
        frequency: k, number of fractures that start per length and strain [1/m].
    """
    release = math.sqrt(2.0 * flow_stress / density) / rate
    spacing = (4.0 * frequency * release / 3.0) ** (2.0 / 3.0) / (math.gamma(5.0 / 3.0) * frequency)
    return 2.0 * math.pi * radius / spacing


# A pressure step that travels along a long thin elastic tube without axial force.
#
#     D w'''' + rho h w_tt + E h w / R^2 = p H(v t - x),    D = E h^3 / 12 (1 - nu^2)
#
# In the frame of the front, with w_0 = p R^2 / E h, q = (v / v_c)^2, b^4 = E h / R^2 D and s = b (x - v t):
#
#     w / w_0 = 1 - e^(a s) (cos(c s) + q sin(c s) / sqrt(1 - q^2)) / 2 behind it for v < v_c, 2 a^2 = 1 - q, 2 c^2 = 1 + q,
#     w / w_0 = 1 - (q + r) cos(s sqrt(q - r)) / 2 r behind it for v > v_c, r = sqrt(q^2 - 1).
#
# Long waves follow a fast front, because their energy is slower; short ones precede it. Source: S. C. Tang, J. Eng. Mech. Div.
# ASCE 91 (1965) 97; W. M. Beltman, J. E. Shepherd, J. Sound Vib. 252 (2002) 617.


def front_amplification(ratio: float) -> float:
    """Return the largest radial displacement behind a steady front, over the static one p R^2 / E h.

    Args:
        ratio: speed of the front over the critical one, see `critical_speed`.

    Returns:
        1.03 for a slow front, infinity for a critical one (which never becomes steady), 2 for a fast one.
    """
    square = ratio * ratio
    if square == 1.0:
        return math.inf
    if square > 1.0:
        root = math.sqrt(square * square - 1.0)
        return 1.0 + (square + root) / (2.0 * root)
    decay, turn = math.sqrt(0.5 * (1.0 - square)), math.sqrt(0.5 * (1.0 + square))
    lead = square / math.sqrt(1.0 - square * square)
    # The largest displacement is at the first zero of the slope behind the front.
    s = (math.atan2(decay + turn * lead, turn - decay * lead) - math.pi) / turn
    return 1.0 - 0.5 * math.exp(decay * s) * (math.cos(turn * s) + lead * math.sin(turn * s))
