"""Stop rules: when a run ends before its duration.

    [[stop]]
    variable = "velocity"
    index = 99          # one element, or reduce = "max", "min" or "any" (the default for arrays)
    above = 1.0         # or below
    every = 1e-6        # s

A rule is looked at whenever `every` seconds have passed, never at time 0, and it looks only: it never changes the steps, so
a run with a rule has the bits of one without, up to the moment where it ends.
"""

from __future__ import annotations

from typing import Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from granular_env.components.component import Component
from granular_env.components.errors import ParameterError, nearest
from granular_env.documents import Table


class StopRule(Table):
    """One `[[stop]]` table."""

    variable: str = Field(description="the name of the output that is watched")
    index: int | None = Field(None, description="one element of it; negative counts from the end")
    reduce: Literal["max", "min", "any"] | None = Field(None, description="how an array becomes one decision")
    above: float | None = Field(None, description="stop when the value is greater, in the variable's unit")
    below: float | None = Field(None, description="stop when the value is smaller, in the variable's unit")
    every: float | None = Field(None, gt=0.0, description="time between two looks [s]; default: record.every, or each step")

    @model_validator(mode="after")
    def _one_of_each(self) -> Self:
        if (self.above is None) == (self.below is None):
            raise ValueError("give exactly one of above and below")
        if self.index is not None and self.reduce is not None:
            raise ValueError("give index or reduce, not both")
        return self

    @property
    def sentence(self) -> str:
        """The rule in words, such as ``velocity[99] above 1``."""
        place = f"[{self.index}]" if self.index is not None else f" ({self.reduce})" if self.reduce else ""
        limit = f"above {self.above:g}" if self.above is not None else f"below {self.below:g}"
        return f"{self.variable}{place} {limit}"

    def is_met(self, value: Any) -> bool:
        """Return whether a value of the variable, a number or an array, ends the run."""
        array = np.asarray(value, dtype=np.float64).ravel()
        if self.index is not None:
            chosen = array[self.index]
        elif self.reduce == "max" or (self.reduce != "min" and self.above is not None):
            chosen = array.max()
        else:
            chosen = array.min()
        return bool(chosen > self.above) if self.above is not None else bool(chosen < self.below)


class StopWatch:
    """The stop rules of a run on the ticks of its component."""

    def __init__(self, rules: list[StopRule], component: Component, default_every: float | None) -> None:
        """Check the rules against the component's variables; `ParameterError` names what does not fit."""
        self._rules = []
        for place, rule in enumerate(rules):
            _check(rule, component, f"stop.{place}")
            every = rule.every if rule.every is not None else default_every
            self._rules.append((rule, 1 if every is None else component.ticks_in(every, f"stop.{place}.every")))

    def next_tick(self, tick: int) -> int | None:
        """Return the next tick after `tick` at which a rule has to be evaluated; None without rules."""
        return min((every * (tick // every + 1) for _, every in self._rules), default=None)

    def stop_reason(self, component: Component) -> str | None:
        """Return the sentence of the first rule that is due and met at this tick."""
        for rule, every in self._rules:
            if component.tick % every == 0 and rule.is_met(component.get(rule.variable)):
                return rule.sentence
        return None


def _check(rule: StopRule, component: Component, place: str) -> None:
    variable = component.variables.get(rule.variable)
    watched = [v.name for v in component.variables.values() if v.causality != "parameter"]
    if variable is None or variable.causality == "parameter":
        raise ParameterError(f"{rule.variable!r} is unknown; {nearest(rule.variable, watched)}", at=f"{place}.variable")
    size = int(np.prod(variable.shape))
    if rule.index is not None and (not variable.shape or not -size <= rule.index < size):
        expected = f"{-size} to {size - 1}" if variable.shape else "none: it is a single number"
        raise ParameterError(f"got {rule.index} for {rule.variable!r}, expected {expected}", at=f"{place}.index")
    if size == 0:
        raise ParameterError(f"{rule.variable!r} has no elements to watch", at=f"{place}.variable")
