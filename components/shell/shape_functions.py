"""Moving least squares: shape functions and their full derivatives, for many points at a time.

N_J = p(0)^T A^-1 p_J W_J, A = sum p_J p_J^T W_J, with the basis p in coordinates relative to the point, and

    N_J,k = (p_,k - A_,k A^-1 p(0))^T A^-1 p_J W_J + p(0)^T A^-1 p_J W_J,k.

Sums run over the neighbours in order, and the moment matrix is decomposed without a library: bitwise the same on every machine.
The functions reproduce the span of the basis but do not interpolate: the field at a node is not the parameter of the node.
Source: Gato & Shie (2010), after (2).
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from ..support.float_arrays import FloatArray
from ..support.jit import internal, jit

BasisName = Literal["linear", "quadratic"]
# A pivot of the moment matrix below this fraction of its entry is a rounding error: the point has too few neighbours.
SMALLEST_PIVOT = 1e-10


class UnspannedBasisError(ValueError):
    """The neighbours of a point do not span the basis.

    Attributes:
        point: index of the point among the requested points.
        place: coordinates of the point along the axes of the lattice, () if they are unknown.
    """

    def __init__(self, point: int, message: str = "", place: tuple[float, ...] = ()) -> None:
        super().__init__(message or f"the neighbours of point {point} do not span the basis")
        self.point, self.place = point, place


def quartic_spline(s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return W = 1 - 6 s^2 + 8 s^3 - 3 s^4 for |s| < 1 and its derivative, 0 beyond."""
    a = np.abs(s)
    inside = a < 1.0
    value = 1.0 + a * a * (-6.0 + a * (8.0 - 3.0 * a))
    slope = s * (-12.0 + a * (24.0 - 12.0 * a))
    return np.where(inside, value, 0.0), np.where(inside, slope, 0.0)


def basis_values(offsets: FloatArray, basis: BasisName) -> list[FloatArray]:
    """Return the basis at offsets from a point, (..., 3): 1, the coordinates, and for a quadratic basis their products."""
    x, y, z = offsets[..., 0], offsets[..., 1], offsets[..., 2]
    linear = [np.ones_like(x), x, y, z]
    return linear if basis == "linear" else [*linear, x * x, y * y, z * z, y * z, z * x, x * y]


def moving_least_squares(
    offsets: FloatArray, weights: FloatArray, slopes: FloatArray, basis: BasisName
) -> tuple[FloatArray, FloatArray]:
    """Return shape functions (k, s) and their gradients (k, s, 3) [1/m] at s points of k neighbours each.

    Args:
        offsets: of the neighbours from the point, shape (k, s, 3) [m].
        weights: of the neighbours, 0 for padding, shape (k, s).
        slopes: gradients of the weights with respect to the point, shape (k, s, 3) [1/m].
        basis: "linear" or "quadratic", the functions that are reproduced.

    Raises:
        UnspannedBasisError: the neighbours of a point do not span the basis.
    """
    length = np.abs(np.where(weights[..., None] > 0.0, offsets, 0.0)).max(axis=(0, 2))
    # A point without neighbours other than itself has no length scale; its moment matrix is singular with any scale.
    length = np.where(length > 0.0, length, 1.0)
    p = basis_values(offsets / length[:, None], basis)
    lower, pivots = decompose_ldl(_moment_matrix(p, weights))
    unit = [np.ones_like(length), *[np.zeros_like(length) for _ in p[1:]]]
    at_point = solve_ldl(lower, pivots, unit)
    spread = _combine_basis(p, at_point)
    gradients = np.empty_like(offsets)
    for k in range(3):
        change = [-(one * spread * slopes[..., k]).sum(axis=0) for one in p]
        change[1 + k] = change[1 + k] + 1.0 / length
        gradients[..., k] = _combine_basis(p, solve_ldl(lower, pivots, change)) * weights + spread * slopes[..., k]
    return spread * weights, gradients


def _combine_basis(p: list[FloatArray], factors: list[FloatArray]) -> FloatArray:
    """Return for each neighbour the sum of the basis functions times the factors of its point, shape (k, s)."""
    total = p[0] * factors[0]
    for one, factor in zip(p[1:], factors[1:], strict=True):
        total = total + one * factor
    return total


def _moment_matrix(p: list[FloatArray], weights: FloatArray) -> list[list[FloatArray]]:
    """Return the lower triangle of the moment matrix, row by row, each entry of shape (s,)."""
    return [[(p[row] * p[column] * weights).sum(axis=0) for column in range(row + 1)] for row in range(len(p))]


def decompose_ldl(matrix: list[list[FloatArray]]) -> tuple[list[list[FloatArray]], list[FloatArray]]:
    """Return L and D of A = L D L^T for many symmetric matrices, given by their lower triangles; L without its diagonal.

    Raises:
        UnspannedBasisError: a matrix is singular to working precision; its index is the point.
    """
    lower: list[list[FloatArray]] = []
    pivots: list[FloatArray] = []
    for row, entries in enumerate(matrix):
        scaled: list[FloatArray] = []
        for column in range(row):
            entry = entries[column]
            for k in range(column):
                entry = entry - scaled[k] * lower[column][k]
            scaled.append(entry)
        factors = [entry / pivots[column] for column, entry in enumerate(scaled)]
        pivot = entries[row]
        for factor, entry in zip(factors, scaled, strict=True):
            pivot = pivot - factor * entry
        poor = ~(pivot > SMALLEST_PIVOT * entries[row])
        if poor.any():
            raise UnspannedBasisError(int(np.argmax(poor)))
        lower.append(factors)
        pivots.append(pivot)
    return lower, pivots


def solve_ldl(lower: list[list[FloatArray]], pivots: list[FloatArray], right: list[FloatArray]) -> list[FloatArray]:
    """Return x of L D L^T x = right."""
    found: list[FloatArray] = []
    for row, entry in enumerate(right):
        for k in range(row):
            entry = entry - lower[row][k] * found[k]
        found.append(entry)
    found = [entry / pivot for entry, pivot in zip(found, pivots, strict=True)]
    for row in reversed(range(len(found))):
        for k in range(row + 1, len(found)):
            found[row] = found[row] - lower[k][row] * found[k]
    return found


# -- in compiled code, point by point, for points at cracks -----------------------------------------------


@jit
def least_squares_rows(offsets, weights, slopes, size, values, gradients, is_spanned):
    """Write moving-least-squares functions and their gradients, point by point, in a fixed order of sums.

    Like `moving_least_squares`, whose sums however depend on the number of points per call.

    Args:
        offsets: of the neighbours, shape (s, k, 3) [m].
        weights: 0 for padding, shape (s, k).
        slopes: gradients of the weights, shape (s, k, 3) [1/m].
        size: number of basis functions, 4 or 10.
        values: written, shape (s, k).
        gradients: written, shape (s, k, 3) [1/m].
        is_spanned: written: whether the neighbours span the basis, shape (s,).
    """
    moment, factor = np.zeros((10, 10)), np.zeros((10, 10))
    p, x, change = np.zeros(10), np.zeros(10), np.zeros(10)
    for s in range(weights.shape[0]):
        values[s], gradients[s] = 0.0, 0.0
        length = 0.0
        for j in range(weights.shape[1]):
            if weights[s, j] > 0.0:
                length = max(length, abs(offsets[s, j, 0]), abs(offsets[s, j, 1]), abs(offsets[s, j, 2]))
        is_spanned[s] = length > 0.0
        if not is_spanned[s]:
            continue
        moment[:] = 0.0
        for j in range(weights.shape[1]):
            if weights[s, j] > 0.0:
                write_basis(offsets[s, j], length, size, p)
                for row in range(size):
                    for column in range(row + 1):
                        moment[row, column] += p[row] * p[column] * weights[s, j]
        is_spanned[s] = decompose_in_place(moment, factor, size)
        if not is_spanned[s]:
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
    """Write to `p` the basis at an offset divided by a length: 1, the coordinates and, for ten functions, their products."""
    x, y, z = offset[0] / length, offset[1] / length, offset[2] / length
    p[0], p[1], p[2], p[3] = 1.0, x, y, z
    if size > 4:
        p[4], p[5], p[6], p[7], p[8], p[9] = x * x, y * y, z * z, y * z, z * x, x * y


@internal
def decompose_in_place(moment, factor, size):
    """Write L below the diagonal and D on it, for a symmetric matrix (lower triangle); return whether it is regular."""
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
    """Overwrite the right side with the solution of L D L^T x = right."""
    for row in range(size):
        for k in range(row):
            x[row] -= factor[row, k] * x[k]
    for row in range(size):
        x[row] /= factor[row, row]
    for row in range(size - 1, -1, -1):
        for k in range(row + 1, size):
            x[row] -= factor[k, row] * x[k]
