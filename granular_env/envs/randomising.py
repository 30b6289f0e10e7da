"""Domain randomisation: parameters drawn for each environment, impacts drawn for each episode.

`randomise` is a mapping: "velocity" -> (low, high), the start velocity of the first grain [m/s], or {grain: (low, high)}, drawn
anew for each episode from the environment's random numbers; any number-valued parameter of the chain -> (low, high), drawn once
for the environment, evenly; "radius" -> {"low": ..., "high": ...}, drawn once for each grain of the environment; "seed" (0).

What is drawn once is a function of "seed", the name and the environment's `index`: whoever makes environment 17 gets its chain.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from numpy.random import Generator

from ..components.chain import Chain
from ..components.chain.parameters import ChainParameters
from ..components.counter_random import uniform
from ..components.errors import ParameterError, nearest, shortened
from ..components.profiles import finite_number

# The environment decides these itself.
_FIXED = {"grains", "step_size", "velocity_scale", "tolerance", "overlap_limit"}
_EACH_EPISODE = "velocity"


def make_chain(
    parameters: Mapping[str, Any],
    chain: Mapping[str, Any] | None = None,
    randomise: Mapping[str, Any] | None = None,
    index: int = 0,
) -> Chain:
    """The chain of an environment.

    Args:
        parameters: what the environment itself gives.
        chain: further parameters, which count more.
        randomise: which of them are drawn, see this module.
        index: the environment's number in a batch.

    Raises:
        ParameterError: a parameter, a name or a range is not valid.
    """
    if not isinstance(chain, Mapping | None):
        raise ParameterError(f"chain: got {shortened(chain)}, expected further parameters of the chain, name -> value")
    return Chain(**{**parameters, **(chain or {}), **_drawn(randomise, index)})


def _drawn(randomise: Any, index: Any) -> dict[str, Any]:
    given = _checked(randomise)
    if isinstance(index, bool) or not isinstance(index, int) or not 0 <= index < 2**32:
        raise ParameterError(f"index: got {shortened(index)}, expected a whole number from 0")
    seed = given.get("seed", 0)
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**63:
        raise ParameterError(f"randomise.seed: got {shortened(seed)}, expected a whole number from 0")
    drawn: dict[str, Any] = {}
    for name, bounds in given.items():
        if name in ("seed", _EACH_EPISODE):
            continue
        key = int.from_bytes(hashlib.blake2b(f"{seed} {name}".encode(), digest_size=8).digest(), "little")
        if name == "radius" and isinstance(bounds, Mapping):
            # Each grain its own, by the chain's own draw.
            drawn[name] = {**bounds, "seed": int(uniform(key, index, 1)[0] * 2.0**53)}
        else:
            low, high = _range(f"randomise.{name}", bounds)
            drawn[name] = low + (high - low) * float(uniform(key, index, 1)[0])
    return drawn


def _checked(randomise: Any) -> Mapping[str, Any]:
    if randomise is None:
        return {}
    if not isinstance(randomise, Mapping):
        raise ParameterError(f"randomise: got {shortened(randomise)}, expected name -> (low, high)")
    fields = ChainParameters.model_fields
    known = {name for name, field in fields.items() if "float" in str(field.annotation) or "Positive" in str(field.annotation)}
    known = (known - _FIXED) | {"seed", _EACH_EPISODE}
    for name in randomise:
        if name not in known:
            raise ParameterError(f"randomise: {shortened(name)} is nothing that can be drawn; {nearest(str(name), known)}")
    return randomise


def _range(name: str, bounds: Any) -> tuple[float, float]:
    if not isinstance(bounds, (tuple, list)) or len(bounds) != 2:
        raise ParameterError(f"{name}: got {shortened(bounds)}, expected (low, high)")
    low, high = finite_number(f"{name}[0]", bounds[0]), finite_number(f"{name}[1]", bounds[1])
    if low > high:
        raise ParameterError(f"{name}: got ({low:g}, {high:g}), expected low <= high")
    return low, high


@dataclass(frozen=True)
class Impacts:
    """Start velocities that are drawn for each episode.

    Attributes:
        ranges: (grain, low, high) of each [m/s].
    """

    ranges: tuple[tuple[int, float, float], ...]

    @staticmethod
    def of(chain: Chain, randomise: Mapping[str, Any] | None) -> Impacts:
        """The "velocity" of a `randomise`; `ParameterError` where it is not valid."""
        given = _checked(randomise).get(_EACH_EPISODE, {})
        grains = chain.parameters.grains
        ranges = []
        for grain, bounds in (given if isinstance(given, Mapping) else {0: given}).items():
            if isinstance(grain, bool) or not isinstance(grain, int) or not -grains <= grain < grains:
                raise ParameterError(
                    f"randomise.velocity: got grain {shortened(grain)}, expected whole numbers from {-grains} to {grains - 1}"
                )
            ranges.append((grain % grains, *_range("randomise.velocity", bounds)))
        if len({grain for grain, _, _ in ranges}) < len(ranges):
            raise ParameterError(f"randomise.velocity: got {shortened(given)}, expected each grain once")
        return Impacts(tuple(ranges))

    def onto(self, start: Mapping[str, Any], random: Generator) -> dict[str, Any]:
        """A task's start values with the impacts drawn; these count more."""
        if not self.ranges:
            return dict(start)
        drawn = {grain: low + (high - low) * float(random.random()) for grain, low, high in self.ranges}
        given = start.get("velocity", {})
        return {**start, "velocity": {**given, **drawn} if isinstance(given, Mapping) else drawn}
