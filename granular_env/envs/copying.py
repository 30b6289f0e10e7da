"""Copies of environments: how each was made, and where it is; for `copy.deepcopy`, pickle, and libraries that use these."""

from __future__ import annotations

import copy
import inspect
from abc import ABCMeta
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any, Self, get_args, get_origin, get_type_hints

import numpy as np

from ..components.errors import ParameterError, nearest


class _Announcing(ABCMeta):
    """Marks an instance once its whole `__init__`, that of subclasses too, has run."""

    def __call__(cls, *positional: Any, **named: Any) -> Any:
        made = super().__call__(*positional, **named)
        made._complete = True
        return made


class Recreatable(metaclass=_Announcing):
    """Base of what can be made again from the arguments of its constructor.

    Subclasses give `__reduce__`, which adds the present state to these arguments.
    """

    _made_with: tuple[tuple[Any, ...], dict[str, Any]]
    _complete: bool = False

    def __new__(cls, *arguments: Any, **keywords: Any) -> Self:
        """Keep the arguments; `ParameterError` with the nearest name for a keyword that there is not."""
        known = known_arguments(cls)
        if known is not None and (unknown := [name for name in keywords if name not in known]):
            raise ParameterError(f"{unknown[0]!r}: unknown argument of {cls.__name__}; {nearest(unknown[0], known)}")
        made = super().__new__(cls)
        made._made_with = _kept(arguments), _kept(keywords)
        return made

    def is_read_once(self, name: str) -> bool:
        """Return whether an attribute is an argument of the constructor that nothing reads afterwards."""
        return self._complete and name not in vars(self) and name in (known_arguments(type(self)) or ())

    def __copy__(self) -> Self:
        """Return an independent copy: one that shares the state would step the original as well."""
        return copy.deepcopy(self)


@cache
def known_arguments(kind: type) -> tuple[str, ...] | None:
    """Return the names that a constructor takes, those of its `Unpack`-ed options included; None where it takes any."""
    names: list[str] = []
    for parameter in list(inspect.signature(kind.__init__).parameters.values())[1:]:
        if parameter.kind is inspect.Parameter.VAR_KEYWORD:
            options = _options(kind, parameter.name)
            if options is None:
                return None
            names += options
        elif parameter.kind is not inspect.Parameter.VAR_POSITIONAL:
            names.append(parameter.name)
    return tuple(names)


def _options(kind: type, name: str) -> Iterable[str] | None:
    """Keys of the TypedDict in `**name: Unpack[...]`; None where there is none."""
    try:
        hint = get_type_hints(kind.__init__)[name]
    except (NameError, KeyError, TypeError):
        return None
    inside = get_args(hint)
    return get_type_hints(inside[0]) if get_origin(hint) is not None and len(inside) == 1 else None


def _kept(value: Any) -> Any:
    """Return arguments as they are now, whatever the caller does to its lists and mappings later."""
    if isinstance(value, Mapping):
        return {name: _kept(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(_kept(item) for item in value) if type(value) in (list, tuple) else value
    return value.copy() if isinstance(value, np.ndarray) else value
