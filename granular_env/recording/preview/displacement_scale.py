"""The scale of drawn displacements, which makes a wave of microns visible on bodies of millimetres."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ...components.support.float_arrays import FloatArray
from ...components.support.round_numbers import round_down_to_125

# Largest size with which the deepest overlap of two neighbours is drawn, relative to the smaller radius.
_DRAWN_OVERLAP = 0.5
# Largest drawn displacement of points and of the nodes of cells, relative to the scene's length.
_DRAWN_TRAVEL, _DRAWN_NODE_TRAVEL = 1.0, 0.1
_LARGEST = 1e9
# Two particles are neighbours up to this distance, relative to the sum of their radii.
_NEARLY = 1.1


def common_exaggeration(
    points: Iterable[tuple[FloatArray, FloatArray, FloatArray]], cells: Iterable[tuple[FloatArray, FloatArray]]
) -> float:
    """Return one factor for all drawn displacements, at which particles do not pass one another and nodes stay close.

    Args:
        points: reference (n, 3), radius (n,) and displacement (frames, n, 3) of points [m].
        cells: reference (n, d) and displacement (frames, n, d) of the nodes of cells [m].
    """
    factors = [choose_exaggeration(*one) for one in points if one[2].any()]
    for nodes, displacement in cells:
        if (travel := float(np.abs(displacement).max(initial=0.0))) > 0.0:
            factors.append(max(1.0, round_down_to_125(_DRAWN_NODE_TRAVEL * float(np.ptp(nodes, axis=0).max()) / travel)))
    return min(factors, default=1.0)


def choose_exaggeration(reference: FloatArray, radius: FloatArray, displacement: FloatArray) -> float:
    """Return the factor by which displacements are drawn larger, of the form 1, 2 or 5 x 10^k and at least 1.

    There are two limits. Neighbours (in a row along x; in a plane and in space those that nearly touch) overlap by at most
    half a radius, so they do not pass one another. No displacement exceeds the length of the scene.

    Args:
        reference: positions at rest, shape (n, 3) [m].
        radius: shape (n,) [m].
        displacement: shape (frames, n, 3) [m].
    """
    travel = float(np.abs(displacement).max(initial=0.0))
    low, high = (reference - radius[:, None]).min(axis=0), (reference + radius[:, None]).max(axis=0)
    factor = _DRAWN_TRAVEL * float((high - low).max()) / travel if travel > 0.0 else 1.0
    if len(radius) > 1:
        factor = min(factor, _overlap_limit(reference, radius, displacement))
    return round_down_to_125(min(factor, _LARGEST) * (1.0 + 1e-12)) if factor > 1.0 else 1.0


def _overlap_limit(reference: FloatArray, radius: FloatArray, displacement: FloatArray) -> float:
    """Return the largest display factor at which no neighbours overlap too far, from their approach along their axis."""
    if np.ptp(reference[:, 1:], axis=0).any():
        from scipy.spatial import KDTree

        pairs = KDTree(reference).query_pairs(_NEARLY * 2.0 * float(radius.max()), output_type="ndarray")
    else:
        order = np.argsort(reference[:, 0], kind="stable")
        pairs = np.stack([order[:-1], order[1:]], axis=1)
    one, other = pairs.T
    apart = reference[other] - reference[one]
    distance = np.sqrt((apart * apart).sum(axis=1))
    way = np.divide(apart, distance[:, None], out=np.zeros_like(apart), where=distance[:, None] > 0.0)
    closing = -((displacement[:, other] - displacement[:, one]) * way).sum(axis=2).min(axis=0, initial=0.0)
    gap = np.maximum(distance - radius[one] - radius[other], 0.0)
    allowed = gap + _DRAWN_OVERLAP * np.minimum(radius[one], radius[other])
    moving = closing > 0.0
    return float((allowed[moving] / closing[moving]).min(initial=_LARGEST))
