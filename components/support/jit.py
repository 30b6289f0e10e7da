"""Compilation by numba without reassociation, cached in a folder for this version of the sources."""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
import time
from collections.abc import Callable
from functools import cache
from importlib import metadata, util
from pathlib import Path
from typing import Any, TypeVar

import numba
import numpy as np

_settings: Any = numba.config  # pyright: ignore[reportPrivateImportUsage]
# Whether functions are compiled; False if numba's JIT is disabled.
JIT = not _settings.DISABLE_JIT
# Options of all kernels. Kernels do not raise, and a division that could raise would prevent vectorisation. Kernels are not
# called from C, and the wrapper for C would take a tenth of the compilation.
OPTIONS = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
# Entry points of packages whose kernels and laws are compiled together with those of this package.
_PLUGIN_GROUPS = ("granular_env.components", "granular_env.chain_laws")
_DAYS_KEPT = 30
F = TypeVar("F", bound=Callable[..., Any])


def jit(function: F) -> F:
    """Compile a function for this CPU without reassociation: bitwise the same results with the JIT on or off. Releases the GIL.

    Machine code of this package and of its plug-ins is cached on disk. Other functions are compiled in each process, because
    numba's cache would miss changes in modules that they import.
    """
    return _compile(function)


def inlined(function: F) -> F:
    """Compile a function like `jit` and make LLVM inline it into its callers, so that their loops vectorise."""
    return _compile(function, forceinline=True)


def internal(function: F) -> F:
    """Compile a function like `jit`, without a wrapper for Python; for functions that only kernels call.

    The wrapper takes longer to compile than a short function.
    """
    return _compile(function, no_cpython_wrapper=True)


def spliced(function: F) -> F:
    """Compile a function as part of its caller; for functions that call others and are called in one place.

    LLVM would optimise a callee separately and again in each caller; without the call it does so once.
    """
    return _compile(function, inline="always", no_cpython_wrapper=True)


def internal_inlined(function: F) -> F:
    """Compile a function without a wrapper for Python (see `internal`) and inline it into its callers (see `inlined`)."""
    return _compile(function, forceinline=True, no_cpython_wrapper=True)


def _compile(function: F, **options: Any) -> F:
    if not JIT:
        return function
    folder = cache_folder() if is_cached(function.__module__) else None
    before, _settings.CACHE_DIR = _settings.CACHE_DIR, str(folder or "")
    try:
        compiled: Any = numba.njit(**OPTIONS, **options, cache=folder is not None)
        return compiled(function)
    finally:
        _settings.CACHE_DIR = before


def is_cached(module: str) -> bool:
    """Return whether machine code of a module is cached on disk, i.e. whether it belongs to this package or a plug-in."""
    return module.partition(".")[0] in _hashed_package_names()


@cache
def cache_folder() -> Path | None:
    """Return the folder of compiled kernels of these sources, or None if none can be written.

    It lies in ``GRANULAR_ENV_CACHE`` or in the user's cache. Folders of other versions are deleted 30 days after their last
    use.
    """
    try:
        kernels = cache_root() / "kernels"
        folder = kernels / kernel_source_hash()
        is_new = not folder.is_dir()
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        os.utime(folder)
        _delete_old_folders(kernels)
    except (OSError, RuntimeError) as error:  # RuntimeError: no home folder
        reason = getattr(error, "strerror", None) or str(error)
        print_notice(f"compiled kernels cannot be cached ({reason}): every process compiles them; set GRANULAR_ENV_CACHE")
        return None
    if is_new:
        print_notice(f"the first run of each system compiles its kernels and caches them in {folder}; this takes some seconds")
    return folder


def print_notice(message: str) -> None:
    """Write one line to stderr, unless ``GRANULAR_ENV_QUIET`` is set to a value other than 0."""
    if os.environ.get("GRANULAR_ENV_QUIET", "0") in ("", "0") and sys.stderr is not None:
        print(f"granular-env: {message}", file=sys.stderr, flush=True)


def cache_root() -> Path:
    """Return ``GRANULAR_ENV_CACHE``, or else the package's folder in the user's cache."""
    given = os.environ.get("GRANULAR_ENV_CACHE")
    if given:
        return Path(given)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "granular-env"


def _delete_old_folders(kernels: Path) -> None:
    limit = time.time() - _DAYS_KEPT * 86400
    for folder in kernels.iterdir():
        if folder.is_dir() and folder.stat().st_mtime < limit:
            shutil.rmtree(folder, ignore_errors=True)


def kernel_source_hash() -> str:
    """Return a hash of the sources of all components and plug-ins, and of the versions of Python, numba and numpy."""
    state = hashlib.sha256(f"{sys.version} {numba.__version__} {np.__version__}".encode())
    for root in (Path(__file__).resolve().parent.parent, *_plugin_sources()):
        for path in sorted(root.rglob("*.py")) if root.is_dir() else [root]:
            state.update(str(path.relative_to(root)).encode())
            state.update(path.read_bytes())
    return state.hexdigest()[:16]


@cache
def _hashed_package_names() -> frozenset[str]:
    """Return the names of this package and of plug-in packages with components or laws."""
    plugins = [entry.module for group in _PLUGIN_GROUPS for entry in metadata.entry_points(group=group)]
    return frozenset(module.partition(".")[0] for module in (__name__, *plugins))


def _plugin_sources() -> list[Path]:
    """Return the folders, or single files, of plug-in packages with components or laws."""
    specs = [util.find_spec(name) for name in sorted(_hashed_package_names()) if name != __name__.partition(".")[0]]
    files = [Path(spec.origin) for spec in specs if spec is not None and spec.origin]
    return [file.parent if file.name == "__init__.py" else file for file in files]
