"""The moving grid: strains, stresses, forces, and the motion of the nodes.

Wilkins' scheme on quadrilaterals: one stress per cell, and the contour integral (11) of Psakhie et al. (2003) for the force on
a node. Hourglass modes have the stiffness of a fully integrated cell. A tick is a half kick, a drift, new stresses and forces,
and a half kick (velocity Verlet). It equals Wilkins' leapfrog, with velocities at whole ticks. Every node sums its forces in a
fixed order and in pairs, so that mirror images along x or y are bitwise mirror images.

A parent that advances the grid together with another body calls `kick`, `drift`, `advance_cells` and `finish_nodes` directly.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from ..materials.hypoelastic import (
    PlaneTensor,
    elastic_increment,
    energy_density,
    rotate_by_half_angle,
    rotate_stress,
    spin_rotation,
)
from ..materials.tensors import Moduli
from ..support.jit import internal, internal_inlined, jit
from ..support.threads import call_in_threads, split_range
from .kernel_arrays import ABSORBED, ANGULAR, BOUNDARY_ANGULAR, BOUNDARY_IMPULSE, IMPULSE, WORK, Yields
from .yielding import CellStep, plastic_step

# A slower node counts as at rest [m/s]. Ahead of a wave velocities decay until they, or products of them, become subnormal
# floating-point numbers, with which a processor is tens of times slower.
_REST = 1e-140
# Number of the event kind for the first yield of a cell.
_YIELDED = 0
# The numbers of the first cell and the first node, as variables: numba compiles a function again for a literal argument.
_ZERO = np.int64(0)
# Unsigned indices in the long loops, so that numba need not check for negative ones.
_ONE, _TWO, _THREE = np.uint64(1), np.uint64(2), np.uint64(3)


@internal_inlined
def corner_forces(stress, hourglass, diagonals, pattern):
    """Return the forces on corners 0 and 1 of a cell by its stress: x and y of one, then of the other [N].

    Corners 2 and 3 get the opposite forces: the contour integral (11), minus the work of hourglass forces in a linear field.

    Args:
        stress: xx, yy, xy [Pa].
        hourglass: amplitude of the hourglass forces along x, y [N].
        diagonals: from corner 0 to 2, x and y, and from corner 1 to 3 [m].
        pattern: (1, -1, 1, -1) times the corners' positions, x and y [m].
    """
    ax, ay, bx, by = diagonals
    inverse = 2.0 / (ax * by - bx * ay)
    qx, qy = hourglass[0] * inverse, hourglass[1] * inverse
    fxx, fxy = 0.5 * (stress[0] - qx * pattern[0]), 0.5 * (stress[2] - qx * pattern[1])
    fyx, fyy = 0.5 * (stress[2] - qy * pattern[0]), 0.5 * (stress[1] - qy * pattern[1])
    return fxx * by - fxy * bx, fyx * by - fyy * bx, fxy * ax - fxx * ay, fyy * ax - fyx * ay


@internal
def record_yield(yields, tick, cell, flow):
    """Append the event of a cell that yields for the first time; `flow` is its `PlasticStep`."""
    row = yields.used[0]
    rows = yields.rows
    rows[row, 0], rows[row, 1], rows[row, 2], rows[row, 3], rows[row, 4] = tick, _YIELDED, cell, flow.equivalent, flow.limit
    yields.used[0] = row + 1


@internal
def advance_cells(grid, state, corner_out, step, tick, yields, begin, end):
    """Advance stresses and energies of cells begin..end-1 after their nodes have drifted, and write the corner forces.

    Args:
        grid: see `kernel_arrays.Grid`.
        state: `stress`, `hourglass_force`, `energy` and the plastic arrays are updated.
        corner_out: force of each cell on each of its nodes, shape (4 m + 1, 2); the last row is 0 [N].
        step: length of the drift [s].
        tick: number of the tick at the end of the step, for events.
        yields: a `kernel_arrays.Yields`, to which first yields are added.
        begin: first cell.
        end: one past the last cell.

    Returns:
        The number of the first non-convex cell, or -1.
    """
    # Read the arrays from their tuples before the loop: inside it, each access would count references.
    cells, x, u, v = grid.cells, grid.reference, state.displacement, state.velocity
    stresses, twists, energy, stiffness = state.stress, state.hourglass_force, state.energy, grid.hourglass
    material, moduli, laws = grid.material, grid.moduli, grid.laws
    plastic_strains, plastic_works = state.plastic_strain, state.plastic_work
    failed, half, plastic = np.int64(-1), 0.5 * step, len(plastic_strains) > 0
    for c in range(np.uint64(begin), np.uint64(end)):
        n0, n1, n2, n3 = cells[c, 0], cells[c, 1], cells[c, 2], cells[c, 3]
        x0, y0, x1, y1 = x[n0, 0] + u[n0, 0], x[n0, 1] + u[n0, 1], x[n1, 0] + u[n1, 0], x[n1, 1] + u[n1, 1]
        x2, y2, x3, y3 = x[n2, 0] + u[n2, 0], x[n2, 1] + u[n2, 1], x[n3, 0] + u[n3, 0], x[n3, 1] + u[n3, 1]
        vx0, vy0, vx1, vy1 = v[n0, 0], v[n0, 1], v[n1, 0], v[n1, 1]
        vx2, vy2, vx3, vy3 = v[n2, 0], v[n2, 1], v[n3, 0], v[n3, 1]
        # Diagonals and hourglass amplitudes (corner values times 1, -1, 1, -1) of positions and velocities.
        ax, ay, bx, by = x2 - x0, y2 - y0, x3 - x1, y3 - y1
        px, py = (x0 + x2) - (x1 + x3), (y0 + y2) - (y1 + y3)
        wax, way, wbx, wby = vx2 - vx0, vy2 - vy0, vx3 - vx1, vy3 - vy1
        gx, gy = (vx0 + vx2) - (vx1 + vx3), (vy0 + vy2) - (vy1 + vy3)
        # Velocity gradient times the step, at mid-step.
        mx_a, my_a, mx_b, my_b = ax - half * wax, ay - half * way, bx - half * wbx, by - half * wby
        twice = mx_a * my_b - mx_b * my_a
        scale = step / twice
        exx, eyx = (my_b * wax - my_a * wbx) * scale, (my_b * way - my_a * wby) * scale
        exy, eyy = (mx_a * wbx - mx_b * wax) * scale, (mx_a * wby - mx_b * way) * scale
        # The old stress is rotated by the rotation of the step, the stress increment (of mid-step) by half of it.
        turn = 0.25 * (eyx - exy)
        cosine, sine = spin_rotation(2.0 * turn)
        half_cosine = sqrt(0.5 + 0.5 * cosine)
        half_sine = turn * half_cosine
        # Hourglass forces grow with the part of the corner motion that the velocity gradient does not describe.
        mpx, mpy, rate = px - half * gx, py - half * gy, stiffness[c]
        hx, hy = cosine * twists[c, 0] - sine * twists[c, 1], sine * twists[c, 0] + cosine * twists[c, 1]
        ix, iy = rate * (step * gx - (exx * mpx + exy * mpy)), rate * (step * gy - (eyx * mpx + eyy * mpy))
        qx, qy = hx + (half_cosine * ix - half_sine * iy), hy + (half_sine * ix + half_cosine * iy)
        # New stresses and their work.
        number = material[c]
        sxx, syy, sxy = rotate_stress(stresses[c, 0], stresses[c, 1], stresses[c, 3], cosine, sine)
        szz, shear_strain = stresses[c, 2], 0.5 * (exy + eyx)
        turned_xx, turned_yy, turned_xy = rotate_by_half_angle(exx, eyy, shear_strain, cosine, sine)
        dxx, dyy, dzz, dxy = elastic_increment(turned_xx, turned_yy, turned_xy, moduli[number, 0], moduli[number, 1])
        txx, tyy, tzz, txy = sxx + dxx, syy + dyy, szz + dzz, sxy + dxy
        if plastic:
            flow = plastic_step(
                laws,
                number,
                CellStep(
                    Moduli(moduli[number, 0], moduli[number, 1]),
                    plastic_strains[c],
                    0.5 * twice,
                    PlaneTensor(sxx, syy, szz, sxy),
                    PlaneTensor(txx, tyy, tzz, txy),
                ),
            )
            txx, tyy, tzz, txy = flow.stress
            if flow.strain > 0.0:
                if plastic_strains[c] == 0.0:
                    record_yield(yields, tick, c, flow)
                plastic_strains[c] += flow.strain
                # The hourglass force represents deviators within the cell, so it is scaled like them. The plastic strain is
                # (1 - kept) q / rate; the mean of the force before and after the step does its work.
                work, kept = flow.work, flow.kept
                if rate > 0.0:
                    twisted = (1.0 - kept) * (qx * (hx + kept * qx) + qy * (hy + kept * qy)) / (2.0 * rate)
                    qx, qy = kept * qx, kept * qy
                    work += twisted
                    energy[c] += twisted
                plastic_works[c] += work
        twists[c, 0], twists[c, 1] = qx, qy
        # The kick before the drift used the old stress in its old orientation, so the old stress enters the work unrotated.
        mean_xx, mean_yy, mean_xy = stresses[c, 0] + txx, stresses[c, 1] + tyy, stresses[c, 3] + txy
        energy[c] += (0.25 * twice) * ((mean_xx * exx + mean_yy * eyy) + 2.0 * (mean_xy * shear_strain))
        stresses[c, 0], stresses[c, 1], stresses[c, 2], stresses[c, 3] = txx, tyy, tzz, txy
        cx, cy, dx, dy = corner_forces((txx, tyy, txy), (qx, qy), (ax, ay, bx, by), (px, py))
        slot = np.uint64(4) * c
        corner_out[slot, 0], corner_out[slot, 1] = cx - qx, cy - qy
        corner_out[slot + _ONE, 0], corner_out[slot + _ONE, 1] = dx + qx, dy + qy
        corner_out[slot + _TWO, 0], corner_out[slot + _TWO, 1] = -cx - qx, -cy - qy
        corner_out[slot + _THREE, 0], corner_out[slot + _THREE, 1] = qx - dx, qy - dy
        # All four angles must be below 180 degrees; NaN fails this test too.
        area = ax * by - bx * ay
        if not (area > abs(px * by - py * bx) and area > abs(ax * py - ay * px)) and failed < 0:
            failed = np.int64(c)
    return failed


@internal_inlined
def node_force(slots, corner, n):
    """Return the force on a node [N], summed in two pairs of corners, so that mirror images are bitwise mirror images."""
    a, b, c, d = slots[n, 0], slots[n, 1], slots[n, 2], slots[n, 3]
    fx = (corner[a, 0] + corner[b, 0]) + (corner[c, 0] + corner[d, 0])
    fy = (corner[a, 1] + corner[b, 1]) + (corner[c, 1] + corner[d, 1])
    return fx, fy


@internal
def write_forces(grid, state, corner, begin, end):
    """Write the forces on the nodes begin..end-1 by summing corner forces."""
    slots, force = grid.node_slots, state.force
    for n in range(np.uint64(begin), np.uint64(end)):
        force[n, 0], force[n, 1] = node_force(slots, corner, n)


@internal
def finish_nodes(grid, state, corner, step, has_next_tick, begin, end):
    """Write the forces on the nodes begin..end-1, and kick those without conditions for the second half of a step.

    If another tick follows (`has_next_tick`), these nodes begin it: half a kick, then the drift.
    """
    slots, special, half_inverse = grid.node_slots, grid.special, grid.half_inverse
    force, velocity, displacement = state.force, state.velocity, state.displacement
    for n in range(np.uint64(begin), np.uint64(end)):
        fx, fy = node_force(slots, corner, n)
        force[n, 0], force[n, 1] = fx, fy
        if special[n]:
            continue
        weight = step * half_inverse[n]
        vx, vy = velocity[n, 0] + weight * fx, velocity[n, 1] + weight * fy
        if has_next_tick:
            vx, vy = drift_velocity(vx + weight * fx), drift_velocity(vy + weight * fy)
            displacement[n, 0] += step * vx
            displacement[n, 1] += step * vy
        velocity[n, 0], velocity[n, 1] = vx, vy


@internal
def finish_forces(grid, state, groups, corner):
    """Complete the forces on nodes: add the corner forces in `further`, and sum the forces of joined nodes."""
    further, force = grid.further, state.force
    for row in range(len(further)):
        n, slot = further[row, 0], further[row, 1]
        force[n, 0] += corner[slot, 0]
        force[n, 1] += corner[slot, 1]
    sum_group_forces(force, groups)


@internal
def sum_group_forces(force, groups):
    """Give all nodes of each group the sum of their forces."""
    for row in range(len(groups)):
        a, b, c, d = groups[row, 0], groups[row, 1], groups[row, 2], groups[row, 3]
        for k in range(2):
            total = force[a, k] + force[b, k]
            if c >= 0:
                total = total + (force[c, k] + force[d, k])
                force[c, k] = force[d, k] = total
            force[a, k] = force[b, k] = total


@jit
def update_forces(grid, state, groups, corner, step):
    """Advance all stresses elastically by a step [s] after the nodes have drifted, and write the forces on all nodes.

    For a grid whose `laws` do not yield. `groups` are the nodes that move together; see `kernel_arrays.Conditions`.

    Returns:
        The first non-convex cell, or -1.
    """
    nothing = Yields(np.zeros((1, 5)), np.zeros(1, np.int64))
    failed = advance_cells(grid, state, corner, step, _ZERO, nothing, _ZERO, len(grid.cells))
    write_forces(grid, state, corner, _ZERO, len(grid.reference))
    finish_forces(grid, state, groups, corner)
    return failed


@internal_inlined
def drift_velocity(velocity):
    """Return a velocity before a drift, or 0 if it is negligible; NaN is kept."""
    return 0.0 if abs(velocity) < _REST else velocity


@internal
def kick(grid, state, step, begin, end):
    """Add the first half kick of a step [s] to the velocities of nodes begin..end-1 without conditions."""
    special, half_inverse, velocity, force = grid.special, grid.half_inverse, state.velocity, state.force
    for n in range(begin, end):
        if not special[n]:
            weight = step * half_inverse[n]
            velocity[n, 0] = drift_velocity(velocity[n, 0] + weight * force[n, 0])
            velocity[n, 1] = drift_velocity(velocity[n, 1] + weight * force[n, 1])


@internal
def drift(grid, state, step, begin, end):
    """Move the nodes begin..end-1 without conditions at their velocities for a step [s]."""
    special, displacement, velocity = grid.special, state.displacement, state.velocity
    for n in range(begin, end):
        if not special[n]:
            displacement[n, 0] += step * velocity[n, 0]
            displacement[n, 1] += step * velocity[n, 1]


@internal
def begin_conditions(grid, state, conditions, factors, row, step):
    """Kick and drift the nodes with conditions: half a kick with the loads of this tick, then the drift.

    Dashpots are implicit in the mid-step velocity, so that any damping is stable.

    Args:
        grid: see `kernel_arrays.Grid`.
        state: `velocity` and `displacement` of these nodes are updated.
        conditions: see `kernel_arrays.Conditions`; `begin` is written.
        factors: mean of each signal over each tick, shape (ticks, signals); a signal multiplies loads or velocities.
        row: row of this tick in `factors`.
        step: internal step [s].
    """
    for i in range(len(conditions.nodes)):
        n = conditions.nodes[i]
        drive_x = drive_y = 0.0
        for signal in range(factors.shape[1]):
            drive_x += factors[row, signal] * conditions.drive[signal, i, 0]
            drive_y += factors[row, signal] * conditions.drive[signal, i, 1]
        given_x, given_y = conditions.prescribed[i, 0] > 0, conditions.prescribed[i, 1] > 0
        force_x, force_y = 0.0 if given_x else drive_x, 0.0 if given_y else drive_y
        vx, vy = state.velocity[n, 0], state.velocity[n, 1]
        weight = 0.5 * step / conditions.mass[i]
        right_x = vx + weight * (state.force[n, 0] + force_x)
        right_y = vy + weight * (state.force[n, 1] + force_y)
        cxx, cyy, cxy = conditions.damping[i, 0], conditions.damping[i, 1], conditions.damping[i, 2]
        mxx, myy, mxy = 1.0 + weight * cxx, 1.0 + weight * cyy, weight * cxy
        determinant = mxx * myy - mxy * mxy
        middle_x = drive_x if given_x else (myy * right_x - mxy * right_y) / determinant
        middle_y = drive_y if given_y else (mxx * right_y - mxy * right_x) / determinant
        begin = conditions.begin
        begin[i, 0, 0], begin[i, 0, 1] = vx, vy
        begin[i, 1, 0], begin[i, 1, 1] = state.force[n, 0], state.force[n, 1]
        begin[i, 2, 0], begin[i, 2, 1] = force_x, force_y
        begin[i, 3, 0] = -(cxx * middle_x + cxy * middle_y)
        begin[i, 3, 1] = -(cxy * middle_x + cyy * middle_y)
        begin[i, 4, 0], begin[i, 4, 1] = middle_x, middle_y
        state.velocity[n, 0], state.velocity[n, 1] = middle_x, middle_y
        state.displacement[n, 0] += step * middle_x
        state.displacement[n, 1] += step * middle_y


@internal
def finish_conditions(grid, state, conditions, step, tally):
    """Kick the nodes with conditions for the second half of a step, and tally work and impulses.

    The work of a force f that is constant over a tick is f.(v0 + v1)/2 times the step; with this definition the discrete energy
    of leapfrog balances to rounding. See `begin_conditions`; `tally` has the entries of `kernel_arrays`.
    """
    for i in range(len(conditions.nodes)):
        n, mass, share = conditions.nodes[i], conditions.mass[i], conditions.share[i]
        weight = 0.5 * step / mass
        work = absorbed = 0.0
        for k in range(2):
            before, old = conditions.begin[i, 0, k], conditions.begin[i, 1, k]
            applied, dashpot, middle = conditions.begin[i, 2, k], conditions.begin[i, 3, k], conditions.begin[i, 4, k]
            new = state.force[n, k]
            given = conditions.prescribed[i, k] > 0
            after = middle if given else middle + weight * ((new + applied) + dashpot)
            state.velocity[n, k] = after
            # Impulses of the condition in the first and second half of the step.
            if given:
                first = mass * (middle - before) - 0.5 * step * old
                second = -0.5 * step * new
                work += 0.5 * mass * (after * after - before * before) - 0.5 * step * middle * (old + new)
            else:
                first = second = 0.5 * step * dashpot
                work += step * applied * (0.5 * (before + after))
                absorbed -= step * dashpot * (0.5 * (before + after))
            lever = grid.reference[n, 1 - k] + state.displacement[n, 1 - k]
            lever_before = lever - step * conditions.begin[i, 4, 1 - k]
            sign = share if k == 1 else -share
            tally[IMPULSE + k] += share * (step * applied)
            tally[BOUNDARY_IMPULSE + k] += share * (first + second)
            tally[ANGULAR] += sign * (step * applied) * (0.5 * (lever + lever_before))
            tally[BOUNDARY_ANGULAR] += sign * (lever_before * first + lever * second)
        tally[WORK] += share * work
        tally[ABSORBED] += share * absorbed


@internal
def start_ticks(body, factors, step):
    """Start a sequence of ticks: half a kick, then drift every node. See `advance` for the arguments."""
    count = len(body.grid.reference)
    kick(body.grid, body.state, step, _ZERO, count)
    drift(body.grid, body.state, step, _ZERO, count)
    begin_conditions(body.grid, body.state, body.conditions, factors, _ZERO, step)


@internal
def finish_tick(body, factors, tally, row, step):
    """Finish a tick after `finish_nodes`: finish the nodes with conditions, and begin their next tick if there is one."""
    finish_forces(body.grid, body.state, body.conditions.groups, body.corner)
    finish_conditions(body.grid, body.state, body.conditions, step, tally)
    if row + 1 < len(factors):
        begin_conditions(body.grid, body.state, body.conditions, factors, row + 1, step)


@jit
def advance(body, factors, tally, step, tick, yields, failure_out):
    """Advance the grid by whole ticks.

    Args:
        body: a `kernel_arrays.Tables`; its state is updated.
        factors: means of the signals over each tick, shape (ticks, signals).
        tally: work and impulses since the reset, updated, shape (TALLY,).
        step: internal step [s].
        tick: number of the tick at the beginning.
        yields: a `kernel_arrays.Yields`, updated.
        failure_out: the number of a non-convex cell, and the tick, shape (2,).

    Returns:
        0, or 1 if a cell is not convex.
    """
    grid, state, corner = body.grid, body.state, body.corner
    start_ticks(body, factors, step)
    for row in range(len(factors)):
        failed = advance_cells(grid, state, corner, step, tick + row + 1, yields, _ZERO, len(grid.cells))
        if failed >= 0:
            failure_out[0], failure_out[1] = failed, tick + row + 1
            return 1
        finish_nodes(grid, state, corner, step, row + 1 < len(factors), _ZERO, len(grid.reference))
        finish_tick(body, factors, tally, row, step)
    return 0


# Entry points from Python for single parts of a tick; compiled only if threads are used.


@jit
def start_parts(body, factors, step):
    """Start a sequence of ticks."""
    start_ticks(body, factors, step)


@jit
def advance_cell_range(body, step, tick, yields, begin, end):
    """Advance the cells begin..end-1; return the first non-convex one, or -1."""
    return advance_cells(body.grid, body.state, body.corner, step, tick, yields, begin, end)


@jit
def finish_node_range(body, step, has_next_tick, begin, end):
    """Write the forces on the nodes begin..end-1, and move those without conditions."""
    finish_nodes(body.grid, body.state, body.corner, step, has_next_tick, begin, end)


@jit
def finish_parts(body, factors, tally, row, step):
    """Finish a tick once the forces on all nodes have been written; arguments as in `advance`."""
    finish_tick(body, factors, tally, row, step)


def advance_in_parts(body, factors, tally, step, tick, yields, failure_out, parts):
    """Advance like `advance`, with one thread for each of several parts of the cells, then of the nodes; bitwise identical.

    Only for a grid that cannot yield, because yield events must be in the order of the cells.
    """
    cells, nodes = split_range(len(body.grid.cells), parts), split_range(len(body.grid.reference), parts)
    start_parts(body, factors, step)
    for row in range(len(factors)):
        now, has_next_tick = tick + row + 1, row + 1 < len(factors)
        found = call_in_threads(advance_cell_range, [(body, step, now, yields, *part) for part in cells])
        failed = [int(cell) for cell in found if cell >= 0]
        if failed:
            failure_out[:] = failed[0], now
            return 1
        call_in_threads(finish_node_range, [(body, step, has_next_tick, *part) for part in nodes])
        finish_parts(body, factors, tally, row, step)
    return 0


@jit
def write_energy_sums(grid, state, own_mass, sums_out):
    """Write kinetic energy, hourglass energy, sum of force^2 / mass of nodes without conditions, momentum, angular momentum.

    Args:
        grid: see `kernel_arrays.Grid`.
        state: see `kernel_arrays.State`.
        own_mass: mass of each node, without nodes joined to it, shape (n,) [kg].
        sums_out: written, shape (6,).
    """
    special, velocity, force, twists = grid.special, state.velocity, state.force, state.hourglass_force
    reference, displacement, stiffness = grid.reference, state.displacement, grid.hourglass
    kinetic = pulled = momentum_x = momentum_y = turning = twisted = 0.0
    for n in range(len(own_mass)):
        vx, vy, mass = velocity[n, 0], velocity[n, 1], own_mass[n]
        kinetic += 0.5 * mass * (vx * vx + vy * vy)
        if not special[n]:
            fx, fy = force[n, 0], force[n, 1]
            pulled += (fx * fx + fy * fy) / mass
        momentum_x += mass * vx
        momentum_y += mass * vy
        x, y = reference[n, 0] + displacement[n, 0], reference[n, 1] + displacement[n, 1]
        turning += mass * (x * vy - y * vx)
    for c in range(len(stiffness)):
        if stiffness[c] > 0.0:
            hx, hy = twists[c, 0], twists[c, 1]
            twisted += (hx * hx + hy * hy) / (2.0 * stiffness[c])
    sums_out[0], sums_out[1], sums_out[2] = kinetic, twisted, pulled
    sums_out[3], sums_out[4], sums_out[5] = momentum_x, momentum_y, turning


@jit
def write_stress_energies(grid, state):
    """Write the elastic energy of the present stresses to `State.energy` [J], as its start value."""
    cells, x, u, s, energy = grid.cells, grid.reference, state.displacement, state.stress, state.energy
    material, moduli = grid.material, grid.moduli
    for c in range(len(cells)):
        n0, n1, n2, n3 = cells[c, 0], cells[c, 1], cells[c, 2], cells[c, 3]
        ax, ay = x[n2, 0] + u[n2, 0] - (x[n0, 0] + u[n0, 0]), x[n2, 1] + u[n2, 1] - (x[n0, 1] + u[n0, 1])
        bx, by = x[n3, 0] + u[n3, 0] - (x[n1, 0] + u[n1, 0]), x[n3, 1] + u[n3, 1] - (x[n1, 1] + u[n1, 1])
        first, shear = moduli[material[c], 0], moduli[material[c], 1]
        energy[c] = 0.5 * (ax * by - bx * ay) * energy_density(s[c, 0], s[c, 1], s[c, 2], s[c, 3], first, shear)


@jit
def norm_ratio(image, vector, mass):
    """Return |image| / |vector| in the norm weighted with nodal masses; both have the shape (n, 2)."""
    above = below = 0.0
    for n in range(len(mass)):
        above += mass[n] * (image[n, 0] * image[n, 0] + image[n, 1] * image[n, 1])
        below += mass[n] * (vector[n, 0] * vector[n, 0] + vector[n, 1] * vector[n, 1])
    return sqrt(above / below)
