"""Kernels for one contact law: the one place where a law's functions come into loops, sensors, tasks and objectives.

Kernels call a law by the names of `laws.placeholders`. `specialise` copies a kernel, and all kernels that it calls, with the
functions and properties of a chosen law in the place of that module, so that each law has loops of its own: its formulas are
inlined, what its properties rule out is not compiled, and a run compiles its own law alone.
"""

from __future__ import annotations

import builtins
import dis
import types
from collections.abc import Callable, Iterator
from functools import cache, lru_cache
from typing import Any
from weakref import WeakKeyDictionary

import numba

from ..support.jit import JIT, OPTIONS
from .laws import placeholders
from .laws.law import Law, law_functions

_EMPTY = types.CellType()


def specialise(kernel: Callable[..., Any], law: type[Law]) -> Callable[..., Any]:
    """Return a kernel with the functions of a contact law in the place of `laws.placeholders`; the same one for the same law.

    A kernel is a jitted function of any module. One that asks nothing of the law is returned as it is.

    Raises:
        ParameterError: a kernel of another package refers to something that has another value than when it was specialised.
    """
    return _specialisation(law).of(kernel)


@cache
def _specialisation(law: Any) -> _Specialisation:
    return _Specialisation(law)


class _Specialisation:
    """The kernels of one law, each copied once."""

    def __init__(self, law: type[Law]) -> None:
        self._functions = law_functions(law)
        # Kernel -> its copy; None for one that asks nothing of the law.
        self._copies: WeakKeyDictionary[Any, Any] = WeakKeyDictionary()

    def of(self, value: Any, names: tuple[str, ...] = ()) -> Any:
        """Return the counterpart of a kernel, or of a tuple or module of kernels; anything else as it is.

        Args:
            value: what a kernel refers to.
            names: of a module's attributes that are asked for.
        """
        if value is placeholders:
            return self._functions
        if isinstance(value, placeholders.Property):
            return getattr(self._functions, value.name)
        if isinstance(value, tuple):
            own = [self.of(one, names) for one in value]
            return value if _same(own, value) else getattr(type(value), "_make", tuple)(own)
        if isinstance(value, types.ModuleType) and not is_versioned(value.__name__):
            return self._module(value, names)
        if not _is_kernel(value):
            return value
        if value not in self._copies:
            self._copies[value] = None  # kernels may call themselves
            self._copies[value] = self._copy(value)
        return self._copies[value] or value

    def _copy(self, kernel: Any) -> Any:
        function = getattr(kernel, "py_func", kernel)
        names, attributes = names_in(function.__code__), attributes_in(function.__code__)
        found = {name: function.__globals__[name] for name in names if name in function.__globals__}
        own = {name: self.of(value, attributes) for name, value in found.items()}
        cells = tuple(self._cell(cell, attributes) for cell in function.__closure__ or ())
        if _same(own.values(), found.values()) and _same(cells, function.__closure__ or ()):
            return None
        space = {"__builtins__": builtins, "__name__": function.__module__, **own}
        copy = types.FunctionType(function.__code__, space, function.__name__, function.__defaults__, cells)
        copy.__doc__, copy.__qualname__ = function.__doc__, function.__qualname__
        options = {name: value for name, value in getattr(kernel, "targetoptions", {}).items() if name == "forceinline"}
        return numba.njit(**OPTIONS, **options)(copy) if JIT else copy

    def _cell(self, cell: types.CellType, names: tuple[str, ...]) -> types.CellType:
        """Return a cell for the counterpart of what it holds."""
        if cell == _EMPTY:
            return cell
        own = self.of(cell.cell_contents, names)
        return cell if own is cell.cell_contents else types.CellType(own)

    def _module(self, module: types.ModuleType, names: tuple[str, ...]) -> types.ModuleType:
        found = {name: getattr(module, name) for name in names if hasattr(module, name)}
        own = {name: self.of(value, names) for name, value in found.items() if value is not module}
        if all(value is found[name] for name, value in own.items()):
            return module
        copy = types.ModuleType(module.__name__, module.__doc__)
        vars(copy).update({**vars(module), **own})
        return copy


def _is_kernel(value: Any) -> bool:
    return hasattr(value, "py_func") or (not JIT and isinstance(value, types.FunctionType))


def _same(some: Any, others: Any) -> bool:
    return all(one is other for one, other in zip(some, others, strict=True))


def is_versioned(module: str) -> bool:
    """Return whether a module belongs to a package whose functions no law changes."""
    return module.split(".")[0] in ("builtins", "math", "cmath", "operator", "numpy", "numba")


@lru_cache(maxsize=4096)
def _names(code: types.CodeType) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the globals that code asks for, that of nested functions included, and the attributes."""
    names: dict[str, None] = {}
    attributes: dict[str, None] = {}
    for one in _walk_code(code):
        for step in dis.get_instructions(one):
            if step.opname in ("LOAD_GLOBAL", "LOAD_NAME"):
                names[step.argval] = None
            elif step.opname in ("LOAD_ATTR", "LOAD_METHOD"):
                attributes[step.argval] = None
    return tuple(names), tuple(attributes)


def names_in(code: types.CodeType) -> tuple[str, ...]:
    """Return the globals that code asks for, those of nested functions included."""
    return _names(code)[0]


def attributes_in(code: types.CodeType) -> tuple[str, ...]:
    """Return the attributes that code asks for, those of nested functions included."""
    return _names(code)[1]


def _walk_code(code: types.CodeType) -> Iterator[types.CodeType]:
    yield code
    for one in code.co_consts:
        if isinstance(one, types.CodeType):
            yield from _walk_code(one)
