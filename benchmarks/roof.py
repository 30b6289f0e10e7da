"""The unit of kernel speed: square roots per second of this core, for arrays in its first-level cache.

Hertz's force needs one square root, so the rate of square roots is an upper bound. The compiler may use only half of a 512-bit
register for the plain loop; a second loop therefore computes eight roots per vector. The roof is the faster loop.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import sqrt

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

# Two arrays of 8 kB, a quarter to a half of the smallest first-level caches.
LENGTH = 1024


@numba.njit
def scalar_roots(values, roots, repeats):
    """Compute the square roots of all values `repeats` times."""
    for _ in range(repeats):
        for i in range(values.size):
            roots[i] = sqrt(values[i])


_EIGHT = ir.VectorType(ir.DoubleType(), 8)


def _vector_pointer(context, builder, kind, array, place):
    """Return a pointer to the eight elements from `place` on."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(cgutils.gep_inbounds(builder, data, place), _EIGHT.as_pointer())


@intrinsic
def _store_eight_roots(typing, values, roots, place):
    """Set roots[place : place + 8] = sqrt(values[place : place + 8]) as one vector."""

    def generate(context, builder, signature, arguments):
        source, target = (
            _vector_pointer(context, builder, kind, array, arguments[2])
            for kind, array in zip(signature.args[:2], arguments[:2], strict=True)
        )
        root = cgutils.get_or_insert_function(builder.module, ir.FunctionType(_EIGHT, [_EIGHT]), "llvm.sqrt.v8f64")
        builder.store(builder.call(root, [builder.load(source, align=8)]), target, align=8)
        return context.get_dummy_value()

    return types.void(values, roots, types.uintp), generate


@numba.njit
def vector_roots(values, roots, repeats):
    """Compute the square roots of all values, eight per vector; the length must be a multiple of eight."""
    for _ in range(repeats):
        for i in range(np.uint64(0), np.uint64(values.size), np.uint64(8)):
            _store_eight_roots(values, roots, i)  # pyright: ignore[reportCallIssue]


def loops(repeats: int) -> dict[str, Callable[[], None]]:
    """Return both loops for timing; each computes `repeats * LENGTH` square roots."""
    values, roots = np.random.default_rng(1).uniform(0.5, 2.0, LENGTH), np.zeros(LENGTH)
    found = {}
    for name, loop in (("plain", scalar_roots), ("eight wide", vector_roots)):
        loop(values, roots, 1)
        if not np.array_equal(roots, np.sqrt(values)):
            raise AssertionError(f"the {name} loop does not give square roots")
        roots[:] = 0.0
        found[name] = partial(loop, values, roots, repeats)
    return found
