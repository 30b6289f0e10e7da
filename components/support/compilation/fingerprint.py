"""Fingerprint of a jitted function: everything its machine code is made from.

Numba freezes what a function refers to (globals, closures, attributes of modules, other jitted functions) when it compiles it.
So machine code may be used again only where all of these are what they were: their values, not the text of a file. What cannot
be told from its value makes a function unknown; its machine code is not kept on disk.
"""

from __future__ import annotations

import builtins
import dis
import enum
import hashlib
import inspect
import struct
import sys
import types
import weakref
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core import config as numba_config
from numba.core.compiler import Compiler
from numba.core.dispatcher import Dispatcher

# What belongs to these is told by their versions.
_VERSIONED = ("builtins", "math", "cmath", "operator", "numpy", "numba")
_VERSIONS = f"python {sys.version_info[:3]} numba {numba.__version__} llvmlite {llvmlite.__version__} numpy {np.__version__}"
# Settings of numba that change machine code.
_SETTINGS = ("BOUNDSCHECK", "OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "DEBUGINFO_DEFAULT")
_MISSING = object()
_settings: Any = numba_config

# Objects that are told by something else than their kind: what `tell_apart` was given.
_tokens: weakref.WeakKeyDictionary[Any, str] = weakref.WeakKeyDictionary()
_package_keys: weakref.WeakKeyDictionary[Any, str | None] = weakref.WeakKeyDictionary()


@dataclass(frozen=True)
class Binding:
    """A name that a function refers to.

    Attributes:
        function: the function's name.
        name: the name, with its module where it is an attribute.
        look_up: gives the present value.
        value: what it was.
        content: a text for what it was, None where there is none.
    """

    function: str
    name: str
    look_up: Callable[[], Any]
    value: Any
    content: str | None

    def has_changed(self) -> bool:
        """Return whether the name stands for another value now."""
        now = self.look_up()
        if self.content is not None:
            return _content(now) != self.content
        if now is self.value:
            return False
        if isinstance(now, Dispatcher) and isinstance(self.value, Dispatcher):
            return fingerprint(now).key is None or fingerprint(now).key != fingerprint(self.value).key
        return True


@dataclass(frozen=True)
class Fingerprint:
    """The sources of a function's machine code.

    Attributes:
        key: a hash of all of it; None where `unknown` says what has no fingerprint.
        bindings: the names that it and the functions it calls refer to, those of numba, numpy and this package left out.
        functions: the jitted functions that it calls, directly or not, and itself, with the same left out.
        unknown: "function: name (type)" of the first value that has no fingerprint.
    """

    key: str | None
    bindings: tuple[Binding, ...]
    functions: tuple[Any, ...]
    unknown: str | None

    def change(self) -> Binding | None:
        """Return a name whose value has changed since, None where there is none."""
        return next((binding for binding in self.bindings if binding.has_changed()), None)


def tell_apart(thing: Any, token: str) -> None:
    """Let an object that jitted functions refer to be told from others by a text: what it does must follow from it."""
    _tokens[thing] = token


def fingerprint(function: Any) -> Fingerprint:
    """Return the fingerprint of a jitted function, with the values that hold now."""
    walk = _Walk(function)
    settings = [f"{name}={getattr(_settings, name, None)}" for name in _SETTINGS]
    key = None if walk.unknown else hashlib.sha256("\0".join([_VERSIONS, *settings, *walk.parts]).encode()).hexdigest()
    return Fingerprint(key, tuple(walk.bindings), tuple(walk.functions), walk.unknown)


def _package_key(dispatcher: Any) -> str | None:
    """Return the key of a function of this package; its constants are what they are, so it is found once."""
    if dispatcher not in _package_keys:
        _package_keys[dispatcher] = f"{dispatcher.py_func.__qualname__} calls itself"
        _package_keys[dispatcher] = fingerprint(dispatcher).key
    return _package_keys[dispatcher]


def is_of_package(function: Any) -> bool:
    """Return whether a jitted function is part of this package, whose constants are never assigned anew."""
    return str(getattr(function, "__module__", "")).split(".")[0] == __name__.split(".")[0]


@lru_cache
def _pipeline_text(pipeline: type) -> str:
    """Return what a compiler of this package does: its name, and the sources of the modules that it is made of."""
    modules = (pipeline.__module__, *getattr(pipeline, "parts", ()))
    source = "\n".join(inspect.getsource(sys.modules[module]) for module in modules)
    return f"{pipeline.__qualname__} {hashlib.sha256(source.encode()).hexdigest()}"


class _Unknown(Exception):
    """A value has no fingerprint."""


class _Walk:
    """The functions that can be reached from one, in the order in which they are met, and their contents as texts."""

    def __init__(self, function: Any) -> None:
        self.parts: list[str] = []
        self.bindings: list[Binding] = []
        self.functions: list[Any] = []
        self.unknown: str | None = None
        self._places: dict[int, int] = {}
        self._visit(function)

    def _visit(self, dispatcher: Any) -> None:
        """Add a jitted function, and what it refers to; one that was met before as its place in the order."""
        place = self._places.get(id(dispatcher))
        self.parts.append(f"function {len(self._places) if place is None else place}")
        if place is not None:
            return
        self._places[id(dispatcher)] = len(self._places)
        own = is_of_package(dispatcher)
        if not own:
            self.functions.append(dispatcher)
        function = dispatcher.py_func
        self.parts += [
            repr(sorted(dispatcher.targetoptions.items())),
            repr(dispatcher._compiler.locals),
            _code_text(function.__code__),
        ]
        if _imports(function.__code__):
            self._give_up(function, "import", "not a value")
        pipeline = dispatcher._compiler.pipeline_class
        if pipeline is not Compiler and not is_of_package(pipeline):
            self._give_up(function, "pipeline", "not a value")
        elif pipeline is not Compiler:
            self.parts.append(_pipeline_text(pipeline))
        for name, look_up in _references(function):
            self._refer(function, name, look_up, own)

    def _refer(self, function: Any, name: str, look_up: Callable[[], Any], own: bool) -> None:
        value = look_up()
        if value is _MISSING:
            return
        self.parts.append(name)
        content = None
        if isinstance(value, Dispatcher):
            self._call(function, name, value)
        else:
            content = _content(value)
            if content is None:
                self._give_up(function, name, type(value).__name__)
            self.parts.append(str(content))
        if not own:
            self.bindings.append(Binding(function.__name__, name, look_up, value, content))

    def _call(self, function: Any, name: str, called: Any) -> None:
        if not is_of_package(called):
            self._visit(called)
            return
        key = _package_key(called)
        if key is None:
            self._give_up(function, name, "jitted function")
        self.parts.append(str(key))

    def _give_up(self, function: Any, name: str, kind: str) -> None:
        self.unknown = self.unknown or f"{function.__name__}: {name} ({kind})"


def _references(function: Any) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Yield the names that a function's code refers to, and how to look each of them up."""
    names, attributes = _names(function.__code__)
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        yield from _resolve(f"{name} (enclosed)", lambda cell=cell: _cell_value(cell), attributes)
    for k, _ in enumerate(function.__defaults__ or ()):
        yield from _resolve(f"default {k}", lambda k=k: _item(function.__defaults__, k), attributes)
    for name in sorted(function.__kwdefaults__ or ()):
        yield from _resolve(
            f"default {name}", lambda name=name: (function.__kwdefaults__ or {}).get(name, _MISSING), attributes
        )
    space = function.__globals__
    for name in names:
        yield from _resolve(name, lambda name=name: space.get(name, getattr(builtins, name, _MISSING)), attributes)


def _resolve(
    name: str, look_up: Callable[[], Any], attributes: tuple[str, ...], depth: int = 0
) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Yield a name itself; of a module the attributes that the code asks anything for, of a tuple its jitted functions too."""
    value = look_up()
    if _has_jitted(value):
        yield name, look_up  # it has no fingerprint: machine code may have addresses of its functions
        for k in range(len(value)):
            yield from _resolve(f"{name}[{k}]", lambda k=k: _item(look_up(), k), attributes, depth)
        return
    if not isinstance(value, types.ModuleType) or is_versioned(value.__name__) or depth > len(attributes):
        yield name, look_up
        return
    yield f"{name} (module)", lambda: value.__name__
    for attribute in attributes:
        if hasattr(value, attribute):
            inner = lambda attribute=attribute: getattr(value, attribute, _MISSING)  # noqa: E731
            yield from _resolve(f"{name}.{attribute}", inner, attributes, depth + 1)


def _has_jitted(value: Any) -> bool:
    """Return whether a value is a tuple with jitted functions, or with tuples of such."""
    return isinstance(value, tuple) and any(isinstance(one, Dispatcher) or _has_jitted(one) for one in value)


def _item(value: Any, k: int) -> Any:
    return value[k] if isinstance(value, tuple) and k < len(value) else _MISSING


def _cell_value(cell: Any) -> Any:
    try:
        return cell.cell_contents
    except ValueError:  # nothing in it yet
        return _MISSING


def is_versioned(module: str) -> bool:
    """Return whether all that a module holds is told by the version of the package that it is part of."""
    return module.split(".")[0] in _VERSIONED


# -- code ---------------------------------------------------------------------------------------------------------------


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


@lru_cache(maxsize=4096)
def _imports(code: types.CodeType) -> bool:
    return any(step.opname == "IMPORT_NAME" for one in _walk_code(code) for step in dis.get_instructions(one))


@lru_cache(maxsize=4096)
def _code_text(code: types.CodeType) -> str:
    """Return what code does, without where it stands."""
    said = [code.co_name, code.co_code.hex(), str(code.co_flags)]
    said += [str((code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount))]
    said += [repr(names) for names in (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)]
    said += [getattr(code, "co_exceptiontable", b"").hex()]
    said += [_code_text(one) if isinstance(one, types.CodeType) else _constant(one) for one in code.co_consts]
    return "\n".join(said)


def _walk_code(code: types.CodeType) -> Iterator[types.CodeType]:
    yield code
    for one in code.co_consts:
        if isinstance(one, types.CodeType):
            yield from _walk_code(one)


def _constant(value: Any) -> str:
    if isinstance(value, frozenset):
        return repr(sorted(map(_constant, value)))
    return str(_content(value))


# -- values -------------------------------------------------------------------------------------------------------------


def _content(value: Any) -> str | None:
    """Return a text that tells a value from every other that machine code could be made from; None where there is none."""
    try:
        return _text(value)
    except _Unknown:
        return None


def _text(value: Any) -> str:
    kind = type(value)
    if value is None or value is Ellipsis or kind in (bool, int, str, bytes):
        return f"{kind.__name__} {value!r}"
    if kind is float:
        return f"float {struct.pack('<d', value).hex()}"
    if kind is complex:
        return f"complex {struct.pack('<dd', value.real, value.imag).hex()}"
    if isinstance(value, (np.ndarray, np.generic)):
        return _array_text(value)
    if isinstance(value, enum.Enum):
        return f"{kind.__module__}.{kind.__qualname__}.{value.name} {_text(value.value)}"
    if isinstance(value, tuple):
        return f"{kind.__qualname__} {getattr(kind, '_fields', '')} ({', '.join(_text(one) for one in value)})"
    if isinstance(value, (numba.types.Number, numba.types.Boolean, numba.types.Array, np.dtype)):
        return f"{kind.__name__} {value!r}"
    return _object_text(value)


def _array_text(value: Any) -> str:
    if value.dtype.hasobject:
        raise _Unknown
    content = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
    return f"{type(value).__name__} {value.dtype.descr} {value.shape} {content}"


def _object_text(value: Any) -> str:
    """Return the text of a function, class or module."""
    try:
        token = _tokens.get(value)
    except TypeError:  # no object that can be a key
        token = None
    if token is not None:
        return token
    if isinstance(value, types.ModuleType) and is_versioned(value.__name__):
        return f"module {value.__name__}"
    if isinstance(value, np.ufunc):
        if getattr(np, value.__name__, None) is value:
            return f"numpy {value.__name__}"
        raise _Unknown
    if isinstance(value, type) and issubclass(value, enum.Enum):
        return f"{value.__module__}.{value.__qualname__} ({', '.join(_text(one) for one in value)})"
    if isinstance(value, type) and issubclass(value, tuple) and hasattr(value, "_fields"):
        return f"{value.__module__}.{value.__qualname__} {getattr(value, '_fields', '')}"
    module, name = getattr(value, "__module__", None), getattr(value, "__qualname__", None)
    if isinstance(module, str) and isinstance(name, str) and is_versioned(module):
        return f"{module}.{name}"
    raise _Unknown
