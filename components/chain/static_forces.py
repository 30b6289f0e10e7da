"""Forces in the contacts of a chain at rest, pressed together and under gravity."""

from __future__ import annotations

import numpy as np

from ..errors import ParameterError
from ..support.float_arrays import FloatArray
from .parameters import ChainParameters


def static_forces(parameters: ChainParameters, mass: FloatArray) -> FloatArray:
    """Force at each place for a contact, the ends included, shape (n + 1,) [N]; 0 where gaps leave the grains unsupported.

    A free end carries `precompression`, and a wall or piston whatever it has to; between two of those the less loaded one
    carries `precompression`.

    Raises:
        ParameterError: gravity would have to be carried by a free end, or pull a contact apart.
    """
    p = parameters
    gaps = p.gap if isinstance(p.gap, list) else [p.gap]
    if p.gravity == 0.0 or any(gap > 0.0 for gap in gaps):
        return np.full(p.grains + 1, p.precompression)
    weight = p.gravity * mass
    # A piston carries its own grain.
    weight[[0] if p.left == "piston" else []] = 0.0
    weight[[-1] if p.right == "piston" else []] = 0.0
    above = np.concatenate(([0.0], np.cumsum(weight)))
    return above + _upstream_force(p, above)


def _upstream_force(p: ChainParameters, above: FloatArray) -> float:
    """Return the force at the left end."""
    total = float(above[-1])
    if p.left == "free" and p.right == "free":
        raise ParameterError(
            f"{p.gravity:g} m/s^2 pulls a chain whose both ends are free, so there is no equilibrium",
            hint="give one end a wall or a piston, or give the grains gaps to let them fall",
            at="gravity",
        )
    if p.left == "free":
        force, end = p.precompression, "right"
    elif p.right == "free":
        force, end = p.precompression - total, "left"
    else:
        return p.precompression + max(0.0, -total)
    lowest = force + float(above.min())
    if lowest < 0.0:
        raise ParameterError(
            f"{p.gravity:g} m/s^2 would pull the grains away from the {end} end with {-lowest:.6g} N, and contacts "
            "carry no tension",
            hint=f"reverse gravity, or give precompression of at least {p.precompression - lowest:.6g} N",
            at="gravity",
        )
    return force
