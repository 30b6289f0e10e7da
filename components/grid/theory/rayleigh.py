"""Rayleigh waves along the free surface of a half-space: their speed, and the ellipse that a point of the surface describes.

Source: J. D. Achenbach, Wave Propagation in Elastic Solids (1973), section 5.11.
"""

from __future__ import annotations

import math

from ...materials.elastic import Material


def rayleigh_speed(material: Material) -> float:
    """Return the speed of Rayleigh waves [m/s]: (2 - x)^2 = 4 sqrt((1 - x)(1 - k x)), x = (c / c_s)^2, k = (c_s / c_p)^2.

    Source: J. D. Achenbach, Wave Propagation in Elastic Solids (1973), equation (5.95).
    """
    k = (material.shear_speed / material.longitudinal_speed) ** 2
    low, high = 0.1, 1.0
    # The difference is negative below the root, x = 0 apart, and positive up to 1.
    for _ in range(200):
        middle = 0.5 * (low + high)
        difference = (2.0 - middle) ** 2 - 4.0 * math.sqrt((1.0 - middle) * (1.0 - k * middle))
        low, high = (middle, high) if difference < 0.0 else (low, middle)
    return math.sqrt(low) * material.shear_speed


def rayleigh_ellipse(material: Material) -> float:
    """Return the vertical over the horizontal axis of the ellipse at the surface.

    It is sqrt(q / s), q = sqrt(1 - (c / c_p)^2), s = sqrt(1 - (c / c_s)^2), by (1 + s^2)^2 = 4 q s; the frequency is not in it.
    """
    speed = rayleigh_speed(material)
    q, s = (math.sqrt(1.0 - (speed / body) ** 2) for body in (material.longitudinal_speed, material.shear_speed))
    return math.sqrt(q / s)
