"""`jit`: numba without reassociation, and with a cache on disk that is right by construction (`kernel_cache`)."""

from __future__ import annotations

import hashlib
import os
import weakref
from collections.abc import Callable
from contextlib import nullcontext
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import llvmlite
import numba
import numpy as np
from numba.core import config as numba_config
from numba.core import sigutils
from numba.core.bytecode import FunctionIdentity
from numba.core.dispatcher import Dispatcher
from numba.core.registry import CPUDispatcher

from .compilation import compilation_notice
from .compilation.fingerprint import is_of_package
from .compilation.garbage_collection import without_collection
from .compilation.kernel_cache import KernelCache, compilers

_settings: Any = numba_config
# Whether anything is compiled at all.
JIT = not _settings.DISABLE_JIT
# Functions of numba.njit -> the same compiled by `jit`, which live as long.
_compiled_again: weakref.WeakKeyDictionary[Any, Any] = weakref.WeakKeyDictionary()
F = TypeVar("F", bound=Callable[..., Any])
# Options of what Python does not call: no entry from there, and no counts of references to arrays.
_INTERNAL = {"no_cpython_wrapper": True, "_nrt": False}


def jit(function: F) -> F:
    """Compile for this CPU without any reassociation: the same bits with the JIT on or off. The GIL is released.

    A function of this package that takes a tuple of arrays may make none.
    """
    return _compile(function)


def inlined(function: F) -> F:
    """`jit` for what long loops call: LLVM puts it into its callers, so that loops become vectors and constants fold."""
    return _compile(function, forceinline=True)


def internal(function: F) -> F:
    """`jit` for what other kernels call and Python does not: intermediate code, without its entry from Python.

    For arguments that are tuples of many arrays that entry takes longer to compile than the function itself. The function may
    make no array. Python can call it all the same, as in a test: it is then compiled once more.
    """
    return _compile(function, **_INTERNAL)


def internal_inlined(function: F) -> F:
    """`inlined` and `internal`."""
    return _compile(function, forceinline=True, **_INTERNAL)


class _Kernel(CPUDispatcher):
    """A function that is compiled once for whole numbers: numba would compile it for each literal that it is called with."""

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return how another jitted function calls this one."""
        return super().get_call_template(tuple(map(_without_literal, args)), kws)

    def compile(self, sig: Any) -> Any:
        """Compile for a signature, or load what was compiled."""
        with without_collection(), nullcontext() if compilers is None else compilers.kept_calls():
            return super().compile(sig)


class _Internal(_Kernel):
    """A function without an entry from Python, as intermediate code."""

    def __call__(self, *arguments: Any, **named: Any) -> Any:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Call it by another one that has such an entry."""
        if not hasattr(self, "_with_entry"):
            self._with_entry = _keep_on_disk(_Kernel(self.py_func, targetoptions=_without_internal(self.targetoptions)))
        return self._with_entry(*arguments, **named)


def _without_literal(kind: Any) -> Any:
    return numba.types.unliteral(kind) if isinstance(kind, numba.types.IntegerLiteral) else kind


def _compile(function: F, **options: Any) -> F:
    if not JIT:
        return function
    # Kernels raise nothing; and a division that may raise would end a loop early, and such a loop is no vector.
    options |= {"nopython": True, "nogil": True, "error_model": "numpy"}
    if is_of_package(function):
        # Functions as values need an entry for C. No kernel of this package is one, and a tenth of the compilation is saved.
        options["no_cfunc_wrapper"] = True
    if compilers is None:
        return _keep_on_disk(_Kernel(function, targetoptions=_without_internal(options)))
    if options.get("no_cpython_wrapper"):
        return _keep_on_disk(_Internal(function, targetoptions=options, pipeline_class=compilers.IntermediateCompiler))
    pipeline = compilers.EntryCompiler if is_of_package(function) else compilers.UserEntryCompiler
    return _keep_on_disk(_Kernel(function, targetoptions=options, pipeline_class=pipeline))


def _without_internal(options: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in options.items() if name not in _INTERNAL}


def _keep_on_disk(kernel: Any) -> Any:
    kernel._cache = KernelCache(kernel)
    return kernel


def compile_like(kernel: Any, function: Callable[..., Any]) -> Any:
    """Return a function jitted with the options of a kernel."""
    if not JIT:
        return function
    return _compile(function, **kernel.targetoptions)


class _UniqueNumbers:
    """Numbers by which numba tells symbols of like functions apart.

    Numba counts from 1 in each process; symbols of machine code that several processes have written could then be the same in
    the process that loads them, and one function would run as the other.
    """

    def __next__(self) -> int:
        return int.from_bytes(os.urandom(6), "big")


if JIT:
    identity: Any = FunctionIdentity
    identity._unique_ids = _UniqueNumbers()
    compilation_notice.listen()


def refuse_stale(function: Callable[..., Any]) -> None:
    """Compare what a jitted function refers to with what it was compiled from.

    Raises:
        ParameterError: a global, an enclosed variable or a called function has another value now; names it.
    """
    function = _recompile_if_plain_numba(function)
    kept = getattr(function, "_cache", None)
    if isinstance(kept, KernelCache) and not is_of_package(function):
        kept.refuse_stale()


def note_references(function: Callable[..., Any]) -> None:
    """Note what a jitted function refers to now, as if it was compiled: `refuse_stale` compares with it."""
    kept = getattr(function, "_cache", None)
    if isinstance(kept, KernelCache):
        kept.note_references()


def current(function: Callable[..., Any]) -> Any:
    """Return what to call for a jitted function so that it runs with what it refers to now; others as they are.

    A function of numba.njit that has run keeps the values of that time, and tells nobody.

    Raises:
        ParameterError: as `refuse_stale`.
    """
    compiled = _recompile_if_plain_numba(function)
    refuse_stale(compiled)
    return compiled


def _recompile_if_plain_numba(function: Callable[..., Any]) -> Any:
    """Return a jitted function itself, or compiled by `jit` where numba.njit made it, which keeps old values."""
    if (
        not isinstance(function, Dispatcher)
        or isinstance(getattr(function, "_cache", None), KernelCache)
        or is_of_package(function)
    ):
        return function
    if function not in _compiled_again:
        _compiled_again[function] = jit(function.py_func)
    return _compiled_again[function]


def entry_point(function: Callable[..., Any], signature: str) -> Callable[..., Any]:
    """Return the machine code of a jitted function for one signature: no look-up of the arguments' types at each call.

    That look-up costs as much as a step of twenty grains. Whoever calls it promises the types.

    Raises:
        ParameterError: what the function refers to has changed since it was compiled.
    """
    if not hasattr(function, "compile"):  # the JIT is off
        return function
    compiled = current(function)
    compiled.compile(signature)
    return compiled.overloads[sigutils.normalize_signature(signature)[0]].entry_point


@cache
def source_hash() -> str:
    """Hash of all component sources and of numba's, llvmlite's and numpy's versions."""
    root = Path(__file__).resolve().parent.parent
    state = hashlib.sha256(f"{numba.__version__} {llvmlite.__version__} {np.__version__}".encode())
    for path in sorted(root.rglob("*.py")):
        state.update(str(path.relative_to(root)).encode())
        state.update(path.read_bytes())
    return state.hexdigest()[:16]
