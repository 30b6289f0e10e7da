"""Looking on while a task runs: values of variables for extremes and means, and the history that measurements need."""

from __future__ import annotations

import math
from array import array
from collections.abc import Mapping
from typing import Any

import numpy as np

from granular_env.components.component import Component
from granular_env.components.errors import LogError, ParameterError
from granular_env.components.support.memory_limits import refuse_beyond
from granular_env.domains import domain_of

from .measures import EXTREMES, FinishedRun, Measure, Measurement, Reading


class RunObserver:
    """An observer that gathers what the measures of a plan need; it never changes the step.

    Args:
        measures: by the name of their column.
        every: time between two looks [s]; None: each internal step.
        duration: of the run [s], so that a history that does not fit is refused at once.
    """

    next_tick: int

    def __init__(self, measures: Mapping[str, Measure], every: float | None, duration: float) -> None:
        self._measures, self._every, self._duration = measures, every, duration
        readings = {name: one for name, one in measures.items() if isinstance(one, Reading)}
        self._looks = {name: array("d") for name in readings}
        self._extremes = {name: one for name, one in readings.items() if one.kind in EXTREMES}
        self._starts = {name: one for name, one in readings.items() if one.kind == "start"}
        self._times, self._watch = array("d"), None
        self.next_tick = 0

    def on_reset(self, component: Component) -> None:
        """Check the measures against the component, and look at its start."""
        for name, measure in self._measures.items():
            try:
                measure.check(component)
            except ParameterError as error:
                raise error.within("measure", name) from None
        self._interval = 1 if self._every is None else component.ticks_in(self._every, "every")
        if any(isinstance(measure, Measurement) for measure in self._measures.values()):
            self._watch = self._begin_history(component)
        for values in (*self._looks.values(), self._times):
            del values[:]
        for name, reading in self._starts.items():
            self._looks[name].append(reading.look(component))
        self.on_sample(component)

    def _begin_history(self, component: Component) -> Any:
        every = self._interval * component.step_size
        make = domain_of(component.name).load("watch")
        if make is None:
            hint = "take its variables, such as 'max NAME[0]'"
            raise ParameterError(f"component {component.name!r} has no measurements", hint=hint, at="measure")
        watch = make(every)
        watch.on_reset(component)
        numbers = sum(np.size(component.get(name)) for name in watch.variables)
        refuse_beyond(int(8 * numbers * self._duration / every), f"a history with a frame every {every:g} s")
        return watch

    def on_sample(self, component: Component) -> None:
        """Look at every variable whose extreme or mean is wanted."""
        self._look(component)
        if self._watch is not None and component.tick:
            self._watch.on_sample(component)
        self.next_tick = component.tick + self._interval if self._extremes or self._watch else 2**62

    def _look(self, component: Component) -> None:
        self._times.append(component.time)
        for name, reading in self._extremes.items():
            self._looks[name].append(reading.look(component))

    def on_step(self, component: Component, ticks: int, inputs: Mapping[str, Any]) -> None:
        """Do nothing: frames alone are kept."""

    def on_failure(self, component: Component, error: BaseException) -> None:
        """Do nothing: a run that failed has no measures."""

    def values(self, component: Component, report: Mapping[str, float]) -> tuple[list[float], list[str]]:
        """Return the measures of a finished run, in their order; NaN, and a sentence, where one has no value."""
        if self._times[-1] < component.time:
            self._look(component)
        history = None if self._watch is None else self._watch.history
        run = FinishedRun(component, report, np.array(self._times), history)
        values, notes = [], []
        for name, measure in self._measures.items():
            try:
                value, note = measure.value(run, np.array(self._looks.get(name, ())))
            except (ParameterError, LogError) as error:
                value, note = math.nan, str(error)
            values.append(value)
            notes += [f"{name}: {note}"] if note else []
        return values, notes
