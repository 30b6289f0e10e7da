"""Types of numba that a cache may tell by their names: numbers, arrays, texts, and tuples of such; functions are none."""

from __future__ import annotations

from typing import Any

from numba.core import types

_TOLD_BY_NAME = (
    types.Number, types.Boolean, types.Array, types.Omitted, types.NoneType, types.Literal, types.UnicodeType,
)  # fmt: skip


def is_told_by_name(kind: Any) -> bool:
    """Return whether a type is such a one."""
    if isinstance(kind, types.BaseTuple):
        return all(map(is_told_by_name, iter(kind)))  # type: ignore[call-overload]
    return isinstance(kind, _TOLD_BY_NAME)
