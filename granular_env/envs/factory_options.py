"""Options that all factories of environments take, and the component's further parameters."""

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
