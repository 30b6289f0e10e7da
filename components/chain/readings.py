"""Single figures of a chain's table for jitted code: what sensors and tasks read, with the bits of the component's outputs.

Grain i has column i (from 1), contact j lies between columns j and j + 1.
"""

from __future__ import annotations

import numpy as np

from ..support.jit import inlined, jit
from . import kernels
from .table import DISSIPATION, ELASTIC, GRAINS, SCALARS, TALLY, WORK_LEFT, WORK_RIGHT, U, V


@jit
def contact_force(a, j):
    """Compressive force in contact j, dissipation included; 0 where there is none."""
    force, _ = kernels._force(int(a[SCALARS, ELASTIC]), int(a[SCALARS, DISSIPATION]), a, U, V, np.uint64(j))
    return force


@jit
def grain_force(a, i):
    """What a sensor inside the grain of column i reads: the mean of the forces in its two contacts."""
    return 0.5 * (contact_force(a, i - 1) + contact_force(a, i))


@inlined
def left_wall_force(a):
    """Force between the left wall and the chain, never negative; 0 without a wall."""
    return contact_force(a, 0)


@inlined
def right_wall_force(a):
    """Force between the chain and the right wall, never negative; 0 without a wall."""
    return contact_force(a, int(a[SCALARS, GRAINS]))


@inlined
def input_work(a):
    """Work done by inputs and boundaries since the reset, as the component's `input_work`."""
    behind = int(a[SCALARS, GRAINS]) + 2
    return (a[TALLY, WORK_LEFT] + a[TALLY, WORK_RIGHT]) + a[V, behind] + a[V, behind + 1]
