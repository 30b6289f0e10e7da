"""The solid over one tick, in total Lagrangian form: drift, strains and stresses at the points, forces at the nodes, kick.

    f_I = -sum_p V_p (dN_I/dX_j)(X_p) P_ji,    P = F^-1 tau,    F = 1 + sum_J u_J (x) dN_J/dX

A tick is a half kick, a drift, new stresses and forces, a half kick (velocity Verlet, which is the central difference of the
paper with the velocities of whole ticks). Points gather from their neighbours, and nodes from the points that see them, both
in a fixed order: the bits do not depend on who does which part.
Source: Gato & Shie (2010), section 2.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from ..materials.finite_strain import nominal_stress, strain_and_spin, turn_stress
from ..materials.tensors import (
    Tensor,
    add,
    contract,
    determinant,
    load_deformation,
    load_symmetric,
    store_symmetric,
    subtract,
    trace,
    trial_stress,
)
from ..materials.thermoviscoplastic import advance_stress, elastic_moduli
from ..support.jit import internal, internal_inlined, jit
from .hourglass import hold_columns
from .kernel_arrays import (
    BOUNDARY_IMPULSE,
    BOUNDARY_WORK,
    FLOWN,
    HEATED,
    INVERTED,
    PRESSURE_IMPULSE,
    PRESSURE_WORK,
    STRAINED,
    WALL_FORCE,
    WALL_IMPULSE,
)

# numba compiles a function again for an argument that is a literal number.
_ZERO = np.int64(0)
# A plastic strain, a temperature [K] or a strain in one tick beyond these is absurd.
LARGEST_PLASTIC_STRAIN, LARGEST_TEMPERATURE, LARGEST_STRAIN_OF_TICK = 10.0, 1e4, 0.2


@jit
def advance(solid, state, scratch, signals, pressures, tally, first_tick, failed):
    """Advance by as many ticks as `signals` has rows, in one part; return 0 or a status of `kernel_arrays`.

    See `ticks.advance` for the arguments.
    """
    for row in range(signals.shape[0]):
        failed[1] = first_tick + row + 1
        drift(solid, state, scratch, signals[row], pressures, tally)
        status = update_stresses(solid, state, scratch, _ZERO, solid.body.volume.size, failed)
        if status != 0:
            return status
        hold_columns(solid, state, scratch, _ZERO, solid.hourglass.partner.shape[0])
        gather_forces(solid, state, scratch, _ZERO, solid.body.mass.size)
        kick(solid, state, scratch, signals[row], pressures, tally)
    return 0


@jit
def drift(solid, state, scratch, signals, pressures, tally):
    """Make the first half kick, and move the nodes; tally what prescribed velocities do.

    Args:
        solid: `kernel_arrays.Solid`.
        state: `kernel_arrays.State`.
        scratch: `kernel_arrays.Scratch`.
        signals: of the tick, as the next two in `ticks.Inputs`.
        pressures: at the stations [Pa].
        tally: shape (TALLY,).
    """
    body, surface, step = solid.body, solid.surface, solid.step
    u, v, f, mass, prescribed = state.displacement, state.velocity, state.force, body.mass, body.prescribed
    half, factor = 0.5 * step, signals[0]
    for s in range(surface.nodes.size):
        j = surface.nodes[s]
        load = half * factor * pressures[surface.station[s]]
        for i in range(3):
            scratch.before[s, i] = v[j, i]
            impulse = load * state.area[s, i]
            tally[PRESSURE_IMPULSE + i] += impulse
            if prescribed[j, i] == 0:
                v[j, i] += impulse / mass[j]
            else:
                tally[BOUNDARY_IMPULSE + i] -= impulse
    for j in range(mass.size):
        share = half / mass[j]
        for i in range(3):
            if prescribed[j, i] == 0:
                v[j, i] += share * f[j, i]
            else:
                given = signals[prescribed[j, i]] if prescribed[j, i] < 255 else 0.0
                tally[BOUNDARY_IMPULSE + i] += mass[j] * (given - v[j, i]) - half * f[j, i]
                tally[BOUNDARY_WORK] += 0.5 * mass[j] * (given * given - v[j, i] * v[j, i]) - half * f[j, i] * given
                v[j, i] = given
            u[j, i] += step * v[j, i]
    tally[WALL_IMPULSE] += half * tally[WALL_FORCE]


@jit
def kick(solid, state, scratch, signals, pressures, tally):
    """Make the second half kick with the new forces, and tally the work of the pressure."""
    body, surface, step = solid.body, solid.surface, solid.step
    v, f, mass, prescribed = state.velocity, state.force, body.mass, body.prescribed
    half, factor = 0.5 * step, signals[0]
    for j in range(mass.size):
        share = half / mass[j]
        for i in range(3):
            if prescribed[j, i] == 0:
                v[j, i] += share * f[j, i]
            else:
                tally[BOUNDARY_IMPULSE + i] -= half * f[j, i]
                tally[BOUNDARY_WORK] -= half * f[j, i] * v[j, i]
    measure_wall(solid, state, tally)
    tally[WALL_IMPULSE] += half * tally[WALL_FORCE]
    work = 0.0
    for s in range(surface.nodes.size):
        j = surface.nodes[s]
        pressure = factor * pressures[surface.station[s]]
        x, y, z = surface_area(surface, state.displacement, s)
        for i in range(3):
            new = x if i == 0 else (y if i == 1 else z)
            impulse = half * pressure * new
            tally[PRESSURE_IMPULSE + i] += impulse
            if prescribed[j, i] == 0:
                v[j, i] += impulse / mass[j]
                work += 0.5 * half * pressure * (state.area[s, i] + new) * (scratch.before[s, i] + v[j, i])
            else:
                tally[BOUNDARY_IMPULSE + i] -= impulse
            state.area[s, i] = new
    tally[PRESSURE_WORK] += work


@internal
def surface_area(surface, u, s):
    """Return the area of the inner surface on one of its nodes, along its normal into the body [m^2]: x, y, z.

    A quarter of the four triangles to its neighbours, twice: exact for the quarter cells of a plane surface.
    """
    before, after, left, right = surface.around[s, 0], surface.around[s, 1], surface.around[s, 2], surface.around[s, 3]
    ax, ay, az = edge(surface, u, before, after)
    bx, by, bz = edge(surface, u, left, right)
    return 0.25 * (ay * bz - az * by), 0.25 * (az * bx - ax * bz), 0.25 * (ax * by - ay * bx)


@internal
def edge(surface, u, first, second):
    """Return the vector from one node of the surface to another, as they are now [m]."""
    a, b, x = surface.nodes[first], surface.nodes[second], surface.reference
    return (
        (x[second, 0] + u[b, 0]) - (x[first, 0] + u[a, 0]),
        (x[second, 1] + u[b, 1]) - (x[first, 1] + u[a, 1]),
        (x[second, 2] + u[b, 2]) - (x[first, 2] + u[a, 2]),
    )


@jit
def update_stresses(solid, state, scratch, begin, end, failed):
    """Advance the stresses of some points to the displacements of now, and write what pulls on their nodes.

    Returns:
        0, or a status; then `failed` holds the point, and `scratch.pull` in its row the value that decided and its limit.
    """
    body, law, u = solid.body, solid.law, state.displacement
    starts, lowest, offsets = body.begin, body.lowest, body.offsets
    kind, first, gradients = body.kind, body.first, body.gradients
    old, stresses, pull = state.gradient, state.stress, scratch.pull
    moduli = elastic_moduli(law, law.reference_temperature)
    for p in range(begin, end):
        axx, axy, axz, ayx, ayy, ayz, azx, azy, azz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        row, low = first[kind[p]], lowest[p]
        for entry in range(starts[p], starts[p + 1]):
            j = low + offsets[entry]
            ux, uy, uz = u[j, 0], u[j, 1], u[j, 2]
            gx, gy, gz = gradients[row, 0], gradients[row, 1], gradients[row, 2]
            row += np.uint32(1)
            axx += ux * gx
            axy += ux * gy
            axz += ux * gz
            ayx += uy * gx
            ayy += uy * gy
            ayz += uy * gz
            azx += uz * gx
            azy += uz * gy
            azz += uz * gz
        stretch = body.along[p]
        axx, ayx, azx = stretch * axx, stretch * ayx, stretch * azx
        # From the frame of the point to that of the body.
        c, s = body.cosine[p], body.sine[p]
        axy, axz = c * axy + s * axz, c * axz - s * axy
        ayy, ayz = c * ayy + s * ayz, c * ayz - s * ayy
        azy, azz = c * azy + s * azz, c * azz - s * azy
        after = Tensor(1.0 + axx, axy, axz, ayx, 1.0 + ayy, ayz, azx, azy, 1.0 + azz)
        volume = determinant(after)
        if not (volume > 0.0 and volume < 1e300):
            failed[0], pull[p, 0], pull[p, 1] = p, volume, 0.0
            return INVERTED
        strain, spin = strain_and_spin(load_deformation(old, p), after)
        largest = max(abs(strain.xx), abs(strain.yy), abs(strain.zz), abs(strain.xy), abs(strain.yz), abs(strain.zx))
        if not largest < LARGEST_STRAIN_OF_TICK:
            failed[0], pull[p, 0], pull[p, 1] = p, largest, LARGEST_STRAIN_OF_TICK
            return STRAINED
        old[p, 0], old[p, 1], old[p, 2], old[p, 3], old[p, 4] = axx, axy, axz, ayx, ayy
        old[p, 5], old[p, 6], old[p, 7], old[p, 8] = ayz, azx, azy, azz
        turned = turn_stress(load_symmetric(stresses, p), spin)
        if solid.plastic:
            new = advance_stress(law, turned, strain, state.plastic_strain[p], state.temperature[p])
            if not new.plastic_strain < LARGEST_PLASTIC_STRAIN:
                failed[0], pull[p, 0], pull[p, 1] = p, new.plastic_strain, LARGEST_PLASTIC_STRAIN
                return FLOWN
            if not new.temperature < LARGEST_TEMPERATURE:
                failed[0], pull[p, 0], pull[p, 1] = p, new.temperature, LARGEST_TEMPERATURE
                return HEATED
            if new.work > 0.0:
                moduli = elastic_moduli(law, state.temperature[p])
                state.plastic_work[p] += dissipation(moduli, turned, new.stress, strain)
            stress = new.stress
            state.plastic_strain[p], state.temperature[p] = new.plastic_strain, new.temperature
        else:
            stress = trial_stress(turned, strain, moduli)
        store_symmetric(stresses, p, stress)
        write_point_pull(body, p, nominal_stress(after, stress), pull)
    return 0


@internal_inlined
def write_point_pull(body, p, nominal, pull_out):
    """Write the nominal stress of a point times its volume, in the frame of the point [N m]."""
    pull, volume = pull_out, body.volume[p]
    c, s = volume * body.cosine[p], volume * body.sine[p]
    volume *= body.along[p]
    pull[p, 0], pull[p, 1], pull[p, 2] = volume * nominal.xx, volume * nominal.xy, volume * nominal.xz
    pull[p, 3], pull[p, 6] = c * nominal.yx - s * nominal.zx, s * nominal.yx + c * nominal.zx
    pull[p, 4], pull[p, 7] = c * nominal.yy - s * nominal.zy, s * nominal.yy + c * nominal.zy
    pull[p, 5], pull[p, 8] = c * nominal.yz - s * nominal.zz, s * nominal.yz + c * nominal.zz


@internal_inlined
def dissipation(moduli, before, after, strain):
    """Return the work of a tick that is not stored, by the mean of both stresses: plastic, and against thermal expansion.

    `before` and `after` are the turned stress before the tick and the stress after it [Pa], `strain` that of the tick.
    """
    twice_mean, change = add(before, after), subtract(after, before)
    traces = trace(twice_mean) * (after.xx + after.yy + after.zz - before.xx - before.yy - before.zz)
    traces = traces * moduli.first_lame / (3.0 * moduli.first_lame + 2.0 * moduli.shear)
    stored = (contract(twice_mean, change) - traces) / (2.0 * moduli.shear)
    return 0.5 * (contract(twice_mean, strain) - stored)


@jit
def gather_forces(solid, state, scratch, begin, end):
    """Write the forces on some nodes: of the points that see them, of the hourglass control, of a wall."""
    body, pull, force = solid.body, scratch.pull, state.force
    starts, lowest, offsets, slots = body.seen_begin, body.seen_lowest, body.seen_offsets, body.seen_slot
    kind, first = body.kind, body.first
    gradients, layers, shares = body.gradients, solid.hourglass.layers, solid.hourglass.shares
    held, has_wall = solid.hourglass.partner.shape[0] > 0, body.bounce.size > 0
    for j in range(begin, end):
        x, y, z, low = 0.0, 0.0, 0.0, lowest[j]
        for entry in range(starts[j], starts[j + 1]):
            p = low + offsets[entry]
            row = first[kind[p]] + slots[entry]
            gx, gy, gz = gradients[row, 0], gradients[row, 1], gradients[row, 2]
            x -= gx * pull[p, 0] + gy * pull[p, 3] + gz * pull[p, 6]
            y -= gx * pull[p, 1] + gy * pull[p, 4] + gz * pull[p, 7]
            z -= gx * pull[p, 2] + gy * pull[p, 5] + gz * pull[p, 8]
        if held:
            column, share = j // layers, shares[j]
            x += share * scratch.column_force[column, 0]
            y += share * scratch.column_force[column, 1]
            z += share * scratch.column_force[column, 2]
        if has_wall:
            depth = wall_depth(solid, state, j)
            x += solid.wall[1] * body.bounce[j] * depth
        force[j, 0], force[j, 1], force[j, 2] = x, y, z


@internal
def wall_depth(solid, state, j):
    """Return how far a node is behind the wall [m]."""
    depth = solid.wall[1] * (solid.wall[0] - (solid.reference[j, 0] + state.displacement[j, 0]))
    return depth if depth > 0.0 else 0.0


@jit
def measure_wall(solid, state, tally):
    """Write the force of the wall on the body now [N]."""
    force = 0.0
    for j in range(solid.body.bounce.size):
        force += solid.wall[1] * solid.body.bounce[j] * wall_depth(solid, state, j)
    tally[WALL_FORCE] = force


@jit
def write_areas(solid, state):
    """Write the area of the inner surface on each of its nodes."""
    for s in range(solid.surface.nodes.size):
        state.area[s, 0], state.area[s, 1], state.area[s, 2] = surface_area(solid.surface, state.displacement, s)


@jit
def norm_ratio(image, vector, mass):
    """Return |image| / |vector| in the norm that weighs nodes with their masses; both of shape (n, 3)."""
    above, below = 0.0, 0.0
    for j in range(mass.size):
        for i in range(3):
            above += mass[j] * image[j, i] * image[j, i]
            below += mass[j] * vector[j, i] * vector[j, i]
    return sqrt(above / below)


@jit
def interpolate(stencils, field, out):
    """Write a field at points, from its parameters at the nodes, shape (n, 3): u(X_p) = sum_J N_J u_J.

    `stencils` are the `Stencils` of the points.
    """
    begin, lowest, offsets, values = stencils.begin, stencils.lowest, stencils.offsets, stencils.values
    for p in range(out.shape[0]):
        x, y, z = 0.0, 0.0, 0.0
        row = stencils.first[stencils.kind[p]]
        for entry in range(begin[p], begin[p + 1]):
            j, value = lowest[p] + offsets[entry], values[row]
            row += np.uint32(1)
            x += value * field[j, 0]
            y += value * field[j, 1]
            z += value * field[j, 2]
        out[p, 0], out[p, 1], out[p, 2] = x, y, z


@jit
def spread_to_nodes(body, values, weights, out):
    """Write at each node the mean of a field over the points that see it, each with its volume and how much it sees.

    It is 0 where no point does.

    Args:
        body: `kernel_arrays.Body`.
        values: shape functions, shape (rows,).
        weights: the field at the points, shape (m,).
        out: shape (n,).
    """
    for j in range(out.size):
        total, field = 0.0, 0.0
        for entry in range(body.seen_begin[j], body.seen_begin[j + 1]):
            p = body.seen_lowest[j] + body.seen_offsets[entry]
            share = abs(values[body.first[body.kind[p]] + body.seen_slot[entry]]) * body.volume[p]
            total += share
            field += share * weights[p]
        out[j] = field / total if total > 0.0 else 0.0
