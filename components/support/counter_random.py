"""Random numbers as a function of (seed, stream, index): no generator state, the same on every machine."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .jit import jit

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)


def _splitmix64(word: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    """Apply the finaliser of SplitMix64 (Steele, Lea & Flood 2014)."""
    word = (word ^ (word >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    word = (word ^ (word >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return word ^ (word >> np.uint64(31))


def uniform(seed: int, stream: int, count: int) -> npt.NDArray[np.float64]:
    """Return `count` numbers in [0, 1) with 53 random bits each, computed from integers alone.

    Args:
        seed: 0 <= seed < 2^64.
        stream: distinguishes independent sequences of one seed.
        count: number of values.
    """
    with np.errstate(over="ignore"):
        key = _splitmix64(_splitmix64(np.array([seed], np.uint64) + _GOLDEN) + np.uint64(stream) * _GOLDEN)
        words = _splitmix64(key + (np.arange(count, dtype=np.uint64) + np.uint64(1)) * _GOLDEN)
    return (words >> np.uint64(11)).astype(np.float64) * 2.0**-53


# The sum of twelve uniform 16-bit numbers has variance 1 about this mean, in units of 2^16.
_WORDS, _MIDDLE = 3, 12 * 32767.5


mix_word: Any = jit(_splitmix64)


@jit
def stream_key(seed, stream):
    """Return the key of a stream of `normal` numbers; seed and stream are counted from 0."""
    return mix_word(mix_word(np.uint64(seed) + _GOLDEN) + np.uint64(stream) * _GOLDEN)


@jit
def normal(key, index):
    """Return a number with mean 0 and variance 1 from a `stream_key`: exactly the sum of twelve uniform ones, so within +-6.

    Its fourth moment is 2.9 instead of the normal distribution's 3. No operation rounds, so that all machines agree.
    """
    total = 0
    for word in range(_WORDS):
        bits = mix_word(key + (np.uint64(index) * np.uint64(_WORDS) + np.uint64(word + 1)) * _GOLDEN)
        for part in range(4):
            total += np.int64((bits >> np.uint64(16 * part)) & np.uint64(0xFFFF))
    return (total - _MIDDLE) * 2.0**-16
