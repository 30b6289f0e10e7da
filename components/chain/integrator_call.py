"""A cheap call from Python into an integrator, for inputs of one number at each end: all that stays lies behind one number."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
import numpy as np
import numpy.typing as npt

from ..support.addresses import address, array_at, caller, location
from ..support.float_arrays import FloatArray
from ..support.jit import JIT, jit
from .integrators import SIGNATURE

# What `held_call` gives, the numbers held at both ends, the tick, and how many ticks.
HELD_SIGNATURE = "int64(int64, float64, float64, int64, int64)"
_NO_PIECES = np.int64(0)
_integers, _floats, _advance = array_at(numba.int64), array_at(numba.float64), caller(SIGNATURE)


def held_call(integrator: Callable[..., Any], table: FloatArray) -> npt.NDArray[Any]:
    """Return the integrator's address, the table's, and its shape: `advance_held` takes their location.

    All three must live as long as that is used.
    """
    numbers = np.empty(4, np.int64 if JIT else object)
    for place, number in enumerate((address(integrator, SIGNATURE), location(table), *table.shape)):
        numbers[place] = number
    return numbers


@jit
def advance_held(call, left, right, tick, ticks):
    """Advance as the integrator does, with no pieces of a drive; `call` is the location of what `held_call` gives."""
    numbers = _integers(call, (4,))
    a = _floats(numbers[1], (numbers[2], numbers[3]))
    return _advance(numbers[0], (a, a[0:0], _NO_PIECES, left, right, tick, ticks))
