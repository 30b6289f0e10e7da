"""Functions whose implementation is chosen by the class of their first argument, in Python and in compiled code.

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

from .jit import OPTIONS, is_kept

_COMPILED = {**OPTIONS, "no_cpython_wrapper": True}
# Name -> class of everything that a function dispatches on: machine code tells classes apart by their names.
_classes: dict[str, type] = {}


def dispatched(function: Callable[..., Any], *, inlined: bool = False, has_default: bool = False) -> Any:
    """Make a function dispatch on the class of its first argument, or on that argument where it is a class.

    ``function.register(Law)`` is a decorator for the implementation for one class: a named function of a module with the same
    arguments. (numba's cache tells functions apart by their names: an implementation must not be a lambda or a closure.)

    Args:
        function: gives the name, the arguments and the docstring.
        inlined: whether compiled callers inline the implementations, as the loops over many contacts need it.
        has_default: whether the body of the function serves the classes that register nothing; else it is never run.

    Raises:
        TypeError: called, or compiled, for a class without an implementation; or two registered classes have one name.
    """
    implementations: dict[type, Callable[..., Any]] = {}

    @wraps(function)
    def call(law: Any, *arguments: Any) -> Any:
        return implementation_for(law if isinstance(law, type) else type(law))(law, *arguments)

    def implementation_for(kind: type) -> Callable[..., Any]:
        if kind in implementations:
            return implementations[kind]
        if not has_default:
            known = ", ".join(sorted(each.__name__ for each in implementations))
            raise TypeError(f"{function.__name__}: got a law {kind.__name__}, expected one of {known}")
        return function

    def compiled(law: Any, *arguments: Any) -> Callable[..., Any]:
        return implementation_for(getattr(law, "instance_class", type(law)))

    def register(kind: type) -> Callable[[Any], Any]:
        _note_class(kind)

        def add(implementation: Any) -> Any:
            implementations[kind] = implementation
            return implementation

        return add

    compiled.__signature__ = inspect.signature(function)  # type: ignore[attr-defined]
    options: Any = {**_COMPILED, "forceinline": inlined}
    overload(call, jit_options=options)(compiled)
    call.register, call.implementations = register, implementations  # type: ignore[attr-defined]
    return call


def _note_class(kind: type) -> None:
    """Refuse a second class of a name; let numba pickle a class that other processes may not be able to import.

    The index of numba's cache names classes by their modules. Where a module is neither part of this package nor of a plug-in,
    the class itself goes into the index: another process can always load that, and compiles its own kernels.
    """
    known = _classes.setdefault(kind.__name__, kind)
    if known is not kind:
        raise TypeError(
            f"{kind.__module__}.{kind.__name__}: {known.__module__} has a law of that name, and compiled code tells laws apart "
            "by their names; rename one, or restart Python if it was defined again"
        )
    module = sys.modules.get(kind.__module__)
    if module is not None and kind.__module__ != "__main__" and not is_kept(kind.__module__):
        numba.cloudpickle.register_pickle_by_value(module)  # type: ignore[attr-defined]
