"""The type `FloatArray`, norms of vectors in such an array, and sums in a fixed order."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


@np.errstate(over="ignore", invalid="ignore")
def norms(vectors: FloatArray) -> FloatArray:
    """Return the Euclidean norm of each vector, shape (..., d) -> (...); infinite where its square is."""
    # A sum along so short an axis would take ten times as long.
    return np.sqrt(sum(vectors[..., axis] ** 2 for axis in range(vectors.shape[-1])))


def sum_in_order(terms: FloatArray) -> FloatArray:
    """Return the sum over the first axis, term by term from 0 on: the same bits on every CPU."""
    return np.add.accumulate(np.concatenate([np.zeros((1, *terms.shape[1:])), terms]))[-1]
