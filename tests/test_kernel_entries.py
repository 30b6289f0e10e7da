"""Kernels have an entry from Python where Python calls them: an entry, with machine code of its own, takes long to compile."""

import importlib
import pkgutil
import types
from collections.abc import Iterator
from typing import Any

import pytest
from numba.core.dispatcher import Dispatcher

import granular_env.components
from granular_env.components.support.jit import JIT

pytestmark = pytest.mark.skipif(not JIT, reason="nothing is compiled")

PACKAGE = granular_env.components.__name__
# A chain's kernels are copied for its law and called by tasks; numbers of `counter_random` are drawn by kernels of others.
OPEN = ("chain", "support.counter_random", "support.addresses")


def modules() -> list[types.ModuleType]:
    found = pkgutil.walk_packages(granular_env.components.__path__, f"{PACKAGE}.")
    return [importlib.import_module(one.name) for one in found]


def own_functions(module: types.ModuleType) -> Iterator[Any]:
    """The functions and methods that a module defines, jitted or not."""
    for value in vars(module).values():
        if getattr(value, "__module__", None) != module.__name__:
            continue
        members = list(vars(value).values()) if isinstance(value, type) else [value]
        for member in members:
            for name in ("__func__", "fget", "func"):
                member = getattr(member, name, None) or member
            if isinstance(member, types.FunctionType | Dispatcher):
                yield member


def codes(code: types.CodeType) -> Iterator[types.CodeType]:
    yield code
    for one in code.co_consts:
        if isinstance(one, types.CodeType):
            yield from codes(one)


def used_kernels(function: Any) -> set[Any]:
    """The jitted functions that a function names, as globals or as attributes of modules."""
    space, found = function.__globals__, set()
    for code in codes(function.__code__):
        values = [space.get(name) for name in code.co_names]
        owners = [value for value in values if isinstance(value, types.ModuleType) and value.__name__.startswith(PACKAGE)]
        values += [getattr(owner, name, None) for owner in owners for name in code.co_names]
        found |= {value for value in values if isinstance(value, Dispatcher)}
    return found


def test_kernels_have_an_entry_where_python_calls_them_and_nowhere_else():
    kernels, by_python, by_kernels = set(), set(), set()
    for module in modules():
        for function in own_functions(module):
            if isinstance(function, Dispatcher):
                kernels.add(function)
                by_kernels |= used_kernels(function.py_func)
            else:
                by_python |= used_kernels(function)
    assert len(kernels) > 300
    wrong = {
        f"{kernel.py_func.__module__}.{kernel.py_func.__qualname__}": "internal" if without else "jit"
        for kernel in kernels
        if (without := bool(kernel.targetoptions.get("no_cpython_wrapper"))) == (kernel in by_python)
        and (kernel in by_kernels or kernel in by_python)
    }
    assert not {name: made for name, made in wrong.items() if not name.removeprefix(f"{PACKAGE}.").startswith(OPEN)}, (
        "kernels that Python calls are to be `jit`, others `internal`"
    )
