"""Forces in a packing all of whose pairs are linked and elastic: no history, the fast path.

    theta_i = sum_j c_ij eps_ij / (1 + c* lambda / 2 G),        c_ij = S r / 2 V
    f_n = S (2 G eps + lambda (theta_i + theta_j) / 2),         f_t = S 2 G gamma
    U = sum over pairs S r G (eps^2 + gamma^2) + sum over automata (1/2) V lambda (1 + c* lambda / 2 G) theta^2

c* is the share of the free faces of a whole cell: they carry no traction, 2 G eps* + lambda theta = 0, and move accordingly.
K and G are exact for a homogeneous strain, for both packings. Every automaton gathers its own forces, and opposite slots are
added first: the sums have the same bits in a mirrored packing.

Automata are taken in runs: neighbours in a row whose neighbours lie equally far on in memory. Some of them at a time are copied
into a tile, one array of rows of a fixed length: the compiler knows there that no row overlaps another, and makes vectors.
"""

from __future__ import annotations

import numpy as np

from ..support.jit import inlined, jit
from .pair import mirrored_slots, relative_strains, strains, turned

# Automata in a tile; its rows: what is known of the automata, of their neighbours in a slot, and what is computed.
_WIDTH = 64
_W = np.uint64(_WIDTH)
_OWN, _OTHER, _PAIR, _SUM = np.uint64(0), np.uint64(5 * _WIDTH), np.uint64(10 * _WIDTH), np.uint64(13 * _WIDTH)
_TILE = 16 * _WIDTH


@inlined
def _copy(displacement, half, first, count, at, tile):
    """Copy displacements and half rotations of automata into rows of a tile."""
    for t in range(count):
        tile[at + t], tile[at + _W + t] = displacement[first + t, 0], displacement[first + t, 1]
    for t in range(count):
        tile[at + _W + _W + t], tile[at + _W + _W + _W + t] = half[first + t, 0], half[first + t, 1]


@inlined
def _copy_dilation(dilation, first, count, at, tile):
    """Copy volumetric strains into the fifth row."""
    for t in range(count):
        tile[at + _W + _W + _W + _W + t] = dilation[first + t]


@inlined
def _tile_strains(tile, t, nx, ny, inverse):
    """Return the strains of a pair in a tile, and cos - 1 and sin of its mean rotation, as `pair.strains`."""
    own, other = _OWN + t, _OTHER + t
    dx, dy = tile[other] - tile[own], tile[other + _W] - tile[own + _W]
    own, other = own + _W + _W, other + _W + _W
    return relative_strains(dx, dy, tile[own], tile[own + _W], tile[other], tile[other + _W], nx, ny, inverse)


@jit
def dilations(body, displacement, half, dilation_out, begin, end):
    """Write the volumetric strains of automata from `begin` up to `end`.

    Args:
        body: a `Body`.
        displacement: shape (n, 2) [m].
        half: see `pair.orient`, shape (n, 2).
        dilation_out: shape (n,).
        begin: first automaton.
        end: after the last one.
    """
    ratio, slots, inverse = body.lame / (2.0 * body.shear), body.directions.shape[0], 1.0 / body.diameter
    tile = np.empty(_TILE)
    for run in range(body.runs.size - 1):
        start, stop = max(body.runs[run], begin), min(body.runs[run + 1], end)
        for low in range(start, stop, _WIDTH):
            first, count, k = np.uint64(low), np.uint64(min(_WIDTH, stop - low)), body.kind[low]
            _copy(displacement, half, first, count, _OWN, tile)
            for t in range(count):
                tile[_SUM + t] = 0.0
            for group in range(slots // 2 - 1, -1, -1):
                a, b = mirrored_slots(slots, group)
                nx, ny, share = body.directions[a, 0], body.directions[a, 1], body.share[k, a]
                _copy(displacement, half, np.uint64(body.neighbours[low, a]), count, _OTHER, tile)
                for t in range(count):
                    eps, _, _, _ = _tile_strains(tile, t, nx, ny, inverse)
                    tile[_PAIR + t] = share * eps
                nx, ny, share = body.directions[b, 0], body.directions[b, 1], body.share[k, b]
                _copy(displacement, half, np.uint64(body.neighbours[low, b]), count, _OTHER, tile)
                for t in range(count):
                    eps, _, _, _ = _tile_strains(tile, t, nx, ny, inverse)
                    tile[_SUM + t] += tile[_PAIR + t] + share * eps
            factor = 1.0 / (1.0 + body.missing[k] * ratio)
            for t in range(count):
                dilation_out[first + t] = tile[_SUM + t] * factor


@inlined
def _tile_pull(tile, t, nx, ny, length, face, shear, lame):
    """Return the force of a pair in a tile on its automaton, x and y, and its torque."""
    eps, gamma, less, sine = _tile_strains(tile, t, nx, ny, 1.0 / length)
    twice, row = 2.0 * shear, _W + _W + _W + _W + t
    fn = face * (twice * eps + lame * (0.5 * (tile[_OWN + row] + tile[_OTHER + row])))
    ft = face * (twice * gamma)
    fx, fy = turned(fn, ft, nx, ny, less, sine)
    return fx, fy, (0.5 * length) * ((1.0 + eps) * ft - gamma * fn)


@jit
def forces(body, displacement, half, dilation, force_out, torque_out, begin, end):
    """Write the forces and torques of the links on automata from `begin` up to `end`.

    Args:
        body: a `Body`.
        displacement: shape (n, 2) [m].
        half: see `pair.orient`, shape (n, 2).
        dilation: see `dilations`, of all automata from `begin` to `end` and their neighbours, shape (n,).
        force_out: shape (n, 2) [N].
        torque_out: shape (n,) [N m].
        begin: first automaton.
        end: after the last one.
    """
    slots, length, shear, lame = body.directions.shape[0], body.diameter, body.shear, body.lame
    tile = np.empty(_TILE)
    for run in range(body.runs.size - 1):
        start, stop = max(body.runs[run], begin), min(body.runs[run + 1], end)
        for low in range(start, stop, _WIDTH):
            first, count, k = np.uint64(low), np.uint64(min(_WIDTH, stop - low)), body.kind[low]
            _copy(displacement, half, first, count, _OWN, tile)
            _copy_dilation(dilation, first, count, _OWN, tile)
            for t in range(count):
                tile[_SUM + t], tile[_SUM + _W + t], tile[_SUM + _W + _W + t] = 0.0, 0.0, 0.0
            for group in range(slots // 2 - 1, -1, -1):
                a, b = mirrored_slots(slots, group)
                nx, ny, face = body.directions[a, 0], body.directions[a, 1], body.face[k, a]
                other = np.uint64(body.neighbours[low, a])
                _copy(displacement, half, other, count, _OTHER, tile)
                _copy_dilation(dilation, other, count, _OTHER, tile)
                for t in range(count):
                    fx, fy, turning = _tile_pull(tile, t, nx, ny, length, face, shear, lame)
                    tile[_PAIR + t], tile[_PAIR + _W + t], tile[_PAIR + _W + _W + t] = fx, fy, turning
                nx, ny, face = body.directions[b, 0], body.directions[b, 1], body.face[k, b]
                other = np.uint64(body.neighbours[low, b])
                _copy(displacement, half, other, count, _OTHER, tile)
                _copy_dilation(dilation, other, count, _OTHER, tile)
                for t in range(count):
                    fx, fy, turning = _tile_pull(tile, t, nx, ny, length, face, shear, lame)
                    tile[_SUM + t] += tile[_PAIR + t] + fx
                    tile[_SUM + _W + t] += tile[_PAIR + _W + t] + fy
                    tile[_SUM + _W + _W + t] += tile[_PAIR + _W + _W + t] + turning
            for t in range(count):
                force_out[first + t, 0], force_out[first + t, 1] = tile[_SUM + t], tile[_SUM + _W + t]
            for t in range(count):
                torque_out[first + t] = tile[_SUM + _W + _W + t]


@jit
def elastic_energy(body, displacement, half, dilation, begin, end):
    """Return the energy stored in automata from `begin` up to `end`, half of each of their pairs [J].

    Args:
        body: a `Body`.
        displacement: shape (n, 2) [m].
        half: see `pair.orient`, shape (n, 2).
        dilation: see `dilations`, shape (n,).
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
