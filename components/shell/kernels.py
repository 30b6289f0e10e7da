"""The solid over one tick, in total Lagrangian form: drift, strains and stresses at the points, forces at the nodes, kick.

    f_I = -sum_p V_p (dN_I/dX_j)(X_p) P_ji,    P = F^-1 tau,    F = 1 + sum_J u_J (x) dN_J/dX

A tick is a half kick, a drift, new stresses and forces, and a half kick (velocity Verlet, i.e. the central difference of the
paper with velocities at whole ticks). Points sum over their neighbours, and nodes over the points with the node in their
supports, both in a fixed order: results are bitwise independent of the order of computation. `ticks` calls these kernels.
Source: Gato & Shie (2010), section 2.
"""

from __future__ import annotations

import numpy as np

from ..materials.finite_strain import nominal_stress, rotate_tensor, strain_and_spin
from ..materials.tensors import (
    Tensor,
    add,
    contract,
    determinant,
    load_deformation_gradient,
    load_symmetric_tensor,
    store_symmetric_tensor,
    subtract,
    trace,
    trial_stress,
)
from ..materials.thermoviscoplastic import advance_stress, elastic_moduli
from ..support.jit import internal_inlined, jit
from .kernel_arrays import (
    BOUNDARY_IMPULSE,
    BOUNDARY_WORK,
    FLOWN,
    HEATED,
    INVERTED,
    PRESSURE_IMPULSE,
    PRESSURE_WORK,
    STRAINED,
)

# Limits of plastic strain, temperature [K], and strain in one tick; a tick in which a point exceeds them has failed.
LARGEST_PLASTIC_STRAIN, LARGEST_TEMPERATURE, LARGEST_STRAIN_OF_TICK = 10.0, 1e4, 0.2


@jit
def drift(nodes, surface, state, scratch, signals, pressures, step, tally):
    """Make the first half kick, and move the nodes; tally the work and impulse of prescribed velocities.

    Args:
        nodes: `kernel_arrays.Nodes`.
        surface: `kernel_arrays.Surface`.
        state: `kernel_arrays.State`.
        scratch: `kernel_arrays.Scratch`; `before` is written.
        signals: means over the tick: the factor of the pressure, then velocities of edges, shape (k,).
        pressures: pressure that the factor scales at each station of the surface, shape (stations,) [Pa].
        step: length of the tick [s].
        tally: sums since the reset, see `kernel_arrays`, shape (TALLY,).
    """
    u, v, f, mass, prescribed = state.displacement, state.velocity, state.force, nodes.mass, nodes.prescribed
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


@jit
def kick(nodes, surface, state, scratch, signals, pressures, step, tally):
    """Make the second half kick with the new forces and areas, and tally the work of the pressure; arguments as in `drift`."""
    v, f, mass, prescribed = state.velocity, state.force, nodes.mass, nodes.prescribed
    half, factor = 0.5 * step, signals[0]
    for j in range(mass.size):
        share = half / mass[j]
        for i in range(3):
            if prescribed[j, i] == 0:
                v[j, i] += share * f[j, i]
            else:
                tally[BOUNDARY_IMPULSE + i] -= half * f[j, i]
                tally[BOUNDARY_WORK] -= half * f[j, i] * v[j, i]
    work = 0.0
    for s in range(surface.nodes.size):
        j = surface.nodes[s]
        pressure = factor * pressures[surface.station[s]]
        for i in range(3):
            new = scratch.area[s, i]
            impulse = half * pressure * new
            tally[PRESSURE_IMPULSE + i] += impulse
            if prescribed[j, i] == 0:
                v[j, i] += impulse / mass[j]
                work += 0.5 * half * pressure * (state.area[s, i] + new) * (scratch.before[s, i] + v[j, i])
            else:
                tally[BOUNDARY_IMPULSE + i] -= impulse
            state.area[s, i] = new
    tally[PRESSURE_WORK] += work


@jit
def write_areas(surface, u, out):
    """Write for each node of the inner surface its area vector, along the normal into the body, shape (s, 3) [m^2].

    It is half the area of the quadrilateral of the four neighbours: on a plane surface exactly a quarter of each adjacent cell.
    """
    x, nodes = surface.reference, surface.nodes
    for s in range(nodes.size):
        before, after, left, right = surface.around[s, 0], surface.around[s, 1], surface.around[s, 2], surface.around[s, 3]
        i, j, k, m = nodes[before], nodes[after], nodes[left], nodes[right]
        ax = (x[after, 0] + u[j, 0]) - (x[before, 0] + u[i, 0])
        ay = (x[after, 1] + u[j, 1]) - (x[before, 1] + u[i, 1])
        az = (x[after, 2] + u[j, 2]) - (x[before, 2] + u[i, 2])
        bx = (x[right, 0] + u[m, 0]) - (x[left, 0] + u[k, 0])
        by = (x[right, 1] + u[m, 1]) - (x[left, 1] + u[k, 1])
        bz = (x[right, 2] + u[m, 2]) - (x[left, 2] + u[k, 2])
        out[s, 0], out[s, 1], out[s, 2] = 0.25 * (ay * bz - az * by), 0.25 * (az * bx - ax * bz), 0.25 * (ax * by - ay * bx)


@jit
def update_stresses(points, law, is_plastic, state, pull, begin, end, failure_out):
    """Advance the stresses of some points to the present displacements, and write their nominal stress times volume.

    Args:
        points: `kernel_arrays.Points`.
        law: `FlowConstants`.
        is_plastic: whether the material can yield.
        state: `kernel_arrays.State`.
        pull: `kernel_arrays.Scratch.pull`.
        begin: first of the points.
        end: one past the last point.
        failure_out: if a point fails, the first entry is set to its number.

    Returns:
        0, or the status of a failure; the point's row of `pull` then contains the value that is too large, and its limit.
    """
    u, starts, nodes = state.displacement, points.begin, points.nodes
    kind, first, gradients = points.kind, points.first, points.gradients
    old, stresses = state.gradient, state.stress
    moduli = elastic_moduli(law, law.reference_temperature)
    for p in range(begin, end):
        axx, axy, axz, ayx, ayy, ayz, azx, azy, azz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        row = first[kind[p]]
        for entry in range(starts[p], starts[p + 1]):
            j = nodes[entry]
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
        stretch = points.along[p]
        axx, ayx, azx = stretch * axx, stretch * ayx, stretch * azx
        # Rotate from the axes of the point to those of the body.
        c, s = points.cosine[p], points.sine[p]
        axy, axz = c * axy + s * axz, c * axz - s * axy
        ayy, ayz = c * ayy + s * ayz, c * ayz - s * ayy
        azy, azz = c * azy + s * azz, c * azz - s * azy
        after = Tensor(1.0 + axx, axy, axz, ayx, 1.0 + ayy, ayz, azx, azy, 1.0 + azz)
        volume = determinant(after)
        if not (volume > 0.0 and volume < 1e300):
            failure_out[0], pull[p, 0], pull[p, 1] = p, volume, 0.0
            return INVERTED
        strain, spin = strain_and_spin(load_deformation_gradient(old, p), after)
        largest = max(abs(strain.xx), abs(strain.yy), abs(strain.zz), abs(strain.xy), abs(strain.yz), abs(strain.zx))
        if not largest < LARGEST_STRAIN_OF_TICK:
            failure_out[0], pull[p, 0], pull[p, 1] = p, largest, LARGEST_STRAIN_OF_TICK
            return STRAINED
        old[p, 0], old[p, 1], old[p, 2], old[p, 3], old[p, 4] = axx, axy, axz, ayx, ayy
        old[p, 5], old[p, 6], old[p, 7], old[p, 8] = ayz, azx, azy, azz
        turned = rotate_tensor(load_symmetric_tensor(stresses, p), spin)
        if is_plastic:
            new = advance_stress(law, turned, strain, state.plastic_strain[p], state.temperature[p])
            if not new.plastic_strain < LARGEST_PLASTIC_STRAIN:
                failure_out[0], pull[p, 0], pull[p, 1] = p, new.plastic_strain, LARGEST_PLASTIC_STRAIN
                return FLOWN
            if not new.temperature < LARGEST_TEMPERATURE:
                failure_out[0], pull[p, 0], pull[p, 1] = p, new.temperature, LARGEST_TEMPERATURE
                return HEATED
            if new.work > 0.0:
                moduli = elastic_moduli(law, state.temperature[p])
                state.plastic_work[p] += dissipation(moduli, turned, new.stress, strain)
            stress = new.stress
            state.plastic_strain[p], state.temperature[p] = new.plastic_strain, new.temperature
        else:
            stress = trial_stress(turned, strain, moduli)
        store_symmetric_tensor(stresses, p, stress)
        write_point_pull(pull, p, nominal_stress(after, stress), points.volume[p], c, s, stretch)
    return 0


@internal_inlined
def write_point_pull(pull, p, nominal, volume, cosine, sine, along):
    """Write the nominal stress of a point times its volume to `pull`, along the axes of the point [N m]."""
    c, s, volume = volume * cosine, volume * sine, volume * along
    pull[p, 0], pull[p, 1], pull[p, 2] = volume * nominal.xx, volume * nominal.xy, volume * nominal.xz
    pull[p, 3], pull[p, 6] = c * nominal.yx - s * nominal.zx, s * nominal.yx + c * nominal.zx
    pull[p, 4], pull[p, 7] = c * nominal.yy - s * nominal.zy, s * nominal.yy + c * nominal.zy
    pull[p, 5], pull[p, 8] = c * nominal.yz - s * nominal.zz, s * nominal.yz + c * nominal.zz


@internal_inlined
def dissipation(moduli, before, after, strain):
    """Return the work of the mean stress in a tick, per volume, that is not stored: plastic, and against thermal expansion.

    `before` is the rotated stress before the tick and `after` the stress after it [Pa], `strain` the strain of the tick.
    """
    twice_mean, change = add(before, after), subtract(after, before)
    traces = trace(twice_mean) * (after.xx + after.yy + after.zz - before.xx - before.yy - before.zz)
    traces = traces * moduli.first_lame / (3.0 * moduli.first_lame + 2.0 * moduli.shear)
    stored = (contract(twice_mean, change) - traces) / (2.0 * moduli.shear)
    return 0.5 * (contract(twice_mean, strain) - stored)


@jit
def gather_forces(points, nodes, hourglass, scratch, force, numbers):
    """Write the forces on some nodes, from the points with the node in their supports and from the hourglass control.

    Args:
        points: `kernel_arrays.Points`.
        nodes: `kernel_arrays.Nodes`.
        hourglass: `kernel_arrays.Hourglass`.
        scratch: `kernel_arrays.Scratch`, with the pull of the points.
        force: written, shape (n, 3) [N].
        numbers: numbers of the nodes, shape (k,).
    """
    pull, starts, seen, slots = scratch.pull, nodes.begin, nodes.points, nodes.slot
    kind, first, gradients = points.kind, points.first, points.gradients
    layers, held = hourglass.layers, hourglass.partner.shape[0] > 0
    for number in range(numbers.size):
        j = numbers[number]
        x, y, z = 0.0, 0.0, 0.0
        for entry in range(starts[j], starts[j + 1]):
            p = seen[entry]
            row = first[kind[p]] + slots[entry]
            gx, gy, gz = gradients[row, 0], gradients[row, 1], gradients[row, 2]
            x -= gx * pull[p, 0] + gy * pull[p, 3] + gz * pull[p, 6]
            y -= gx * pull[p, 1] + gy * pull[p, 4] + gz * pull[p, 7]
            z -= gx * pull[p, 2] + gy * pull[p, 5] + gz * pull[p, 8]
        if held:
            column, share = j // layers, hourglass.shares[j]
            x += share * scratch.column_force[column, 0]
            y += share * scratch.column_force[column, 1]
            z += share * scratch.column_force[column, 2]
        force[j, 0], force[j, 1], force[j, 2] = x, y, z


@jit
def interpolate_field(stencils, field, out):
    """Write the values of a field at points from the coefficients `field` of the nodes, shape (n, 3): u(X_p) = sum_J N_J u_J.

    `stencils` are the `Stencils` of the points.
    """
    begin, nodes, values = stencils.begin, stencils.nodes, stencils.values
    for p in range(out.shape[0]):
        x, y, z = 0.0, 0.0, 0.0
        row = stencils.first[stencils.kind[p]]
        for entry in range(begin[p], begin[p + 1]):
            j, value = nodes[entry], values[row]
            row += np.uint32(1)
            x += value * field[j, 0]
            y += value * field[j, 1]
            z += value * field[j, 2]
        out[p, 0], out[p, 1], out[p, 2] = x, y, z


@jit
def weigh_points(stencils, nodes, volume, numbers, field, out):
    """Write for some nodes their total weight at points, sum_p |N_J| V_p, and sum_p |N_J| V_p f_p with a field f of the points.

    Args:
        stencils: `Stencils` of the points.
        nodes: `kernel_arrays.Nodes`.
        volume: volumes of the points, shape (m,) [m^3].
        numbers: numbers of the nodes, shape (k,).
        field: f, the field at the points, shape (m,).
        out: written, shape (k, 2).
    """
    kind, first, values = stencils.kind, stencils.first, stencils.values
    for number in range(numbers.size):
        j = numbers[number]
        total, weighted = 0.0, 0.0
        for entry in range(nodes.begin[j], nodes.begin[j + 1]):
            p = nodes.points[entry]
            share = abs(values[first[kind[p]] + nodes.slot[entry]]) * volume[p]
            total += share
            weighted += share * field[p]
        out[number, 0], out[number, 1] = total, weighted
