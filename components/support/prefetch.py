"""Ask for a part of an array before it is read, so that arithmetic goes on while it comes from memory.

A core sees by itself that a loop goes through an array, but not what comes after the loop: a sweep in tiles, whose stages take
turns, begins anew with each tile. What is asked for comes into the second-level cache; the first holds what is worked on.
"""

from __future__ import annotations

from typing import Any

import numba
from llvmlite import ir
from numba.core import cgutils
from numba.extending import intrinsic

from .compilation.fingerprint import tell_apart
from .jit import JIT, internal_inlined

# Numbers of 8 bytes in a cache line.
_LINE = 8
# Arguments of llvm.prefetch: to read; into the second-level cache; data.
_TO_READ, _SECOND_LEVEL, _DATA = 0, 2, 1


def _make_request() -> Any:
    """Return a function for jitted code, request(array, i), that asks for the cache line of an element."""
    if not JIT:
        return lambda array, i: None

    @intrinsic
    def request(context: Any, array: Any, i: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            start = context.make_array(signature.args[0])(context, builder, values[0]).data
            place = builder.bitcast(builder.gep(start, [values[1]]), cgutils.voidptr_t)
            words = [ir.Constant(cgutils.int32_t, number) for number in (_TO_READ, _SECOND_LEVEL, _DATA)]
            kind = ir.FunctionType(ir.VoidType(), [cgutils.voidptr_t, *(word.type for word in words)])
            builder.call(builder.module.declare_intrinsic("llvm.prefetch", [cgutils.voidptr_t], kind), [place, *words])
            return context.get_dummy_value()

        return numba.types.void(array, i), generate

    tell_apart(request, "prefetch of an element")
    return request


_request: Any = _make_request()


@internal_inlined
def prefetch(array, begin, end):
    """Ask for the numbers of a flat array from one on up to another."""
    for i in range(begin, end, _LINE):
        _request(array, i)
