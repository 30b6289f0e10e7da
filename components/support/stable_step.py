"""The largest stable step of leapfrog, 2 / omega, from the highest frequency of a body at rest."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError
from .float_arrays import FloatArray
from .round_numbers import round_down_to_125

# Largest allowed step and suggested step, as fractions of the largest stable step 2 / omega.
ALLOWED, SUGGESTED = 0.9, 0.8
_KEPT = 16


class ResultCache:
    """Cache of recent results, so that building the same body twice computes its frequencies once."""

    def __init__(self) -> None:
        self._results: dict[bytes, Any] = {}

    def get(self, inputs: Iterable[Any], compute: Callable[[], Any]) -> Any:
        """Return the result of `compute`, cached for bitwise equal `inputs`, i.e. all numbers and arrays that it reads."""
        digest = hashlib.blake2b(digest_size=32)
        for value in inputs:
            array = np.ascontiguousarray(value)
            digest.update(f"{array.dtype.str}{array.shape}".encode())
            digest.update(array.reshape(-1).view(np.uint8).data)
        key = digest.digest()
        if key not in self._results:
            if len(self._results) == _KEPT:
                del self._results[next(iter(self._results))]
            self._results[key] = compute()
        return self._results[key]


def highest_frequency(
    shape: FloatArray,
    size: float,
    is_held: npt.NDArray[np.bool_],
    mass: FloatArray,
    force: Callable[[FloatArray], FloatArray],
    norm_ratio: Callable[[FloatArray, FloatArray, FloatArray], float],
    *,
    iterations: int,
    tolerance: float,
) -> float:
    """Return a lower estimate of the highest angular frequency of a body at rest [rad/s]; 0 if all nodes are held.

    Args:
        shape: initial displacements, shape (n, dimensions).
        size: largest trial displacement [m]; small enough to leave the geometry unchanged.
        is_held: mask of prescribed displacements, of the same shape, bool.
        mass: mass of each node, shape (n,) [kg].
        force: function that returns the forces for displacements from rest, both of that shape [m, N].
        norm_ratio: function of (image, vector, mass) that returns |image| / |vector|, norms weighted by the masses.
        iterations: largest number of power iterations.
        tolerance: relative change of the squared frequency at which the iteration stops.
    """
    square = 0.0
    for _ in range(iterations):
        shape[is_held] = 0.0
        largest = float(np.abs(shape).max())
        if largest == 0.0:
            return 0.0
        vector = shape * (size / largest)
        found = force(vector)
        found[is_held] = 0.0
        shape = found / (-mass[:, np.newaxis])
        # |M^-1 K x| / |x| in the mass-weighted norm lies between Rayleigh's quotient and the highest squared frequency.
        before, square = square, norm_ratio(shape, vector, mass)
        if abs(square - before) <= tolerance * square:
            break
    return math.sqrt(square)


def suggest_step(frequency: float, hint: str) -> float:
    """Return a stable step [s], rounded down to 1, 2 or 5 x 10^k; raise `ParameterError` with the hint if no node can move."""
    if frequency == 0.0:
        raise ParameterError("no node can move", hint=hint, at="boundaries")
    return round_down_to_125(longest_suggested_step(frequency))


def longest_suggested_step(frequency: float) -> float:
    """Return the suggested fraction of the largest stable step [s], without rounding."""
    return SUGGESTED * 2.0 / frequency


def refuse_large_step(step: float, frequency: float, hint: str) -> None:
    """Raise `ParameterError` if a step [s] is too close to the largest stable one; `hint` is advice for the user."""
    if frequency * step > 2.0 * ALLOWED:
        largest = 2.0 / frequency
        expected = f"at most {ALLOWED * largest:.4g} s, {ALLOWED:g} of the largest stable one, 2 / omega = {largest:.4g} s"
        raise ParameterError(f"got {step:g} s", expected=expected, hint=hint, at="step_size")
