"""Jitted functions as plain Python: what `NUMBA_DISABLE_JIT=1` gives, for one function and all that it calls."""

from __future__ import annotations

import builtins
import types
from collections.abc import Callable
from typing import Any

from granular_env.components.chain.specialisation import is_versioned, names_in

_EMPTY = types.CellType()


def plain_function(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return the Python of a jitted function, which calls the Python of the jitted functions that it refers to.

    Arrays are those of numpy there: an index out of bounds raises `IndexError`, a write into a read-only one `ValueError`.
    """
    return _Copies().of(function)


class _Copies:
    """Plain copies of functions; each is made once, so that functions may call themselves."""

    def __init__(self) -> None:
        self._made: dict[int, Any] = {}

    def of(self, value: Any) -> Any:
        """Return the plain counterpart of a jitted function, a tuple or a module that may have some; anything else as it is."""
        if isinstance(value, types.ModuleType) and not is_versioned(value.__name__):
            return _Module(self, value)
        if isinstance(value, types.FunctionType):
            return self._copy(value) if not self._made else value
        if hasattr(value, "py_func") and hasattr(value, "overloads"):
            return self._copy(value.py_func)
        if isinstance(value, tuple):
            plain = [self.of(one) for one in value]
            changed = any(one is not other for one, other in zip(plain, value, strict=True))
            return (getattr(type(value), "_make", tuple)(plain)) if changed else value
        return value

    def _copy(self, function: types.FunctionType) -> Any:
        known = self._made.get(id(function))
        if known is not None:
            return known
        space: dict[str, Any] = {"__builtins__": builtins, "__name__": function.__module__}
        cells = tuple(types.CellType() for _ in function.__closure__ or ())
        copy = types.FunctionType(function.__code__, space, function.__name__, None, cells)
        self._made[id(function)] = copy
        copy.__defaults__ = self.of(function.__defaults__)
        copy.__kwdefaults__ = {name: self.of(value) for name, value in (function.__kwdefaults__ or {}).items()}
        for name in names_in(function.__code__):
            if name in function.__globals__:
                space[name] = self.of(function.__globals__[name])
        for cell, original in zip(cells, function.__closure__ or (), strict=True):
            if original != _EMPTY:
                cell.cell_contents = self.of(original.cell_contents)
        return copy


class _Module:
    """A module whose jitted functions are plain."""

    def __init__(self, copies: _Copies, module: types.ModuleType) -> None:
        self._copies, self._module = copies, module

    def __getattr__(self, name: str) -> Any:
        return self._copies.of(getattr(self._module, name))
