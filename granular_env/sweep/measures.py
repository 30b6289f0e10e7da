"""Measures of each run of a plan: words for the component's own variables, tables for its domain's measurements.

[measure]
peak = "max velocity[40]"             # final, start, max, min, mean, time of max, time of min; of several axes velocity[3,1]
largest = "max |velocity|"            # an array without an index: over all its elements
energy = "final kinetic_energy"       # any output that `granular-env describe` names
broken = "events link_broken"         # the number of events of a kind; "first link_broken": the time of the first
pressure = "report peak contact pressure"   # a figure that a run ends with; the beginning of its name is enough
speed = { measurement = "front_speed", above = 0.1, first = 20, last = 60 }
pulse = { measurement = "waves_at", take = "amplitude", which = 0, grain = 40, above = 0.1 }
"""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import PlainValidator

from granular_env.components.component import Component
from granular_env.components.errors import ParameterError, nearest, one_line
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.validation import refusal
from granular_env.components.variables import ELEMENT, Element, parse_element
from granular_env.crests_and_crossings import resolved_top
from granular_env.domains import DOMAINS, load

# Columns that every table may have; no measure is called so.
OWN_COLUMNS = ("task", "sample", "repetition", "seed", "outcome", "error", "notes", "hash", "log")
EXTREMES = ("max", "min", "mean", "time of max", "time of min")
_KINDS = (*EXTREMES, "final", "start")
_WORDS = re.compile(rf"(?P<kind>{'|'.join(_KINDS)})\s+(?P<bar>\|?)(?P<element>{ELEMENT})(?P=bar)")
_EVENTS = re.compile(r"(?P<what>events|first)\s+(?P<kind>\w+)")
_REPORT = re.compile(r"report\s+(?P<name>\S.*)")


class FinishedRun(NamedTuple):
    """The end of a run, of which measures are taken.

    Attributes:
        component: at the end of the run.
        report: its figures.
        times: of the looks [s].
        history: of the domain's watch, see `Domain.watch`; None without.
    """

    component: Component
    report: Mapping[str, float]
    times: FloatArray
    history: Any


@dataclass(frozen=True)
class Reading:
    """A number read off a variable: at the end, at the start, or over all looks at it.

    Attributes:
        kind: final, start, max, min, mean, time of max, time of min.
        element: of a variable; without an index a number, or all elements.
        absolute: of the magnitude.
    """

    kind: str
    element: Element
    absolute: bool

    def check(self, component: Component) -> None:
        """`ParameterError` where this component has no such variable, or no such element."""
        variable = self.element.find(component.variables, f"an output of component {component.name!r}", "output", "input")
        size, name = math.prod(variable.shape), self.element.name
        if not self.element.index and variable.shape and (self.kind not in ("max", "min") or not size):
            hint = f"name one, such as {Element(name, (-1,) * len(variable.shape))}, or take max or min"
            raise ParameterError(f"{name!r} has {size} elements", hint=hint)

    def unit(self, component: Component) -> str:
        """Return the unit of the number."""
        return "s" if self.kind.startswith("time") else component.variables[self.element.name].unit

    def look(self, component: Component) -> float:
        """Return the present value; of all elements the greatest, or the least for min."""
        value = np.asarray(self.element.of(component.peek(self.element.name)))
        value = np.abs(value) if self.absolute else value
        return float(value if not value.ndim else value.min() if self.kind == "min" else value.max())

    def value(self, run: FinishedRun, looks: FloatArray) -> tuple[float, str]:
        """Return the number, and a note where it is not resolved.

        An extreme of a single number is read off the curve through the looks next to it; that of all elements of an array is
        the greatest, or the least, of the looks.

        Args:
            run: which one.
            looks: the value at `run.times`; only the first for start.
        """
        if self.kind == "final":
            return self.look(run.component), ""
        if self.kind == "start":
            return float(looks[0]), ""
        if self.kind == "mean":
            return math.fsum(looks) / len(looks), ""
        sign = -1.0 if self.kind.endswith("min") else 1.0
        heights, times = sign * looks, run.times
        peak, note = int(np.argmax(heights)), ""
        is_single = bool(self.element.index) or not run.component.variables[self.element.name].shape
        found = resolved_top(times, heights, peak) if is_single else None
        if found is None and self.kind.startswith("time") and peak:
            note = "its time is that of the last look, the crest may lie later; run for longer"
            if peak < len(times) - 1:
                near = f"in {times[peak - 1]:g} s to {times[peak + 1]:g} s"
                note = f"the crest is not resolved, its time is that of a look, {near}; look more often"
        time, height = found or (float(times[peak]), float(heights[peak]))
        return (time if self.kind.startswith("time") else sign * height), note


@dataclass(frozen=True)
class Figure:
    """One of the figures of `Component.report`, by the beginning of its name."""

    name: str

    def check(self, component: Component) -> None:
        """`ParameterError` where the component reports no figure of that name, or several."""
        self._find(component.report())

    def value(self, run: FinishedRun, looks: FloatArray) -> tuple[float, str]:
        """Return the figure."""
        return float(run.report[self._find(run.report)]), ""

    def unit(self, component: Component) -> str:
        """Return the unit that the figure's name ends with."""
        match = re.search(r"\[([^\[\]]+)\]$", self._find(component.report()))
        return match[1] if match else "1"

    def _find(self, report: Mapping[str, float]) -> str:
        fitting = [name for name in report if name.startswith(self.name)]
        if self.name in report or len(fitting) == 1:
            return self.name if self.name in report else fitting[0]
        advice = f"several begin so: {', '.join(fitting)}" if fitting else nearest(self.name, report)
        expected = "the beginning of one figure of the run's report"
        raise ParameterError(f"got 'report {self.name}'", expected=expected, hint=advice)


@dataclass(frozen=True)
class EventMeasure:
    """The number of events of one kind, or the time of the first.

    Attributes:
        kind: of the events.
        is_first: whether the time of the first is taken [s]; NaN without one.
    """

    kind: str
    is_first: bool

    def check(self, component: Component) -> None:
        """`ParameterError` for a kind of events that the component does not have."""
        component.events(self.kind)

    def value(self, run: FinishedRun, looks: FloatArray) -> tuple[float, str]:
        """Return the number of events, or the time of the first."""
        found = run.component.events(self.kind)
        if not self.is_first:
            return float(len(found)), ""
        return (found[0].tick * run.component.step_size if found else math.nan), ""

    def unit(self, component: Component) -> str:
        """Return the unit of the number."""
        return "s" if self.is_first else "1"


@dataclass(frozen=True)
class Measurement:
    """A measurement of a domain, and which of its numbers is taken.

    Attributes:
        columns: the domain's module of that name, see `Domain.columns`.
        name: of the function.
        take: which number.
        which: of several waves, in the order that the function gives them; negative counts from the last.
        arguments: the function's own.
    """

    columns: str
    name: str
    take: str
    which: int
    arguments: tuple[tuple[str, Any], ...]

    def check(self, component: Component) -> None:
        """Do nothing: the domain's watch is looked for when the run begins."""

    def value(self, run: FinishedRun, looks: FloatArray) -> tuple[float, str]:
        """Return the number; NaN where there are fewer waves."""
        return load(self.columns).MEASUREMENTS[self.name][self.take](run.history, self.which, dict(self.arguments)), ""

    def unit(self, component: Component) -> str:
        """Return the unit of what is taken."""
        units = load(self.columns).UNITS
        return units.get((self.name, self.take)) or units[self.take]


Measure = Reading | Figure | EventMeasure | Measurement


def parse_measure(given: Any) -> Measure:
    """Return a measure from its words or its table in the plan; for pydantic."""
    if isinstance(given, Mapping):
        return _parse_measurement(given)
    words = " ".join(given.split()) if isinstance(given, str) else ""
    if (match := _WORDS.fullmatch(words)) is not None:
        return Reading(match["kind"], parse_element(match["element"]), bool(match["bar"]))
    if (match := _REPORT.fullmatch(words)) is not None:
        return Figure(match["name"])
    if (match := _EVENTS.fullmatch(words)) is not None:
        return EventMeasure(match["kind"], match["what"] == "first")
    raise refusal(
        f"got {one_line(given, 60)}",
        f"such as 'max velocity[40]' ({', '.join(_KINDS)}), 'events KIND' or 'first KIND' of what can happen, "
        "'report NAME' of a figure that runs end with, or a measurement of the domain, "
        f"{{ measurement = NAME, ... }} ({', '.join(_measurements())})",
    )


AnyMeasure = Annotated[Measure, PlainValidator(parse_measure)]


def _parse_measurement(table: Mapping[str, Any]) -> Measurement:
    known, name = _measurements(), table.get("measurement")
    if not isinstance(name, str) or name not in known:
        came = "missing" if name is None else f"got {one_line(name, 60)}"
        raise refusal(came, hint=nearest(str(name), known), at=("measurement",))
    columns = load(known[name])
    takes = columns.MEASUREMENTS[name]
    take, which = table.get("take", next(iter(takes))), table.get("which", 0)
    if not isinstance(take, str) or take not in takes:
        raise refusal(f"got {one_line(take, 60)}", hint=nearest(str(take), takes), at=("take",))
    if isinstance(which, bool) or not isinstance(which, int):
        raise refusal(f"got {one_line(which, 60)}", "a whole number: 0 is the first, -1 the last", at=("which",))
    arguments = {key: value for key, value in table.items() if key not in ("measurement", "take", "which")}
    _, *parameters = inspect.signature(columns.function(name)).parameters.values()
    needed = {one.name: one.default is one.empty for one in parameters}
    for key in arguments.keys() - needed.keys():
        raise refusal("unknown", hint=nearest(key, ["take", "which", *needed]), at=(key,))
    for key in needed:
        if needed[key] and key not in arguments:
            raise refusal("missing", hint=f"{name} needs it", at=(key,))
    return Measurement(known[name], name, take, which, tuple(arguments.items()))


def _measurements() -> dict[str, str]:
    """Return name -> the domain's module that has it, of all domains."""
    homes = [domain.columns for domain in DOMAINS.values() if domain.columns is not None]
    return {name: home for home in homes for name in load(home).MEASUREMENTS}
