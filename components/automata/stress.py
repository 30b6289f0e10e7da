"""Stresses of automata whose pairs are all linked and elastic, from their forces: sigma_i = (1 / 2 V) sum S r n (F / S)."""

from __future__ import annotations

import numpy as np

from ..support.jit import internal_inlined, jit
from .pair import strains, turned


@jit
def stresses(body, displacement, half, dilation, stress_out, begin, end):
    """Write the stresses in the plane of automata all of whose pairs are linked and elastic.

    Args:
        body: a `Body`.
        displacement: shape (n, 2) [m].
        half: see `pair.orient`, shape (n, 2).
        dilation: see `linked_sweep.update_forces`, shape (n,).
        stress_out: xx, yy and xy, tension positive, along the axes as they are now, shape (n, 3) [Pa].
        begin: first automaton.
        end: after the last one.
    """
    for i in range(begin, end):
        k, xx, yy, xy = body.kind[i], 0.0, 0.0, 0.0
        for slot in range(body.directions.shape[0]):
            nx, ny, j = body.directions[slot, 0], body.directions[slot, 1], body.neighbours[i, slot]
            eps, gamma, less, sine = strains(displacement, half, i, j, nx, ny, body.diameter)
            normal = 2.0 * body.shear * eps + body.lame * (0.5 * (dilation[i] + dilation[j]))
            a, b, c = virial(normal, 2.0 * body.shear * gamma, nx, ny, less, sine)
            share = body.share[k, slot]
            xx, yy, xy = xx + share * a, yy + share * b, xy + share * c
        stress_out[i, 0], stress_out[i, 1], stress_out[i, 2] = xx, yy, xy


@internal_inlined
def virial(normal, tangential, nx, ny, less, sine):
    """Return what the tractions on a face add to the stress, for a share of 1: xx, yy and xy [Pa]."""
    tx, ty = turned(normal, tangential, nx, ny, less, sine)
    ex, ey = turned(1.0, 0.0, nx, ny, less, sine)
    return ex * tx, ey * ty, 0.5 * (ex * ty + ey * tx)


@internal_inlined
def equivalent_stress(xx, yy, zz, xy):
    """Return von Mises' equivalent stress [Pa]."""
    squares = (xx - yy) * (xx - yy) + (yy - zz) * (yy - zz) + (zz - xx) * (zz - xx)
    return np.sqrt(0.5 * squares + 3.0 * xy * xy)
