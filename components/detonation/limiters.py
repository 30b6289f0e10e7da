"""Slope limiters by name: the family minmod(theta a, (a + b) / 2, theta b) of the differences a, b to the two neighbours.

Source: B. van Leer, J. Comput. Phys. 32 (1979) 101, section 3; theta = 2 is his monotonised central difference.
"""

from __future__ import annotations

from typing import Literal

from ..support.jit import internal_inlined

LimiterName = Literal["first_order", "minmod", "monotonized_central"]
# Name of the limiter -> its theta.
LIMITERS: dict[str, float] = {"first_order": 0.0, "minmod": 1.0, "monotonized_central": 2.0}


@internal_inlined
def limited_difference(theta, backward, forward):
    """Return the limited difference over a cell; 0 at an extremum."""
    a, b = abs(backward), abs(forward)
    middle = 0.5 * abs(backward + forward)
    least = theta * a if theta * a < theta * b else theta * b
    least = middle if middle < least else least
    signed = least if backward > 0.0 else -least
    return signed if backward * forward > 0.0 else 0.0
