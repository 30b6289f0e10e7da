"""Factories of environments: functions that build a component and a task, and return the environment of both."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from functools import cache, partial, wraps
from typing import Any, ParamSpec, TypedDict, TypeVar, get_args, get_origin, get_type_hints

from ..components.errors import ParameterError, nearest, one_line
from .environment import ComponentEnv

Given = ParamSpec("Given")
Env = TypeVar("Env", bound=ComponentEnv)


class Options(TypedDict, total=False):
    """Options of every environment, in addition to the arguments of its factory; see `ComponentEnv`."""

    internal_steps: int
    deadline: int | None
    hold: int
    clock: int
    observe: Any
    noise: float
    action_rate: float | None
    control_delay: int
    randomise: Mapping[str, Any] | None
    info: str
    step_error_reward: float
    render_mode: str | None


def environment_factory(make: Callable[Given, Env]) -> Callable[Given, Env]:
    """Decorate a function that returns the environment of one task.

    Unknown arguments are refused with the nearest name, and so are parameters of the component that are given twice: as an
    argument, and in the further ones, a mapping whose name is that of the component. Gymnasium finds the render modes as it
    does on a class.
    """

    @wraps(make)
    def make_checked(*arguments: Given.args, **keywords: Given.kwargs) -> Env:
        known = known_arguments(make) or ()
        if unknown := [name for name in keywords if name not in known]:
            raise ParameterError("unknown", source=make.__name__, hint=nearest(unknown[0], known), at=unknown[0])
        env = make(*arguments, **keywords)
        _refuse_given_twice(env.component.name, {**dict(zip(known, arguments, strict=False)), **keywords})
        return env

    make_checked.metadata = ComponentEnv.metadata  # type: ignore[attr-defined]
    return make_checked


def further_parameters(name: str, given: Any) -> dict[str, Any]:
    """Return the parameters of a component that a factory takes as one argument; none where it is None.

    Raises:
        ParameterError: it is no mapping, name -> value.
    """
    if not isinstance(given, Mapping | None):
        expected = "further parameters of the component, name -> value"
        raise ParameterError(f"got {one_line(given)}", expected=expected, at=name)
    return {str(key): value for key, value in (given or {}).items()}


def refuse_early(deadline: int | None, least: int, duration: float, reason: str, at: str = "deadline") -> None:
    """Refuse a deadline by which nothing that the agent does can have arrived; None is no deadline.

    Args:
        deadline: control steps of an episode.
        least: control steps that the fastest arrival takes.
        duration: of a control step [s].
        reason: what takes so many.
        at: argument at fault.

    Raises:
        ParameterError: the deadline is less than `least`.
    """
    if deadline is not None and deadline < least:
        raise ParameterError(
            f"got {deadline} control steps of {duration:g} s", expected=f"{least} or more, because {reason}", at=at
        )


@cache
def known_arguments(make: Callable[..., Any]) -> tuple[str, ...] | None:
    """Return the names that a class or a function takes, those of its `Unpack`-ed options included; None where it takes any."""
    while isinstance(make, partial):
        make = make.func
    function = make.__init__ if isinstance(make, type) else make
    names: list[str] = []
    for parameter in list(inspect.signature(function).parameters.values())[isinstance(make, type) :]:
        if parameter.kind is inspect.Parameter.VAR_KEYWORD:
            options = _options(function, parameter.name)
            if options is None:
                return None
            names += options
        elif parameter.kind is not inspect.Parameter.VAR_POSITIONAL:
            names.append(parameter.name)
    return tuple(names)


def _options(function: Callable[..., Any], name: str) -> Iterable[str] | None:
    """Return the keys of the TypedDict in `**name: Unpack[...]`; None where there is none."""
    try:
        hint = get_type_hints(function)[name]
    except (NameError, KeyError, TypeError):
        return None
    inside = get_args(hint)
    return get_type_hints(inside[0]) if get_origin(hint) is not None and len(inside) == 1 else None


def _refuse_given_twice(component: str, given: Mapping[str, Any]) -> None:
    """Raise `ParameterError` where a parameter of the component is among its further ones and an argument too."""
    further = given.get(component)
    for name, value in further.items() if isinstance(further, Mapping) else ():
        if given.get(name) is not None:
            came = f"got {one_line(value)}, and {name} = {one_line(given[name])} as an argument of the environment"
            raise ParameterError(came, expected="it once", at=(component, str(name)))
