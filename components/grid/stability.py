"""The highest frequency of a grid at rest, which limits the step: the largest stable one of leapfrog is 2 / omega."""

from __future__ import annotations

import math

import numpy as np

from ..support import stable_step
from ..support.counter_random import uniform
from ..support.float_arrays import FloatArray
from ..support.stable_step import ResultCache
from . import kernels
from .kernel_arrays import Conditions, Grid, State
from .mesh import cell_areas
from .yielding import NoYield

# Size of the strains in the iteration: so small that the geometry is unchanged to rounding.
_SMALL = 1e-13
_ITERATIONS = 100
_SETTLED = 2e-5
_found = ResultCache()


def highest_frequency(grid: Grid, conditions: Conditions, corner: FloatArray) -> float:
    """Return the highest angular frequency of the grid at rest [rad/s], by power iteration: up to half a percent too low.

    The last row of `corner`, scratch of the kernels, is 0.
    """
    # The frequency does not depend on plastic laws; of the conditions, only prescribed and joined nodes matter.
    nothing = np.zeros(0)
    inputs = (*grid._replace(laws=nothing), conditions.nodes, conditions.prescribed, conditions.groups)
    return _found.get(inputs, lambda: _compute_frequency(grid, conditions, corner))


def _compute_frequency(grid: Grid, conditions: Conditions, corner: FloatArray) -> float:
    n, m = len(grid.reference), len(grid.cells)
    nothing = np.zeros(0)
    elastic = grid._replace(laws=NoYield())
    state = State(
        np.zeros((n, 2)), np.zeros((n, 2)), np.zeros((n, 2)), np.zeros((m, 4)), np.zeros((m, 2)), np.zeros(m), nothing, nothing
    )
    held = np.zeros((n, 2), dtype=bool)
    held[conditions.nodes] = conditions.prescribed.astype(bool)
    size = _SMALL * math.sqrt(float(np.abs(cell_areas(grid.reference, grid.cells.astype(np.int64))).min()))
    shape = uniform(1, 0, 2 * n).reshape(n, 2) - 0.5
    for group in conditions.groups:
        members = group[group >= 0]
        shape[members] = shape[members[0]]

    def nodal_forces(displacement: FloatArray) -> FloatArray:
        # With a step of 1 s, velocities are displacements.
        state.velocity[:] = displacement
        state.stress[:] = 0.0
        state.hourglass_force[:] = 0.0
        kernels.update_forces(elastic, state, conditions.groups, corner, 1.0)
        return state.force

    return stable_step.highest_frequency(
        shape, size, held, grid.mass, nodal_forces, kernels.norm_ratio, iterations=_ITERATIONS, tolerance=_SETTLED
    )
