"""Killed or interrupted runs resume from their logs and are bitwise identical to uninterrupted runs."""

from __future__ import annotations

import multiprocessing
import os
import random
import signal
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.recording_helpers import rewrite_log

from granular_env import run_loop
from granular_env.cli import main
from granular_env.components.errors import GranularError, LogError, ParameterError
from granular_env.experiments import load_experiment
from granular_env.log_runs import resume
from granular_env.recording import Log, open_log, recorder, recover, schedule, verify
from granular_env.recording.index import FIRST
from granular_env.recording.records import SNAPSHOTS, Record
from granular_env.recording.recovery import make_continuation
from granular_env.run_loop import RunResult, run

# Each run breaks, flows or is driven by a profile; snapshots are so close that a run passes several.
RUNS: dict[str, tuple[str, dict[str, Any]]] = {
    "chain": (
        "nesterenko-1983/3.3-triangle-100us",
        {"component.grains": 40, "duration": 2e-4, "record.every": 5e-6, "record.snapshot_every": 5e-5},
    ),
    "discs": ("discs/broken-row", {"duration": 0.008, "record.snapshot_every": 2e-3}),
    "coupled": (
        "psakhie-2003/impact-on-a-cracking-core",
        {"component.automata.diameter": 2.5e-3, "record.snapshot_every": 1e-5, "duration": 4.4e-5},
    ),
}
SWING = {
    "name": "swing",
    "duration": 10.0,
    "component": {"type": "oscillator", "stiffness": 4.0},
    "start": {"position": 1.0},
    "input": {"force": {"profile": "triangle", "peak": 1.0, "duration": 0.5}},
    "record": {"every": 0.1, "variables": ["position"], "snapshot_every": 1.0},
}
# Duration of each step of a run [s].
PAUSE = 4e-4


class Slow:
    """An observer that waits, so that the log is written in many parts."""

    next_tick = 2**62

    def __init__(self, seconds: float, interrupt_at: int = 2**62) -> None:
        self.seconds, self.interrupt_at = seconds, interrupt_at

    def on_reset(self, component: Any) -> None:
        pass

    def on_sample(self, component: Any) -> None:
        pass

    def on_step(self, component: Any, ticks: int, inputs: Mapping[str, Any]) -> None:
        time.sleep(self.seconds)
        if component.tick >= self.interrupt_at:
            self.interrupt_at = 2**62
            os.kill(os.getpid(), signal.SIGINT)

    def on_failure(self, component: Any, error: BaseException) -> None:
        pass


@pytest.fixture(autouse=True)
def in_small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the steps short, and write their results immediately."""
    monkeypatch.setattr(run_loop, "_PIECE_SECONDS", 2e-4)
    monkeypatch.setattr(recorder, "_WRITE_SECONDS", 1e-3)


def run_slowly(name: str, log: Path, seconds: float = PAUSE) -> RunResult:
    experiment, overrides = RUNS[name]
    return run(experiment, overrides=overrides, log=log, observers=[Slow(seconds)])


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return the logs of uninterrupted runs, created on demand."""
    folder = tmp_path_factory.mktemp("whole")

    class Logs(dict[str, Path]):
        def __missing__(self, name: str) -> Path:
            path = folder / f"{name}.mcap"
            run_slowly(name, path)
            self[name] = path
            return path

    return Logs()


def assert_same(path: Path, other: Path) -> None:
    """Assert that a resumed log has the same history as another log."""
    assert_same_history(path, other)
    with open_log(path) as log:
        assert log.incidents[-1]["incident"] == "resumed"


def assert_same_history(path: Path, other: Path) -> None:
    """Assert that two logs have equal frames, events, snapshot ticks, final states and reports."""
    with open_log(path) as mine, open_log(other) as theirs:
        assert mine.complete and mine.end_tick == theirs.end_tick
        for name in theirs.variables:
            for here, there in zip(mine.series(name), theirs.series(name), strict=True):
                assert here.tobytes() == there.tobytes(), name
        assert mine.events() == theirs.events()
        assert mine.rows(SNAPSHOTS)[:, FIRST].tolist() == theirs.rows(SNAPSHOTS)[:, FIRST].tolist()
        assert _end_state(mine) == _end_state(theirs)
        assert mine.metadata["report"] == theirs.metadata["report"]
    found = verify(path)
    assert found.identical, found.message


def assert_made_whole(path: Path, other: Path) -> None:
    """Assert that recovery suffices for a run that lacks only the index of its log."""
    again = path.with_name("whole-again.mcap")
    recover(path, again, overwrite=True).close()
    with open_log(again) as mine, open_log(other) as theirs:
        assert mine.complete and mine.end_tick == theirs.end_tick
        assert _end_state(mine) == _end_state(theirs)
    assert verify(again).identical


def _end_state(log: Log) -> bytes:
    segment = log.segments[-1]
    return log.snapshot(segment, segment.end).to_bytes()


# -- kills ------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", RUNS)
def test_a_log_that_ends_anywhere(name: str, whole: dict[str, Path], tmp_path: Path) -> None:
    """A kill leaves the first bytes of the file; the run resumes in a separate log or in the same file."""
    data, chance, resumed = whole[name].read_bytes(), random.Random(name), 0
    with open_log(whole[name]) as log:
        assert log.calls > 10
        assert name == "chain" or log.events()
        end = log.end_tick
    for own in (True, False):
        path = tmp_path / "killed.mcap"
        size = chance.randrange(len(data) // 4, len(data))
        path.write_bytes(data[:size])
        target = tmp_path / "resumed.mcap" if own else path
        result = resume(path, log=tmp_path / "resumed.mcap") if own else resume(path)
        resumed += result.ticks < end
        assert result.log == target
        assert_same(target, whole[name])
        assert not own or path.read_bytes() == data[:size]
    assert resumed


@pytest.mark.parametrize("name", RUNS)
def test_killed_by_the_system(name: str, whole: dict[str, Path], tmp_path: Path) -> None:
    """SIGKILL at a random time, and again during the resumption."""
    path, chance = tmp_path / "killed.mcap", random.Random(name)
    assert whole[name].exists()  # compiles all kernels
    _kill(path, chance.uniform(0.05, 0.4), run_slowly, name, path, 2e-2)
    with open_log(path) as log:
        assert not log.complete and log.end_tick > 0
    _kill(path, chance.uniform(0.0, 0.3), resume, path)
    with open_log(path) as log:
        ended = log.complete
    if not ended:
        resume(path)
    assert_same(path, whole[name])


def _kill(path: Path, after: float, call: Any, *arguments: Any) -> None:
    """Call a function in a separate process, and kill this process some time after the log contains steps."""
    process = multiprocessing.get_context("fork").Process(target=call, args=arguments)
    process.start()
    deadline = time.monotonic() + 60.0
    while process.is_alive() and not _holds_steps(path) and time.monotonic() < deadline:
        time.sleep(0.01)
    time.sleep(after)
    process.kill()
    process.join()


def _holds_steps(path: Path) -> bool:
    try:
        with open_log(path) as log:
            return log.calls > 2
    except (GranularError, FileNotFoundError):
        return False


def test_of_a_run_that_came_to_its_end_only_the_file_is_mended(whole: dict[str, Path], tmp_path: Path) -> None:
    """The run is killed while the index is written."""
    path = tmp_path / "killed.mcap"
    path.write_bytes(whole["discs"].read_bytes()[:-8])
    with pytest.raises(
        LogError, match="only the end of the file is missing; nothing is left to resume; `granular-env recover`"
    ):
        resume(path)
    assert_made_whole(path, whole["discs"])


def test_a_run_of_costly_ticks_goes_on_from_nearby(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Simulate the cost per tick of a large shell: snapshots are 20 ticks apart, later a sixteenth of the run."""
    monkeypatch.setattr(schedule, "_SNAPSHOT_WORK", 120)
    monkeypatch.setattr(schedule, "_SNAPSHOT_STEPS", 20)
    experiment = {**SWING, "record": {"every": 0.1, "variables": ["position"]}}
    run(experiment, log=tmp_path / "whole.mcap", observers=[Slow(PAUSE)])
    data, path = (tmp_path / "whole.mcap").read_bytes(), tmp_path / "killed.mcap"
    path.write_bytes(data[: 2 * len(data) // 3])
    with open_log(path) as log:
        found = make_continuation(log)
        repeated = found.component.tick - found.key
        assert found.component.tick > 100 and 0 <= repeated <= 1000 // 16
    resume(path)
    assert_same(path, tmp_path / "whole.mcap")


# -- interruptions and stops ------------------------------------------------------------------------------------------------


def test_ctrl_c_ends_a_run_that_goes_on_later(tmp_path: Path) -> None:
    path = tmp_path / "swing.mcap"
    first = run(SWING, log=path, observers=[Slow(PAUSE, interrupt_at=300)])
    assert first.interrupted and 300 <= first.component.tick < 1000
    result = resume(path, experiment=SWING)
    assert (result.ticks, result.component.tick) == (1000 - first.component.tick, 1000)
    run(SWING, log=tmp_path / "whole.mcap", observers=[Slow(PAUSE)])
    assert_same(path, tmp_path / "whole.mcap")


def test_stop_rules_hold(tmp_path: Path) -> None:
    """Stop rules are evaluated at their scheduled times, including the end time of the log."""
    rule = {"variable": "position", "below": -0.5, "every": 0.07}
    stopped = run(SWING, overrides={"stop": [rule]}, log=tmp_path / "whole.mcap", observers=[Slow(PAUSE)])
    data = (tmp_path / "whole.mcap").read_bytes()
    path = tmp_path / "killed.mcap"
    path.write_bytes(data[: len(data) // 2])
    result = resume(path)
    assert result.stopped_by == stopped.stopped_by == "position below -0.5"
    assert_same(path, tmp_path / "whole.mcap")
    with pytest.raises(LogError, match="is complete: its run was stopped by position below -0.5"):
        resume(path)


def test_a_profile_from_a_csv_file_is_in_the_log(tmp_path: Path) -> None:
    """The original file may have been deleted."""
    (tmp_path / "force.csv").write_text("time [s],force [N]\n0,0\n1,2\n3,-1\n5,0\n")
    table = {"profile": "csv", "path": "force.csv", "time_column": 0, "value_column": 1, "gaps": "bridge"}
    experiment = load_experiment({**SWING, "input": {"force": table}}, folder=tmp_path)
    run(experiment, log=tmp_path / "whole.mcap", observers=[Slow(PAUSE)])
    (tmp_path / "force.csv").unlink()
    data = (tmp_path / "whole.mcap").read_bytes()
    (tmp_path / "killed.mcap").write_bytes(data[: len(data) // 3])
    resume(tmp_path / "killed.mcap")
    assert_same(tmp_path / "killed.mcap", tmp_path / "whole.mcap")


# -- refusals ---------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def swing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the log of a killed run."""
    folder = tmp_path_factory.mktemp("swing")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run_loop, "_PIECE_SECONDS", 2e-4)
        patch.setattr(recorder, "_WRITE_SECONDS", 1e-3)
        run(SWING, log=folder / "whole.mcap", observers=[Slow(PAUSE)])
    data = (folder / "whole.mcap").read_bytes()
    (folder / "killed.mcap").write_bytes(data[: len(data) // 2])
    return folder / "killed.mcap"


def test_a_complete_log_is_refused(swing: Path) -> None:
    with pytest.raises(
        LogError, match=r"whole\.mcap': the log is complete: its experiment has run to its end; nothing is left to resume"
    ):
        resume(swing.with_name("whole.mcap"))


def test_a_log_of_another_experiment_is_refused(swing: Path) -> None:
    with pytest.raises(LogError, match="the log is of experiment 'swing', expected experiment 'oscillator/pushed'"):
        resume(swing, experiment="oscillator/pushed")
    with pytest.raises(LogError, match="the experiment 'swing' in the log has different values of the keys duration"):
        resume(swing, experiment=SWING, overrides={"duration": 20.0})


def test_a_run_that_failed_is_refused(tmp_path: Path) -> None:
    experiment = {**SWING, "component": {"type": "oscillator", "stiffness": 4.0}, "start": {"velocity": 1e150}}
    with pytest.raises(GranularError):
        run(experiment, overrides={"input.force": 1e308}, log=tmp_path / "failed.mcap")
    with pytest.raises(LogError, match="is complete: its run ended with StepError"):
        resume(tmp_path / "failed.mcap")


def test_other_bits_are_refused(swing: Path, tmp_path: Path) -> None:
    """Frames after the last snapshot are changed, as if another version had computed them."""

    def change(record: Record) -> Record:
        if "values" in record.arrays and record.last > 350 and record.detail == 0:
            return Record(*record.row, record.header, {**record.arrays, "values": np.nextafter(record.arrays["values"], 9.0)})
        return record

    rewrite_log(swing.with_name("whole.mcap"), tmp_path / "changed.mcap", change)
    data = (tmp_path / "changed.mcap").read_bytes()
    (tmp_path / "killed.mcap").write_bytes(data[: 2 * len(data) // 3])
    with pytest.raises(LogError, match="the re-run gives a different position at .* run the experiment again"):
        resume(tmp_path / "killed.mcap")


def test_another_log_is_not_replaced_unasked(swing: Path, tmp_path: Path) -> None:
    before, other = swing.read_bytes(), swing.with_name("whole.mcap").read_bytes()
    (tmp_path / "other.mcap").write_bytes(other)
    with pytest.raises(ParameterError, match=r"log '.*other\.mcap': it exists"):
        resume(swing, log=tmp_path / "other.mcap")
    assert (swing.read_bytes(), (tmp_path / "other.mcap").read_bytes()) == (before, other)
    resume(swing, log=tmp_path / "other.mcap", overwrite=True)
    assert_same(tmp_path / "other.mcap", swing.with_name("whole.mcap"))


# -- the command ------------------------------------------------------------------------------------------------------------


def test_the_command(swing: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "killed.mcap"
    path.write_bytes(swing.read_bytes())
    assert main(["run", "--resume", str(path), "--quiet"]) == 0
    assert capsys.readouterr().out.strip() == str(path)
    assert_same(path, swing.with_name("whole.mcap"))
    assert main(["run", "--resume", str(path)]) == 2
    assert "is complete" in capsys.readouterr().err
