"""The measures of a plan: a number for each run, given by a text (variables, events, report) or a table (measurements).

[measure]
peak = "max velocity[40]"             # final, start, max, min, mean, time of max, time of min; velocity[3,1] for several axes
largest = "max |velocity|"            # an array without an index: over all elements
energy = "final kinetic_energy"       # any output listed by `granular-env describe`
broken = "events link_broken"         # number of events of a kind; "first link_broken": time of the first event
pressure = "report peak contact pressure"   # a figure of the final report; the beginning of its name suffices
speed = { measurement = "front_speed", above = 0.1, first = 20, last = 60 }
pulse = { measurement = "waves_at", take = "amplitude", which = 0, grain = 40, above = 0.1 }

Each class of measures has two methods. `unit` checks a measure against a component and returns the unit of the number. `value`
returns the number for a finished run, and a note if the samples do not resolve it. `RunObserver` takes the measures of a run.
"""

from __future__ import annotations

import inspect
import math
import re
from array import array
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import PlainValidator

from granular_env.components.component import Component
from granular_env.components.errors import LogError, ParameterError, one_line, spelling_hint
from granular_env.components.stepping import Observer
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.memory_limits import refuse_excess_memory
from granular_env.components.variables import ELEMENT, Element, parse_element
from granular_env.crests_and_crossings import resolved_maximum
from granular_env.domains import find_domain

# Columns that every table has; a measure must not have one of these names.
OWN_COLUMNS = ("task", "sample", "outcome", "error", "notes", "hash", "log")
_EXTREMES = ("max", "min", "mean", "time of max", "time of min")
_KINDS = (*_EXTREMES, "final", "start")
_WORDS = re.compile(rf"(?P<kind>{'|'.join(_KINDS)})\s+(?P<bar>\|?)(?P<element>{ELEMENT})(?P=bar)")
_EVENTS = re.compile(r"(?P<what>events|first)\s+(?P<kind>\w+)")
_REPORT = re.compile(r"report\s+(?P<name>\S.*)")


class FinishedRun(NamedTuple):
    """A finished run, from which measures are taken.

    Attributes:
        component: component at the end of the run.
        report: name -> number, from `Component.report`.
        times: times at which the variables were sampled [s].
        history: history recorded by the observer `Domain.watch`; None without such an observer.
    """

    component: Component
    report: Mapping[str, float]
    times: FloatArray
    history: Any


@dataclass(frozen=True)
class Reading:
    """A number from a variable: its final or start value, or a statistic over all samples.

    Attributes:
        kind: which number: final, start, max, min, mean, time of max, time of min.
        element: the element of a variable; without an index the whole variable.
        absolute: whether to use the magnitude of the values.
    """

    kind: str
    element: Element
    absolute: bool

    def unit(self, component: Component) -> str:
        """Return the unit of the number; `ParameterError` if the component has no such variable or element."""
        expected = f"an output of component {component.name!r}"
        variable = self.element.find_variable(component.variables, expected, "output", "input")
        size, name = math.prod(variable.shape), self.element.name
        if not self.element.index and variable.shape and (self.kind not in ("max", "min") or not size):
            hint = f"give an index, such as {Element(name, (-1,) * len(variable.shape))}, or use max or min"
            raise ParameterError(f"{name!r} has {size} elements", hint=hint)
        return "s" if self.kind.startswith("time") else variable.unit

    def read_value(self, component: Component) -> float:
        """Return the present value of the element; for a whole variable, the largest element (for min, the smallest)."""
        value = np.asarray(self.element.select_from(component.peek(self.element.name)))
        value = np.abs(value) if self.absolute else value
        return float(value if not value.ndim else value.min() if self.kind == "min" else value.max())

    def value(self, run: FinishedRun, samples: FloatArray) -> tuple[float, str]:
        """Return the number computed from `samples`, the values at `run.times` (for start, only the first is needed).

        An extreme of a single element is interpolated between samples; that of a whole variable is the largest or the smallest
        sample.
        """
        if self.kind == "final":
            return self.read_value(run.component), ""
        if self.kind == "start":
            return float(samples[0]), ""
        if self.kind == "mean":
            return math.fsum(samples) / len(samples), ""
        sign = -1.0 if self.kind.endswith("min") else 1.0
        peak = int(np.argmax(sign * samples))
        is_single = bool(self.element.index) or not run.component.variables[self.element.name].shape
        found = resolved_maximum(run.times, sign * samples, peak) if is_single else None
        time, height = found or (float(run.times[peak]), float(sign * samples[peak]))
        if not self.kind.startswith("time"):
            return sign * height, ""
        return time, "" if found or not peak else "the extremum is not resolved; sample more often or run longer"


@dataclass(frozen=True)
class ReportFigure:
    """A number from `Component.report`, selected by the beginning of its name."""

    name: str

    def unit(self, component: Component) -> str:
        """Return the unit, which ends the number's name in the report; `ParameterError` unless exactly one name matches."""
        match = re.search(r"\[([^\[\]]+)\]$", self._full_name(component.report()))
        return match[1] if match else "1"

    def value(self, run: FinishedRun, samples: FloatArray) -> tuple[float, str]:
        """Return the number in the report of the run."""
        return float(run.report[self._full_name(run.report)]), ""

    def _full_name(self, report: Mapping[str, float]) -> str:
        fitting = [self.name] if self.name in report else [name for name in report if name.startswith(self.name)]
        if len(fitting) == 1:
            return fitting[0]
        advice = f"several names begin with it: {', '.join(fitting)}" if fitting else spelling_hint(self.name, report)
        expected = "the beginning of the name of one figure in the run's report"
        raise ParameterError(f"got 'report {self.name}'", expected=expected, hint=advice)


@dataclass(frozen=True)
class EventMeasure:
    """The number of events of one kind, or the time of the first event.

    Attributes:
        kind: kind of the events that are counted.
        is_first: whether to return the time of the first event [s] (NaN without events).
    """

    kind: str
    is_first: bool

    def unit(self, component: Component) -> str:
        """Return the unit of the number; `ParameterError` if the component has no events of this kind."""
        component.events(self.kind)
        return "s" if self.is_first else "1"

    def value(self, run: FinishedRun, samples: FloatArray) -> tuple[float, str]:
        """Return the number of events, or the time of the first event."""
        found = run.component.events(self.kind)
        if not self.is_first:
            return float(len(found)), ""
        return (found[0].tick * run.component.step_size if found else math.nan), ""


@dataclass(frozen=True)
class Measurement:
    """A measurement function of the component's domain (see `Domain.columns`), and which number of its result to take.

    Attributes:
        name: name of the measurement function.
        take: name of the number in its result; "" for the first that the domain lists.
        which: if the result is a list (of waves), index of the item to take; negative values count from the last.
        arguments: arguments of the measurement function.
    """

    name: str
    take: str
    which: int
    arguments: Mapping[str, Any]

    def unit(self, component: Component) -> str:
        """Return the unit of the number; `ParameterError` if the domain has no such measurement, number or argument."""
        columns = find_domain(component.name).load_attribute("columns")
        if columns is None:
            hint = "measure its variables, such as 'max NAME[0]'"
            raise ParameterError(f"component {component.name!r} has no measurements", hint=hint)
        if self.name not in columns.MEASUREMENTS:
            raise ParameterError(f"got {self.name!r}", hint=spelling_hint(self.name, columns.MEASUREMENTS), at="measurement")
        take = self._column_name(columns)
        if take not in columns.MEASUREMENTS[self.name]:
            raise ParameterError(f"got {take!r}", hint=spelling_hint(take, columns.MEASUREMENTS[self.name]), at="take")
        signature = inspect.signature(columns.measurement_function(self.name))
        try:
            signature.bind(None, **self.arguments)
        except TypeError as error:
            hint = f"{self.name} has the arguments {', '.join(list(signature.parameters)[1:])}"
            raise ParameterError(str(error), hint=hint) from None
        return columns.UNITS.get((self.name, take)) or columns.UNITS[take]

    def value(self, run: FinishedRun, samples: FloatArray) -> tuple[float, str]:
        """Return the number for a finished run; NaN if the result has no item `which`."""
        columns = find_domain(run.component.name).load_attribute("columns")
        taken = columns.MEASUREMENTS[self.name][self._column_name(columns)]
        return taken(run.history, self.which, dict(self.arguments)), ""

    def _column_name(self, columns: Any) -> str:
        return self.take or next(iter(columns.MEASUREMENTS[self.name]))


Measure = Reading | ReportFigure | EventMeasure | Measurement


def parse_measure(content: Any) -> Measure:
    """Return the measure that a text or a table in the plan describes; pydantic calls this to validate the plan."""
    words = " ".join(content.split()) if isinstance(content, str) else ""
    if isinstance(content, Mapping) and isinstance(content.get("measurement"), str):
        arguments = {key: value for key, value in content.items() if key not in ("measurement", "take", "which")}
        if type(which := content.get("which", 0)) is not int:
            raise ParameterError(f"got {one_line(which)}", expected="a whole number, -1 for the last", at="which")
        return Measurement(content["measurement"], str(content.get("take", "")), which, arguments)
    if match := _WORDS.fullmatch(words):
        return Reading(match["kind"], parse_element(match["element"]), bool(match["bar"]))
    if match := _REPORT.fullmatch(words):
        return ReportFigure(match["name"])
    if match := _EVENTS.fullmatch(words):
        return EventMeasure(match["kind"], match["what"] == "first")
    raise ParameterError(
        f"got {one_line(content, 60)}",
        expected=f"a measure such as 'max velocity[40]' ({', '.join(_KINDS)}), 'events KIND' or 'first KIND' for an event, "
        "'report NAME' for a figure of the final report, or a measurement of the domain, { measurement = NAME, ... }",
    )


AnyMeasure = Annotated[Measure, PlainValidator(parse_measure)]


class RunObserver(Observer):
    """An observer that collects the data for the measures of a plan; it never changes a step.

    Args:
        measures: column name -> measure.
        every: sampling interval [s]; None to sample at each internal step.
        duration: duration of the run [s]; a run whose history would exceed the memory is refused.
    """

    def __init__(self, measures: Mapping[str, Measure], every: float | None, duration: float) -> None:
        self._measures, self._every, self._duration = measures, every, duration
        self._readings = {name: one for name, one in measures.items() if isinstance(one, Reading)}
        self._extremes = {name: one for name, one in self._readings.items() if one.kind in _EXTREMES}
        self._looks, self._times, self._watch = {name: array("d") for name in self._readings}, array("d"), None
        self.next_tick = 0

    def on_reset(self, component: Component) -> None:
        """Check the measures against the component, and take the first sample."""
        for name, measure in self._measures.items():
            try:
                measure.unit(component)
            except ParameterError as error:
                raise error.with_outer_location("measure", name) from None
        self._interval = 1 if self._every is None else component.duration_ticks(self._every, "every")
        if any(isinstance(measure, Measurement) for measure in self._measures.values()):
            self._watch = self._begin_history(component)
        self._sample_variables(component, self._readings)
        self._plan_next_sample(component)

    def _begin_history(self, component: Component) -> Any:
        every = self._interval * component.step_size
        watch = find_domain(component.name).load_attribute("watch")(every)
        watch.on_reset(component)
        numbers = sum(np.size(component.get(name)) for name in watch.variables)
        refuse_excess_memory(int(8 * numbers * self._duration / every), f"a history with a frame every {every:g} s")
        return watch

    def on_sample(self, component: Component) -> None:
        """Sample every variable of which a measure needs an extreme or the mean."""
        self._sample_variables(component, self._extremes)
        if self._watch is not None:
            self._watch.on_sample(component)
        self._plan_next_sample(component)

    def _sample_variables(self, component: Component, readings: Mapping[str, Reading]) -> None:
        self._times.append(component.time)
        for name, reading in readings.items():
            self._looks[name].append(reading.read_value(component))

    def _plan_next_sample(self, component: Component) -> None:
        self.next_tick = component.tick + self._interval if self._extremes or self._watch else 2**62

    def values(self, component: Component, report: Mapping[str, float]) -> tuple[list[float], list[str]]:
        """Return the numbers of all measures for a finished run, in order; for a number that does not exist, NaN and a note."""
        if self._times[-1] < component.time:
            self._sample_variables(component, self._extremes)
        run = FinishedRun(component, report, np.array(self._times), self._watch and self._watch.history)
        values, notes = [], []
        for name, measure in self._measures.items():
            try:
                value, note = measure.value(run, np.array(self._looks.get(name, ())))
            except (ParameterError, LogError) as error:
                value, note = math.nan, str(error)
            values.append(value)
            notes += [f"{name}: {note}"] if note else []
        return values, notes
