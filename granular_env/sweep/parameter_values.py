"""The values that a plan gives to keys of its experiment: lists and ranges of a grid, and random samples.

    [grid]
    "component.grains" = [20, 40]
    "start.velocity.0" = { from = 0.05, to = 5.0, count = 7, spacing = "log" }

    [samples]
    count = 100
    "component.radius" = { distribution = "uniform", from = 2e-3, to = 4e-3 }

Sample i depends only on the seed, the key and i, not on the number of samples or on other keys. Logarithmically spaced values
are rounded to 12 digits, so that they and the task hashes do not depend on the library that computes logarithms.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Field, PlainValidator, model_validator

from granular_env.components.errors import ParameterError, one_line
from granular_env.components.support.counter_random import uniform
from granular_env.components.support.quantities import Value, to_si
from granular_env.documents import Table


class Range(Table):
    """A range of a grid: evenly (or logarithmically) spaced values of a key, instead of a list."""

    begin: Value = Field(alias="from", description="first value")
    end: Value = Field(alias="to", description="last value")
    count: int = Field(ge=1, description="number of values")
    spacing: Literal["linear", "log"] = Field("linear", description="equal steps (linear) or equal ratios (log)")

    @model_validator(mode="after")
    def _check_ends(self) -> Self:
        if self.spacing == "log" and not (self.begin > 0.0 and self.end > 0.0):
            raise ParameterError(f"log needs values above 0, got from = {self.begin:g} and to = {self.end:g}", at="spacing")
        if self.count == 1 and self.begin != self.end:
            raise ParameterError("a single value cannot equal both from and to", hint="give count = 2 or more", at="count")
        return self

    def values(self) -> list[float | int]:
        """Return all values of the range; they are integers if all are whole numbers."""
        parts = [i / max(self.count - 1, 1) for i in range(self.count)]
        place = interpolate_geometrically if self.spacing == "log" else _interpolate_linearly
        found = [self.begin, *(place(self.begin, self.end, part) for part in parts[1:-1]), self.end][: self.count]
        is_whole = all(float(value).is_integer() for value in found)
        return [int(value) if is_whole else float(value) for value in found]


class Distribution(Table):
    """The distribution from which a key's values are sampled.

    uniform: uniform density. log_uniform: uniform density of the logarithm. integer: equal probability of all whole numbers,
    including the ends. choice: an entry of a list.
    """

    distribution: Literal["uniform", "log_uniform", "integer", "choice"] = Field(
        description="kind of distribution", examples=["uniform"]
    )
    begin: float | None = Field(None, alias="from", description="smallest value", examples=[2e-3])
    end: float | None = Field(None, alias="to", description="largest value", examples=[4e-3])
    values: list[Any] = Field([], description="values to choose from", examples=[["hertz", "viscous"]])

    @model_validator(mode="after")
    def _check_ends(self) -> Self:
        low, high, kind = self.begin, self.end, self.distribution
        if kind == "choice":
            if not self.values or low is not None or high is not None:
                raise ParameterError("choice requires values, without from and to", expected="values = [...]", at="values")
        elif low is None or high is None or not low < high or self.values:
            raise ParameterError(f"got from = {low} and to = {high}", expected="from < to; `values` belong to choice")
        elif kind == "log_uniform" and low <= 0.0:
            raise ParameterError(f"log_uniform needs values above 0, got {low:g}", at="from")
        elif kind == "integer" and not (low.is_integer() and high.is_integer() and abs(high) < 2.0**52):
            raise ParameterError(f"integer needs whole numbers, got from = {low:g} and to = {high:g}")
        return self

    def quantile(self, number: float) -> Any:
        """Return the value for which the cumulative distribution is `number`, in [0, 1)."""
        if self.distribution == "choice":
            return self.values[int(number * len(self.values))]
        low, high = self.begin or 0.0, self.end or 0.0
        if self.distribution == "integer":
            return int(low) + int(number * (high - low + 1.0))
        return (
            interpolate_geometrically(low, high, number) if self.distribution == "log_uniform" else low + number * (high - low)
        )


class Samples(Table):
    """The [samples] table: the number of samples, the seed, and keys of the experiment, each with its distribution."""

    model_config = {"extra": "allow"}
    __pydantic_extra__: dict[str, Distribution]  # pyright: ignore[reportIncompatibleVariableOverride]

    count: int = Field(ge=1, description="number of samples", examples=[100])
    seed: int = Field(0, ge=0, lt=2**63, description="seed of the samples")

    @property
    def distributions(self) -> dict[str, Distribution]:
        """Key of the experiment -> distribution of its values."""
        return dict(self.__pydantic_extra__)

    @model_validator(mode="after")
    def _check_keys(self) -> Self:
        if not self.distributions:
            example = '"component.radius" = { distribution = "uniform", from = ..., to = ... }'
            raise ParameterError("no key is sampled", hint=f"add a key, such as {example}")
        return self


def _parse_axis(value: Any) -> list[Any] | Range:
    if isinstance(value, list) and value:
        return to_si(value, None)
    if isinstance(value, Mapping):
        return Range.model_validate(value)
    expected = "a list of values, or a table; a single value for all tasks belongs in [set]"
    raise ParameterError(f"got {one_line(value, 60)}", expected=expected)


Axis = Annotated[list[Any] | Range, PlainValidator(_parse_axis)]


def _interpolate_linearly(begin: float, end: float, fraction: float) -> float:
    """Return begin + fraction (end - begin), rounded to 12 digits."""
    return float(f"{begin + fraction * (end - begin):.12g}")


def interpolate_geometrically(begin: float, end: float, fraction: float) -> float:
    """Return begin (end/begin)^fraction, rounded to 12 digits."""
    low, high = math.log(begin), math.log(end)
    return float(f"{math.exp(low + fraction * (high - low)):.12g}")


def sample_values(distribution: Distribution, key: str, seed: int, count: int) -> list[Any]:
    """Return `count` values of a key, sampled from its distribution."""
    stream = int.from_bytes(hashlib.sha256(key.encode()).digest()[:8], "little")
    return [distribution.quantile(number) for number in uniform(seed, stream, count).tolist()]


def flatten_table(content: Any) -> Any:
    """Return a table with dotted keys ("a.b"); `content` may also have the key b in a nested table a."""
    if not isinstance(content, Mapping):
        return content
    found: dict[str, Any] = {}
    for key, value in content.items():
        if isinstance(value, Mapping) and value and not value.keys() & _KEYS_OF_AXES:
            found |= {f"{key}.{rest}": inner for rest, inner in flatten_table(value).items()}
        else:
            found[str(key)] = value
    return found


_KEYS_OF_AXES = {"from", "to", "count", "distribution", "values"}
