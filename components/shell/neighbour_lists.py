"""Lists of neighbours in little memory: numbers that lie near each other, as the least one of each list and steps from it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

IndexArray = npt.NDArray[np.uint32]
# As few bytes as the largest of these numbers takes.
SmallArray = npt.NDArray[np.unsignedinteger[Any]]


def shorten(begin: npt.NDArray[Any], numbers: npt.NDArray[Any]) -> tuple[IndexArray, SmallArray]:
    """Return the least number of each list, 0 of one that is empty, and all numbers less that of their list.

    Args:
        begin: where each of n lists begins in `numbers`, and the end of the last, shape (n + 1,).
        numbers: of all lists, one after the other, whole ones from 0.
    """
    counts = np.diff(begin.astype(np.int64))
    lowest = np.zeros(len(counts), dtype=np.uint32)
    filled = counts > 0
    lowest[filled] = np.minimum.reduceat(numbers, begin[:-1][filled].astype(np.int64))
    return lowest, in_few_bytes(numbers - np.repeat(lowest, counts))


def lengthen(begin: npt.NDArray[Any], lowest: IndexArray, steps: SmallArray) -> IndexArray:
    """Return the numbers of all lists, as `shorten` took them."""
    return np.repeat(lowest, np.diff(begin.astype(np.int64))) + steps


def in_few_bytes(numbers: npt.NDArray[Any]) -> SmallArray:
    """Return whole numbers from 0 in the smallest type that holds the largest of them."""
    largest = int(numbers.max(initial=0))
    return numbers.astype(np.uint8 if largest < 2**8 else np.uint16 if largest < 2**16 else np.uint32)
