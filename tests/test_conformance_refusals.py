"""Refusals, tested on three components, and failures of all components, which must not change the state."""

from __future__ import annotations

import math
import warnings
from functools import cache
from itertools import product

import numpy as np
import pytest
from support.component_examples import EXAMPLES, Example
from support.conformance_tools import (
    THREE,
    Watcher,
    drive_component,
    every_example,
    on_three_components,
    state_bits,
    variable_bytes,
)

from granular_env.components.component import Component
from granular_env.components.errors import GranularError, GranularWarning, ParameterError, StepError
from granular_env.components.profiles import CompiledProfile, Profile
from granular_env.components.snapshot import Snapshot

NAN, HUGE = math.nan, 10**400


def refused(component: Component, action, *expected: str) -> None:  # noqa: ANN001
    """Assert that the action raises ParameterError with this text and changes nothing."""
    before, observed = state_bits(component), variable_bytes(component)
    with pytest.raises(ParameterError) as caught:
        action()
    for words in expected:
        assert words in str(caught.value)
    assert state_bits(component) == before
    assert variable_bytes(component) == observed
    reference = state_bits(component)
    component.step()
    assert state_bits(component) != reference


@cache
def halfway(label: str) -> tuple[Component, Snapshot]:
    """Return a cached component in the middle of a run and its state; refusals do not change it, so tests share it."""
    example = next(example for example in EXAMPLES if example.label == label)
    component = example.make_started()
    drive_component(component, example, 25)
    return component, component.save()


@pytest.fixture(params=THREE, ids=lambda example: example.label)
def moving(request: pytest.FixtureRequest) -> tuple[Component, Example]:
    """Return a component in the middle of a run, and its example."""
    component, state = halfway(request.param.label)
    component.restore(state)
    return component, request.param


def test_wrong_durations_are_refused(moving: tuple[Component, Example]) -> None:
    component, _ = moving
    for wrong in [0.0, -1.0, NAN, "1", [1.0], HUGE]:
        refused(component, lambda wrong=wrong: component.step(wrong), "duration")


@pytest.mark.parametrize("count", [0.5, 10.25])
def test_a_duration_that_is_no_multiple_names_its_neighbours(moving: tuple[Component, Example], count: float) -> None:
    component, _ = moving
    h = component.step_size
    refused(component, lambda: component.step(count * h), "internal steps", f"{h:.12g}", f"{math.ceil(count) * h:.12g} s")


def test_unknown_inputs_are_refused_with_the_nearest_name(moving: tuple[Component, Example]) -> None:
    component, example = moving
    for name, value in example.inputs.items():
        refused(component, lambda name=name, value=value: component.step(None, **{f"{name}s": value}), f"{name}s", repr(name))
        output = next(v.name for v in component.variables.values() if v.causality == "output")
        refused(component, lambda value=value, output=output: component.step(None, **{output: value}), output)


def test_inputs_that_are_no_numbers_are_refused(moving: tuple[Component, Example]) -> None:
    component, example = moving
    for wrong in [NAN, math.inf, "3", None, HUGE, 1j, {0: 1.0}]:
        for name in example.inputs:
            refused(component, lambda name=name, wrong=wrong: component.step(None, **{name: wrong}), name)


def test_one_bad_element_of_an_array_is_named(moving: tuple[Component, Example]) -> None:
    component, example = moving
    arrays = {name: np.array(good) for name, good in example.inputs.items() if np.ndim(good)}
    for (name, good), wrong in product(arrays.items(), [NAN, math.inf, -math.inf]):
        place, bad = tuple(extent - 1 for extent in good.shape), good.copy()
        bad[place] = wrong
        said = f"input.{name}[{','.join(map(str, place))}]: got {wrong:g}, expected a finite number"
        refused(component, lambda name=name, bad=bad: component.step(None, **{name: bad}), said)


def test_arrays_of_another_shape_are_refused_with_both(moving: tuple[Component, Example]) -> None:
    component, example = moving
    for name, good in example.inputs.items():
        if np.ndim(good):
            shape, given = np.shape(good), np.array(good)
            longer = np.concatenate([given, given[..., :1]], axis=-1)
            fewer_axes = [given[..., 0]] if given.ndim > 1 else []  # a single number would apply to all
            for bad in (given[1:], *fewer_axes, longer.tolist(), given[np.newaxis]):
                refused(component, lambda name=name, bad=bad: component.step(None, **{name: bad}), name, str(shape))
            other = Profile.constant(1.0) * np.ones(3)
            refused(component, lambda name=name, other=other: component.step(None, **{name: other}), name, "(3,)", str(shape))
            refused(component, lambda name=name: component.step(None, **{name: [[0.0], [0.0, 1.0]]}), name)


def test_what_is_peeked_at_is_closed_to_writing(moving: tuple[Component, Example]) -> None:
    component, _ = moving
    before = component.save().to_bytes()
    for name, variable in component.variables.items():
        if variable.shape and variable.causality != "parameter":
            with pytest.raises(ValueError, match="read-only"):
                component.peek(name)[...] = 1.0
            component.get(name)[...] = 1.0
    assert component.save().to_bytes() == before


def test_a_profile_compiled_for_another_step_is_refused(moving: tuple[Component, Example]) -> None:
    component, example = moving
    for name in example.inputs:
        foreign = Profile.constant(1.0).compile(2.0 * component.step_size)
        refused(component, lambda name=name, foreign=foreign: component.step(None, **{name: foreign}), name)
        pattern = np.asarray(example.inputs[name], dtype=np.float64)
        own = CompiledProfile(component.step_size, np.array([0]), np.ones((1, 1)), pattern if pattern.ndim else None)
        component.step(None, **{name: own})


def test_wrong_start_values_are_refused(moving: tuple[Component, Example]) -> None:
    component, example = moving
    for wrong in [NAN, "fast", None, HUGE, np.ones((2, 3, 4)), [[1.0], [1.0, 2.0]], {"a": 1.0}]:
        for name in example.start:
            refused(component, lambda name=name, wrong=wrong: component.reset(**{name: wrong}), name)


def test_wrong_start_names_are_refused(moving: tuple[Component, Example]) -> None:
    component, example = moving
    for name in example.start:
        refused(component, lambda name=name: component.reset(**{f"{name}x": 0.0}), f"{name}x", repr(name))
    for variable in component.variables.values():
        if not variable.state:
            refused(component, lambda name=variable.name: component.reset(**{name: 0.0}), variable.name)


@pytest.mark.parametrize("name", ["no_such_variable", None, ["velocity"]])
def test_unknown_variables_are_refused(moving: tuple[Component, Example], name: object) -> None:
    component, _ = moving
    refused(component, lambda: component.get(name))  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def snapshots() -> list[Snapshot]:
    """Return one component of each example."""
    return [example.make_started().save() for example in EXAMPLES]


def test_foreign_snapshots_are_refused(moving: tuple[Component, Example], snapshots: list[Snapshot]) -> None:
    component, _ = moving
    own = component.save()
    others = [foreign for foreign in snapshots if foreign.identity != component.identity]
    assert len(others) > len(snapshots) // 2
    for foreign in others:
        refused(component, lambda foreign=foreign: component.restore(foreign), "snapshot", component.identity[:12])
    cut = Snapshot(own.identity, own.tick, own.data[:-8], dict(own.inputs))
    refused(component, lambda: component.restore(cut), "snapshot")
    fewer = Snapshot(own.identity, own.tick, own.data, {**own.inputs, "no_such_input": 1.0})
    refused(component, lambda: component.restore(fewer), "snapshot")
    for nothing in (None, 3, "snapshot", own.to_bytes(), np.zeros(3)):
        refused(component, lambda nothing=nothing: component.restore(nothing), "snapshot")  # type: ignore[arg-type]


@every_example
def test_forged_memory_does_no_harm(example: Example) -> None:
    """A snapshot with the right name and arbitrary numbers is restored or refused, then stepped or refused, without traces."""
    component, generator = example.make_started(), np.random.default_rng(0)
    own, fresh = component.save(), state_bits(component)
    drive_component(component, example, 20)
    for wildness in (1, 3, 10, len(own.memory)):
        for _ in range(5):
            memory = component.save().memory.copy()
            places = generator.integers(len(memory), size=wildness)
            memory.view(np.int64)[places] = generator.integers(-(2**63), 2**63 - 1, size=wildness)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", GranularWarning)
                try:
                    component.restore(Snapshot(own.identity, 7, memory.tobytes(), own.inputs))
                    component.step(10 * component.step_size)
                except GranularError:
                    pass
            component.reset(**example.start)
            assert state_bits(component) == fresh


@on_three_components
def test_wrong_parameters_are_refused(example: Example) -> None:
    with pytest.raises(ParameterError, match="no_such_parameter"):
        example.make_variant({**example.parameters, "no_such_parameter": 1.0})
    for name, value in example.parameters.items():
        others = {key: other for key, other in example.parameters.items() if key != name}
        with pytest.raises(ParameterError, match=name):
            example.make_variant({**others, f"{name}x": value})
        if isinstance(value, float):
            for bad in (NAN, math.inf, "much", {}, -1.0, HUGE):
                with pytest.raises(ParameterError, match=name):
                    example.make_variant({**example.parameters, name: bad})


# -- failure ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("example", [e for e in EXAMPLES if e.breaks], ids=lambda example: example.label)
@pytest.mark.parametrize(("watched", "ticks"), [(False, 1), (True, None)])
def test_a_step_happens_whole_or_not_at_all(example: Example, watched: bool, ticks: int | None) -> None:
    assert example.breaks is not None
    parameters, start, inputs = example.breaks
    component = example.make_variant({**example.parameters, **parameters})
    component.reset(**start)
    watcher = Watcher(3)
    if watched:
        component.observe(watcher)
    duration = (ticks or example.breaks_after) * component.step_size
    with warnings.catch_warnings(), pytest.raises(StepError) as caught:
        warnings.simplefilter("ignore", GranularWarning)  # a component may warn before it refuses
        for _ in range(example.breaks_after):
            before, observed = state_bits(component), variable_bytes(component)
            component.step(duration, **inputs)
    assert state_bits(component) == before
    assert variable_bytes(component) == observed
    error = caught.value
    assert error.variable in component.variables
    assert error.variable in str(error)
    assert component.time <= error.time <= component.time + duration * (1 + 1e-12)
    assert error.index is None or 0 <= error.index < component.variables[error.variable].shape[0]
    assert not abs(error.value) <= error.limit
    if watched:
        assert watcher.calls[-1] == "StepError"
    component.reset()
    fresh = example.make_variant({**example.parameters, **parameters})
    assert state_bits(component) == state_bits(fresh)


@on_three_components
def test_an_observer_that_fails_undoes_the_step(example: Example) -> None:
    class Broken(Watcher):
        def on_sample(self, component: Component) -> None:
            raise OSError("no space left")

    component = example.make_started()
    drive_component(component, example, 10)
    broken = Broken(5)
    component.observe(broken)
    before = state_bits(component)
    with pytest.raises(OSError, match="no space left"):
        component.step(20 * component.step_size)
    assert state_bits(component) == before
    component.ignore(broken)
    component.step(20 * component.step_size)


@on_three_components
@pytest.mark.parametrize("watched", [False, True])
def test_an_interrupt_undoes_the_step(example: Example, watched: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    component = example.make_started()
    if watched:
        component.observe(Watcher(1000))
    drive_component(component, example, 10)
    before, advance = state_bits(component), component._advance_state

    def interrupted(ticks: int) -> int:
        advance(ticks)
        raise KeyboardInterrupt

    monkeypatch.setattr(component, "_advance_state", interrupted)
    with pytest.raises(KeyboardInterrupt):
        component.step(5 * component.step_size, **example.inputs)
    assert state_bits(component) == before
