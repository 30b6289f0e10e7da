"""Domain randomisation: component parameters and start values sampled for each episode.

`randomise` maps names to what is sampled. For a scalar parameter, this is (low, high), the range of a uniform sample. For a
parameter that accepts a distribution over the particles, it is a distribution without seed, such as {"low": 2e-3, "high":
3e-3}; the seed is sampled. For a state variable, it is (low, high) of its first element's start value, or {index: (low, high)}.

All samples come from the environment's random generator (`np_random`) at each reset. A seed therefore determines the component,
in single environments and in all kinds of batches.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.random import Generator

from ..components.component import Component
from ..components.errors import ParameterError, one_line, spelling_hint
from ..components.support.validation import finite_number
from ..components.variables import check_index, parse_index
from .state import Drawn


class Randomization:
    """The random samples of an environment at a reset.

    Args:
        randomise: see the module; None to sample nothing.
        component: component with the sampled parameters and start values.

    Attributes:
        parameters: parameter name -> (low, high), or a distribution without a seed.
        starts: (state variable, index, (low, high)) of each start value.

    Raises:
        ParameterError: a name, a range or an index is invalid.
    """

    def __init__(self, randomise: Mapping[str, Any] | None, component: Component) -> None:
        if not isinstance(randomise or {}, Mapping):
            raise ParameterError(f"got {one_line(randomise)}", expected="a mapping of names to ranges", at="randomise")
        fields, shapes = type(component).Parameters.model_fields, _state_shapes(component)
        self.parameters: dict[str, Any] = {}
        self.starts: list[tuple[str, tuple[int, ...], tuple[float, float]]] = []
        self._whole = {name for name in fields if fields[name].annotation is int}
        numbers = [name for name in fields if name in self._whole or "float" in str(fields[name].annotation)]
        # Sample in the order of the names, so that the samples do not depend on the order of the mapping.
        for name, bounds in sorted((randomise or {}).items()):
            if name in shapes:
                shape = shapes[name]
                ranges = bounds if isinstance(bounds, Mapping) else {(0,) * len(shape) or None: bounds}
                self.starts += [
                    (name, _parse_index(name, place, shape), _parse_range(name, pair)) for place, pair in ranges.items()
                ]
            elif name in numbers:
                self.parameters[name] = dict(bounds) if isinstance(bounds, Mapping) else _parse_range(name, bounds)
            else:
                hint = spelling_hint(name, [*numbers, *shapes])
                raise ParameterError(f"{one_line(name)} cannot be sampled", hint=hint, at="randomise")

    def sample_parameters(self, random: Generator) -> Drawn:
        """Return sampled values of the parameters for an episode; a distribution gets a sampled seed."""
        return {name: self._sample_value(name, bounds, random) for name, bounds in self.parameters.items()}

    def extreme_parameters(self) -> list[Drawn]:
        """Return two sets of parameters, at the lower and at the upper ends of their ranges; none if none is sampled."""

        def bound_value(end: int, name: str, bounds: Any) -> Any:
            if isinstance(bounds, dict):
                return {**bounds, "seed": end}
            return int(bounds[end]) if name in self._whole else bounds[end]

        ends = (0, 1) if self.parameters else ()
        return [{name: bound_value(end, name, bounds) for name, bounds in self.parameters.items()} for end in ends]

    def _sample_value(self, name: str, bounds: Any, random: Generator) -> Any:
        if isinstance(bounds, dict):
            return {**bounds, "seed": int(random.integers(2**53))}
        low, high = bounds
        return int(random.integers(low, high + 1)) if name in self._whole else low + (high - low) * float(random.random())

    def add_start_values(self, start: Mapping[str, Any], random: Generator) -> dict[str, Any]:
        """Return the start values of a task, in which the sampled ones replace or complete those of the task."""
        found = dict(start)
        for name, index, (low, high) in self.starts:
            value = low + (high - low) * float(random.random())
            given = found.get(name, {})
            place = index[0] if len(index) == 1 else index
            found[name] = {**(given if isinstance(given, Mapping) else {}), place: value} if index else value
        return found


def rebuild_component(component: Component, sampled: Drawn) -> Component:
    """Return a new component in its start state, with new values of the sampled parameters."""
    parameters: dict[str, Any] = component.parameters.model_dump()  # type: ignore[attr-defined]
    if "step_size" in parameters:
        parameters["step_size"] = component.step_size
    made = type(component)(**{**parameters, **sampled})
    if _state_shapes(made) != _state_shapes(component):
        raise ParameterError(f"sampling {', '.join(sampled)} changes the size of the component", at="randomise")
    return made


def sampled_parameter_info(sampled: Drawn) -> dict[str, float]:
    """Return the entries of ``info`` for sampled parameters ("drawn_radius" and so on; for a distribution its seed)."""
    seeds = {f"drawn_{name}_seed": float(one["seed"]) for name, one in sampled.items() if isinstance(one, Mapping)}
    return seeds | {f"drawn_{name}": float(one) for name, one in sampled.items() if not isinstance(one, Mapping)}


def _state_shapes(component: Component) -> dict[str, tuple[int, ...]]:
    return {variable.name: variable.shape for variable in component.variables.values() if variable.state}


def _parse_index(name: str, value: Any, shape: tuple[int, ...]) -> tuple[int, ...]:
    """Return an index as a tuple of numbers >= 0, () for a scalar variable; `ParameterError` if it does not fit the shape."""
    index = () if value is None else parse_index(value)
    check_index(("randomise", name), index, shape)
    return tuple(number % size for number, size in zip(index, shape, strict=True))


def _parse_range(name: str, bounds: Any) -> tuple[float, float]:
    at = f"randomise.{name}"
    if not isinstance(bounds, (tuple, list)) or len(bounds) != 2:
        raise ParameterError(f"got {one_line(bounds)}", expected="(low, high)", at=at)
    low, high = finite_number(f"{at}[0]", bounds[0]), finite_number(f"{at}[1]", bounds[1])
    if low > high:
        raise ParameterError(f"got ({low:g}, {high:g})", expected="low <= high", at=at)
    return low, high
