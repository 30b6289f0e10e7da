"""The highest frequency of the body at rest, which limits the step: the largest stable one of leapfrog is 2 / omega."""

from __future__ import annotations

import numpy as np

from ..support import stable_step
from ..support.counter_random import uniform
from ..support.float_arrays import FloatArray, ordered_sum
from ..support.stable_step import ResultCache
from . import ticks
from .kernel_arrays import Solid, State, make_scratch

# Size of displacements in the iteration, over the size of the stencils: so small that the geometry is unchanged.
_SMALL = 1e-7
_ITERATIONS = 60
_SETTLED = 1e-4
# Upper bound, from measurements, of the ratio of the highest frequency of a cracked body to that of the intact one: points with
# neighbours on one side of a crack only are stiffer.
CRACKED = 1.5
# Ratio of the stiffness of a wall against a node to mass times the squared highest frequency: the step hardly decreases, and a
# rebounding node loses no energy by the step (with ten times this stiffness 1 % of an impact would be lost).
WALL_STIFFNESS = 0.05
_found = ResultCache()


def highest_frequency(solid: Solid) -> float:
    """Return the highest angular frequency of the body at rest [rad/s], by power iteration; 0 if no node can move.

    The solid has no wall; its material is treated as elastic.
    """
    nodes, tied = solid.nodes, solid.hourglass
    inputs = (
        *solid.points, *nodes._replace(prescribed=nodes.prescribed > 0), tied.place, tied.partner, tied.stiffness, tied.shares,
        solid.law.young, solid.law.poisson,
    )  # fmt: skip
    return _found.get(inputs, lambda: _compute_frequency(solid))


def _compute_frequency(solid: Solid) -> float:
    mass = solid.nodes.mass
    n, m, nothing = len(mass), len(solid.points.volume), np.zeros(0)
    state = State(
        np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((m, 9)), np.zeros((m, 6)), nothing, nothing, nothing,
        np.zeros((0, 3)),
    )  # fmt: skip
    scratch, failed = make_scratch(m, len(solid.hourglass.partner), 0), np.zeros(2, dtype=np.int64)
    size = _SMALL / float(np.abs(solid.points.gradients).max())
    shape = uniform(1, 0, 3 * n).reshape(n, 3) - 0.5

    def nodal_forces(displacement: FloatArray) -> FloatArray:
        state.displacement[:] = displacement
        state.gradient[:] = 0.0
        state.stress[:] = 0.0
        ticks.update_forces(solid, state, scratch, failed)
        return state.force

    return stable_step.highest_frequency(
        shape, size, solid.nodes.prescribed > 0, mass, nodal_forces, _norm_ratio, iterations=_ITERATIONS, tolerance=_SETTLED
    )


@np.errstate(all="ignore")
def _norm_ratio(image: FloatArray, vector: FloatArray, mass: FloatArray) -> float:
    """Return |image| / |vector| in the norm weighted with nodal masses; both have the shape (n, 3)."""
    above, below = (ordered_sum(mass[:, None] * one * one) for one in (image, vector))
    return float(np.sqrt(above / below))
