"""Interrupts at every place of a step and its record: no step is lost, and what is lost is told."""

from __future__ import annotations

import linecache
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Any

import pytest
from support.conformance_tools import bits

from granular_env.components.component import Component
from granular_env.components.discs import Discs
from granular_env.components.oscillator import Oscillator
from granular_env.recording import open_log, record, verify
from granular_env.recording.recorder.recorder import Recorder
from granular_env.recording.recorder.recorder import _close_all as close_all
from granular_env.viewing.reports.run_incidents import incident_sentences

_FILES = ("components/stepping.py", "components/undo.py", "recorder/recorder.py", "recorder/history_items.py")
_RECORDER_FILES = ("recorder/recorder.py", "recorder/history_items.py")
# No signal's handler runs before this line when the block ends: Python lets it in after calls and at the ends of loops only.
_BLOCK = "with self._lock:"


def interrupt_at(place: int, function: Callable[[], Any], files: tuple[str, ...] = _FILES) -> bool:
    """Call a function, interrupted where it begins that many-th line of these files; return whether it had so many."""
    left = [place]

    def trace(frame: FrameType, event: str, argument: object) -> Any:
        if not frame.f_code.co_filename.endswith(files):
            return None
        if event == "line" and linecache.getline(frame.f_code.co_filename, frame.f_lineno).strip() != _BLOCK:
            left[0] -= 1
            if left[0] < 0:
                sys.settrace(None)
                raise KeyboardInterrupt
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        function()
    except KeyboardInterrupt:
        return True
    finally:
        sys.settrace(before)
    return False


@pytest.mark.parametrize("make", [lambda: Oscillator(step_size=0.01), Discs], ids=["oscillator", "discs"])
def test_an_interrupt_at_any_line_of_a_recorded_step_loses_no_step(make: Callable[[], Component], tmp_path: Path) -> None:
    component = make()
    h, place = component.step_size, 0
    with record(component, tmp_path / "a.mcap", every=2 * h, hash_every=3):
        component.step(h, force=1.0)
        while interrupt_at(place, partial(component.step, 3 * h, force=0.5 + place)):
            place += 1
        before = component.tick
        component.step(h)
    assert place > 60
    log = open_log(tmp_path / "a.mcap")
    assert log.end_tick == component.tick == before + 1 and len(log.segments) == 1
    assert {incident["incident"] for incident in log.incidents} == {"interrupted"}
    (segment,) = log.segments
    assert log.snapshot(segment, segment.end).data == component.save().data
    assert verify(log).identical


@pytest.mark.parametrize("make", [lambda: Oscillator(step_size=0.01), Discs], ids=["oscillator", "discs"])
def test_an_interrupt_of_a_step_without_a_frame_loses_no_step(make: Callable[[], Component], tmp_path: Path) -> None:
    """Such steps are noted in another way: the first begins a list of them, the others go on with it."""
    component = make()
    h, place = component.step_size, 0
    with record(component, tmp_path / "a.mcap", every=1000 * h):
        while interrupt_at(place, partial(component.step, h, force=0.5 + place), _RECORDER_FILES):
            place += 1
        before = component.tick
        component.step(2 * h)
    assert place > 5
    log = open_log(tmp_path / "a.mcap")
    assert log.end_tick == component.tick == before + 2 and len(log.segments) == 1
    assert verify(log).identical


@pytest.mark.parametrize("call", ["reset", "restore"])
def test_an_interrupted_reset_is_a_new_segment(call: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the tick is the same as before, nothing else would tell."""
    component = Oscillator(step_size=0.01)
    component.step(0.01)
    other = component.save()
    component.reset()
    on_reset, cut = Recorder.on_reset, [True]

    def interrupt_once(self: Recorder, component: Component) -> None:
        if cut.pop() if cut else False:
            raise KeyboardInterrupt
        on_reset(self, component)

    with record(component, tmp_path / "a.mcap"):
        component.step(0.01, force=1.0)
        monkeypatch.setattr(Recorder, "on_reset", interrupt_once)
        with pytest.raises(KeyboardInterrupt):
            component.reset(position=2.0) if call == "reset" else component.restore(other)
        component.step(0.01, force=1.0)
    log = open_log(tmp_path / "a.mcap")
    assert len(log.segments) == 2 and verify(log).identical


def test_steps_that_are_not_recorded_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two interrupts in the same instant: the one that tells of a step once more is cut as well."""
    component = Oscillator(step_size=0.01)
    on_step, cuts = Recorder.on_step, [True, True]

    def cut(self: Recorder, *arguments: Any) -> None:
        if cuts:
            cuts.pop()
            raise KeyboardInterrupt
        on_step(self, *arguments)

    with record(component, tmp_path / "a.mcap"):
        component.step(0.05, force=1.0)
        monkeypatch.setattr(Recorder, "on_step", cut)
        with pytest.raises(KeyboardInterrupt):
            component.step(0.02, force=2.0)
        component.step(0.02)
        component.step(0.03)
        component.step(0.04)
    log = open_log(tmp_path / "a.mcap")
    (incident,) = log.incidents
    told = "what happened between 0.05 s and 0.09 s of the component's time is not in the log"
    assert (incident["incident"], incident["message"]) == ("unrecorded", told)
    assert [(segment.start, segment.end) for segment in log.segments] == [(0, 5), (9, 16)]
    segment = log.segments[-1]
    assert log.snapshot(segment, segment.end).data == component.save().data
    found = verify(log)
    assert found.identical and found.gaps == [told] and told in found.message
    assert incident_sentences(log)[0] == f"Steps are missing: {told}."


def test_a_part_that_its_owner_has_stepped_is_told(tmp_path: Path) -> None:
    component = Oscillator(step_size=0.01)
    with record(component, tmp_path / "a.mcap"):
        component.step(0.02)
        component.adopt(7, {})
    assert [incident["incident"] for incident in open_log(tmp_path / "a.mcap").incidents] == ["unrecorded"]


def test_a_gap_before_a_long_step_is_no_step(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("granular_env.recording.recorder.recorder._WAKE_BYTES", 0)
    component = Oscillator(step_size=0.01)
    with record(component, tmp_path / "a.mcap", every=0.05):
        component.step(0.03, force=1.0)
        component.adopt(7, {})
        component.step(0.2)
    log = open_log(tmp_path / "a.mcap")
    assert [(segment.start, segment.end) for segment in log.segments] == [(0, 3), (10, 27)]
    assert len(log.incidents) == 1 and verify(log).identical


def test_observers_that_count_know_from_the_tick_which_steps_they_have() -> None:
    """A step that was made before the interrupt stands, and the others are told of it once."""

    class Counter:
        def __init__(self) -> None:
            self.next_tick, self.ticks = 1 << 60, list[int]()

        def on_reset(self, component: Component) -> None: ...
        def on_sample(self, component: Component) -> None: ...
        def on_failure(self, component: Component, error: BaseException) -> None: ...
        def on_step(self, component: Component, ticks: int, inputs: object) -> None:
            self.ticks.append(component.tick)

    class Interrupted(Counter):
        def on_step(self, component: Component, ticks: int, inputs: object) -> None:
            super().on_step(component, ticks, inputs)
            raise KeyboardInterrupt

    component, first, second = Discs(), Interrupted(), Counter()
    for observer in (first, second):
        component.observe(observer)
    with pytest.raises(KeyboardInterrupt):
        component.step(3 * component.step_size)
    before = bits(component)
    assert component.tick == 3 and first.ticks == [3, 3] and second.ticks == [3] and before == bits(component)


def test_an_interrupt_at_any_line_of_closing_a_log_leaves_it_to_the_end_of_the_program(tmp_path: Path) -> None:
    """As a second Ctrl-C does, while the first one's log is being completed."""
    place, is_left = 0, True
    while is_left:
        component = Oscillator()
        recorder = record(component, tmp_path / f"{place}.mcap", every=0.1)
        component.step(1.0, force=0.2)
        is_left = interrupt_at(place, recorder.close, _RECORDER_FILES)
        close_all()
        assert verify(tmp_path / f"{place}.mcap").identical
        assert len(open_log(tmp_path / f"{place}.mcap").series("position")[0]) == 11
        place += 1
    assert place > 10
