"""The number of modes without energy of a free patch: what an integration rule does not see.

A body that nothing holds has six, the rigid motions. A rule that has more lets the body deform at no cost. All sums are made
in a fixed order, without a library of linear algebra: whether a rule is refused does not depend on the machine.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..support.float_arrays import FloatArray
from .geometry.lattice import Lattice
from .geometry.lattice_axis import even_axis
from .quadrature import IntegrationPoints, RuleName, integration_points
from .shape_functions import BasisName
from .stencils import Stencils, make_stencils

RIGID_MOTIONS = 6
# Columns along each side of the patch, and the part of the largest pivot below which one counts as 0.
_COLUMNS, _NONE = 6, 1e-10
_POISSON = 0.3


@lru_cache(maxsize=32)
def zero_mode_count(layers: int, rule: RuleName, through: int, basis: BasisName, radius: float) -> int:
    """Return how many modes of a free patch of cubes have no energy.

    Raises:
        UnspannedBasisError: the neighbours of a point do not span the basis.
    """
    side, depth = even_axis(_COLUMNS - 1.0, _COLUMNS), even_axis(layers - 1.0, layers)
    lattice = Lattice((side, side, depth), bent=False)
    points = integration_points(lattice, rule, through, radius)
    stencils = make_stencils(lattice, points.lines, (radius, radius, radius), basis)
    matrix = stiffness_matrix(lattice.node_count, points, stencils, 1.0, _POISSON)
    return len(matrix) - rank(matrix)


def rank(matrix: FloatArray) -> int:
    """Return the rank of a symmetric matrix without negative eigenvalues, by elimination with the largest pivot first."""
    left = matrix.copy()
    least = _NONE * left.diagonal().max()
    for number in range(len(left)):
        pivot = number + int(left.diagonal()[number:].argmax())
        if not left[pivot, pivot] > least:
            return number
        left[[number, pivot]] = left[[pivot, number]]
        left[:, [number, pivot]] = left[:, [pivot, number]]
        row = left[number, number + 1 :]
        left[number + 1 :, number + 1 :] -= row[:, None] * (row / left[number, number])
    return len(left)


def gradient_matrices(nodes: int, points: IntegrationPoints, stencils: Stencils) -> list[FloatArray]:
    """Return the derivatives along x, y and z at the points by the parameters of the nodes, each of shape (m, n) [1/m]."""
    counts = np.diff(stencils.begin.astype(np.int64))
    rows = np.repeat(np.arange(len(counts)), counts)
    slot = np.arange(len(rows)) - np.repeat(stencils.begin[:-1].astype(np.int64), counts)
    local = stencils.gradients[stencils.first[stencils.kind].astype(np.int64)[rows] + slot]
    along = stencils.along[rows]
    sine, cosine = points.sine[rows], points.cosine[rows]
    columns = (
        along * local[:, 0],
        cosine * local[:, 1] + sine * local[:, 2],
        cosine * local[:, 2] - sine * local[:, 1],
    )
    found, nodes_seen = [], stencils.all_neighbours()
    for column in columns:
        matrix = np.zeros((len(counts), nodes))
        matrix[rows, nodes_seen] = column
        found.append(matrix)
    return found


def stiffness_matrix(nodes: int, points: IntegrationPoints, stencils: Stencils, young: float, poisson: float) -> FloatArray:
    """Return the stiffness of a small body, all x first, then y, then z, shape (3n, 3n) [N/m]."""
    first_lame, shear = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), 0.5 * young / (1 + poisson)
    slopes, found = np.stack(gradient_matrices(nodes, points, stencils), axis=1), np.zeros((3, nodes, 3, nodes))
    for point, volume in enumerate(points.volume):
        seen = stencils.neighbours(point)
        slope = slopes[point][:, seen]
        products = volume * slope[:, :, None, None] * slope
        part = first_lame * products + shear * products.transpose(2, 1, 0, 3)
        for k in range(3):
            part[k, :, k] += shear * (products[0, :, 0] + products[1, :, 1] + products[2, :, 2])
        found[:, seen[:, None], :, seen] += part.transpose(1, 3, 0, 2)
    return found.reshape(3 * nodes, 3 * nodes)
