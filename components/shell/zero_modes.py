"""The number of zero-energy modes of a free patch, i.e. of modes in which all integration points have no strain.

A free body has six, the rigid motions. With a rule that has more, the body can deform without energy.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..support.float_arrays import FloatArray
from .geometry.axis import even_axis
from .geometry.lattice import Lattice
from .kernel_arrays import support_entries
from .quadrature import IntegrationPoints, RuleName, integration_points
from .shape_functions import BasisName
from .stencils import Stencils, make_stencils

RIGID_MOTIONS = 6
# Number of columns along each side of the patch; a stiffness below this fraction of the largest one counts as 0.
_COLUMNS, _NONE = 6, 1e-10
_POISSON = 0.3


@lru_cache(maxsize=32)
def zero_mode_count(layers: int, rule: RuleName, thickness_count: int, basis: BasisName, radius: float) -> int:
    """Return the number of zero-energy modes of a free patch of cubes.

    Raises:
        UnspannedBasisError: the neighbours of a point do not span the basis.
    """
    side, depth = even_axis(_COLUMNS - 1.0, _COLUMNS), even_axis(layers - 1.0, layers)
    lattice = Lattice((side, side, depth), bent=False)
    points = integration_points(lattice, rule, thickness_count, radius)
    stencils = make_stencils(lattice, points.lines, radius, basis)
    stiffnesses = np.linalg.eigvalsh(stiffness_matrix(lattice.node_count, points, stencils, 1.0, _POISSON))
    return int((stiffnesses < _NONE * stiffnesses[-1]).sum())


def gradient_matrices(nodes: int, points: IntegrationPoints, stencils: Stencils) -> FloatArray:
    """Return matrices from the nodes' coefficients to the derivatives along x, y, z at the points, shape (3, m, n) [1/m]."""
    count = len(points.volume)
    owner, seen, rows = support_entries(stencils, np.arange(count))
    along, around, out = stencils.gradients[rows].T
    sine, cosine, found = points.sine[owner], points.cosine[owner], np.zeros((3, count, nodes))
    found[:, owner, seen] = stencils.along[owner] * along, cosine * around + sine * out, cosine * out - sine * around
    return found


def stiffness_matrix(nodes: int, points: IntegrationPoints, stencils: Stencils, young: float, poisson: float) -> FloatArray:
    """Return the stiffness matrix of a small body, ordered by all x, then all y, then all z, shape (3n, 3n) [N/m]."""
    lame, shear = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), 0.5 * young / (1 + poisson)
    slopes = gradient_matrices(nodes, points, stencils)
    # Sums over the points of V dN_J/dX_i dN_L/dX_k.
    products = [[(points.volume[:, None] * one).T @ other for other in slopes] for one in slopes]
    alike = shear * (products[0][0] + products[1][1] + products[2][2])
    return np.block([[lame * products[i][k] + shear * products[k][i] + (i == k) * alike for k in range(3)] for i in range(3)])
