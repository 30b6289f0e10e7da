"""The highest frequency of a grid at rest, which bounds the step: 2 / omega is the largest that leapfrog bears."""

from __future__ import annotations

import math

import numpy as np

from ..support.arrays import FloatArray
from ..support.counter_random import uniform
from ..support.result_cache import ResultCache
from . import kernels
from .layout import Conditions, Grid, State

# Strains so small that the geometry stays what it is, to rounding.
_SMALL = 1e-13
_ITERATIONS = 100
_SETTLED = 2e-5
# The part of the largest stable step that is allowed, and the part that is suggested.
ALLOWED, SUGGESTED = 0.9, 0.8
_found = ResultCache()


def highest_frequency(grid: Grid, conditions: Conditions, corner: FloatArray) -> float:
    """Return the highest angular frequency of the grid at rest [rad/s], by power iteration: up to half a percent too low.

    Args:
        grid: see `layout.Grid`.
        conditions: what is prescribed, and what moves as one.
        corner: scratch of the kernels; its last row is 0.
    """
    # Of plastic laws nothing counts, and of the conditions where nodes cannot move and which move as one.
    inputs = (*grid._replace(laws=np.zeros(0)), conditions.nodes, conditions.prescribed, conditions.groups)
    return _found.get(inputs, lambda: _compute_frequency(grid, conditions, corner))


def _compute_frequency(grid: Grid, conditions: Conditions, corner: FloatArray) -> float:
    n, m = len(grid.reference), len(grid.cells)
    nothing = np.zeros(0)
    elastic = grid._replace(laws=np.zeros_like(grid.laws))
    state = State(
        np.zeros((n, 2)), np.zeros((n, 2)), np.zeros((n, 2)), np.zeros((m, 4)), np.zeros((m, 2)), np.zeros(m), nothing, nothing
    )
    held = np.zeros((n, 2), dtype=bool)
    held[conditions.nodes] = conditions.prescribed.astype(bool)
    size = _SMALL * math.sqrt(float(np.abs(corner_area(grid)).min()))
    shape = uniform(1, 0, 2 * n).reshape(n, 2) - 0.5
    for group in conditions.groups:
        members = group[group >= 0]
        shape[members] = shape[members[0]]
    events, counts = np.zeros((1, 5)), np.zeros(1, dtype=np.int64)
    square = 0.0
    for _ in range(_ITERATIONS):
        shape[held] = 0.0
        largest = float(np.abs(shape).max())
        if largest == 0.0:
            return 0.0
        state.velocity[:] = shape * (size / largest)
        state.stress[:] = 0.0
        state.hourglass_force[:] = 0.0
        kernels.forces(elastic, state, conditions.groups, corner, 1.0, 0, events, counts)
        state.force[held] = 0.0
        shape = state.force / (-grid.mass[:, np.newaxis])
        # |K x| / |M x| in the norm of the masses: between Rayleigh's quotient and the highest one.
        before, square = square, kernels.norm_ratio(shape, state.velocity, grid.mass)
        if abs(square - before) <= _SETTLED * square:
            break
    return math.sqrt(square)


def corner_area(grid: Grid) -> FloatArray:
    """Return the area of each cell before anything moves, shape (m,) [m2]."""
    corners = grid.reference[grid.cells]
    first, second = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    return 0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
