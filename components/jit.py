"""`jit`: numba with a cache that notices every edit.

Numba's own cache looks only at the file of the function itself, so an edited law would keep its old physics in the kernels that
call it. Here the cache folder's name is a hash of all component sources and of the versions that shape the machine code; for a
function of another package, of all sources in its folder too.
"""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import llvmlite
import numba
import numpy as np
from numba.core import cgutils, sigutils
from numba.core import config as numba_config
from numba.core.errors import TypingError
from numba.extending import intrinsic

_KEPT_FOLDERS = 32
_settings: Any = numba_config
# Whether anything is compiled at all.
JIT = not _settings.DISABLE_JIT
F = TypeVar("F", bound=Callable[..., Any])


def jit(function: F) -> F:
    """Compile for this CPU without any reassociation: the same bits with the JIT on or off. The GIL is released."""
    return _compiled(function)


def inlined(function: F) -> F:
    """`jit` for what long loops call: LLVM puts it into its callers, so that loops become vectors and constants fold."""
    return _compiled(function, forceinline=True)


def _compiled(function: F, **options: Any) -> F:
    # Kernels raise nothing; and a division that may raise would end a loop early, and such a loop is no vector.
    compiled: Any = numba.njit(nogil=True, error_model="numpy", **options)(function)
    folder = cache_folder(_package_of(function))
    if folder is not None and hasattr(compiled, "enable_caching"):
        with _cache_in(folder), suppress(RuntimeError):  # numba found no folder it may write to
            compiled.enable_caching()
    return compiled


def entry_point(function: Callable[..., Any], signature: str) -> Callable[..., Any]:
    """The machine code of a jitted function for one signature, without numba's look-up of the arguments' types at each call.

    That look-up costs as much as a step of twenty grains. Whoever calls it promises the types.
    """
    if not hasattr(function, "compile"):  # the JIT is off
        return function
    compiled: Any = function
    compiled.compile(signature)
    return compiled.overloads[sigutils.normalize_signature(signature)[0]].entry_point


def address(function: Callable[..., Any], signature: str) -> Any:
    """Where the machine code of a jitted function for one signature lies: a number, for `caller`.

    So one compiled loop runs anybody's functions, and is compiled once. The function must live as long as the number is used.
    With the JIT off it is the function itself.
    """
    if not hasattr(function, "compile"):
        return function
    compiled: Any = function
    compiled.compile(signature)
    result = compiled.overloads[sigutils.normalize_signature(signature)[0]]
    wanted = sigutils.normalize_signature(signature)[1]
    if wanted is not None and result.signature.return_type != wanted:
        raise TypeError(f"{compiled.__name__} returns {result.signature.return_type}, expected {wanted}")
    return result.library.get_pointer_to_function(result.fndesc.llvm_func_name)


def caller(signature: str) -> Any:
    """A function for jitted code, call(where, (argument, ...)), that calls what lies at an `address` of that signature.

    The arguments must have exactly the signature's types.
    """
    if not JIT:
        return lambda function, arguments: function(*arguments)
    types, given_return = sigutils.normalize_signature(signature)
    returned: Any = given_return

    @intrinsic
    def call(context: Any, where: Any, arguments: Any) -> Any:
        given = tuple(arguments)
        if given != types:
            raise TypingError(f"call through an address: got {given}, expected {types}")

        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            convention = context.call_conv
            kind = convention.get_function_type(returned, types)
            function = builder.inttoptr(values[0], kind.as_pointer())
            parts = [builder.extract_value(values[1], place) for place in range(len(types))]
            status, result = convention.call_function(builder, function, returned, types, parts)
            with cgutils.if_unlikely(builder, status.is_error):
                convention.return_status_propagate(builder, status)
            return result

        return returned(numba.types.int64, arguments), generate

    return call


@contextmanager
def _cache_in(folder: Path) -> Iterator[None]:
    """Numba asks its settings for the cache's place when a function's caching is switched on, and never again."""
    settings: Any = numba_config
    before = settings.CACHE_DIR
    settings.CACHE_DIR = str(folder)
    try:
        yield
    finally:
        settings.CACHE_DIR = before


@cache
def source_hash() -> str:
    """Hash of all component sources and of numba's, llvmlite's and numpy's versions."""
    root = Path(__file__).resolve().parent
    state = hashlib.sha256(f"{numba.__version__} {llvmlite.__version__} {np.__version__}".encode())
    for path in sorted(root.rglob("*.py")):
        state.update(str(path.relative_to(root)).encode())
        state.update(path.read_bytes())
    return state.hexdigest()[:16]


def _package_of(function: Callable[..., Any]) -> Path | None:
    """The folder of a function's package; None for the components themselves, and for a file that stands alone."""
    folder = Path(function.__code__.co_filename).resolve().parent
    inside = folder.is_relative_to(Path(__file__).resolve().parent)
    return None if inside or not (folder / "__init__.py").exists() else folder


@cache
def cache_folder(package: Path | None = None) -> Path | None:
    """Where compiled kernels are kept (``GRANULAR_ENV_CACHE`` or the user's cache); None if nothing can be written."""
    given = os.environ.get("GRANULAR_ENV_CACHE")
    base = Path(given) if given else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "granular-env"
    name = source_hash()
    if package is not None:
        sources = [path.read_bytes() for path in sorted(package.glob("*.py"))]
        name = hashlib.sha256(b"\0".join([name.encode(), str(package).encode(), *sources])).hexdigest()[:16]
    folder = base / name
    try:
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
        _forget_old(base)
    except OSError:
        return None
    return folder


def _forget_old(base: Path) -> None:
    folders = sorted((path for path in base.iterdir() if path.is_dir()), key=lambda path: path.stat().st_mtime)
    for path in folders[:-_KEPT_FOLDERS]:
        shutil.rmtree(path, ignore_errors=True)
