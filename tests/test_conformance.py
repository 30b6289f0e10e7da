"""Tests of the contract for every component of the catalogue.

The drives are in support/component_examples.py; a new component needs an entry there. Refusals are in
test_conformance_refusals.py.
"""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.component_examples import EXAMPLES, Example, load_examples
from support.conformance_tools import (
    CALL_TICKS,
    Watcher,
    drive_component,
    every_example,
    growing_load,
    load_until_refused,
    on_three_components,
    state_bits,
    variable_bytes,
)
from support.declarations import check_declarations

from granular_env.components import catalogue
from granular_env.components.component import Component
from granular_env.components.drawables import element_count
from granular_env.components.errors import GranularError, StepError
from granular_env.components.snapshot import Snapshot
from granular_env.recording import record, verify
from granular_env.recording.drawables import drawable_facts, parse_drawables

ROOT = Path(__file__).resolve().parent.parent


# -- descriptions -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", catalogue.component_names())
def test_every_component_has_an_example(name: str) -> None:
    assert load_examples(name), f"add an entry for {name!r} to tests/support/component_examples.py"


@every_example
def test_declarations_fit_together(example: Example) -> None:
    component = example.make()
    check_declarations(component)
    for name, field in component.Parameters.model_fields.items():
        assert field.description, f"parameter {name} has no description"
        assert isinstance(field.json_schema_extra, dict) and field.json_schema_extra.get("unit"), f"parameter {name}: no unit"
    assert any(variable.state for variable in component.variables.values())
    facts, arrays = drawable_facts(component.drawables())
    assert len(parse_drawables(facts, arrays, component.variables)) == len(component.drawables()), "a log can hold them"


@every_example
def test_state_variables_can_be_started(example: Example) -> None:
    component = example.make()
    for variable in component.variables.values():
        if variable.state:
            value = 0.5 * np.asarray(component.get(variable.name))
            component.reset(**{variable.name: value})
            np.testing.assert_array_equal(component.get(variable.name), value)


@every_example
def test_report_and_cautions_can_be_read_at_any_time(example: Example) -> None:
    component = example.make_started()
    for _ in range(2):
        assert all(isinstance(name, str) and isinstance(value, float) for name, value in component.report().items())
        assert all(isinstance(text, str) and text for text in [*component.cautions(), *component.conclusions()])
        drive_component(component, example, example.ticks)


# -- reset, get, inputs -----------------------------------------------------------------------------------------------


@every_example
def test_reset_and_restore_leave_nothing_behind(example: Example) -> None:
    """The history of a component, even beyond its limits, changes neither its bits nor its messages."""
    fresh, used, restored = example.make_started(), example.make_started(), example.make_started()
    drive_component(used, example, example.ticks)
    assert state_bits(used) != state_bits(fresh)
    for component in (used, restored):
        load_until_refused(component, example)
    used.reset(**example.start)
    restored.restore(fresh.save())
    assert_same([fresh, used, restored])
    for component in (fresh, used, restored):
        drive_component(component, example, example.ticks)
    assert_same([fresh, used, restored])
    load_until_refused(restored, example)
    restored.restore(used.save())
    assert_same([used, restored])


def assert_same(components: list[Component]) -> None:
    """Compare the bits, reports and messages of components."""
    first = components[0]
    for other in components[1:]:
        assert state_bits(other) == state_bits(first)
        assert variable_bytes(other) == variable_bytes(first)
        assert other.report() == first.report()
        assert (other.cautions(), other.conclusions()) == (first.cautions(), first.conclusions())


@pytest.mark.parametrize("example", [e for e in EXAMPLES if e.breaks], ids=lambda example: example.label)
def test_a_refusal_depends_on_the_state_alone(example: Example, tmp_path: Path) -> None:
    """Used, new, copied, restored and replayed components refuse the same call from the same state with the same message."""
    assert example.breaks is not None
    parameters, start, _ = example.breaks
    fresh, used, restored = (example.make_variant({**example.parameters, **parameters}) for _ in range(3))
    for component in (fresh, used):
        component.reset(**start)
    for component in (used, restored):
        load_until_refused(component, example)
    used.reset(**start)
    restored.restore(fresh.save())
    with record(used, tmp_path / "used.mcap", every=CALL_TICKS * used.step_size):
        refused = load_until_refused(used, example)
    assert refused[1], "the load grows until the component refuses it"
    assert [load_until_refused(component, example) for component in (fresh, restored)] == [refused, refused]
    assert_same([used, fresh, restored])
    assert not refused[0] or verify(tmp_path / "used.mcap").identical
    # Copies of a used component in the middle of a run.
    used.reset(**start)
    load_until_refused(used, example, last=refused[0] // 2)
    copies = [copy.deepcopy(used), pickle.loads(pickle.dumps(used)), used]
    assert_same(copies)
    assert [load_until_refused(one, example, first=refused[0] // 2) for one in copies] == [refused] * 3
    assert_same([fresh, *copies])
    with pytest.raises(StepError):  # a call is refused if one of its ticks is
        for _ in range(CALL_TICKS):
            used.step(**growing_load(example, refused[0]))


@on_three_components
def test_get_gives_copies(example: Example) -> None:
    component = example.make_started()
    drive_component(component, example, 20)
    before, snapshot = variable_bytes(component), state_bits(component)
    for name, variable in component.variables.items():
        value = component.get(name)
        if isinstance(value, np.ndarray):
            value[...] = 1.0 if variable.dtype != "float64" else -123.456
        elif isinstance(value, list):
            value.insert(0, None)
            assert component.get(name)[:1] != [None]
    assert variable_bytes(component) == before
    assert state_bits(component) == snapshot


@on_three_components
def test_inputs_persist_and_reset_brings_their_start_back(example: Example) -> None:
    component = example.make_started()
    starts = {name: component.get(name) for name in example.inputs}
    component.step(None, **example.inputs)
    component.step()
    for name, value in example.inputs.items():
        np.testing.assert_array_equal(component.get(name), value)
    again = example.make_started()
    for _ in range(2):
        again.step(None, **example.inputs)
    assert state_bits(again) == state_bits(component)
    component.reset(**example.start)
    for name, value in starts.items():
        np.testing.assert_array_equal(component.get(name), value)


@on_three_components
def test_a_profile_is_read_at_the_present_time(example: Example) -> None:
    component = example.make_started()
    profiles = example.all_profiles(component)
    component.step(None, **profiles)
    for _ in range(30):
        for name, profile in profiles.items():
            # Both evaluate the same polynomial, in seconds and in ticks, and differ by the rounding of the coefficients.
            assert component.get(name) == pytest.approx(profile(component.time), rel=1e-12, abs=1e-12)
        component.step()


# -- determinism ------------------------------------------------------------------------------------------------------

_ELSEWHERE = """
import pickle, sys
sys.path.insert(0, sys.argv[1])
from support.component_examples import EXAMPLES
from support.conformance_tools import drive_component
from granular_env.components.snapshot import Snapshot
from granular_env.recording import record, verify
from granular_env.recording.drawables import drawable_facts, parse_drawables
sent, answers = pickle.load(sys.stdin.buffer), {}
for example in EXAMPLES:
    driven, continued = example.make_started(), example.make()
    drive_component(driven, example, example.ticks)
    continued.restore(Snapshot.from_bytes(sent[example.label]))
    for _ in range(example.ticks):
        continued.step()
    answers[example.label] = driven.save().to_bytes(), continued.save().to_bytes()
sys.stdout.buffer.write(pickle.dumps(answers))
"""


def halfway(example: Example) -> Component:
    """Return an example in the middle of its mixed drive."""
    component = example.make_started()
    drive_component(component, example, example.ticks // 2 + 1)
    return component


@pytest.fixture(scope="module")
def elsewhere() -> dict[str, tuple[bytes, bytes]]:
    """Return the results of a new process for every example: driven from the start, and continued from halfway."""
    sent = pickle.dumps({example.label: state_bits(halfway(example)) for example in EXAMPLES})
    command = [sys.executable, "-c", _ELSEWHERE, str(ROOT / "tests")]
    return pickle.loads(subprocess.run(command, input=sent, capture_output=True, check=True, cwd=ROOT).stdout)


@every_example
def test_another_process_gives_the_same_bits(example: Example, elsewhere: dict[str, tuple[bytes, bytes]]) -> None:
    here = example.make_started()
    drive_component(here, example, example.ticks)
    assert elsewhere[example.label][0] == state_bits(here)


@every_example
def test_another_process_goes_on_from_a_snapshot(example: Example, elsewhere: dict[str, tuple[bytes, bytes]]) -> None:
    here = halfway(example)
    for _ in range(example.ticks):
        here.step()
    assert elsewhere[example.label][1] == state_bits(here)


@every_example
def test_save_and_restore_at_every_step(example: Example) -> None:
    straight, hopping, other = example.make_started(), example.make_started(), example.make()
    drive_component(straight, example, example.ticks)
    original_step = hopping.step

    def step_in_the_other(duration: float | None = None, **inputs: float) -> None:
        """Let another component, restored from bytes, make the step."""
        other.restore(Snapshot.from_bytes(hopping.save().to_bytes()))
        other.step(duration, **inputs)
        original_step(1.0 * hopping.step_size)  # a step that the restore must undo
        hopping.restore(other.save())

    vars(hopping)["step"] = step_in_the_other
    drive_component(hopping, example, example.ticks)
    assert state_bits(hopping) == state_bits(straight)
    assert variable_bytes(hopping) == variable_bytes(straight)
    assert hopping.report() == straight.report()


@cache
def twins(label: str) -> tuple[Component, Component]:
    """Return two components of an example, cached."""
    example = next(example for example in EXAMPLES if example.label == label)
    return example.make(), example.make()


@contextmanager
def watched(component: Component, every: int | None) -> Iterator[None]:
    """Attach an observer that reads all variables every `every` ticks (none for None) within the block."""
    watcher = Watcher(every or 1)
    if every is not None:
        component.observe(watcher)
    try:
        yield
    finally:
        component.ignore(watcher)


@every_example
@settings(max_examples=6)
@given(data=st.data())
def test_a_long_step_equals_its_parts(example: Example, data: st.DataObject) -> None:
    parts = data.draw(st.lists(st.integers(1, 60), min_size=1, max_size=8), label="parts")
    whole, cut = twins(example.label)
    for component in (whole, cut):
        component.reset(**example.start)
    kinds = {"numbers": dict(example.inputs), "profiles": example.all_profiles(whole)}
    inputs = kinds[data.draw(st.sampled_from(sorted(kinds)), label="inputs")]
    every = data.draw(st.one_of(st.none(), st.integers(1, 50)), label="watched every")
    whole.step(sum(parts) * whole.step_size, **inputs)
    with watched(cut, every):
        for index, part in enumerate(parts):
            cut.step(part * cut.step_size, **(inputs if index == 0 else {}))
    assert state_bits(cut) == state_bits(whole)
    assert cut.report() == whole.report()


@every_example
def test_observers_never_change_the_bits(example: Example) -> None:
    alone = example.make_started()
    drive_component(alone, example, example.ticks)
    alone.step(50 * alone.step_size)
    watched = example.make_started()
    for every in (7, 1000):
        watched.reset(**example.start)
        watcher = Watcher(every)
        watched.observe(watcher)
        drive_component(watched, example, example.ticks)
        watched.step(50 * watched.step_size)
        assert state_bits(watched) == state_bits(alone)
        assert watcher.looks == list(range(every, example.ticks + 51, every))
        assert watcher.calls == ["on_reset", *[1] * example.ticks, 50]
        watched.ignore(watcher)
        watched.step()
        assert len(watcher.calls) == example.ticks + 2


# -- conservation -----------------------------------------------------------------------------------------------------


@every_example
def test_the_balances_close(example: Example) -> None:
    """Each residual stays within its tolerance relative to the largest amount; opposite amounts must not cancel in a sum."""
    component = example.make_started()
    largest: dict[str, float] = {}
    worst: dict[str, float] = {}
    original_step = component.step

    def watched_step(*arguments: float, **inputs: float) -> None:
        original_step(*arguments, **inputs)
        for balance in component.balances():
            amounts = [*balance.stored.values(), *balance.lost.values(), *balance.supplied.values(), balance.initial]
            seen = max(float(np.abs(amount).max()) for amount in amounts)
            seen = max(seen, momentum_scale(component) if balance.quantity == "momentum" else 0.0)
            largest[balance.quantity] = max(largest.get(balance.quantity, 0.0), seen)
            worst[balance.quantity] = max(worst.get(balance.quantity, 0.0), float(np.abs(balance.residual).max()))

    vars(component)["step"] = watched_step
    drive_component(component, example, example.ticks)
    assert largest["energy"] > 0.0
    for quantity, residual in worst.items():
        tolerance = example.energy_tolerance if quantity == "energy" else example.momentum_tolerance
        assert residual <= tolerance * largest[quantity], quantity


def momentum_scale(component: Component) -> float:
    """Return a bound of the sum of |m v|, sqrt(2 m E): opposite motions cancel in the momentum but not in its rounding."""
    mass = np.sum(getattr(component, "geometry", component).mass)
    return float(np.sqrt(2.0 * mass * component.get("kinetic_energy")))


# -- events -----------------------------------------------------------------------------------------------------------


@every_example
def test_events_are_in_order_and_of_known_kinds(example: Example) -> None:
    component = example.make_started()
    assert component.events() == [] and component.event_count == 0
    drive_component(component, example, example.ticks)
    events = component.events()
    assert len(events) == component.event_count == len(component.event_rows())
    assert [event.tick for event in events] == sorted(event.tick for event in events)
    for event in events:
        assert event.kind in component.event_kinds and 1 <= event.tick <= component.tick
    assert not component.event_kinds or events, "the example makes each of its events happen"
    drawn = {one.name: one for one in component.drawables()}
    for kind, detail in component.event_details.items():
        assert kind in component.event_kinds and detail.counts in {"", *drawn}
        if detail.ratio:
            (count,) = component.variables[detail.ratio].shape
            assert detail.counts and count == element_count(drawn[detail.counts])
    component.reset(**example.start)
    assert component.events() == []


# -- the life cycle -----------------------------------------------------------------------------------------------------


class Calling(Watcher):
    """An observer that calls every method in the middle of a step."""

    def on_sample(self, component: Component) -> None:
        for name, call in {
            "step": component.step,
            "reset": component.reset,
            "restore": lambda: component.restore(component.save()),
        }.items():
            with pytest.raises(GranularError, match=f"{name}: .*in the middle of a step"):
                call()
        super().on_sample(component)


@on_three_components
def test_everything_can_be_read_in_the_middle_of_a_step_and_nothing_changed(example: Example) -> None:
    component, alone = example.make_started(), example.make_started()
    component.observe(Calling(2))
    for one in (component, alone):
        one.step(5 * one.step_size, **example.inputs)
    assert state_bits(component) == state_bits(alone)


# -- memory ---------------------------------------------------------------------------------------------------------------


@every_example
def test_a_parent_can_own_the_memory(example: Example) -> None:
    alone = example.make_started()
    whole = np.full((2, *alone.memory.shape), 7.0)
    parts = [example.make_part(whole[0]), alone.clone(whole[1])]
    for component in (alone, *parts):
        component.reset(**example.start)
        drive_component(component, example, example.ticks)
    assert state_bits(parts[0]) == state_bits(alone) == state_bits(parts[1])
    before = state_bits(alone)
    whole[:] = 0.0  # includes the lengths of growing lists
    assert state_bits(parts[0]) == state_bits(parts[1]) != before == state_bits(alone)
    assert parts[0].events() == []


@on_three_components
def test_the_state_can_be_looked_at_without_a_copy(example: Example) -> None:
    component = example.make_started()
    drive_component(component, example, 30)
    assert bytes(component.state_view()) == component.save().data
    assert component.state_bytes == len(component.save().data)
    with pytest.raises(TypeError):
        component.state_view()[0] = 1
