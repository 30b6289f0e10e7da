"""A cache of the types of calls of operators and built-in functions: numba looks each call up anew, among all overloads.

It tries each overload with and without the values of constants, and words an error for each that does not fit: a sixth of the
time of a compilation.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core.target_extension import get_local_target
from numba.core.types.functions import BaseFunction

from .cacheable_types import is_told_by_name

_look_up = BaseFunction.get_call_type
_CALLS = "_calls_of_granular_env"


def _get_call_type(function: Any, context: Any, arguments: Any, named: Any) -> Any:
    """Return the signature of a call, the one that was found before where there is one."""
    if named:
        return _look_up(function, context, arguments, named)
    calls = function.__dict__.setdefault(_CALLS, {})
    place = (context, get_local_target(context), tuple(arguments))
    if place not in calls:
        found = _look_up(function, context, arguments, named)
        if not _is_built_in(function, found) or not all(map(is_told_by_name, arguments)):
            return found
        calls[place] = found
    return calls[place]


def _is_built_in(function: Any, signature: Any) -> bool:
    """Return whether numba has the operation itself; others are compiled for the flags of the function that calls them."""
    return getattr(function, "_impl_keys", {}).get(signature.args) is function.key[0]


@contextmanager
def kept_calls() -> Iterator[None]:
    """Keep the types of calls until the end of the block, in which numba's lock for compilation has to be held."""
    before = BaseFunction.get_call_type
    BaseFunction.get_call_type = _get_call_type  # type: ignore[method-assign]
    try:
        yield
    finally:
        BaseFunction.get_call_type = before  # type: ignore[method-assign]
