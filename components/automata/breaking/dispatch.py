"""The criterion of a run, chosen by its number: the one place that knows them all."""

from __future__ import annotations

import numpy as np

from ...support.jit import inlined
from .criterion import DRUCKER_PRAGER, MOHR_COULOMB, NONE, STRAIN, VON_MISES
from .drucker_prager import drucker_prager
from .mohr_coulomb import mohr_coulomb
from .strain import strain
from .von_mises import von_mises

# The numbers that `failure` knows, and that of a specimen which it judges not at all.
KNOWN = (NONE, VON_MISES, DRUCKER_PRAGER, MOHR_COULOMB, STRAIN)


@inlined
def failure(code, constants, eps, gamma, normal, tangential, equivalent, mean, factor):
    """Return what decides, the limit that it breaks at, and the number of the cause.

    Args:
        code: number of the criterion.
        constants: see `Criterion.constants`, shape (3,).
        eps: strain along the pair.
        gamma: shear angle of the pair.
        normal: traction along the pair, tension positive [Pa].
        tangential: traction across the pair [Pa].
        equivalent: von Mises' equivalent stress [Pa].
        mean: mean stress, tension positive [Pa].
        factor: of the strength of this pair.
    """
    if code == VON_MISES:
        return von_mises(equivalent, constants[0], factor)
    if code == DRUCKER_PRAGER:
        return drucker_prager(equivalent, mean, constants[0], constants[1], constants[2], factor)
    if code == MOHR_COULOMB:
        return mohr_coulomb(normal, tangential, constants[0], constants[1], constants[2], factor)
    if code == STRAIN:
        return strain(eps, gamma, constants[0], constants[1], factor)
    return np.nan, np.nan, 0
