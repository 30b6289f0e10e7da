"""Looking on while a task runs: extremes and means of variables, and the history that measurements want."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from typing import Any

import numpy as np

from granular_env.components.component import Component
from granular_env.components.errors import LogError, ParameterError
from granular_env.components.support.memory_limits import refuse_beyond
from granular_env.crests_and_crossings import SAMPLES, resolved_top
from granular_env.domains import domain_of

from .measures import EXTREMES, Figure, Happening, Measure, Measurement, Reading


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
        self._wants_history = any(isinstance(measure, Measurement) for measure in measures.values())
        self._watch: Any = None
        self._gathered: dict[str, _Gathered] = {}
        self.next_tick = 0

    def on_reset(self, component: Component) -> None:
        """Check the measures against the component, and look at its start."""
        self._check(component)
        self._interval = 1 if self._every is None else component.ticks_in(self._every, "every")
        readings = {name: measure for name, measure in self._measures.items() if isinstance(measure, Reading)}
        self._starts = {name: one.of(component) for name, one in readings.items() if one.kind == "start"}
        self._gathered = {name: _Gathered(one) for name, one in readings.items() if one.kind in EXTREMES}
        if self._wants_history:
            self._begin_history(component)
        self.on_sample(component)

    def _check(self, component: Component) -> None:
        for name, measure in self._measures.items():
            try:
                if isinstance(measure, Reading):
                    measure.check(component)
                elif isinstance(measure, Figure):
                    measure.of(component.report())
                elif isinstance(measure, Happening):
                    measure.of(component)
            except ParameterError as error:
                raise error.within("measure", name) from None

    def _begin_history(self, component: Component) -> None:
        every = self._interval * component.step_size
        watch = domain_of(component.name).load("watch")
        if watch is None:
            raise ParameterError(
                f"component {component.name!r} has no measurements",
                hint="take its variables, such as 'max NAME[0]'",
                at="measure",
            )
        self._watch = watch(every)
        self._watch.on_reset(component)
        numbers = sum(np.size(component.get(name)) for name in self._watch.variables)
        refuse_beyond(int(8 * numbers * self._duration / every), f"a history with a frame every {every:g} s")

    def on_sample(self, component: Component) -> None:
        """Take every reading that is taken over the whole run."""
        time = component.time
        for gathered in self._gathered.values():
            gathered.take(component, time)
        if self._watch is not None and component.tick:
            self._watch.on_sample(component)
        self._last = component.tick
        self.next_tick = component.tick + self._interval if self._gathered or self._watch else 2**62

    def on_step(self, component: Component, ticks: int, inputs: Mapping[str, Any]) -> None:
        """Do nothing: frames alone are kept."""

    def on_failure(self, component: Component, error: BaseException) -> None:
        """Do nothing: a run that failed has no measures."""

    def values(self, component: Component, report: Mapping[str, float]) -> tuple[list[float], list[str]]:
        """Return the measures of a finished run, in their order; NaN, and a sentence, where one has no value."""
        if self._last < component.tick and self._gathered:
            for gathered in self._gathered.values():
                gathered.take(component, component.time)
        history = None if self._watch is None else self._watch.history
        values, notes = [], [note for name, one in self._gathered.items() if (note := one.note(name))]
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
        if isinstance(measure, Happening) or measure.kind == "final":
            return measure.of(component)
        return self._starts[name] if measure.kind == "start" else self._gathered[name].value


class _Gathered:
    """The extreme or the mean of one reading.

    An extreme of a single number is read off the curve through the looks next to it, as `crests_and_crossings` reads crests;
    that of all elements of an array is the greatest, or the least, of the looks.
    """

    def __init__(self, reading: Reading) -> None:
        self._reading, self._kind = reading, reading.kind
        self._sign = -1.0 if self._kind.endswith("min") else 1.0
        self._sum, self._count = 0.0, 0
        self._best = -math.inf
        self._before: deque[tuple[float, float]] = deque(maxlen=SAMPLES - 1)
        self._window: list[tuple[float, float]] = []
        self._peak = self._room = 0

    def take(self, component: Component, time: float) -> None:
        """Take one more reading."""
        value = self._reading.of(component)
        self._single = bool(self._reading.element.index) or not component.variables[self._reading.name].shape
        self._sum += value
        self._count += 1
        height = self._sign * value
        if height > self._best or self._count == 1:
            # The best so far, the looks before it, and those that will follow: a curve through the nearest goes over it.
            self._best, self._window, self._peak = height, [*self._before, (time, height)], len(self._before)
            self._room = SAMPLES - 1
        elif self._room:
            self._window.append((time, height))
            self._room -= 1
        self._before.append((time, height))

    @property
    def value(self) -> float:
        """The extreme, its time, or the mean."""
        if self._kind == "mean":
            return self._sum / self._count
        time, height = self._top() or self._window[self._peak]
        return time if self._kind.startswith("time") else self._sign * height

    def note(self, name: str) -> str:
        """Return what is to be said of the value: a time that is known no better than from look to look; "" else."""
        if not self._kind.startswith("time") or not self._peak or self._top() is not None:
            return ""
        if self._peak == len(self._window) - 1:
            return f"{name}: its time is that of the last look, the crest may lie later; run for longer"
        (before, _), _, (after, _) = self._window[self._peak - 1 : self._peak + 2]
        return f"{name}: the crest is not resolved, its time is that of a look, in {before:g} s to {after:g} s; look more often"

    def _top(self) -> tuple[float, float] | None:
        if not self._single:
            return None
        times, heights = np.array(self._window).T
        return resolved_top(times, heights, self._peak)
