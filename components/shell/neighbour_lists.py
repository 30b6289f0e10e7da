"""Lists of neighbours in little memory: the lowest number of each, and how far the others lie above it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

IndexArray = npt.NDArray[np.uint32]
# Of one, two or four bytes.
CompactArray = npt.NDArray[np.unsignedinteger[Any]]


def compress(begin: npt.NDArray[Any], numbers: npt.NDArray[Any]) -> tuple[IndexArray, CompactArray]:
    """Return the lowest number of each list, 0 of one that is empty, and all numbers less that of their list.

    Args:
        begin: where each of n lists begins in `numbers`, and the end of the last, shape (n + 1,).
        numbers: of all lists, one after the other, whole ones from 0.
    """
    counts = np.diff(begin.astype(np.int64))
    lowest = np.zeros(len(counts), dtype=np.uint32)
    filled = counts > 0
    lowest[filled] = np.minimum.reduceat(numbers, begin[:-1][filled].astype(np.int64))
    # Never one byte: kernels are compiled for types, and would be once more for bodies of few nodes.
    return lowest, compact(numbers - np.repeat(lowest, counts), np.uint16)


def expand(begin: npt.NDArray[Any], lowest: IndexArray, offsets: CompactArray) -> IndexArray:
    """Return the numbers of all lists, as `compress` took them."""
    return np.repeat(lowest, np.diff(begin.astype(np.int64))) + offsets


def compact(numbers: npt.NDArray[Any], smallest: type[np.unsignedinteger[Any]] = np.uint8) -> CompactArray:
    """Return whole numbers from 0 in the first type from a smallest one on that holds the largest of them."""
    return numbers.astype(np.promote_types(smallest, np.min_scalar_type(int(numbers.max(initial=0)))))
