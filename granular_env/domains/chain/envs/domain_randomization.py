"""Domain randomisation: parameters of the chain and impacts that are drawn anew for each episode.

`randomise` is a mapping: "velocity" -> (low, high), the start velocity of the first grain [m/s], or {grain: (low, high)}; any
number-valued parameter of the chain -> (low, high), drawn evenly; "radius" -> {"low": ..., "high": ...}, drawn for each grain.

Everything is drawn from the environment's own random numbers (`np_random`) at each reset, so a seed decides the chain, in
single environments and in batches of any kind alike.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import Generator

from granular_env.components.chain import Chain
from granular_env.components.chain.parameters import ChainParameters
from granular_env.components.errors import ParameterError, nearest, one_line
from granular_env.components.support.validation import finite_number
from granular_env.envs.state import Drawn

# The environment decides these itself.
_FIXED = {"grains", "step_size", "velocity_scale", "tolerance", "overlap_limit"}
_IMPACT = "velocity"


@dataclass(frozen=True)
class Randomization:
    """The draws of an environment at a reset.

    Attributes:
        parameters: name -> (low, high), of the chain.
        each_grain: whether the radius is drawn for each grain.
        impacts: (grain, low, high) of each start velocity [m/s].
    """

    parameters: Mapping[str, tuple[float, float]]
    each_grain: bool
    impacts: tuple[tuple[int, float, float], ...]

    @staticmethod
    def of(randomise: Mapping[str, Any] | None, grains: int) -> Randomization:
        """Check what an environment's `randomise` says.

        Raises:
            ParameterError: a name, a range or a grain is not valid.
        """
        given = _validate(randomise)
        radius, ranges = given.get("radius"), {}
        for name, bounds in given.items():
            if name == _IMPACT:
                continue
            if isinstance(bounds, Mapping) and name == "radius":
                if set(bounds) != {"low", "high"}:
                    raise ParameterError(
                        f"got {one_line(bounds)}", expected="(low, high), or the keys low, high", at="randomise.radius"
                    )
                bounds = (bounds["low"], bounds["high"])
            ranges[name] = _range(f"randomise.{name}", bounds)
        # In the order of the names: a draw must not depend on how the mapping was written.
        ranges = dict(sorted(ranges.items()))
        return Randomization(ranges, isinstance(radius, Mapping), _impacts(given.get(_IMPACT, {}), grains))

    def draw(self, random: Generator) -> Drawn:
        """Draw the parameters of an episode's chain."""
        return {name: self._value(name, float(random.random()), random) for name in self.parameters}

    def at(self, part: float) -> Drawn:
        """Return the parameters at a part of their ranges, 0 to 1."""
        return {name: self._value(name, part, None) for name in self.parameters}

    def _value(self, name: str, part: float, random: Generator | None) -> float | dict[str, float]:
        low, high = self.parameters[name]
        if name == "radius" and self.each_grain:
            return {"low": low, "high": high, "seed": 0 if random is None else int(random.integers(2**53))}
        return low + (high - low) * part

    def add_impacts(self, start: Mapping[str, Any], random: Generator) -> dict[str, Any]:
        """Return a task's start values with the impacts drawn; these count more."""
        if not self.impacts:
            return dict(start)
        drawn = {grain: low + (high - low) * float(random.random()) for grain, low, high in self.impacts}
        given = start.get("velocity", {})
        return {**start, "velocity": {**given, **drawn} if isinstance(given, Mapping) else drawn}


def make_chain(parameters: Mapping[str, Any], chain: Any = None, randomise: Any = None) -> Chain:
    """Return the chain of an environment, with what is drawn in the middle of its range.

    Args:
        parameters: what the environment itself gives.
        chain: further parameters, which count more.
        randomise: which of them are drawn at each reset, see this module.

    Raises:
        ParameterError: a parameter, a name or a range is not valid.
    """
    if not isinstance(chain, Mapping | None):
        raise ParameterError(f"got {one_line(chain)}", expected="further parameters of the chain, name -> value", at="chain")
    given = {**parameters, **(chain or {})}
    ranges = Randomization.of(_without_impacts(randomise), 1)
    return Chain(**{**given, **ranges.at(0.5)})


def redrawn(chain: Chain, drawn: Drawn) -> Chain:
    """Return a chain like this one, at rest, with other values of the parameters that are drawn."""
    parameters = {**chain.parameters.model_dump(), "step_size": chain.step_size, **drawn}
    made = type(chain)(**parameters)
    made.share_cautions(chain.issued_cautions)
    return made


def info_of_draws(chain: Chain, drawn: Drawn) -> dict[str, Any]:
    """Return what ``info`` tells of drawn parameters: "drawn_radius" and so on, numbers or arrays of one for each grain."""
    info: dict[str, Any] = {}
    for name, value in drawn.items():
        info[f"drawn_{name}"] = np.array(chain.geometry.radius) if isinstance(value, Mapping) else float(value)
    return info


def _without_impacts(randomise: Any) -> Any:
    if not isinstance(randomise, Mapping):
        return randomise
    return {name: bounds for name, bounds in randomise.items() if name != _IMPACT}


def _validate(randomise: Any) -> Mapping[str, Any]:
    if randomise is None:
        return {}
    if not isinstance(randomise, Mapping):
        raise ParameterError(f"got {one_line(randomise)}", expected="name -> (low, high)", at="randomise")
    fields = ChainParameters.model_fields
    known = {name for name, field in fields.items() if "float" in str(field.annotation) or "Positive" in str(field.annotation)}
    known = (known - _FIXED) | {_IMPACT}
    for name in randomise:
        if name not in known:
            raise ParameterError(
                f"{one_line(name)} is nothing that can be drawn", hint=nearest(str(name), known), at="randomise"
            )
    return randomise


def _impacts(given: Any, grains: int) -> tuple[tuple[int, float, float], ...]:
    impacts = []
    for grain, bounds in (given if isinstance(given, Mapping) else {0: given}).items():
        if isinstance(grain, bool) or not isinstance(grain, int) or not -grains <= grain < grains:
            raise ParameterError(
                f"got grain {one_line(grain)}",
                expected=f"whole numbers from {-grains} to {grains - 1}",
                at="randomise.velocity",
            )
        impacts.append((grain % grains, *_range("randomise.velocity", bounds)))
    if len({grain for grain, _, _ in impacts}) < len(impacts):
        raise ParameterError(f"got {one_line(given)}", expected="each grain once", at="randomise.velocity")
    return tuple(impacts)


def _range(name: str, bounds: Any) -> tuple[float, float]:
    if not isinstance(bounds, (tuple, list)) or len(bounds) != 2:
        raise ParameterError(f"got {one_line(bounds)}", expected="(low, high)", at=name)
    low, high = finite_number(f"{name}[0]", bounds[0]), finite_number(f"{name}[1]", bounds[1])
    if low > high:
        raise ParameterError(f"got ({low:g}, {high:g})", expected="low <= high", at=name)
    return low, high
