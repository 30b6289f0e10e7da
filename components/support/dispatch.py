"""Dispatch on the class of the first argument, in Python and in compiled code.

This is how a law reaches a kernel. A law is a `NamedTuple` of its constants. A kernel takes the law as an argument and calls,
for example, ``force(law, overlap)``; numba compiles the kernel once for each class of law, with that law's function inlined.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable
from functools import wraps
from typing import Any

import numba
from numba.extending import overload

from .jit import OPTIONS, is_cached

_COMPILED = {**OPTIONS, "no_cpython_wrapper": True}
# Name -> class, for all classes used in dispatch, because machine code distinguishes classes by name.
_classes: dict[str, type] = {}


def dispatch_by_class(function: Callable[..., Any], *, inlined: bool = False, has_default: bool = False) -> Any:
    """Make a function dispatch on the class of its first argument, or on the argument itself if it is a class.

    ``function.register(Law)`` is a decorator for the implementation for one class: a named function of a module with the same
    arguments. (numba's cache distinguishes functions by name: an implementation must not be a lambda or a closure.)

    Args:
        function: function with the name, the arguments and the docstring.
        inlined: whether compiled callers inline the implementations, as loops over many contacts require.
        has_default: whether the body of the function serves unregistered classes; otherwise the body is never run.

    Raises:
        TypeError: for a class without an implementation, when called or compiled; or if two classes have the same name.
    """
    implementations: dict[type, Callable[..., Any]] = {}

    @wraps(function)
    def call_implementation(law: Any, *arguments: Any) -> Any:
        return implementation_for(law if isinstance(law, type) else type(law))(law, *arguments)

    def implementation_for(kind: type) -> Callable[..., Any]:
        if kind in implementations:
            return implementations[kind]
        if not has_default:
            known = ", ".join(sorted(each.__name__ for each in implementations))
            raise TypeError(f"{function.__name__}: got a law {kind.__name__}, expected one of {known}")
        return function

    def compiled_implementation(law: Any, *arguments: Any) -> Callable[..., Any]:
        return implementation_for(getattr(law, "instance_class", type(law)))

    def register(kind: type) -> Callable[[Any], Any]:
        _register_class(kind)

        def add_implementation(implementation: Any) -> Any:
            implementations[kind] = implementation
            return implementation

        return add_implementation

    compiled_implementation.__signature__ = inspect.signature(function)  # type: ignore[attr-defined]
    options: Any = {**_COMPILED, "forceinline": inlined}
    overload(call_implementation, jit_options=options)(compiled_implementation)
    call_implementation.register, call_implementation.implementations = register, implementations  # type: ignore[attr-defined]
    return call_implementation


def _register_class(kind: type) -> None:
    """Refuse a second class with the same name; make numba pickle a class that other processes may not be able to import.

    The index of numba's cache names classes by their modules. If a module is part of neither this package nor a plug-in, the
    class itself is put into the index: another process can always load the index, and compiles its own kernels.
    """
    known = _classes.setdefault(kind.__name__, kind)
    if known is not kind:
        raise TypeError(
            f"{kind.__module__}.{kind.__name__}: {known.__module__} has a law of that name, but compiled code distinguishes "
            "laws by name; rename one, or restart Python if it was defined again"
        )
    module = sys.modules.get(kind.__module__)
    if module is not None and kind.__module__ != "__main__" and not is_cached(kind.__module__):
        numba.cloudpickle.register_pickle_by_value(module)  # type: ignore[attr-defined]
