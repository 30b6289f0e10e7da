"""Copying and pickling of environments: how each was made, and where it is; for `copy.deepcopy` and libraries that pickle."""

from __future__ import annotations

import copy
import inspect
import warnings
from abc import ABCMeta
from collections.abc import Callable, Iterable, Mapping
from functools import cache, partial, wraps
from typing import Any, ParamSpec, Self, TypeVar, get_args, get_origin, get_type_hints

import numpy as np

from ..components.errors import GranularWarning, ParameterError, nearest

Arguments = tuple[tuple[Any, ...], dict[str, Any]]
Given = ParamSpec("Given")
Made = TypeVar("Made", bound="Recreatable")


class _Announcing(ABCMeta):
    """Marks an instance once its whole `__init__`, that of subclasses too, has run."""

    def __call__(cls, *positional: Any, **named: Any) -> Any:
        made = super().__call__(*positional, **named)
        made._complete = True
        return made


class Recreatable(metaclass=_Announcing):
    """Base of what can be made again: from the arguments of its constructor, or of the factory that made it.

    Subclasses give `__reduce__`, which adds the present state to these arguments.
    """

    _made_by: Callable[..., Any]
    _made_with: Arguments
    _complete: bool = False

    def __new__(cls, *arguments: Any, **keywords: Any) -> Self:
        """Keep the arguments; `ParameterError` with the nearest name for a keyword that there is not."""
        refuse_unknown(cls, keywords)
        made = super().__new__(cls)
        made._made_by, made._made_with = cls, (_keep(arguments), _keep(keywords))
        return made

    def is_read_once(self, name: str) -> bool:
        """Return whether an attribute is an argument of what made this that nothing reads afterwards."""
        return self._complete and name not in vars(self) and name in (known_arguments(self._made_by) or ())

    def __copy__(self) -> Self:
        """Return an independent copy: one that shares the state would step the original as well."""
        return copy.deepcopy(self)


def recreatable(make: Callable[Given, Made]) -> Callable[Given, Made]:
    """Let what a factory makes be copied and pickled by the factory's arguments, of which it refuses unknown ones by name.

    A decorator of functions at the top of a module, which return a `Recreatable`.
    """

    @wraps(make)
    def make_copyable(*arguments: Given.args, **keywords: Given.kwargs) -> Made:
        refuse_unknown(make_copyable, keywords)
        kept = _keep(arguments), _keep(keywords)
        one = make(*arguments, **keywords)
        one._made_by, one._made_with = make_copyable, kept
        return one

    return make_copyable


def make_again(make: Callable[..., Made], arguments: tuple[Any, ...], keywords: Mapping[str, Any]) -> Made:
    """Return what was made so before, when the cautions of making it were issued."""
    with warnings.catch_warnings(action="ignore", category=GranularWarning):
        return make(*arguments, **keywords)


def refuse_unknown(make: Callable[..., Any], keywords: Iterable[str]) -> None:
    """Raise `ParameterError` with the nearest name for a keyword that a class or a factory does not take."""
    known = known_arguments(make)
    if known is not None and (unknown := [name for name in keywords if name not in known]):
        raise ParameterError("unknown", source=make.__name__, hint=nearest(unknown[0], known), at=unknown[0])


@cache
def known_arguments(make: Callable[..., Any]) -> tuple[str, ...] | None:
    """Return the names that a class or a function takes, those of its `Unpack`-ed options included; None where it takes any."""
    names: list[str] = []
    while isinstance(make, partial):
        make = make.func
    function = make.__init__ if isinstance(make, type) else make
    parameters = list(inspect.signature(function).parameters.values())
    for parameter in parameters[1:] if isinstance(make, type) else parameters:
        if parameter.kind is inspect.Parameter.VAR_KEYWORD:
            options = _options(function, parameter.name)
            if options is None:
                return None
            names += options
        elif parameter.kind is not inspect.Parameter.VAR_POSITIONAL:
            names.append(parameter.name)
    return tuple(names)


def _options(function: Callable[..., Any], name: str) -> Iterable[str] | None:
    """Keys of the TypedDict in `**name: Unpack[...]`; None where there is none."""
    try:
        hint = get_type_hints(function)[name]
    except (NameError, KeyError, TypeError):
        return None
    inside = get_args(hint)
    return get_type_hints(inside[0]) if get_origin(hint) is not None and len(inside) == 1 else None


def _keep(value: Any) -> Any:
    """Return arguments as they are now, whatever the caller does to its lists and mappings later."""
    if isinstance(value, Mapping):
        return {name: _keep(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(_keep(item) for item in value) if type(value) in (list, tuple) else value
    return value.copy() if isinstance(value, np.ndarray) else value
