"""The variables of numba's instructions, listed faster: numba goes through all fields of each, seven times in a compilation.

By the class of a field it is known whether it can hold a variable; numba asks what each value is an instance of.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core.ir import Inst, Var

_numba_lists = getattr(Inst, "_rec_list_vars", None)
_NOTHING, _VARIABLE, _INSTRUCTION, _SEQUENCE, _MAPPING = range(5)
_kinds: dict[type, int] = {}


def _kind_of(field: type) -> int:
    parents = (Var, Inst, (list, tuple), dict)
    found = next((number for number, parent in enumerate(parents, _VARIABLE) if issubclass(field, parent)), _NOTHING)
    _kinds[field] = found
    return found


def _list_variables(instruction: Any, value: Any) -> list[Any]:
    """Return the variables in a field of an instruction, in the order in which they stand there."""
    of_class = value.__class__
    kind = _kinds[of_class] if of_class in _kinds else _kind_of(of_class)
    if kind == _NOTHING:
        return []
    if kind == _VARIABLE:
        return [value]
    if kind == _INSTRUCTION:
        return value.list_vars()
    found: list[Any] = []
    for one in value.values() if kind == _MAPPING else value:
        of_class = one.__class__
        kind_of_one = _kinds[of_class] if of_class in _kinds else _kind_of(of_class)
        if kind_of_one == _VARIABLE:
            found.append(one)
        elif kind_of_one != _NOTHING:
            found += _list_variables(instruction, one)
    return found


@contextmanager
def quick_lists() -> Iterator[None]:
    """List variables in this way until the end of the block."""
    if _numba_lists is None:
        yield
        return
    before = Inst._rec_list_vars
    Inst._rec_list_vars = _list_variables
    try:
        yield
    finally:
        Inst._rec_list_vars = before
