"""Helpers for factories, the functions that build a component and a task and return the environment of both."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any, ParamSpec, TypedDict, TypeVar, get_args, get_type_hints

from ..components.catalogue import built_in_names
from ..components.errors import ParameterError, one_line, spelling_hint
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
    """Decorate a factory: unknown arguments raise an error that suggests the nearest name."""

    @wraps(make)
    def make_checked(*arguments: Given.args, **keywords: Given.kwargs) -> Env:
        refuse_unknown_arguments(make, keywords)
        refuse_repeated_parameters(keywords)
        return make(*arguments, **keywords)

    # Gymnasium reads the render modes from the entry point, which is usually a class.
    make_checked.metadata = ComponentEnv.metadata  # type: ignore[attr-defined]
    return make_checked


def refuse_unknown_arguments(make: Callable[..., Any], arguments: Mapping[str, Any]) -> None:
    """Raise `ParameterError` for an argument that a function with declared options does not accept."""
    known: list[str] = []
    for name, parameter in inspect.signature(make).parameters.items():
        if parameter.kind is not parameter.VAR_KEYWORD:
            known.append(name)
        elif parameter.annotation is parameter.empty:
            return
        else:
            known += get_type_hints(options_type(make))
    for name in arguments:
        if name not in known:
            raise ParameterError("unknown", source=make.__name__, hint=spelling_hint(name, known), at=name)


def options_type(make: Callable[..., Any]) -> Any:
    """Return the `TypedDict` of the options that a factory accepts as ``**options: Unpack[...]``."""
    return get_args(get_type_hints(make)["options"])[0]


def refuse_repeated_parameters(arguments: Mapping[str, Any]) -> None:
    """Raise `ParameterError` if a component's parameters, such as `chain`, are no mapping or repeat another argument."""
    for component in (name for name in built_in_names() if arguments.get(name) is not None):
        if not isinstance(arguments[component], Mapping):
            raise ParameterError(f"got {one_line(arguments[component])}", expected="a mapping of its parameters", at=component)
        for name in arguments[component]:
            if name in arguments:
                raise ParameterError(f"given twice: here and as the argument {name}", at=(component, name))


def refuse_early_deadline(deadline: int | None, least: int, duration: float, reason: str, at: str = "deadline") -> None:
    """Refuse a deadline below `least` control steps (of `duration` [s]), the agent's earliest effect; None is no deadline.

    Raises:
        ParameterError: the deadline is less than `least`.
    """
    if deadline is not None and deadline < least:
        raise ParameterError(
            f"got {deadline} control steps of {duration:g} s", expected=f"{least} or more, because {reason}", at=at
        )
