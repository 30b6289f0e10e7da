"""The theoretical dispersion curves of a precompressed chain of equal or of two alternating grains."""

from __future__ import annotations

import math

import numpy as np

from granular_env.components.chain import Chain
from granular_env.components.chain.theory.dispersion import diatomic_frequencies, monatomic_frequency, tangent_stiffness
from granular_env.components.support.float_arrays import FloatArray

# Largest relative difference of masses and stiffnesses that count as equal.
_EQUAL = 1e-6


def dispersion_curves(chain: Chain, phases: FloatArray) -> dict[str, FloatArray]:
    """Return the frequencies of small waves for each phase difference between neighbouring grains.

    Args:
        chain: a chain; its mass and stiffness must repeat after one or two grains.
        phases: wave number times the distance of neighbours, shape (n,) [rad].

    Returns:
        Name of a branch -> frequencies, shape (n,) [Hz]. It is empty for other chains, without precompression, and for a law
        whose force is not k d^p.
    """
    grains, law, inner = chain.geometry, chain.parameters.law, slice(1, chain.parameters.grains)
    force, stiffness, mass = grains.static_force[inner], grains.stiffness[inner], grains.mass
    is_power = np.allclose(stiffness * grains.static_overlap[inner] ** law.exponent, force, rtol=_EQUAL, atol=0.0)
    if len(mass) < 3 or law.has_history or not is_power or not np.all(force > 0.0):
        return {}
    tangent = tangent_stiffness(stiffness, force, law.exponent)
    if np.ptp(tangent) > _EQUAL * tangent.max() or not np.allclose(mass[2:], mass[:-2], rtol=_EQUAL):
        return {}
    whole, (first, second) = float(tangent[0]), mass[:2].tolist()
    if math.isclose(first, second, rel_tol=_EQUAL):
        return {"theory": monatomic_frequency(phases, whole, first, 1.0) / math.tau}
    # The unit cell has two grains.
    acoustic, optical = diatomic_frequencies(phases, whole, first, second, 2.0)
    return {"theory, acoustic": acoustic / math.tau, "theory, optical": optical / math.tau}
