"""Stop rules, which end a run before its duration.

    [[stop]]
    variable = "velocity[99]"   # one element (velocity[3,1] for several axes); or velocity, with
    reduce = "max"              # "max", "min" or "any" (the default) of all elements
    above = 1.0                 # or below
    every = 1e-6                # s

A rule is evaluated every `every` seconds, but not at time 0. It never changes the steps, so a run with a rule is bitwise
identical to a run without the rule up to its end.
"""

from __future__ import annotations

import math
from typing import Any, Literal, Self

import numpy as np
from pydantic import Field, PrivateAttr, model_validator

from granular_env.components.component import Component
from granular_env.components.errors import ParameterError
from granular_env.components.support.quantities import Seconds, Value, to_si
from granular_env.components.variables import Element, parse_element
from granular_env.documents import Table


class StopRule(Table):
    """A rule that ends the run; a file may have several."""

    variable: str = Field(description="the watched output, or an element of it", examples=["velocity[99]"])
    reduce: Literal["max", "min", "any"] | None = Field(
        None, description="reduction over the elements of an array; default: any"
    )
    above: Value | None = Field(None, description="upper limit, in the variable's unit", examples=[1.0])
    below: Value | None = Field(None, description="lower limit, in the variable's unit", examples=[0.0])
    every: Seconds | None = Field(
        None, gt=0.0, description="time between two evaluations [s]; default: record.every, or each tick", examples=[1e-6]
    )
    _element: Element = PrivateAttr()

    @model_validator(mode="after")
    def _parse_rule(self) -> Self:
        if (self.above is None) == (self.below is None):
            raise ValueError("give exactly one of above and below")
        try:
            self._element = parse_element(self.variable)
        except ParameterError as error:
            raise error.with_outer_location("variable") from None
        if self._element.index and self.reduce is not None:
            raise ValueError(f"{self.variable} is one element, so there is nothing to reduce; omit reduce")
        return self

    @property
    def element(self) -> Element:
        """The variable and, if given, the index of an element."""
        return self._element

    @property
    def sentence(self) -> str:
        """The rule as text, such as ``velocity[99] above 1``."""
        limit = f"above {self.above:g}" if self.above is not None else f"below {self.below:g}"
        return f"{self.element}{f' ({self.reduce})' if self.reduce else ''} {limit}"

    def is_met(self, value: Any) -> bool:
        """Return whether a value of the variable (a number or an array) ends the run."""
        array = np.asarray(self.element.select_from(value), dtype=np.float64)
        if self.reduce == "max" or (self.reduce != "min" and self.above is not None):
            chosen = array.max()
        else:
            chosen = array.min()
        return bool(chosen > self.above) if self.above is not None else bool(chosen < self.below)


class StopWatch:
    """The stop rules of a run, with their evaluation intervals converted to ticks of the component."""

    def __init__(self, rules: list[StopRule], component: Component, default_every: float | None) -> None:
        """Check that the component has the variables and elements of the rules; otherwise raise `ParameterError`."""
        self._rules = []
        for place, rule in enumerate(rules):
            _check_rule(rule, component, place)
            every = rule.every if rule.every is not None else default_every
            self._rules.append((rule, 1 if every is None else component.duration_ticks(every, ("stop", place, "every"))))

    @property
    def sentences(self) -> list[str]:
        """The rules as texts."""
        return [rule.sentence for rule, _ in self._rules]

    def next_tick(self, tick: int) -> int | None:
        """Return the next tick after `tick` at which a rule must be evaluated; None without rules."""
        return min((every * (tick // every + 1) for _, every in self._rules), default=None)

    def stop_reason(self, component: Component) -> str | None:
        """Return the text of the first rule that is to be evaluated at the present tick and is met; None if there is none."""
        for rule, every in self._rules:
            if component.tick % every == 0 and rule.is_met(component.peek(rule.element.name)):
                return rule.sentence
        return None


def _check_rule(rule: StopRule, component: Component, place: int) -> None:
    try:
        expected = f"an output of component {component.name!r}"
        variable = rule.element.find_variable(component.variables, expected, "output", "input")
    except ParameterError as error:
        raise error.with_outer_location("stop", place, "variable") from None
    if math.prod(variable.shape) == 0:
        raise ParameterError(f"{rule.variable!r} has no elements to watch", at=("stop", place, "variable"))
    to_si({"above": rule.above, "below": rule.below}, variable.unit, ("stop", place))
