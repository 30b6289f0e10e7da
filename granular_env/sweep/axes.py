"""The values of a plan's keys: lists and ranges of a grid, and drawn samples.

    [grid]
    "component.grains" = [20, 40]
    "start.velocity.0" = { from = 0.05, to = 5.0, count = 7, spacing = "log" }

    [samples]
    count = 100
    "component.radius" = { distribution = "uniform", from = 2e-3, to = 4e-3 }

What sample i is, depends on the seed, the key and i alone: neither on how many there are nor on the other keys. Powers are
taken in decimal arithmetic, so that a plan has the same values, and its tasks the same hashes, on every machine.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from decimal import Context, Decimal
from fractions import Fraction
from typing import Any, Literal, Self

from pydantic import Field, model_validator

from granular_env.components.errors import nearest
from granular_env.components.support.counter_random import uniform
from granular_env.experiments.faults import Faults, Table, shortened

_DECIMAL = Context(prec=40)


class Range(Table):
    """Evenly spaced values of a key of the grid."""

    begin: float = Field(alias="from", description="the first value")
    end: float = Field(alias="to", description="the last value")
    count: int = Field(ge=1, description="how many values")
    spacing: Literal["linear", "log"] = Field("linear", description="even steps, or even ratios")

    @model_validator(mode="after")
    def _ends(self) -> Self:
        if self.spacing == "log" and not (self.begin > 0.0 and self.end > 0.0):
            raise ValueError(f"spacing: log needs values above 0, got from = {self.begin:g} and to = {self.end:g}")
        if self.count == 1 and self.begin != self.end:
            raise ValueError("count: one value cannot be both from and to; give count = 2 or more")
        return self

    def values(self) -> list[float | int]:
        """All of them; whole numbers where the ends and the step are."""
        steps = max(self.count - 1, 1)
        found: list[float | int] = [self._value(i, steps) for i in range(1, self.count - 1)]
        found = [self.begin, *found, self.end][: self.count]
        whole = self.spacing == "linear" and all(float(value).is_integer() for value in found)
        return [int(value) for value in found] if whole else [float(value) for value in found]

    def _value(self, place: int, steps: int) -> float:
        if self.spacing == "log":
            return between_by_ratio(self.begin, self.end, place / steps)
        # Correctly rounded: whole numbers come out whole.
        first = Fraction(self.begin)
        return float(first + (Fraction(self.end) - first) * place / steps)


class Distribution(Table):
    """Where the samples of a key are drawn from."""

    distribution: Literal["uniform", "log_uniform", "integer", "choice"] = Field(description="which one")
    begin: float | None = Field(None, alias="from", description="the least value; of uniform, log_uniform, integer")
    end: float | None = Field(None, alias="to", description="the greatest value; of uniform, log_uniform, integer")
    values: list[Any] | None = Field(None, min_length=1, description="those to choose from; of choice")

    @model_validator(mode="after")
    def _fitting(self) -> Self:
        kind, ends = self.distribution, (self.begin, self.end)
        if kind == "choice":
            if self.values is None or ends != (None, None):
                raise ValueError("choice takes values = [...] and nothing else")
            return self
        if self.begin is None or self.end is None or self.values is not None:
            raise ValueError(f"{kind} takes from and to, and nothing else")
        if not self.begin < self.end:
            raise ValueError(f"from is {self.begin:g} and to is {self.end:g}, expected from < to")
        if kind == "log_uniform" and self.begin <= 0.0:
            raise ValueError(f"from: log_uniform needs values above 0, got {self.begin:g}")
        if kind == "integer" and not (self.begin.is_integer() and self.end.is_integer() and abs(self.end) < 2.0**52):
            raise ValueError(f"from, to: integer needs whole numbers, got {self.begin:g} and {self.end:g}")
        return self

    def draw(self, number: float) -> Any:
        """The value that belongs to a number in [0, 1)."""
        if self.distribution == "choice":
            values = self.values or []
            return values[int(number * len(values))]
        assert self.begin is not None and self.end is not None
        if self.distribution == "integer":
            return int(self.begin) + int(number * (self.end - self.begin + 1.0))
        if self.distribution == "log_uniform":
            return between_by_ratio(self.begin, self.end, number)
        return self.begin + number * (self.end - self.begin)


def between_by_ratio(begin: float, end: float, part: float) -> float:
    """Begin (end/begin)^part, correctly rounded but for halves at the 40th digit."""
    first = Decimal(begin)
    logarithm = _DECIMAL.ln(_DECIMAL.divide(Decimal(end), first))
    return float(_DECIMAL.multiply(first, _DECIMAL.exp(_DECIMAL.multiply(logarithm, Decimal(part)))))


def draws(distribution: Distribution, key: str, seed: int, count: int) -> list[Any]:
    """The samples of one key."""
    stream = int.from_bytes(hashlib.sha256(key.encode()).digest()[:8], "little")
    return [distribution.draw(number) for number in uniform(seed, stream, count).tolist()]


def parse_grid(content: Any, faults: Faults) -> dict[str, list[Any] | Range]:
    """Key -> its values, or a range of them."""
    found: dict[str, list[Any] | Range] = {}
    for key, value in _flat(content, "grid", faults):
        if isinstance(value, list):
            if not value:
                faults.add(f"grid.{key}", "got no values, expected at least one")
            found[key] = value
        elif (table := faults.table(Range, value, f"grid.{key}")) is not None:
            found[key] = table
    return found


def parse_distributions(content: Mapping[str, Any], faults: Faults) -> dict[str, Distribution]:
    """Key -> its distribution, from the [samples] table without its settings."""
    parsed = ((key, faults.table(Distribution, value, f"samples.{key}")) for key, value in _flat(content, "samples", faults))
    return {key: table for key, table in parsed if table is not None}


def _flat(content: Any, place: str, faults: Faults) -> list[tuple[str, Any]]:
    """(dotted key, what stands there): whether keys are written as "a.b" = ..., a.b = ... or [grid.a] b = ..."""
    if not isinstance(content, Mapping):
        faults.add(place, f"got {shortened(content)}, expected a table of keys and values")
        return []
    found = []
    for key, value in content.items():
        if isinstance(value, Mapping) and value and not value.keys() & {"from", "to", "count", "distribution", "values"}:
            found += [(f"{key}.{rest}", inner) for rest, inner in _flat(value, f"{place}.{key}", faults)]
        elif isinstance(value, list | Mapping):
            found.append((str(key), value))
        else:
            known = nearest(str(key), ("count", "seed")) if place == "samples" else "one value for all belongs into [set]"
            faults.add(f"{place}.{key}", f"got {shortened(value)}, expected a list of values, or a table; {known}")
    return found
