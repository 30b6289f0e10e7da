"""Validation of an experiment against its component: all errors are found before anything is written."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, ClassVar

from granular_env.components import catalogue
from granular_env.components.component import Component
from granular_env.components.errors import Location, ParameterError, StepError, issue_warning, spelling_hint
from granular_env.components.number_arrays import number_array, start_array
from granular_env.components.profiles import CompiledProfile, Profile
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.quantities import to_si
from granular_env.components.variables import Variable
from granular_env.documents import Document, Overrides, load_document

from .experiment import Experiment
from .inputs import Input, ProfileTable
from .stop_rules import StopWatch

InputValue = float | FloatArray | Profile

# Warn if a run's duration is less than this fraction of the duration of an input's profile.
_SHORT_RUN = 0.5


@dataclasses.dataclass(frozen=True)
class Prepared:
    """An experiment that is ready to run.

    Attributes:
        experiment: the experiment.
        component: the component in its start state.
        inputs: values or profiles of the inputs, set in the first step and kept afterwards.
        ticks: duration of the run as a number of the component's internal steps.
        stops: the stop rules, with their times converted to ticks.
    """

    experiment: Experiment
    component: Component
    inputs: dict[str, InputValue]
    ticks: int
    stops: StopWatch


def prepare_experiment(experiment: Experiment, has_trial_step: bool = True) -> Prepared:
    """Build an experiment's component, start values, inputs; check names, units, times and (`has_trial_step`) a first step.

    Raises:
        ExperimentError: names file, table and key, the received and the expected value.
    """
    locate = experiment.locate_errors
    with locate("component"):
        component = catalogue.make(experiment.component.type, **experiment.component.parameters)
    with locate("start"):
        reset_component(component, experiment)
    inputs = {}
    for name, value in experiment.input.items():
        with locate("input", name):
            inputs[name] = _make_input(experiment.folder, component, name, value)
    with locate("duration"):
        ticks = component.duration_ticks(experiment.duration)
    for name, value in inputs.items():
        _warn_if_cut_short(f"{experiment.origin}: input.{name}", value, experiment.duration)
    with locate("record"):
        _check_record(experiment, component)
    with locate("stop"):
        stops = StopWatch(experiment.stop, component, experiment.record.every)
    if has_trial_step:
        with locate("input"):
            with suppress(StepError):  # the run will report this error itself, after its log is open
                component.step(component.step_size, **inputs)
            reset_component(component, experiment)
    return Prepared(experiment, component, inputs, ticks, stops)


def reset_component(component: Component, experiment: Experiment) -> None:
    """Reset a component to the start values of the experiment."""
    states = [v.name for v in component.variables.values() if v.state]
    start = {}
    for name, value in experiment.start.items():
        if name not in states:
            came = "an output, but not a state variable" if name in component.variables else "unknown"
            raise ParameterError(came, hint=spelling_hint(name, states), at=("start", name))
        start[name] = to_si(value, component.variables[name].unit, ("start", name))
    component.reset(seed=experiment.seed, **start)


def branch_inputs(overrides: Overrides, component: Component) -> dict[str, InputValue]:
    """Return the new inputs that overrides such as ``{"input.left_force": 100.0}`` give for a branch of a log.

    CSV files are searched in the current folder.

    Raises:
        ExperimentError: a key that is not an input, an unknown input, or an invalid value.
    """
    branch = load_document(_BranchDocument, {}, overrides)
    found = {}
    for name, value in branch.input.items():
        with branch.locate_errors("input", name):
            found[name] = _make_input(Path(), component, name, value)
    return found


class _BranchDocument(Document):
    """The model of the keys that can be overridden in a branch of a log: only inputs."""

    kind: ClassVar[str] = "branch"

    input: dict[str, Input] = {}

    @classmethod
    def advice_for_unknown(cls, key: str, given: Mapping[str, Any]) -> str:
        """Return the hint that a branch can override only inputs."""
        return "a branch changes inputs only; expected input.NAME=VALUE"


def _make_input(folder: Path, component: Component, name: str, value: Any) -> InputValue:
    known = {v.name: v for v in component.variables.values() if v.causality == "input"}
    if name not in known:
        raise ParameterError("unknown", hint=component.input_advice(name), at=("input", name))
    value = to_si(value, known[name].unit, ("input", name))
    if isinstance(value, dict):
        return _complete_input(component, known[name], value)
    if isinstance(value, list):
        return _shaped_array(("input", name), value, known[name].shape)
    if not isinstance(value, ProfileTable):
        return value
    profile = value.make_profile(folder, known[name].unit)
    if value.pattern is not None:
        profile = profile * _pattern_array(("input", name, "pattern"), value.pattern, known[name].shape)
    # Compile the profiles once here, so that their warnings are issued before anything is written.
    profile.compile(component.step_size, f"input.{name}")
    return profile


def _complete_input(component: Component, variable: Variable, value: dict[str, Any]) -> InputValue:
    """Return the whole array of an input of which `value` gives some elements; the others keep the component's values."""
    at = ("input", variable.name)
    if isinstance(component.held_inputs[variable.name], CompiledProfile):
        hint = f"set the whole input, input.{variable.name}=..."
        raise ParameterError("got single elements, but a time profile drives this input", hint=hint, at=at)
    array = start_array(at, value, variable.shape, component.get(variable.name))
    return array if variable.shape else float(array)


def _pattern_array(at: Location, value: list[Any] | dict[str, Any], shape: tuple[int, ...]) -> FloatArray:
    return start_array(at, value, shape) if isinstance(value, dict) else _shaped_array(at, value, shape)


def _shaped_array(at: Location, value: list[Any], shape: tuple[int, ...]) -> FloatArray:
    return number_array(at, value, f"an array of shape {shape}" if shape else "a single number", (shape,))


def _warn_if_cut_short(where: str, value: InputValue, duration: float) -> None:
    """Warn if a run ends long before the profile of its input does, which usually means a wrong time unit."""
    end = float(value.starts[-1]) if isinstance(value, Profile) else 0.0
    if duration < _SHORT_RUN * end:
        issue_warning(
            f"{where}: the run ends at {duration:g} s, after {100.0 * duration / end:.2g} % of the signal, which ends at "
            f"{end:g} s; check the unit of the signal's times, and the duration"
        )


def _check_record(experiment: Experiment, component: Component) -> None:
    record = experiment.record
    recordable = [v.name for v in component.variables.values() if v.causality != "parameter"]
    for place, name in enumerate(record.variables or []):
        if name not in recordable:
            expected = f"an input or output of component {component.name!r}"
            at = ("record", "variables", place)
            raise ParameterError(f"got {name!r}", expected=expected, hint=spelling_hint(name, recordable), at=at)
    for key in ("every", "snapshot_every"):
        if (interval := getattr(record, key)) is not None:
            component.duration_ticks(interval, ("record", key))
