"""Rayleigh waves along the free surface of a half-space: the ellipse that a point of the surface describes.

Source: J. D. Achenbach, Wave Propagation in Elastic Solids (1973), section 5.11.
"""

from __future__ import annotations

import math

from ...materials.elastic import Material, rayleigh_speed


def rayleigh_ellipse(material: Material) -> float:
    """Return the vertical over the horizontal axis of the ellipse at the surface.

    It is sqrt(q / s), q = sqrt(1 - (c / c_p)^2), s = sqrt(1 - (c / c_s)^2), by (1 + s^2)^2 = 4 q s; the frequency is not in it.
    """
    speed = rayleigh_speed(material)
    q, s = (math.sqrt(1.0 - (speed / body) ** 2) for body in (material.longitudinal_speed, material.shear_speed))
    return math.sqrt(q / s)
