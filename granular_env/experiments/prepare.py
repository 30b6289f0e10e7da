"""An experiment held against its component: everything that can be wrong is found before anything is written."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

from granular_env.components import catalogue
from granular_env.components.component import Component
from granular_env.components.errors import ExperimentError, ParameterError, StepError, caution, nearest
from granular_env.components.profiles import Profile

from .faults import Faults, blamed, overridden, shortened
from .inputs import ProfileTable, parse_input
from .load import parse_override
from .schema import Experiment
from .stops import StopWatch

# A run that is over before this part of an input's signal is told of.
_SHORT_RUN = 0.5


@dataclasses.dataclass(frozen=True)
class Prepared:
    """An experiment that is ready to run.

    Attributes:
        experiment: where it came from.
        component: at its start state.
        inputs: for its first step; they hold from then on.
        ticks: the run's length in internal steps.
        stops: the stop rules on this component's ticks.
    """

    experiment: Experiment
    component: Component
    inputs: dict[str, float | Profile]
    ticks: int
    stops: StopWatch


def prepare(experiment: Experiment) -> Prepared:
    """Build the component, the start, the inputs; check names, units and times.

    Raises:
        ExperimentError: file, table and key, what came and what was expected.
    """
    with overridden(experiment.origin, experiment.overrides):
        return _prepared(experiment)


def _prepared(experiment: Experiment) -> Prepared:
    origin = experiment.origin
    with blamed(origin, "component"):
        component = catalogue.make(experiment.component.type, **experiment.component.parameters)
    with blamed(origin, "start"):
        reset(component, experiment)
    inputs = {name: _input(origin, experiment.folder, component, name, value) for name, value in experiment.input.items()}
    with blamed(origin, "duration"):
        ticks = component.ticks_in(experiment.duration)
    for name, value in inputs.items():
        _tell_of_a_short_run(f"{origin}: input.{name}", value, experiment.duration)
    with blamed(origin, "record"):
        _check_record(experiment, component)
    with blamed(origin, "stop"):
        stops = StopWatch(experiment.stop, component, experiment.record.every)
    with blamed(origin, "input"):
        _try(component, inputs)
        reset(component, experiment)
    return Prepared(experiment, component, inputs, ticks, stops)


def reset(component: Component, experiment: Experiment) -> None:
    """Put a component at the experiment's start."""
    states = [v.name for v in component.variables.values() if v.state]
    for name in experiment.start:
        if name not in states:
            raise ParameterError(f"start.{name}: no state variable of this {component.name}; {nearest(name, states)}")
    component.reset(seed=experiment.seed, **experiment.start)


def inputs_from(overrides: list[str], component: Component) -> dict[str, float | Profile]:
    """Inputs from ``"input.left_force=100"`` and the like, for a component that runs; CSV paths from the current folder.

    Raises:
        ExperimentError: another key than an input's, an unknown input, or one that is not valid.
    """
    origin, faults, found = "branch", Faults("branch"), {}
    for override in overrides:
        parts, value = parse_override(override)
        if parts[0] != "input" or len(parts) != 2:
            raise ExperimentError(f"override {shortened(override)}: a branch changes inputs only; expected input.NAME=VALUE")
        found[parts[1]] = parse_input(value, f"input.{parts[1]}", faults)
    faults.raise_any()
    return {name: _input(origin, Path(), component, name, value) for name, value in found.items()}


def _input(origin: str, folder: Path, component: Component, name: str, value: Any) -> float | Profile:
    known = {v.name: v for v in component.variables.values() if v.causality == "input"}
    with blamed(origin, f"input.{name}"):
        if name not in known:
            raise ParameterError(f"unknown to this {component.name}; {component.input_advice(name)}")
        if not isinstance(value, ProfileTable):
            return value
        profile = value.build(folder, known[name].unit)
        # Compiled once, here, so that what has to be told of it is told before anything is written.
        profile.compile(component.step_size, name)
        return profile


def _tell_of_a_short_run(where: str, value: float | Profile, duration: float) -> None:
    """Warn where a run ends long before its signal: mostly a wrong unit of the time."""
    end = float(value.starts[-1]) if isinstance(value, Profile) else 0.0
    if duration < _SHORT_RUN * end:
        caution(
            f"{where}: the run ends at {duration:g} s, after {100.0 * duration / end:.2g} % of the signal, which goes on to "
            f"{end:g} s; check the unit of its times and the duration"
        )


def _check_record(experiment: Experiment, component: Component) -> None:
    record = experiment.record
    recordable = [v.name for v in component.variables.values() if v.causality != "parameter"]
    for name in record.variables or []:
        if name not in recordable:
            raise ParameterError(
                f"record.variables: {name!r} is no input or output of this {component.name}; {nearest(name, recordable)}"
            )
    for key in ("every", "key_every"):
        if (interval := getattr(record, key)) is not None:
            component.ticks_in(interval, f"record.{key}")


def _try(component: Component, inputs: dict[str, float | Profile]) -> None:
    """One step with the inputs, to be thrown away: only the component itself knows everything that it refuses."""
    try:
        component.step(component.step_size, **inputs)
    except StepError:
        pass  # The run will meet it, with its log open, and tell.
