"""Functions and arrays that compiled code reaches by a number: where they lie in memory.

So one compiled loop serves any function of a signature, and a call from Python hands over a number where looking at an array
would take as long as a tick of ten grains. What lies there must live as long as its number is used.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
import numpy.typing as npt
from numba.core import cgutils, sigutils
from numba.core.errors import TypingError
from numba.extending import intrinsic

from .jit import JIT, jit


def address(function: Callable[..., Any], signature: str) -> Any:
    """Return where the machine code of a jitted function for one signature lies, for `caller`.

    With the JIT off it is the function itself.
    """
    if not hasattr(function, "compile"):
        return function
    compiled: Any = function
    compiled.compile(signature)
    result = compiled.overloads[sigutils.normalize_signature(signature)[0]]
    wanted = sigutils.normalize_signature(signature)[1]
    if wanted is not None and result.signature.return_type != wanted:
        raise TypeError(f"{compiled.__name__} returns {result.signature.return_type}, expected {wanted}")
    return result.library.get_pointer_to_function(result.fndesc.llvm_func_name)


def caller(signature: str) -> Any:
    """Return a function for jitted code, call(where, (argument, ...)), that calls what lies at an `address` of that signature.

    The arguments must have exactly the signature's types.
    """
    if not JIT:
        return lambda function, arguments: function(*arguments)
    types, given_return = sigutils.normalize_signature(signature)
    returned: Any = given_return

    @intrinsic
    def call(context: Any, where: Any, arguments: Any) -> Any:
        given = tuple(arguments)
        if given != types:
            raise TypingError(f"call through an address: got {given}, expected {types}")

        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            convention = context.call_conv
            kind = convention.get_function_type(returned, types)
            function = builder.inttoptr(values[0], kind.as_pointer())
            parts = [builder.extract_value(values[1], place) for place in range(len(types))]
            status, result = convention.call_function(builder, function, returned, types, parts)
            with cgutils.if_unlikely(builder, status.is_error):
                convention.return_status_propagate(builder, status)
            return result

        return returned(numba.types.int64, arguments), generate

    return call


def location(array: npt.NDArray[Any]) -> Any:
    """Return where the numbers of a C-ordered array lie, for `array_at`; with the JIT off the array itself."""
    if not array.flags.c_contiguous:
        raise ValueError(f"location: got an array of shape {array.shape} and strides {array.strides}, expected C order")
    return array.ctypes.data if JIT else array


def array_at(kind: Any) -> Any:
    """Return a function for jitted code, found(where, shape), that gives the array of numbers of that kind at a `location`.

    The shape must be that of the array: nothing checks it.
    """
    if not JIT:
        return lambda where, shape: where
    pointed: Any = numba.types.CPointer(kind)

    @intrinsic
    def to_pointer(context: Any, where: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            return builder.inttoptr(values[0], context.get_value_type(pointed))

        return pointed(numba.types.int64), generate

    pointer: Any = to_pointer

    @jit
    def found(where, shape):  # noqa: ANN001, ANN202
        return numba.carray(pointer(where), shape)  # type: ignore[attr-defined]

    return found
