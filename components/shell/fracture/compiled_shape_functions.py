"""Moving-least-squares shape functions in compiled code, each point by itself, as points beside cracks need them."""

from __future__ import annotations

import numpy as np

from ...support.jit import internal, jit
from ..shape_functions import SMALLEST_PIVOT


@jit
def least_squares_rows(offsets, weights, slopes, size, values, gradients, sound):
    """Write moving-least-squares functions and their gradients, each point by itself, in a fixed order of sums.

    As `shape_functions.moving_least_squares`, whose sums depend on how many points there are at a time.

    Args:
        offsets: of the neighbours, shape (s, k, 3) [m].
        weights: 0 of those that are none, shape (s, k).
        slopes: gradients of the weights, shape (s, k, 3) [1/m].
        size: functions of the basis, 4 or 10.
        values: written, shape (s, k).
        gradients: written, shape (s, k, 3) [1/m].
        sound: written: whether the neighbours span the basis, shape (s,).
    """
    moment, factor = np.zeros((10, 10)), np.zeros((10, 10))
    p, x, change = np.zeros(10), np.zeros(10), np.zeros(10)
    for s in range(weights.shape[0]):
        values[s], gradients[s] = 0.0, 0.0
        length = 0.0
        for j in range(weights.shape[1]):
            if weights[s, j] > 0.0:
                length = max(length, abs(offsets[s, j, 0]), abs(offsets[s, j, 1]), abs(offsets[s, j, 2]))
        sound[s] = length > 0.0
        if not sound[s]:
            continue
        moment[:] = 0.0
        for j in range(weights.shape[1]):
            if weights[s, j] > 0.0:
                write_basis(offsets[s, j], length, size, p)
                for row in range(size):
                    for column in range(row + 1):
                        moment[row, column] += p[row] * p[column] * weights[s, j]
        sound[s] = decompose_in_place(moment, factor, size)
        if not sound[s]:
            continue
        x[:] = 0.0
        x[0] = 1.0
        solve_in_place(factor, size, x)
        for j in range(weights.shape[1]):
            if weights[s, j] > 0.0:
                write_basis(offsets[s, j], length, size, p)
                for row in range(size):
                    values[s, j] += p[row] * x[row]
        for k in range(3):
            change[:] = 0.0
            for j in range(weights.shape[1]):
                if weights[s, j] > 0.0:
                    write_basis(offsets[s, j], length, size, p)
                    for row in range(size):
                        change[row] -= p[row] * values[s, j] * slopes[s, j, k]
            change[1 + k] += 1.0 / length
            solve_in_place(factor, size, change)
            for j in range(weights.shape[1]):
                if weights[s, j] > 0.0:
                    write_basis(offsets[s, j], length, size, p)
                    total = 0.0
                    for row in range(size):
                        total += p[row] * change[row]
                    gradients[s, j, k] = total * weights[s, j] + values[s, j] * slopes[s, j, k]
        for j in range(weights.shape[1]):
            values[s, j] *= weights[s, j]


@internal
def write_basis(offset, length, size, p):
    """Write the basis at an offset over a length: 1, the coordinates, and of ten functions their products."""
    x, y, z = offset[0] / length, offset[1] / length, offset[2] / length
    p[0], p[1], p[2], p[3] = 1.0, x, y, z
    if size > 4:
        p[4], p[5], p[6], p[7], p[8], p[9] = x * x, y * y, z * z, y * z, z * x, x * y


@internal
def decompose_in_place(moment, factor, size):
    """Write L below the diagonal and D on it, of a symmetric matrix given below; return whether it is regular."""
    for row in range(size):
        for column in range(row):
            entry = moment[row, column]
            for k in range(column):
                entry -= factor[row, k] * factor[k, k] * factor[column, k]
            factor[row, column] = entry / factor[column, column]
        pivot = moment[row, row]
        for k in range(row):
            pivot -= factor[row, k] * factor[row, k] * factor[k, k]
        if not pivot > SMALLEST_PIVOT * moment[row, row]:
            return False
        factor[row, row] = pivot
    return True


@internal
def solve_in_place(factor, size, x):
    """Put the solution of L D L^T x = right in the place of the right side."""
    for row in range(size):
        for k in range(row):
            x[row] -= factor[row, k] * x[k]
    for row in range(size):
        x[row] /= factor[row, row]
    for row in range(size - 1, -1, -1):
        for k in range(row + 1, size):
            x[row] -= factor[k, row] * x[k]


@jit
def write_hold(body, kind, first, values, nodes, out):
    """Write how much points see some nodes: the sum of shape functions times volumes [m^3].

    Args:
        body: `kernel_arrays.Body`, of which volumes and the points that see each node are read.
        kind: number of each point's rows, shape (m,).
        first: where those begin, shape (kinds,).
        values: shape functions, shape (rows,).
        nodes: shape (k,).
        out: shape (k,).
    """
    for number in range(nodes.size):
        j = nodes[number]
        total = 0.0
        for entry in range(body.seen_begin[j], body.seen_begin[j + 1]):
            p = body.seen_lowest[j] + body.seen_offsets[entry]
            total += abs(values[first[kind[p]] + body.seen_slot[entry]]) * body.volume[p]
        out[number] = total
