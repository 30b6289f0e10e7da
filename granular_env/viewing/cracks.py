"""Drawing of links between points: an intact link is a line between them, a broken link a short crack across its middle.

With many points, lines would hide the points' colours, so only cracks are drawn.
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
    places: FloatArray, rest: FloatArray, pairs: npt.NDArray[np.int64], state: FloatArray, normal: tuple[float, ...] = ()
) -> FloatArray:
    """Return a short line across the middle of each broken link, shape (cracks, 2, d) [m].

    Points that have moved far apart leave a visible gap and get no line.

    Args:
        places: drawn positions of the points, shape (n, d) with d = 2 or 3 [m].
        rest: initial positions, shape (n, d) [m].
        pairs: indices of the two points of each link, shape (m, 2).
        state: 0 for a broken link, shape (m,).
        normal: viewing direction, to which the cracks are perpendicular; only for d = 3.
    """
    broken = pairs[state == 0.0]
    along, began = places[broken[:, 1]] - places[broken[:, 0]], rest[broken[:, 1]] - rest[broken[:, 0]]
    length = np.sqrt((along * along).sum(axis=1))
    distance = np.sqrt((began * began).sum(axis=1))
    is_near = (length < _FARTHEST * distance) & (length > 0.0)
    along, length, distance, broken = along[is_near], length[is_near], distance[is_near], broken[is_near]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1) if along.shape[1] == 2 else np.cross(np.array(normal), along)
    reach = 0.5 * _LENGTH * (distance / length)[:, None] * across
    middle = 0.5 * (places[broken[:, 0]] + places[broken[:, 1]])
    return np.stack([middle - reach, middle + reach], axis=1)
