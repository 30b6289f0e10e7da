"""Wave fronts of a short load on the surface of a half-space: P, S, head waves (C) and the Rayleigh wave (R).

Source: J. D. Achenbach, Wave Propagation in Elastic Solids (1973), section 7.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...materials.elastic import Material, rayleigh_speed
from ...support.float_arrays import FloatArray

_POINTS = 181
# Depth to which a Rayleigh front is drawn, as a fraction of the distance travelled; most of the wave lies above it.
_DEPTH_OF_RAYLEIGH = 0.25


@dataclass(frozen=True)
class Front:
    """A wave front in the plane of x, along the surface, and y, upwards.

    Attributes:
        name: P, S, C (head wave) or R (Rayleigh).
        points: polyline along the front, shape (k, 2) [m].
        outward: a point of the front and the direction of propagation there, for its label, shape (2, 2).
    """

    name: str
    points: FloatArray
    outward: FloatArray


def load_fronts(material: Material, time: float, source: float = 0.0) -> tuple[Front, ...]:
    """Return the wave fronts of an impulse on the surface y = 0; C and R appear twice, to the left and to the right.

    Args:
        material: of the half-space.
        time: since the impulse [s].
        source: position of the impulse along x [m].
    """
    fast, slow, reach = (
        speed * time for speed in (material.longitudinal_speed, material.shear_speed, rayleigh_speed(material))
    )
    angles = np.linspace(-math.pi, 0.0, _POINTS)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    p_way, s_way = (np.array([math.sin(angle), -math.cos(angle)]) for angle in (0.25 * math.pi, 0.12 * math.pi))
    found = [("P", fast * circle, fast * p_way, p_way), ("S", slow * circle, slow * s_way, s_way)]
    # The head wave extends from the P front at the surface to the S front, which it touches at the critical angle.
    normal = np.array([slow / fast, -math.sqrt(1.0 - (slow / fast) ** 2)])
    head = np.array([[fast, 0.0], slow * normal])
    rayleigh = np.array([[reach, 0.0], [reach, -_DEPTH_OF_RAYLEIGH * reach]])
    for name, line, place, way in (("C", head, head.mean(axis=0), normal), ("R", rayleigh, rayleigh[0], np.array([0.0, 1.0]))):
        found += [(name, line * side, place * side, way * side) for side in (np.array([-1.0, 1.0]), np.array([1.0, 1.0]))]
    origin = np.array([source, 0.0])
    return tuple(Front(name, line + origin, np.array([place + origin, way])) for name, line, place, way in found)
