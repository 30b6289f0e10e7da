"""Loops for one contact law: the one place where a law's functions come into the loops.

Kernels call a law by the names of `laws.functions`. `specialise` copies a kernel, and all kernels that it calls, with the
functions and properties of a chosen law in the place of that module, so that each law has loops of its own: its formulas are
inlined, what its properties rule out is not compiled, and a run compiles its own law alone.
"""

from __future__ import annotations

import types
from collections.abc import Callable
from functools import cache
from typing import Any

from numba.core.dispatcher import Dispatcher

from ..support.jit import JIT, inlined, jit
from .laws import LAWS, functions
from .laws.law import Law, lacks, law_functions
from .layout import LAW, SCALARS

_PACKAGE = __name__.rpartition(".")[0]


def specialise(kernel: Callable[..., Any], law: type[Law]) -> Callable[..., Any]:
    """Return a kernel with the functions of a contact law in the place of `laws.functions`; the same one for the same law.

    A kernel is a jitted function of a module. One that asks nothing of the law is returned as it is.
    """
    return _specialisation(law).of(kernel)


@cache
def _specialisation(law: Any) -> _Specialisation:
    return _Specialisation(law)


class _Specialisation:
    """The kernels of one law, each copied once."""

    def __init__(self, law: type[Law]) -> None:
        self._functions = law_functions(law)
        self._made: dict[Any, Any] = {}

    def of(self, value: Any) -> Any:
        """Return the counterpart of a kernel or of a module of kernels; anything else as it is."""
        if value is functions:
            return self._functions
        if isinstance(value, functions.Property):
            return getattr(self._functions, value.name)
        if not (_is_kernel(value) or _is_module(value)):
            return value
        if value not in self._made:
            self._made[value] = value  # kernels may call themselves
            self._made[value] = self._module(value) if _is_module(value) else self._kernel(value)
        return self._made[value]

    def _kernel(self, kernel: Any) -> Any:
        function = getattr(kernel, "py_func", kernel)
        found = {name: function.__globals__[name] for name in function.__code__.co_names if name in function.__globals__}
        own = {name: self.of(value) for name, value in found.items()}
        if all(own[name] is value for name, value in found.items()):
            return kernel
        copy = types.FunctionType(
            function.__code__, {**function.__globals__, **own}, function.__name__, function.__defaults__, function.__closure__
        )
        copy.__doc__ = function.__doc__
        if not JIT:
            return copy
        return inlined(copy) if kernel.targetoptions.get("forceinline") else jit(copy)

    def _module(self, module: types.ModuleType) -> types.ModuleType:
        found = {name: value for name, value in vars(module).items() if _is_kernel(value)}
        own = {name: self.of(value) for name, value in found.items()}
        if all(own[name] is value for name, value in found.items()):
            return module
        copy = types.ModuleType(module.__name__, module.__doc__)
        vars(copy).update({**vars(module), **own})
        return copy


def _is_kernel(value: Any) -> bool:
    return isinstance(value, Dispatcher) or (not JIT and isinstance(value, types.FunctionType))


def _is_module(value: Any) -> bool:
    return isinstance(value, types.ModuleType) and value.__name__.startswith(f"{_PACKAGE}.")


def of_any_law(kernel: Callable[..., Any], otherwise: Callable[..., Any], needed: tuple[str, ...] = ()) -> Callable[..., Any]:
    """Return a kernel(a, ...) that runs that of the law which the table names: for code that is compiled before a law is known.

    Args:
        kernel: for one law, see `specialise`.
        otherwise: what takes its place for laws that lack a needed function.
        needed: functions of a law without which the kernel does not work.
    """
    chosen = otherwise
    for number, law in reversed(list(enumerate(LAWS.values()))):
        if not lacks(law, needed):
            chosen = _choice(number, specialise(kernel, law), chosen)
    return chosen


def _choice(number: int, first: Callable[..., Any], others: Callable[..., Any]) -> Callable[..., Any]:
    @jit
    def choose(a, *rest):
        if a[SCALARS, LAW] == number:
            return first(a, *rest)
        return others(a, *rest)

    return choose
