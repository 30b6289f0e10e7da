"""Results of verification: "identical" only for a closed, replayed log; otherwise the differences or missing parts."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.recording_helpers import CHAIN, chain_log, change_arrays, oscillator_log, rewrite_log

import granular_env.components.catalogue as catalogue
from granular_env.cli import main
from granular_env.components.errors import StepError
from granular_env.components.snapshot import Snapshot
from granular_env.recording import open_log, record, verify
from granular_env.recording.records import KEY, SNAPSHOTS, START, STEPS, Record


def said(path: Path, capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    """Return the exit status and output of the command."""
    capsys.readouterr()
    status = main(["replay", str(path), "--verify"])
    return status, capsys.readouterr().out


# -- complete or not ---------------------------------------------------------------------------------------------------


def test_a_complete_log_is_identical(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    oscillator_log(tmp_path / "a.mcap")
    log, result = open_log(tmp_path / "a.mcap"), verify(tmp_path / "a.mcap")
    instants = len(np.unique(log.ticks("velocity")))
    assert result.identical and bool(result) and result.frames == instants
    assert (result.calls, result.ticks) == (62, 260) == (log.calls, log.end_tick)
    status, text = said(tmp_path / "a.mcap", capsys)
    assert status == 0 and text.startswith(f"identical: 62 calls of step, 260 ticks ({instants} frames, ")


def test_a_log_that_was_not_closed_is_incomplete(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    oscillator_log(tmp_path / "a.mcap")
    data = (tmp_path / "a.mcap").read_bytes()
    (tmp_path / "b.mcap").write_bytes(data[:-60])
    result = verify(tmp_path / "b.mcap")
    assert result.outcome == "incomplete" and not result.identical and not result and result.calls == 62
    status, text = said(tmp_path / "b.mcap", capsys)
    assert status == 3 and text.startswith("incomplete: ") and "was not closed" in text and "identical" not in text


def test_a_log_of_which_only_the_start_is_left_was_not_compared(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    oscillator_log(tmp_path / "a.mcap")
    whole = open_log(tmp_path / "a.mcap")
    offset, length = whole.container.places[0]
    (tmp_path / "b.mcap").write_bytes((tmp_path / "a.mcap").read_bytes()[: offset + length + 40])
    result = verify(tmp_path / "b.mcap")
    assert result.outcome == "nothing was compared" and not result.identical and result.ticks == 0
    status, text = said(tmp_path / "b.mcap", capsys)
    assert status == 3 and "nothing was compared" in text and "identical" not in text


# -- comparisons -------------------------------------------------------------------------------------------------------


def test_incidents_that_cannot_be_compared_are_named(tmp_path: Path) -> None:
    """A failed step does not change the run after it, so a replay cannot detect whether it happened."""
    component = catalogue.make("chain", grains=8)
    with record(component, tmp_path / "a.mcap", every=1e-6):
        component.step(1e-5)
        with pytest.raises(StepError):
            component.step(1e-4, left_force=1e9)
    result = verify(tmp_path / "a.mcap")
    assert result.identical and result.incidents == ["failed"]
    assert "not compared: incidents of the recording (failed)" in result.message
    chain_log(tmp_path / "b.mcap")
    assert "incidents" not in verify(tmp_path / "b.mcap").message


def test_a_run_with_failed_and_empty_histories_is_identical(tmp_path: Path) -> None:
    """Resets without a step, a failed step, and a failed step with written parts: the preview is recreated."""
    component = catalogue.make("chain", **CHAIN)
    h = component.step_size
    with record(component, tmp_path / "a.mcap", every=h):
        component.reset(velocity={0: 1.0})
        time.sleep(0.2)
        component.reset(velocity={0: 2.0})
        component.step(90 * h)
        with pytest.raises(ArithmeticError):
            component.step(3000 * h, left_force=1e9)
        component.step(200 * h)
        component.reset(velocity={0: 0.5})
    result = verify(tmp_path / "a.mcap")
    assert result.identical, result.message
    assert result.ticks == 290


# -- messages ----------------------------------------------------------------------------------------------------------


def test_a_difference_is_told_once_in_one_vocabulary(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    chain_log(tmp_path / "a.mcap", steps=20)

    def change(old: Record) -> Record:
        if old.kind != STEPS or old.first > 0:
            return old
        values = old.arrays["0.values"].copy()
        values[0] += 1.0
        return change_arrays(old, **{"0.values": values})

    rewrite_log(tmp_path / "a.mcap", tmp_path / "b.mcap", change)
    status, text = said(tmp_path / "b.mcap", capsys)
    lines = text.splitlines()
    assert status == 1 and lines[0].startswith("different: ") and len(lines) == len(set(lines))
    assert "displacement[0] differs between 0 s and" in text and "tick" in text
    assert "internal step" not in text and " steps" not in text
    assert " steps" not in repr(open_log(tmp_path / "a.mcap")) + repr(verify(tmp_path / "a.mcap"))


def _with_other_snapshot(why: int) -> Callable[[Record], Record]:
    def change(old: Record) -> Record:
        if old.kind != SNAPSHOTS or old.detail != why:
            return old
        snapshot = Snapshot.from_bytes(old.arrays["snapshot"].tobytes())
        memory = snapshot.memory.copy()
        words = memory.view(np.int64)
        if not words.any():  # frames of the start before the reset, if they were written in time
            return old
        words[np.flatnonzero(words)[0]] ^= 1
        other = Snapshot(snapshot.identity, snapshot.tick, memory.tobytes(), snapshot.inputs)
        return change_arrays(old, snapshot=np.frombuffer(other.to_bytes(), dtype=np.uint8))

    return change


def test_a_changed_start_state_is_found_at_the_start(tmp_path: Path) -> None:
    oscillator_log(tmp_path / "a.mcap")
    rewrite_log(tmp_path / "a.mcap", tmp_path / "b.mcap", _with_other_snapshot(START))
    assert "position differs at 0 s (tick 0)" in verify(tmp_path / "b.mcap").message


def test_a_changed_snapshot_is_called_that(tmp_path: Path) -> None:
    oscillator_log(tmp_path / "a.mcap", snapshot_every=0.5)
    rewrite_log(tmp_path / "a.mcap", tmp_path / "b.mcap", _with_other_snapshot(KEY))
    result = verify(tmp_path / "b.mcap")
    assert not result.identical and "the snapshot at " in result.message


def test_warnings_of_the_re_run_are_notes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    component = catalogue.make("chain", **CHAIN, integrator="hamming", step_size=1e-6)
    with pytest.warns(UserWarning), record(component, tmp_path / "a.mcap"):
        component.reset(velocity={0: 5.0})
        component.step(1e-4)
    capsys.readouterr()
    assert main(["replay", str(tmp_path / "a.mcap"), "--verify"]) == 0
    output = capsys.readouterr()
    assert "note: " in output.out and "GranularWarning" not in output.err
