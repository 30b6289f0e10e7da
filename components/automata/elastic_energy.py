"""The energy of a packing all of whose pairs are linked and elastic; see `linked_sweep`."""

from __future__ import annotations

from ..support.jit import jit
from .pair import strains


@jit
def elastic_energy(body, displacement, half, dilation, begin, end):
    """Return the energy stored in automata from `begin` up to `end`, half of each of their pairs [J].

    Args:
        body: a `Body`.
        displacement: shape (n, 2) [m].
        half: see `pair.orient`, shape (n, 2).
        dilation: see `linked_sweep.update_forces`, shape (n,).
        begin: first automaton.
        end: after the last one.
    """
    total = 0.0
    for i in range(begin, end):
        k = body.kind[i]
        squares = 0.0
        for slot in range(body.directions.shape[0]):
            nx, ny = body.directions[slot, 0], body.directions[slot, 1]
            eps, gamma, _, _ = strains(displacement, half, i, body.neighbours[i, slot], nx, ny, body.diameter)
            squares += body.face[k, slot] * (eps * eps + gamma * gamma)
        stiffening = 1.0 + body.missing[k] * body.lame / (2.0 * body.shear)
        total += 0.5 * body.diameter * body.shear * squares
        total += 0.5 * body.volume[k] * body.lame * stiffening * dilation[i] * dilation[i]
    return total
