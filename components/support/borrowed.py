"""Arrays whose references compiled code does not count."""

from __future__ import annotations

from typing import Any

from numba.extending import intrinsic

from .jit import JIT


def _borrowed(typing_context: Any, array: Any) -> Any:
    """Return the same array without its owner."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        found = context.make_array(array)(context, builder, values[0])
        found.meminfo, found.parent = found.meminfo.type(None), found.parent.type(None)
        return found._getvalue()

    return array(array), generate


# borrowed(array): numba counts references to the owner of an array and of each view of it, atomically. In a tick of a hundred
# grains that takes longer than the arithmetic. The caller keeps the owner alive: an argument from Python is.
borrowed: Any = intrinsic(_borrowed) if JIT else lambda array: array
