"""One sweep through a linked packing: motion, strains, forces and the kick, while automata are in the cache.

    theta_i = sum_j c_ij eps_ij / (1 + c* lambda / 2 G),        c_ij = S r / 2 V
    f_n = S (2 G eps + lambda (theta_i + theta_j) / 2),         f_t = S 2 G gamma
    U = sum over pairs S r G (eps^2 + gamma^2) + sum over automata (1/2) V lambda (1 + c* lambda / 2 G) theta^2

c* is the share of the free faces of a whole cell: they carry no traction, 2 G eps* + lambda theta = 0, and move accordingly.
K and G are exact for a homogeneous strain, for both packings. See `pair` for the strains and the forces.

Each pair is computed once, at the end whose neighbour lies in the first half of the slots, and gathered by both ends. Opposite
slots are added first: the sums have the same bits in a mirrored packing, and in any number of parts.

Five stages follow each other through the packing, each so far behind the one before as neighbours lie apart in memory. What
they hand on stays in rings of tiles, rows of a fixed length in a fixed distance: the compiler sees there that no row overlaps
another, and makes vectors.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..support.jit import internal_inlined, jit
from .pair import half_turn, small_turn
from .sweep_order import LANES, LINK_ROWS, POINT_ROWS, PULL_ROWS, SHIFT, STRIDE, VECTOR

# Indices are of one unsigned kind: others would be checked for signs, and the loops be no vectors.
_S, _NONE, _ONE = np.uint64(STRIDE), np.uint64(0), np.uint64(1)
_THETA = np.uint64(4 * STRIDE)
# Rotations whose halves are not reduced by quarter turns.
_SMALL = 1.5
# Columns of what is kept of automata with inputs; see `sweep`.
KEPT = 6
# How far ahead of the tile that is moved another one is asked for.
# How a sweep moves the automata: not at all; half a drift, a kick, half a drift; a drift and half a kick; a drift, half a kick
# that ends a step, and half of one that begins the next.
STILL, DRIFT_KICK_DRIFT, DRIFT_HALF_KICK, DRIFT_TWO_HALF_KICKS = 0, 1, 2, 3
# Marked automata, and what is kept of them, where nothing moves.
_NOBODY, _NOTHING = np.zeros(0, np.int64), np.zeros((0, KEPT))


@internal_inlined
def _place(i, last, rows):
    """Return where an automaton is in a ring of so many rows."""
    return np.uint64(((i >> SHIFT) & last) * (rows * STRIDE) + (i & (LANES - 1)))


@internal_inlined
def _room(i, most):
    """Return how many automata from one on lie in one tile, at most so many."""
    return min(most, LANES - (i & (LANES - 1)))


@internal_inlined
def _vectors(count):
    """Return a number of automata or pairs rounded up to whole vectors; what these overwrite in a ring is computed later."""
    return np.uint64((count + VECTOR - 1) // VECTOR * VECTOR)


@internal_inlined
def _move(u, v, rotation, spin, first, time, inverse, points, at, count):
    """Drift for a time; write displacements in diameters and half rotations."""
    for t in range(count):
        i = first + first + t + t
        x, y = u[i] + time * v[i], u[i + _ONE] + time * v[i + _ONE]
        u[i], u[i + _ONE] = x, y
        points[at + t], points[at + _S + t] = inverse * x, inverse * y
    large = 0
    for t in range(count):
        angle = rotation[first + t] + time * spin[first + t]
        rotation[first + t] = angle
        large += 0 if abs(angle) <= _SMALL else 1
    _turn(rotation, first, large, points, at + _S + _S, count)


@internal_inlined
def _turn(rotation, first, large, points, at, count):
    """Write half rotations, `large` of which are not small: of small ones both ways have the same bits."""
    if large == 0:
        for t in range(count):
            points[at + t], points[at + _S + t] = small_turn(0.5 * rotation[first + t])
    else:
        for t in range(count):
            points[at + t], points[at + _S + t] = half_turn(rotation[first + t])


@internal_inlined
def _strain(points, own, other, links, at, count, nx, ny):
    """Write strains and directions of pairs."""
    for t in range(count):
        p, q = own + t, other + t
        dx, dy = points[q] - points[p], points[q + _S] - points[p + _S]
        p, q = p + _S + _S, q + _S + _S
        ci, si, cj, sj = points[p], points[p + _S], points[q], points[q + _S]
        less, sine = (ci + cj) + (ci * cj - si * sj), (si + sj) + (ci * sj + cj * si)
        cosine = 1.0 + less
        x, y = cosine * nx - sine * ny, cosine * ny + sine * nx
        row = at + t
        links[row], links[row + _S] = less + (dx * x + dy * y), (dy * x - dx * y) - sine
        row = row + _S + _S
        links[row], links[row + _S] = x, y


@internal_inlined
def _pull(points, own, other, links, at, pulls, to, count, stiffness, volumetric):
    """Write the forces and torques of pairs; those on the second automaton are the opposite forces, and the same torques."""
    for t in range(count):
        p = at + t
        eps, gamma = links[p], links[p + _S]
        p += _S + _S
        x, y = links[p], links[p + _S]
        pressing = volumetric * (points[own + t] + points[other + t])
        fn, ft = stiffness * eps + pressing, stiffness * gamma
        p = to + t
        pulls[p], pulls[p + _S] = fn * x - ft * y, fn * y + ft * x
        # (1 + eps) ft - gamma fn, without what cancels.
        pulls[p + _S + _S] = ft - gamma * pressing


@internal_inlined
def _dilate_square(links, a, b, c, d, share, points, at, count, factor):
    """Write the volumetric strains of automata with four neighbours, whose pairs begin at a, b, c and d."""
    sa, sb, sc, sd = share[0], share[1], share[2], share[3]
    for t in range(count):
        second = sb * links[b + t] + sd * links[d + t]
        points[at + t] = (second + (sa * links[a + t] + sc * links[c + t])) * factor


@internal_inlined
def _dilate_hexagonal(links, a, b, c, d, e, f, share, points, at, count, factor):
    """Write the volumetric strains of automata with six neighbours."""
    sa, sb, sc, sd, se, sf = share[0], share[1], share[2], share[3], share[4], share[5]
    for t in range(count):
        third = se * links[e + t] + sf * links[f + t]
        second = sb * links[b + t] + sc * links[c + t]
        points[at + t] = ((third + second) + (sa * links[a + t] + sd * links[d + t])) * factor


@internal_inlined
def _gather_square(pulls, a, b, c, d, of_c, of_d, sums, to, count):
    """Write a row of sums over four pairs, the last two times numbers."""
    for t in range(count):
        sums[to + t] = (pulls[b + t] + of_d * pulls[d + t]) + (pulls[a + t] + of_c * pulls[c + t])


@internal_inlined
def _gather_hexagonal(pulls, a, b, c, d, e, f, of_d, of_e, of_f, sums, to, count):
    """Write a row of sums over six pairs, the last three times numbers."""
    for t in range(count):
        third = of_e * pulls[e + t] + of_f * pulls[f + t]
        second = pulls[b + t] + pulls[c + t]
        sums[to + t] = (third + second) + (pulls[a + t] + of_d * pulls[d + t])


@internal_inlined
def _kick(u, v, rotation, spin, first, sums, count, by_mass, by_inertia, time, limit):
    """Accelerate automata and let them drift for a time; return how many are faster than the root of a limit."""
    bad = 0
    for t in range(count):
        i = first + first + t + t
        vx, vy = v[i] + by_mass * sums[t], v[i + _ONE] + by_mass * sums[_S + t]
        v[i], v[i + _ONE] = vx, vy
        u[i] += time * vx
        u[i + _ONE] += time * vy
        bad += 0 if vx * vx + vy * vy <= limit else 1
    for t in range(count):
        w = spin[first + t] + by_inertia * sums[_S + _S + t]
        spin[first + t] = w
        rotation[first + t] += time * w
    return bad


@internal_inlined
def _kick_halves(v, spin, first, sums, count, by_mass, by_inertia, radius, twice, limit):
    """Accelerate automata for half a step, or for two; return how many are faster than the root of a limit after the first."""
    bad = 0
    for t in range(count):
        i = first + first + t + t
        vx, vy = v[i] + by_mass * sums[t], v[i + _ONE] + by_mass * sums[_S + t]
        v[i], v[i + _ONE] = vx, vy
        bad += 0 if vx * vx + vy * vy <= limit else 1
        spin[first + t] += by_inertia * (radius * sums[_S + _S + t])
    if twice:
        for t in range(count):
            i = first + first + t + t
            v[i] += by_mass * sums[t]
            v[i + _ONE] += by_mass * sums[_S + t]
            spin[first + t] += by_inertia * (radius * sums[_S + _S + t])
    return bad


@internal_inlined
def _write(sums, points, theta, force, torque, dilation, first, count, radius):
    """Write forces, torques and volumetric strains of a tile."""
    for t in range(count):
        i = first + first + t + t
        force[i], force[i + _ONE] = sums[t], sums[_S + t]
    for t in range(count):
        torque[first + t], dilation[first + t] = radius * sums[_S + _S + t], points[theta + t]


@internal_inlined
def _pair_place(last, slots, rows, way, i, slot):
    """Return where the pair of an automaton in a slot is in a ring of pairs: with its other end, where that comes first.

    Args:
        last: of the ring's tiles.
        slots: how many neighbours an automaton has.
        rows: of a pair in the ring.
        way: how far on the neighbour in the slot lies.
        i: the automaton.
        slot: the slot.
    """
    half = slots // 2
    if slot >= half:
        i, slot = i + way, slot - half
    return _place(i, last, rows * half) + np.uint64(rows * slot * STRIDE)


@internal_inlined
def _move_tile(body, part, displacement, velocity, rotation, spin, low, high, time):
    """Move automata, and those of other parts as far as they are needed here."""
    while low < high:
        before = part.begin - part.ranges[0, 0]
        ghost = low < part.begin or low >= part.end
        first = low - part.ranges[0, 0] if low < part.begin else low - part.end + before if ghost else low
        u = part.ghost_displacement if ghost else displacement
        v = part.ghost_velocity if ghost else velocity
        w, s = part.ghost_rotation if ghost else rotation, part.ghost_spin if ghost else spin
        stop = min(high, part.begin) if low < part.begin else min(high, part.end) if low < part.end else high
        at, count = _place(low, part.last, POINT_ROWS), np.uint64(stop - low)
        _move(u, v, w, s, np.uint64(first), time, 1.0 / body.diameter, part.points, at, count)
        low = stop


@internal_inlined
def _strain_run(body, part, run, low, high):
    """Strain the pairs of automata of a run."""
    last, slots = part.last, body.directions.shape[0]
    for slot in range(slots // 2):
        nx, ny, way = body.directions[slot, 0], body.directions[slot, 1], part.offsets[run, slot]
        i = low
        while i < high:
            count = _room(i + way, _room(i, high - i))
            own, other = _place(i, last, POINT_ROWS), _place(i + way, last, POINT_ROWS)
            _strain(
                part.points, own, other, part.links, _pair_place(last, slots, LINK_ROWS, way, i, slot), _vectors(count), nx, ny
            )
            i += count


@internal_inlined
def _dilate_run(body, part, run, low, high):
    """Compute the volumetric strains of automata of a run."""
    k, slots, way = part.kinds[run], body.directions.shape[0], part.offsets[run]
    factor = 1.0 / (1.0 + body.missing[k] * body.lame / (2.0 * body.shear))
    share, i, last = body.share[k], low, part.last
    while i < high:
        count = _room(i, high - i)
        for slot in range(slots // 2, slots):
            count = _room(i + way[slot], count)
        at = _place(i, last, POINT_ROWS) + _THETA
        a, b = _pair_place(last, slots, LINK_ROWS, way[0], i, 0), _pair_place(last, slots, LINK_ROWS, way[1], i, 1)
        c, d = _pair_place(last, slots, LINK_ROWS, way[2], i, 2), _pair_place(last, slots, LINK_ROWS, way[3], i, 3)
        if slots == 4:
            _dilate_square(part.links, a, b, c, d, share, part.points, at, _vectors(count), factor)
        else:
            e, f = _pair_place(last, slots, LINK_ROWS, way[4], i, 4), _pair_place(last, slots, LINK_ROWS, way[5], i, 5)
            _dilate_hexagonal(part.links, a, b, c, d, e, f, share, part.points, at, _vectors(count), factor)
        i += count


@internal_inlined
def _pull_run(body, part, run, low, high):
    """Compute what the pairs of automata of a run do."""
    k, slots, last = part.kinds[run], body.directions.shape[0], part.last
    for slot in range(slots // 2):
        stiffness, volumetric = body.face[k, slot] * (2.0 * body.shear), body.face[k, slot] * (0.5 * body.lame)
        i, way = low, part.offsets[run, slot]
        while i < high:
            count = _room(i + way, _room(i, high - i))
            own, other = _place(i, last, POINT_ROWS) + _THETA, _place(i + way, last, POINT_ROWS) + _THETA
            at, to = _pair_place(last, slots, LINK_ROWS, way, i, slot), _pair_place(last, slots, PULL_ROWS, way, i, slot)
            _pull(part.points, own, other, part.links, at, part.pulls, to, _vectors(count), stiffness, volumetric)
            i += count


@internal_inlined
def _gather(part, slots, run, i, high):
    """Write the forces and torques on automata of a run from one on; return on how many."""
    last, way, half = part.last, part.offsets[run], slots // 2
    count = _room(i, high - i)
    for slot in range(half, slots):
        count = _room(i + way[slot], count)
    a, b = _pair_place(last, slots, PULL_ROWS, way[0], i, 0), _pair_place(last, slots, PULL_ROWS, way[1], i, 1)
    c, d = _pair_place(last, slots, PULL_ROWS, way[2], i, 2), _pair_place(last, slots, PULL_ROWS, way[3], i, 3)
    e, f = a, b
    if slots == 6:
        e, f = _pair_place(last, slots, PULL_ROWS, way[4], i, 4), _pair_place(last, slots, PULL_ROWS, way[5], i, 5)
    to = _NONE
    for row in range(3):
        # A pair in the second half of the slots is that of the neighbour, whose force is opposite; its torque is the same.
        sign = -1.0 if row < 2 else 1.0
        of_c, of_d = sign * (way[2] != 0), sign * (way[3] != 0)
        if slots == 4:
            _gather_square(part.pulls, a, b, c, d, of_c, of_d, part.sums, to, _vectors(count))
        else:
            of_e, of_f = sign * (way[4] != 0), sign * (way[5] != 0)
            _gather_hexagonal(part.pulls, a, b, c, d, e, f, of_d, of_e, of_f, part.sums, to, _vectors(count))
        a, b, c, d, e, f, to = a + _S, b + _S, c + _S, d + _S, e + _S, f + _S, to + _S
    return count


@internal_inlined
def _keep(sums, radius, marked, at, first, end, u, v, rotation, spin, force, torque, kept):
    """Keep what is known before the kick of automata that inputs act on; return which of them comes next."""
    while at < marked.size and marked[at] < end:
        i, t = marked[at], marked[at] - first
        kept[at, 0], kept[at, 1], kept[at, 2], kept[at, 3] = u[2 * i], u[2 * i + 1], v[2 * i], v[2 * i + 1]
        kept[at, 4], kept[at, 5] = rotation[i], spin[i]
        force[2 * i], force[2 * i + 1], torque[i] = sums[t], sums[STRIDE + t], radius * sums[2 * STRIDE + t]
        at += 1
    return at


@internal_inlined
def _count_fast(body, part, marked, kept, force, time, limit):
    """Return how many of the marked automata a kick of `time` [s] has made too fast: inputs act on them yet, and judge them."""
    fast = 0
    for row in range(marked.size):
        i = marked[row]
        if part.begin <= i and i < part.end:
            by = time / body.mass[body.kind[i]]
            vx, vy = kept[row, 2] + by * force[2 * i], kept[row, 3] + by * force[2 * i + 1]
            fast += 0 if vx * vx + vy * vy <= limit else 1
    return fast


@jit
def sweep(body, part, motion, scratch, marked, kept, time, limit, moves):
    """Advance automata by an internal step with the forces of their links, or compute those forces alone.

    Args:
        body: a `Body`.
        part: a `sweep_order.Part`, its rings overwritten.
        motion: a `Motion`, updated in place where automata move.
        scratch: a `Scratch`. Its volumetric strains are written with the forces of all; forces and torques of the links are
            written of marked automata, of all where nothing moves or is kicked for half a step.
        marked: automata that inputs act on, in increasing order, shape (m,).
        kept: written of these where they move: displacement, velocity, rotation and spin before the kick, shape (m, 6).
        time: length of the step [s].
        limit: square of the largest speed that is allowed [m^2/s^2].
        moves: see STILL.

    Returns:
        How many automata are too fast, but of the marked ones.
    """
    displacement, velocity = (
        motion.displacement.reshape(motion.displacement.size),
        motion.velocity.reshape(motion.velocity.size),
    )
    rotation, spin, dilation, torque = motion.rotation, motion.spin, scratch.dilation, scratch.torque
    force = scratch.force.reshape(scratch.force.size)
    slots, radius, half = body.directions.shape[0], 0.5 * body.diameter, 0.5 * time
    before = 0.0 if moves == STILL else half if moves == DRIFT_KICK_DRIFT else time
    passed, fast, at, start = part.passed, 0, 0, part.ranges[0, 0] >> SHIFT << SHIFT
    while at < marked.size and marked[at] < part.begin:
        at += 1
    passed[:] = 0
    for base in range(start, part.end + part.lags[4] + LANES, LANES):
        low, high = max(base, part.ranges[0, 0]), min(base + LANES, part.ranges[0, 1])
        _move_tile(body, part, displacement, velocity, rotation, spin, low, high, before)
        for stage in range(1, 5):
            low = max(base - part.lags[stage], part.ranges[stage, 0])
            high = min(base - part.lags[stage] + LANES, part.ranges[stage, 1])
            while low < high:
                while part.runs[passed[stage] + 1] <= low:
                    passed[stage] += 1
                run, stop = passed[stage], min(high, part.runs[passed[stage] + 1])
                if stage == 1:
                    _strain_run(body, part, run, low, stop)
                elif stage == 2:
                    _dilate_run(body, part, run, low, stop)
                elif stage == 3:
                    _pull_run(body, part, run, low, stop)
                else:
                    k, stop = part.kinds[run], low + _gather(part, slots, run, low, stop)
                    first, count = np.uint64(low), np.uint64(stop - low)
                    if moves != STILL:
                        at = _keep(
                            part.sums,
                            radius,
                            marked,
                            at,
                            low,
                            stop,
                            displacement,
                            velocity,
                            rotation,
                            spin,
                            force,
                            torque,
                            kept,
                        )
                    if moves == DRIFT_KICK_DRIFT:
                        fast += _kick(
                            displacement, velocity, rotation, spin, first, part.sums, count, time / body.mass[k],
                            radius * time / body.inertia[k], half, limit,
                        )  # fmt: skip
                    elif moves != STILL:
                        fast += _kick_halves(
                            velocity, spin, first, part.sums, count, half / body.mass[k], half / body.inertia[k], radius,
                            moves == DRIFT_TWO_HALF_KICKS, limit,
                        )  # fmt: skip
                    if moves == STILL or moves == DRIFT_HALF_KICK:
                        theta = _place(low, part.last, POINT_ROWS) + _THETA
                        _write(part.sums, part.points, theta, force, torque, dilation, first, count, radius)
                low = stop
    if fast > 0 and moves != STILL:
        fast -= _count_fast(body, part, marked, kept, force, time if moves == DRIFT_KICK_DRIFT else half, limit)
    return fast


def update_forces(body: Any, part: Any, motion: Any, scratch: Any) -> None:
    """Write the volumetric strains of the positions as they are, and the forces and torques of the links.

    Args:
        body: a `Body`.
        part: the packing as one `sweep_order.Part`, its rings overwritten.
        motion: a `Motion`; its velocities are not looked at.
        scratch: a `Scratch`, overwritten.
    """
    sweep(body, part, motion, scratch, _NOBODY, _NOTHING, 0.0, 0.0, STILL)
