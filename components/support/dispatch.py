"""Functions whose implementation is chosen by the class of their first argument, in Python and in compiled code.

This is how a law reaches a kernel. A law is a `NamedTuple` of its constants. A kernel takes the law as an argument and calls,
for example, ``force(law, overlap)``; numba compiles the kernel once for each class of law, with that law's function inlined.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Any

from numba.extending import overload

from .jit import OPTIONS

_COMPILED: Any = {**OPTIONS, "no_cpython_wrapper": True}


def dispatched(function: Callable[..., Any]) -> Any:
    """Make a function dispatch on the class of its first argument; its own body is never run.

    ``function.register(Law)`` is a decorator for the implementation for one class: a named function of a module with the
    same arguments. (numba's cache tells functions apart by their names: an implementation must not be a lambda or a closure.)

    Raises:
        TypeError: called, or compiled, for a class without an implementation.
    """
    implementations: dict[type, Callable[..., Any]] = {}

    @wraps(function)
    def call(law: Any, *arguments: Any) -> Any:
        return implementation_for(type(law))(law, *arguments)

    def implementation_for(kind: type) -> Callable[..., Any]:
        if kind not in implementations:
            known = ", ".join(sorted(each.__name__ for each in implementations))
            raise TypeError(f"{function.__name__}: got a law {kind.__name__}, expected one of {known}")
        return implementations[kind]

    def compiled(law: Any, *arguments: Any) -> Callable[..., Any]:
        return implementation_for(getattr(law, "instance_class", type(law)))

    def register(kind: type) -> Callable[[Any], Any]:
        def add(implementation: Any) -> Any:
            implementations[kind] = implementation
            return implementation

        return add

    compiled.__signature__ = inspect.signature(function)  # type: ignore[attr-defined]
    overload(call, jit_options=_COMPILED)(compiled)
    call.register, call.implementations = register, implementations  # type: ignore[attr-defined]
    return call
