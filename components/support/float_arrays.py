"""The type `FloatArray`, and the norms of vectors in such an array."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


@np.errstate(over="ignore", invalid="ignore")
def norms(vectors: FloatArray) -> FloatArray:
    """Return the Euclidean norm of each vector, shape (..., d) -> (...); infinite where its square is."""
    # A sum along so short an axis would take ten times as long.
    return np.sqrt(sum(vectors[..., axis] ** 2 for axis in range(vectors.shape[-1])))
