"""The eigenvalues that tell whether an integration rule sees every deformation: the modes without energy of a free patch.

A body that nothing holds has six, the rigid motions. A rule that has more lets the body deform at no cost.
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
# Columns along each side of the patch, and the part of the largest eigenvalue below which one counts as 0.
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
    points = integration_points(lattice, rule, through)
    stencils = make_stencils(lattice, points.lines, (radius, radius, radius), basis)
    values = np.linalg.eigvalsh(stiffness_matrix(lattice.node_count, points, stencils, 1.0, _POISSON))
    return int((values < _NONE * values[-1]).sum())


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
    slopes = gradient_matrices(nodes, points, stencils)
    weighted = [points.volume[:, None] * one for one in slopes]
    diagonal = shear * sum(slopes[k].T @ weighted[k] for k in range(3))
    blocks = [
        [
            first_lame * slopes[i].T @ weighted[j] + shear * slopes[j].T @ weighted[i] + (diagonal if i == j else 0.0)
            for j in range(3)
        ]
        for i in range(3)
    ]
    return np.block(blocks)
