"""Fronts of the waves of a short load on the surface of a half-space: P, S, head waves (C) and the Rayleigh wave (R).

Source: J. D. Achenbach, Wave Propagation in Elastic Solids (1973), section 7.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...materials.elastic import Material
from ...support.float_arrays import FloatArray
from .rayleigh import rayleigh_speed

_POINTS = 181
# A Rayleigh wave is drawn down to this part of the way that it has gone: most of it is above.
_DEPTH_OF_RAYLEIGH = 0.25


@dataclass(frozen=True)
class Front:
    """The front of a wave, seen in the plane of x along the surface and y upwards.

    Attributes:
        name: P, S, C (head wave) or R (Rayleigh).
        points: a line through the front, shape (k, 2) [m].
        outward: a point on it, and the direction in which it moves there, shape (2, 2): a place for its name.
    """

    name: str
    points: FloatArray
    outward: FloatArray


def load_fronts(material: Material, time: float, source: float = 0.0) -> tuple[Front, ...]:
    """Return the fronts of an impulse on the surface y = 0; C and R twice, to the left and to the right.

    Args:
        material: of the half-space.
        time: since the impulse [s].
        source: where it acted, along x [m].
    """
    fast, slow = material.longitudinal_speed * time, material.shear_speed * time
    fronts = [_arc("P", fast, 0.25 * math.pi), _arc("S", slow, 0.12 * math.pi)]
    fronts += [
        mirrored for front in (_head(fast, slow), _rayleigh(rayleigh_speed(material) * time)) for mirrored in _both(front)
    ]
    place = np.array([[source, 0.0], [0.0, 0.0]])
    return tuple(Front(one.name, one.points + place[:1], one.outward + place) for one in fronts)


def _arc(name: str, radius: float, angle: float) -> Front:
    """Return a half circle, named at an angle from the depth."""
    angles = np.linspace(-math.pi, 0.0, _POINTS)
    direction = np.array([math.sin(angle), -math.cos(angle)])
    return Front(name, radius * np.stack([np.cos(angles), np.sin(angles)], axis=1), np.array([radius * direction, direction]))


def _head(fast: float, slow: float) -> Front:
    """Return the line from where P meets the surface to the front of S, which it touches at the critical angle."""
    sine = slow / fast
    normal = np.array([sine, -math.sqrt(1.0 - sine * sine)])
    ends = np.array([[fast, 0.0], slow * normal])
    return Front("C", ends, np.array([0.5 * (ends[0] + ends[1]), normal]))


def _rayleigh(reach: float) -> Front:
    ends = np.array([[reach, 0.0], [reach, -_DEPTH_OF_RAYLEIGH * reach]])
    return Front("R", ends, np.array([ends[0], [0.0, 1.0]]))


def _both(front: Front) -> tuple[Front, Front]:
    flip = np.array([-1.0, 1.0])
    return Front(front.name, front.points * flip, front.outward * flip), front
