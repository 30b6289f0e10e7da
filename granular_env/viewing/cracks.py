"""Drawing of cracks: a broken link is a short line across its middle, a broken cell falls into a piece for each corner.

With many points, the lines of intact links would hide the points' colours, so only broken links are drawn.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from granular_env.components.support.float_arrays import FloatArray

# With more links than this, the lines of intact links are not drawn, because they would hide the points.
MOST_LINES = 400
# Length of a drawn crack, and the distance of its two points beyond which none is drawn, relative to their rest distance.
_LENGTH, _FARTHEST = 0.6, 1.5


def crack_lines(
    places: FloatArray, rest: FloatArray, pairs: npt.NDArray[np.int64], state: FloatArray, normal: FloatArray
) -> FloatArray:
    """Return a short line across the middle of each broken link, shape (cracks, 2, 3) [m].

    Points that have moved far apart leave a visible gap and get no line.

    Args:
        places: drawn positions of the points, shape (n, 3) [m].
        rest: initial positions, shape (n, 3) [m].
        pairs: indices of the two points of each link, shape (m, 2).
        state: 0 for a broken link, shape (m,).
        normal: viewing direction, to which the cracks are perpendicular, shape (3,).
    """
    broken = pairs[state == 0.0]
    along, began = places[broken[:, 1]] - places[broken[:, 0]], rest[broken[:, 1]] - rest[broken[:, 0]]
    length, distance = (np.sqrt((one * one).sum(axis=1)) for one in (along, began))
    is_near = (length < _FARTHEST * distance) & (length > 0.0)
    reach = 0.5 * _LENGTH * (distance[is_near] / length[is_near])[:, None] * np.cross(normal, along[is_near])
    middle = places[broken[is_near]].mean(axis=1)
    return np.stack([middle - reach, middle + reach], axis=1)


def corner_pieces(rest: FloatArray, displacement: FloatArray, connectivity: npt.NDArray[np.int64]) -> FloatArray:
    """Return the quadrilaterals into which broken cells fall, one for each corner, which move with their nodes.

    A piece has the corner's node, the middles of the two adjacent edges, and the middle of the cell in the initial state.

    Args:
        rest: initial positions of the nodes, shape (n, d) [m].
        displacement: drawn displacements of the nodes, shape (n, d) [m].
        connectivity: nodes of each broken cell in cyclic order, shape (m, k).

    Returns:
        Corners of the pieces, shape (m k, 4, d) [m].
    """
    corners = rest[connectivity]
    middles = 0.5 * (corners + np.roll(corners, -1, axis=1))
    centres = np.broadcast_to(corners.mean(axis=1, keepdims=True), corners.shape)
    pieces = np.stack([corners, middles, centres, np.roll(middles, 1, axis=1)], axis=2)
    return (pieces + displacement[connectivity][:, :, None]).reshape(-1, 4, rest.shape[1])
