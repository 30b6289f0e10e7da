"""The type `FloatArray`, norms of vectors in an array, and sums in a fixed order."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


@np.errstate(over="ignore", invalid="ignore")
def norms(vectors: FloatArray) -> FloatArray:
    """Return the Euclidean norm of each vector, shape (..., d) -> (...); infinite if its square overflows."""
    # numpy's `sum` along a short axis would take ten times as long.
    return np.sqrt(sum(vectors[..., axis] ** 2 for axis in range(vectors.shape[-1])))


def ordered_sum(*terms: npt.ArrayLike) -> float:
    """Return the sum of numbers and arrays, added in order: bitwise the same on every CPU and with every Python.

    (Python's `sum` of floats is compensated since 3.12.)
    """
    return float(np.concatenate([np.zeros(1), *(np.ravel(one) for one in terms)]).cumsum()[-1])


def ordered_sum_of_rows(terms: FloatArray) -> FloatArray:
    """Return the sum over the first axis, row by row: bitwise the same on every CPU."""
    return np.add.accumulate(np.concatenate([np.zeros((1, *terms.shape[1:])), terms]))[-1]
