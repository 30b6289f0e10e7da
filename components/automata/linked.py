"""Forces in a packing all of whose pairs are linked and elastic: no history, the fast path.

    theta_i = sum_j c_ij eps_ij / (1 + c* lambda / 2 G),        c_ij = S r / 2 V
    f_n = S (2 G eps + lambda (theta_i + theta_j) / 2),         f_t = S 2 G gamma
    U = sum over pairs S r G (eps^2 + gamma^2) + sum over automata (1/2) V lambda (1 + c* lambda / 2 G) theta^2

c* is the share of the free faces of a whole cell: they carry no traction, 2 G eps* + lambda theta = 0, and move accordingly.
K and G are exact for a homogeneous strain, for both packings. Every automaton gathers its own forces, and opposite slots are
added first: the sums have the same bits in a mirrored packing.
"""

from __future__ import annotations

from ..support.jit import inlined, jit
from .pair import strains, turned


@inlined
def _stretch(body, displacement, half, i, kind, slot):
    """Return what a pair adds to the volumetric strain."""
    nx, ny = body.directions[slot, 0], body.directions[slot, 1]
    eps, _, _, _ = strains(displacement, half, i, body.neighbours[i, slot], nx, ny, body.diameter)
    return body.share[kind, slot] * eps


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
    ratio = body.lame / (2.0 * body.shear)
    if body.directions.shape[0] == 4:
        for i in range(begin, end):
            k = body.kind[i]
            x = _stretch(body, displacement, half, i, k, 0) + _stretch(body, displacement, half, i, k, 2)
            y = _stretch(body, displacement, half, i, k, 1) + _stretch(body, displacement, half, i, k, 3)
            dilation_out[i] = (x + y) / (1.0 + body.missing[k] * ratio)
    else:
        for i in range(begin, end):
            k = body.kind[i]
            x = _stretch(body, displacement, half, i, k, 0) + _stretch(body, displacement, half, i, k, 3)
            up = _stretch(body, displacement, half, i, k, 1) + _stretch(body, displacement, half, i, k, 2)
            down = _stretch(body, displacement, half, i, k, 4) + _stretch(body, displacement, half, i, k, 5)
            dilation_out[i] = (x + (up + down)) / (1.0 + body.missing[k] * ratio)


@inlined
def _pull(body, displacement, half, dilation, i, kind, slot):
    """Return the force of a pair on an automaton, x and y, and its torque."""
    nx, ny, j = body.directions[slot, 0], body.directions[slot, 1], body.neighbours[i, slot]
    eps, gamma, less, sine = strains(displacement, half, i, j, nx, ny, body.diameter)
    face, twice = body.face[kind, slot], 2.0 * body.shear
    fn = face * (twice * eps + body.lame * (0.5 * (dilation[i] + dilation[j])))
    ft = face * (twice * gamma)
    fx, fy = turned(fn, ft, nx, ny, less, sine)
    return fx, fy, (0.5 * body.diameter) * ((1.0 + eps) * ft - gamma * fn)


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
    if body.directions.shape[0] == 4:
        for i in range(begin, end):
            k = body.kind[i]
            ax, ay, at = _pull(body, displacement, half, dilation, i, k, 0)
            bx, by, bt = _pull(body, displacement, half, dilation, i, k, 1)
            cx, cy, ct = _pull(body, displacement, half, dilation, i, k, 2)
            dx, dy, dt = _pull(body, displacement, half, dilation, i, k, 3)
            force_out[i, 0] = (ax + cx) + (bx + dx)
            force_out[i, 1] = (ay + cy) + (by + dy)
            torque_out[i] = (at + ct) + (bt + dt)
    else:
        for i in range(begin, end):
            k = body.kind[i]
            ax, ay, at = _pull(body, displacement, half, dilation, i, k, 0)
            bx, by, bt = _pull(body, displacement, half, dilation, i, k, 1)
            cx, cy, ct = _pull(body, displacement, half, dilation, i, k, 2)
            dx, dy, dt = _pull(body, displacement, half, dilation, i, k, 3)
            ex, ey, et = _pull(body, displacement, half, dilation, i, k, 4)
            fx, fy, ft = _pull(body, displacement, half, dilation, i, k, 5)
            force_out[i, 0] = (ax + dx) + ((bx + cx) + (ex + fx))
            force_out[i, 1] = (ay + dy) + ((by + cy) + (ey + fy))
            torque_out[i] = (at + dt) + ((bt + ct) + (et + ft))


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
