"""The number of pieces of an expanding ring, after N. F. Mott.

Where the ring has parted, a release runs away from the fracture, and behind it nothing parts any more. In a rigid, perfectly
plastic ring it has come c sqrt(e) far when the strain has grown by e, with c = sqrt(2 Y / rho) / rate. Fractures begin at
random, k of them per length and strain, so that after e a part exp(-4/3 k c e^(3/2)) of the ring is not released yet, and their
number per length is

    n = k int_0^inf exp(-4/3 k c e^(3/2)) de = Gamma(5/3) k (4 k c / 3)^(-2/3).

Source: N. F. Mott, Proc. R. Soc. London A 189 (1947) 300; D. Grady, Fragmentation of Rings and Shells (2006), chapter 3.
"""

from __future__ import annotations

import math


def mott_fragments(radius: float, rate: float, flow_stress: float, density: float, frequency: float) -> float:
    """Return the mean number of pieces of a ring.

    Args:
        radius: when it parts [m].
        rate: of the hoop strain [1/s].
        flow_stress: Y [Pa].
        density: [kg/m^3].
        frequency: k, of the fractures that begin per length and strain [1/m].
    """
    release = math.sqrt(2.0 * flow_stress / density) / rate
    spacing = (4.0 * frequency * release / 3.0) ** (2.0 / 3.0) / (math.gamma(5.0 / 3.0) * frequency)
    return 2.0 * math.pi * radius / spacing
