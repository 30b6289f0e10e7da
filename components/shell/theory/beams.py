"""Vibrations of a slender beam that is clamped at one end, by Euler and Bernoulli, and of a bar along itself.

Valid where the length is more than ten thicknesses. Source: S. P. Timoshenko, Vibration Problems in Engineering (1937), 34, 53.
"""

from __future__ import annotations

import math

import numpy as np

from ...support.float_arrays import FloatArray

# The first root of cos(k) cosh(k) = -1.
_FIRST_ROOT = 1.8751040687119612


def cantilever_frequency(young: float, density: float, length: float, thickness: float) -> float:
    """Return the first frequency of bending [Hz] of a clamped strip of rectangular cross-section."""
    wave_number = _FIRST_ROOT / length
    return wave_number**2 * math.sqrt(young * thickness**2 / (12.0 * density)) / (2.0 * math.pi)


def cantilever_shape(x: FloatArray, length: float) -> FloatArray:
    """Return the shape of that mode, 0 at the clamped end and 1 at the free one."""
    k = _FIRST_ROOT
    share = (math.cosh(k) + math.cos(k)) / (math.sinh(k) + math.sin(k))
    s = k * x / length
    return 0.5 * (np.cosh(s) - np.cos(s) - share * (np.sinh(s) - np.sin(s)))


def clamped_bar_frequency(young: float, density: float, length: float) -> float:
    """Return the first frequency [Hz] of a bar along itself, clamped at one end."""
    return math.sqrt(young / density) / (4.0 * length)
