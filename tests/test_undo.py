"""A step that fails leaves what was there before it: by a copy, or by an older copy and the steps made since."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest
from support.component_examples import Example
from support.conformance_tools import bits, every_example

from granular_env.components import stepping, undo
from granular_env.components.component import Component
from granular_env.components.discs import Discs
from granular_env.components.errors import GranularError, ParameterError
from granular_env.components.oscillator import Oscillator
from granular_env.components.profiles import Profile
from granular_env.components.state_block import Block


class Interrupter:
    """An observer that raises at a tick."""

    def __init__(self, tick: int, error: type[BaseException] = RuntimeError) -> None:
        self.next_tick, self.error = tick, error

    def on_reset(self, component: Any) -> None: ...

    def on_sample(self, component: Any) -> None:
        raise self.error

    def on_step(self, component: Any, ticks: int, inputs: Any) -> None: ...

    def on_failure(self, component: Any, error: BaseException) -> None: ...


@pytest.fixture
def one_copy(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every state counts as a large one, of which no second copy is ever due."""
    monkeypatch.setattr(undo, "_SMALL_STATE", 0)
    monkeypatch.setattr(undo, "_SHARE", 0.0)
    monkeypatch.setattr(undo, "_MOST_ARRAYS", 1e9)


def interrupted(component: Component, ticks: int) -> None:
    """Begin a step that fails half way."""
    observer = Interrupter(component.tick + max(ticks // 2, 1))
    component.observe(observer)
    with pytest.raises(RuntimeError):
        component.step(ticks * component.step_size)
    component.ignore(observer)


@every_example
def test_steps_are_made_again_bit_for_bit(one_copy: None, example: Example) -> None:
    component, twin = example.started(), example.started()
    halved = {name: 0.5 * np.asarray(value) for name, value in example.inputs.items()}
    profiles = example.all_profiles(component)
    for ticks, inputs in ((3, example.inputs), (1, {}), (2, halved), (4, profiles), (1, {}), (2, example.inputs)):
        for one in (component, twin):
            one.step(ticks * one.step_size, **inputs)
    assert len(component._undo.steps) == 6
    interrupted(component, 4)
    assert bits(component) == bits(twin)
    for one in (component, twin):
        one.step(3 * one.step_size, **halved)
    interrupted(component, 2)
    assert bits(component) == bits(twin)
    assert component.events() == twin.events()


def test_what_changes_a_state_beside_steps_is_not_undone(one_copy: None) -> None:
    component = Discs()
    component.step(5e-5, force=1.0)
    earlier = component.save()
    component.step(5e-5)
    component.restore(earlier)
    interrupted(component, 4)
    assert component.save().to_bytes() == earlier.to_bytes()
    component.reset(velocity=[1.0, 0.0])
    start = component.save()
    interrupted(component, 4)
    assert component.save().to_bytes() == start.to_bytes()


def test_a_restore_is_a_copy(one_copy: None, monkeypatch: pytest.MonkeyPatch) -> None:
    component, twin = Discs(), Discs()
    component.step(5e-5, force=1.0)
    earlier = component.save()
    component.step(5e-5)
    component.restore(earlier)

    def refuse(self: undo.Undo) -> None:
        raise AssertionError("no further copy is needed")

    monkeypatch.setattr(undo.Undo, "_copy", refuse)
    component.step(5e-5, force=0.5)
    interrupted(component, 4)
    monkeypatch.undo()
    twin.step(5e-5, force=1.0)
    twin.step(5e-5, force=0.5)
    assert bits(component) == bits(twin)


def test_a_reset_that_fails_leaves_the_phase_as_it_was(one_copy: None) -> None:
    component = Discs()
    interrupted(component, 4)
    assert component.phase == "failed"
    with pytest.raises(ParameterError, match="finite"):
        component.reset(velocity=[1e200, 0.0])
    assert component.phase == "failed"


def test_an_array_that_is_held_on_counts_once() -> None:
    noted, force = undo.Undo(Block(position=("f8", (8,))), is_shared=False), np.zeros(100)
    for number in range(5):
        noted.note(1, {"force": force, "pull": float(number)})
    assert noted._array_bytes == force.nbytes


def test_memory_that_others_own_is_copied_at_each_step(one_copy: None) -> None:
    memory = np.zeros_like(Oscillator().memory)
    component = Oscillator(memory=memory)
    component.step(0.1)
    component._block["position"][...] = 0.25  # as the owner of the memory may
    interrupted(component, 4)
    assert component.get("position") == 0.25


def test_interrupts_do_not_cut_the_undo(one_copy: None, monkeypatch: pytest.MonkeyPatch) -> None:
    component = Discs()
    for _ in range(5):
        component.step(2e-5, force=1.0)
    before, advance, calls = bits(component), Discs._advance, []

    def advance_with_interrupts(self: Discs, ticks: int) -> int:
        calls.append(ticks)
        if len(calls) in (1, 4):
            raise KeyboardInterrupt
        return advance(self, ticks)

    monkeypatch.setattr(Discs, "_advance", advance_with_interrupts)
    with pytest.raises(KeyboardInterrupt):
        component.step(3e-5)
    # The step, two of the five that are made again, then all five.
    assert calls == [3, 2, 2, 2, 2, 2, 2, 2, 2]
    assert bits(component) == before


@pytest.mark.parametrize("error", [KeyboardInterrupt, TimeoutError, SystemExit])
@pytest.mark.parametrize("is_noted", [False, True])
def test_a_step_whose_note_is_cut_is_not_forgotten(
    one_copy: None, monkeypatch: pytest.MonkeyPatch, error: type[BaseException], is_noted: bool
) -> None:
    component, note = Discs(), undo.Undo.note
    component.step(2e-5, force=1.0)

    def cut(self: undo.Undo, *arguments: Any) -> None:
        if is_noted:
            self.steps.append(arguments)
        raise error

    monkeypatch.setattr(undo.Undo, "note", cut)
    with pytest.raises(error):
        component.step(2e-5)
    monkeypatch.setattr(undo.Undo, "note", note)
    assert component.tick == 4
    before = bits(component)
    interrupted(component, 4)
    assert bits(component) == before


def test_a_copy_that_fails_changes_nothing(one_copy: None, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(self: undo.Undo) -> None:
        raise MemoryError

    component = Discs()
    monkeypatch.setattr(undo.Undo, "_copy", fail)
    before = bits(component)
    with pytest.raises(MemoryError):
        component.step(2e-5, force=1.0)
    assert bits(component) == before and not component.held_inputs["force"].any()


def test_what_is_no_observer_is_refused_and_does_not_stay() -> None:
    component = Discs()
    with pytest.raises(
        ParameterError, match="observer: got 3; expected what `observer.Observer` describes|observer: got 3, expected"
    ):
        component.observe(3)  # type: ignore[arg-type]
    component.step(2e-5)


def test_the_undo_is_begun_anew_whatever_interrupts_it(one_copy: None, monkeypatch: pytest.MonkeyPatch) -> None:
    component = Discs()
    for _ in range(5):
        component.step(2e-5, force=1.0)
    before, advance, calls = bits(component), Discs._advance, [0]

    def advance_with_faults(self: Discs, ticks: int) -> int:
        calls[0] += 1
        if calls[0] in (1, 3, 9):
            raise TimeoutError
        return advance(self, ticks)

    monkeypatch.setattr(Discs, "_advance", advance_with_faults)
    with pytest.raises(TimeoutError):
        component.step(3e-5)
    assert bits(component) == before and component.phase == "failed"


def test_a_state_that_cannot_be_put_back_is_told(one_copy: None, monkeypatch: pytest.MonkeyPatch) -> None:
    component = Discs()
    component.step(2e-5, force=1.0)
    calls, told = [], "could not be put back to 2e-05 s, where a step failed .StepError.*a step that was made before fails now"

    def fail(self: Discs, ticks: int) -> int:
        calls.append(ticks)
        return 1

    monkeypatch.setattr(Discs, "_advance", fail)
    with pytest.raises(GranularError, match=told) as caught:
        component.step(3e-5)
    # It stays at the copy, says so, and does not try for ever.
    assert component.phase == "failed" and component.tick == 0 and "it is at 0 s" in str(caught.value) and len(calls) == 4
    monkeypatch.undo()
    component.reset()
    component.step(2e-5)
    assert component.phase == "ready"


@pytest.mark.parametrize(("copy", "step"), [(1e-3, 1e-3), (1e-3, 1e-6), (0.2, 1e-3), (1e-6, 1.0)])
def test_copies_of_a_large_state_cost_little(monkeypatch: pytest.MonkeyPatch, copy: float, step: float) -> None:
    """Whatever a copy and a step take, by a clock of the test's own, copies are a fortieth of a run at most."""
    clock, copies, looks = [0.0], [0], [0]

    def look() -> float:
        looks[0] += 1
        return clock[0]

    class Heavy(Oscillator):
        def _advance(self, ticks: int) -> int:
            clock[0] += step * ticks
            return super()._advance(ticks)

    monkeypatch.setattr(undo, "_SMALL_STATE", 0)
    monkeypatch.setattr(undo, "perf_counter", look)
    monkeypatch.setattr(stepping, "perf_counter", lambda: clock[0])
    component = Heavy()
    take = undo.Undo._copy

    def copy_slowly(self: undo.Undo) -> None:
        clock[0] += copy
        copies[0] += 1
        take(self)

    monkeypatch.setattr(undo.Undo, "_copy", copy_slowly)
    for _ in range(5000):
        component.step()
    assert copies[0] >= 1
    assert (copies[0] - 1) * copy <= 0.025 * clock[0]
    # Two looks at the clock for each copy; between two copies a few, however many steps there are.
    assert looks[0] - 2 * copies[0] <= 30 + 2 * copies[0]


def test_arrays_that_are_held_do_not_pile_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(undo, "_SHARE", 0.0)
    component = Discs(rows=8, columns=8)
    for number in range(40):
        component.step(force=np.full((64, 2), float(number)))
        held = sum(inputs["force"].nbytes for _, inputs in component._undo.steps)
        assert held <= (undo._MOST_ARRAYS + 1) * component.state_bytes
    component.reset()
    for number in range(40):
        component.step(force=Profile.constant(float(number)) * np.ones((64, 2)))
        assert len(component._undo.steps) <= (undo._MOST_ARRAYS + 1) * component.state_bytes // (64 * 2 * 8)


def test_of_a_large_state_that_grows_there_is_one_copy_at_a_time() -> None:
    block = Block(growing={"rows": ("f8", (2,))}, fixed=("f8", (1_000_000,)))
    kept = undo.Undo(block, is_shared=True)
    tracemalloc.start()
    try:
        kept.prepare(0)
        buffer = kept.buffer
        kept.prepare(1)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert kept.until == 1 and kept.buffer is buffer and peak < 1.1 * block.nbytes


def test_a_state_that_grows_is_put_back_with_its_rows() -> None:
    block = Block(growing={"rows": ("f8", (2,)), "none": ("f8", ())}, fixed=("f8", (1000,)))
    block["fixed"] = 3.0
    block.append("rows", [1.0, 2.0])
    kept, before = undo.Undo(block, is_shared=False), block.to_bytes()
    kept.prepare(0)
    block["fixed"] = 4.0
    for _ in range(40):
        block.append("rows", [5.0, 6.0])
        block.append("none", 7.0)
    kept.load()
    assert block.to_bytes() == before and block.count("rows") == 1 and block.count("none") == 0
