"""Arrays without reference counting in compiled code."""

from __future__ import annotations

from typing import Any

from numba.extending import intrinsic

from .jit import JIT


def _unowned_array(typing_context: Any, array: Any) -> Any:
    """Return the array without the reference to the owner of its memory."""

    def generate_code(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        found = context.make_array(array)(context, builder, values[0])
        found.meminfo, found.parent = found.meminfo.type(None), found.parent.type(None)
        return found._getvalue()

    return array(array), generate_code


# unowned_array(array): numba counts references to the owner of an array, and of each view of it, atomically. In a tick of a
# hundred grains the counting takes longer than the arithmetic. The caller must keep the owner alive; Python does so for its
# arguments.
unowned_array: Any = intrinsic(_unowned_array) if JIT else lambda array: array
