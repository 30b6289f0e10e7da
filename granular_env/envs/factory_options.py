"""Arguments that factories of environments share: options, the component's further parameters, and the deadline."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypedDict

from ..components.errors import ParameterError, one_line


class Options(TypedDict, total=False):
    """Options of an environment beside the arguments of its factory; see `ComponentEnv`."""

    hold: int
    clock: int
    step_error_reward: float
    render_mode: str | None


def further_parameters(name: str, given: Any) -> dict[str, Any]:
    """Return the parameters of a component that a factory takes as one argument; none where it is None.

    Raises:
        ParameterError: it is no mapping, name -> value.
    """
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        expected = "further parameters of the component, name -> value"
        raise ParameterError(f"got {one_line(given)}", expected=expected, at=name)
    return {str(key): value for key, value in given.items()}


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
