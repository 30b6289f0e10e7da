"""Collisions of two automata that nothing holds."""

from __future__ import annotations

import math


def restitution(damping_ratio: float) -> float:
    """Return speed of leaving over speed of approach for a spring and a dashpot that do not pull.

    e = exp(-(pi - 2 a) tan a), sin a = zeta. Schwager & Poeschel (2007), Granular Matter 9, 465, equation 20.

    Args:
        damping_ratio: zeta, from 0 up to below 1; `contact_damping` of a specimen.
    """
    if not 0.0 <= damping_ratio < 1.0:
        raise ValueError(f"damping_ratio: got {damping_ratio:g}, expected at least 0 and less than 1")
    angle = math.asin(damping_ratio)
    return math.exp(-(math.pi - 2.0 * angle) * math.tan(angle))
