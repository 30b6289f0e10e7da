"""A step of pressure that travels along a long thin tube, of an elastic material without axial force.

    D w'''' + rho h w_tt + E h w / R^2 = p H(v t - x),    D = E h^3 / 12 (1 - nu^2)

In the frame of the front, with w_0 = p R^2 / E h, q = (v / v_c)^2, b^4 = E h / R^2 D and s = b (x - v t):

    w / w_0 = 1 - e^(a s) (cos(c s) + q sin(c s) / sqrt(1 - q^2)) / 2 behind it for v < v_c, 2 a^2 = 1 - q, 2 c^2 = 1 + q,
    w / w_0 = 1 - (q + r) cos(s sqrt(q - r)) / 2 r behind it for v > v_c, r = sqrt(q^2 - 1).

Long waves follow a fast front, as their energy is slower; short ones precede it. Source: S. C. Tang, J. Eng. Mech. Div. ASCE 91
(1965) 97; W. M. Beltman, J. E. Shepherd, J. Sound Vib. 252 (2002) 617.
"""

from __future__ import annotations

import math


def front_amplification(ratio: float) -> float:
    """Return the largest radial displacement behind a steady front, over the static one p R^2 / E h.

    Args:
        ratio: speed of the front over the critical one, see `tubes.critical_speed`.

    Returns:
        1.03 for a slow front, infinity for a critical one (which takes for ever to become steady), 2 for a fast one.
    """
    square = ratio * ratio
    if square == 1.0:
        return math.inf
    if square > 1.0:
        root = math.sqrt(square * square - 1.0)
        return 1.0 + (square + root) / (2.0 * root)
    decay, turn = math.sqrt(0.5 * (1.0 - square)), math.sqrt(0.5 * (1.0 + square))
    lead = square / math.sqrt(1.0 - square * square)
    # Where the slope vanishes for the first time behind the front.
    s = (math.atan2(decay + turn * lead, turn - decay * lead) - math.pi) / turn
    return 1.0 - 0.5 * math.exp(decay * s) * (math.cos(turn * s) + lead * math.sin(turn * s))
