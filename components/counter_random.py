"""Random numbers as a function of (seed, stream, index): no generator state, the same on every machine."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)


def _mixed(word: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    """The finaliser of SplitMix64 (Steele, Lea & Flood 2014)."""
    word = (word ^ (word >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    word = (word ^ (word >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return word ^ (word >> np.uint64(31))


def uniform(seed: int, stream: int, count: int) -> npt.NDArray[np.float64]:
    """`count` numbers in [0, 1), 53 random bits each, from integers alone.

    Args:
        seed: 0 <= seed < 2^64.
        stream: tells apart the draws of one seed.
        count: how many.
    """
    with np.errstate(over="ignore"):
        key = _mixed(_mixed(np.array([seed], np.uint64) + _GOLDEN) + np.uint64(stream) * _GOLDEN)
        words = _mixed(key + (np.arange(count, dtype=np.uint64) + np.uint64(1)) * _GOLDEN)
    return (words >> np.uint64(11)).astype(np.float64) * 2.0**-53
