"""Machine code of jitted functions on disk, found again by their `fingerprint`: one file for each function and signature.

Nothing that is wrong with the disk may stop a run: what cannot be read is compiled, what is damaged is thrown away, what cannot
be written is not kept. It is said once.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import re
import tempfile
import weakref
from contextlib import suppress
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from numba.core import sigutils
from numba.core.serialize import dumps

from ...errors import ParameterError
from ..notice import tell
from .cache_folder import cache_folder
from .cacheable_types import is_told_by_name
from .fingerprint import Fingerprint, fingerprint
from .registry_refresh import refresh_after_imports

try:
    from . import compilers
except ImportError as _error:
    compilers = None
    tell(
        f"this version of numba is built in another way than those that were tested ({_error}): kernels are compiled in every "
        "process, and that takes longer; install numba>=0.61,<0.69"
    )

_DIGEST_SIZE = hashlib.sha256().digest_size
# When the files together are larger, those that were not used for longest go.
_LARGEST_CACHE = 256 * 1024 * 1024

# What each function outside of this package was compiled from.
_made_from: weakref.WeakKeyDictionary[Any, Fingerprint] = weakref.WeakKeyDictionary()
# Functions that were compiled before anybody asked what from.
_compiled_elsewhere: weakref.WeakSet[Any] = weakref.WeakSet()


class KernelCache:
    """The cache of one jitted function, in the form in which numba asks for it (`numba.core.caching._Cache`)."""

    def __init__(self, dispatcher: Any) -> None:
        self._dispatcher = dispatcher
        self._made_from: Fingerprint | None = None

    @property
    def cache_path(self) -> str | None:
        """The folder, for people."""
        folder = cache_folder()
        return None if folder is None else str(folder)

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """Return the compiled function for a signature; None where it has to be compiled."""
        refresh_after_imports(target_context)
        self.refuse_stale()
        self.note_references()
        path = self._path(signature, target_context.codegen())
        content = None if path is None else _read(path)
        if path is None or content is None or compilers is None:
            return None
        try:
            return compilers.rebuild(target_context, *pickle.loads(content))
        except Exception:  # whatever it is, it is not what was written by this version of numba
            _remove(path)
            return None

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Keep a compiled function where it can be kept."""
        if compilers is None:
            return
        parts = compiled._reduce()
        for environment in parts[-1]:
            compiled.library.codegen.set_env(environment.env_name, environment)
        path = self._path(signature, compiled.codegen)
        if path is None or compiled.library.has_dynamic_globals or any(not one.can_cache for one in compiled.lifted):
            return
        content = dumps(parts)
        try:
            _write(path, hashlib.sha256(content).digest() + content)
            _forget_oldest(path.parent)
        except OSError as error:
            tell(f"compiled kernels cannot be kept in {path.parent} ({error.strerror}): they are compiled in every process")

    def note_references(self) -> None:
        """Note what the function and those that it calls refer to now, unless that was done before."""
        self._made_from = self._made_from or self._current()

    def refuse_stale(self) -> None:
        """Compare what the function and those that it calls refer to with what they were compiled from.

        Raises:
            ParameterError: something has another value now, and compiled code still has the old one; names it.
        """
        if self._made_from is not None:
            _refuse_stale(self._made_from)

    def _current(self) -> Fingerprint:
        """Return the fingerprint as it is now; what the function calls must not have been compiled from other values."""
        found = fingerprint(self._dispatcher)
        _refuse_stale(found)
        for function in found.functions:
            if function not in _made_from:
                if function.overloads and function is not self._dispatcher:
                    _compiled_elsewhere.add(function)
                elif not isinstance(function._cache, KernelCache):  # numba's own cache looks at its own file alone
                    function._cache = KernelCache(function)
                _made_from[function] = fingerprint(function)
        elsewhere = any(function in _compiled_elsewhere for function in found.functions)
        return replace(found, key=None) if elsewhere else found

    def _path(self, signature: Any, codegen: Any) -> Path | None:
        made_from, folder = self._made_from, cache_folder()
        arguments, returned = sigutils.normalize_signature(signature)
        if folder is None or made_from is None or made_from.key is None or not all(map(is_told_by_name, arguments)):
            return None
        key = repr((made_from.key, arguments, returned, codegen.magic_tuple()))
        function = self._dispatcher.py_func
        name = re.sub(r"[^\w.]", "", f"{function.__module__.rpartition('.')[2]}.{function.__qualname__}")[:60]
        return folder / f"{name}-{hashlib.sha256(key.encode()).hexdigest()[:32]}.kernel"

    # What numba's own caches have besides.

    def enable(self) -> None:
        """Do nothing: it is never off."""

    def disable(self) -> None:
        """Do nothing: it is never off."""

    def flush(self) -> None:
        """Do nothing: no file is ever out of date."""


def _refuse_stale(found: Fingerprint) -> None:
    for function in found.functions:
        before = _made_from.get(function)
        changed = None if before is None else before.change()
        if changed is not None:
            raise ParameterError(
                f"{changed.name} has another value than when {changed.function} was compiled, and compiled code keeps "
                "the first one",
                hint="hand numbers that change over as constants, or define the function anew",
                at=changed.function,
            )


# -- files --------------------------------------------------------------------------------------------------------------


def _read(path: Path) -> bytes | None:
    """Return what was written; None where nothing was. A file that is not whole is removed."""
    try:
        data = path.read_bytes()
    except OSError:
        return None
    content = data[_DIGEST_SIZE:]
    if hashlib.sha256(content).digest() != data[:_DIGEST_SIZE]:
        _remove(path)
        return None
    with suppress(OSError):
        os.utime(path)
    return content


def _write(path: Path, data: bytes) -> None:
    """Write a file that is whole whenever it is there."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=".part-")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        os.replace(name, path)
    except BaseException:
        _remove(Path(name))
        raise


def _remove(path: Path) -> None:
    with suppress(OSError):
        path.unlink()


@cache
def _forget_oldest(folder: Path) -> None:
    """Remove the files that were not used for longest where all are too large together; looked at once in a process."""
    files = [(path.stat(), path) for path in folder.iterdir() if path.is_file()]
    size = sum(status.st_size for status, _ in files)
    for status, path in sorted(files, key=lambda one: one[0].st_mtime):
        if size <= _LARGEST_CACHE:
            return
        _remove(path)
        size -= status.st_size
