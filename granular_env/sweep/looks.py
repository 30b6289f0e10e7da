"""Looking on while a task runs: extremes and means of variables, and the history that measurements want."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from granular_env.components.contract import Component
from granular_env.components.errors import LogError, ParameterError
from granular_env.components.memory import refuse_beyond
from granular_env.measurement.watching import Watch, watched

from .measures import EXTREMES, Figure, Measure, Measurement, Reading


class Looks:
    """An observer that gathers what the measures of a plan need; it never changes the step.

    Args:
        measures: by the name of their column.
        every: time between two looks [s]; None: each internal step.
        duration: of the run [s], so that a history that does not fit is refused at once.
    """

    next_tick: int

    def __init__(self, measures: Mapping[str, Measure], every: float | None, duration: float) -> None:
        self._measures, self._every, self._duration = measures, every, duration
        self._wants_history = any(isinstance(measure, Measurement) for measure in measures.values())
        self._watch: Watch | None = None
        self._gathered: dict[str, _Gathered] = {}
        self.next_tick = 0

    def began(self, component: Component) -> None:
        """Check the measures against the component, and look at its start."""
        self._check(component)
        self._interval = 1 if self._every is None else component.ticks_in(self._every, "every")
        readings = {name: measure for name, measure in self._measures.items() if isinstance(measure, Reading)}
        self._starts = {name: one.of(component) for name, one in readings.items() if one.kind == "start"}
        self._gathered = {name: _Gathered(one) for name, one in readings.items() if one.kind in EXTREMES}
        if self._wants_history:
            self._begin_history(component)
        self.look(component)

    def _check(self, component: Component) -> None:
        for name, measure in self._measures.items():
            try:
                if isinstance(measure, Reading):
                    measure.check(component)
                elif isinstance(measure, Figure):
                    measure.of(component.report())
            except ParameterError as error:
                raise ParameterError(f"measure.{name}: {error}") from None

    def _begin_history(self, component: Component) -> None:
        every = self._interval * component.step_size
        self._watch = Watch(every)
        self._watch.began(component)
        numbers = sum(np.size(component.get(name)) for name in watched(component))
        refuse_beyond(int(8 * numbers * self._duration / every), f"a history with a frame every {every:g} s")

    def look(self, component: Component) -> None:
        """Take every reading that is taken over the whole run."""
        time = component.time
        for gathered in self._gathered.values():
            gathered.take(component, time)
        if self._watch is not None and component.tick:
            self._watch.look(component)
        self._last = component.tick
        self.next_tick = component.tick + self._interval if self._gathered or self._watch else 2**62

    def stepped(self, component: Component, ticks: int, inputs: Mapping[str, Any]) -> None:
        """Nothing is kept of the steps themselves."""

    def failed(self, component: Component, error: BaseException) -> None:
        """A run that failed has no measures."""

    def values(self, component: Component, report: Mapping[str, float]) -> tuple[list[float], list[str]]:
        """The measures of a run that is over, in their order; NaN, and a sentence, where one has no value."""
        if self._last < component.tick and self._gathered:
            for gathered in self._gathered.values():
                gathered.take(component, component.time)
        history = None if self._watch is None else self._watch.history
        values, notes = [], []
        for name, measure in self._measures.items():
            try:
                values.append(self._value(name, measure, component, report, history))
            except (ParameterError, LogError) as error:
                values.append(math.nan)
                notes.append(f"{name}: {error}")
        return values, notes

    def _value(self, name: str, measure: Measure, component: Component, report: Mapping[str, float], history: Any) -> float:
        if isinstance(measure, Measurement):
            return measure.of(history)
        if isinstance(measure, Figure):
            return measure.of(report)
        if measure.kind == "final":
            return measure.of(component)
        return self._starts[name] if measure.kind == "start" else self._gathered[name].value


class _Gathered:
    """The extreme or the mean of one reading."""

    def __init__(self, reading: Reading) -> None:
        self._reading, self._kind = reading, reading.kind
        self._least = self._kind.endswith("min")
        self._best, self._time, self._sum, self._count = math.nan, math.nan, 0.0, 0

    def take(self, component: Component, time: float) -> None:
        """One more reading."""
        value = self._reading.of(component)
        if self._count == 0 or (value < self._best if self._least else value > self._best):
            self._best, self._time = value, time
        self._sum += value
        self._count += 1

    @property
    def value(self) -> float:
        """What it came to."""
        if self._kind == "mean":
            return self._sum / self._count
        return self._time if self._kind.startswith("time") else self._best
