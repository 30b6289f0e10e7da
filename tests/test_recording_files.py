"""The file of a log: how much of it is read to open it, who may write it, what it may replace, and when it is closed."""

from __future__ import annotations

import gc
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.recording_helpers import chain_log, oscillator_log
from support.work import count_calls

import granular_env.components.catalogue as catalogue
from granular_env.cli import main
from granular_env.components.balances import Balance
from granular_env.components.component import Component
from granular_env.components.errors import ExperimentError, LogError, ParameterError, StepError
from granular_env.components.oscillator import Oscillator
from granular_env.components.support.validation import Parameters
from granular_env.components.variables import Variable
from granular_env.experiments import load_experiment
from granular_env.experiments.cost import recorded_bytes
from granular_env.experiments.preparation import prepare
from granular_env.recording import Log, open_log, record, recover, verify
from granular_env.recording.container.reader import McapReader
from granular_env.recording.recorder.arguments import make_schedule
from granular_env.recording.recorder.sampling import (
    Schedule,
    doubling_for,
    frames_for,
    least_snapshot_interval,
    schedule_from,
)
from granular_env.recording.recorder.size_estimate import estimated_bytes
from granular_env.run_loop import run

# -- opening -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def reads(monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, int]]:
    """How many chunks were unpacked, and bytes read from files."""
    found = {"chunks": 0, "bytes": 0}
    content, read = McapReader._chunk_content, McapReader._read

    def count_chunk(self: McapReader, offset: int, length: int) -> bytes:
        found["chunks"] += 1
        return content(self, offset, length)

    def count_bytes(self: McapReader, offset: int, length: int) -> bytes:
        found["bytes"] += length
        return read(self, offset, length)

    monkeypatch.setattr(McapReader, "_chunk_content", count_chunk)
    monkeypatch.setattr(McapReader, "_read", count_bytes)
    yield found


def _long_log(path: Path, grains: int, frames: int) -> None:
    component = catalogue.make("chain", grains=grains, radius=3e-3, material="steel")
    every = component.step_size
    with record(component, path, every=every, variables=["velocity", "displacement", "position"]):
        component.reset(velocity=np.random.default_rng(1).normal(0.0, 0.1, grains))
        component.step(frames * every)


def test_opening_reads_the_first_and_the_last_chunk(tmp_path: Path, reads: dict[str, int]) -> None:
    _long_log(tmp_path / "a.mcap", 1000, 300)
    log = open_log(tmp_path / "a.mcap")
    assert log.complete and log.records.container.chunk_count > 10
    assert reads["chunks"] == 2 and reads["bytes"] < log.size / 20
    log.get("velocity", log.duration / 2)
    assert reads["chunks"] <= 4, "one frame is in one chunk"


@pytest.mark.slow
def test_opening_a_large_log_takes_little_work(tmp_path: Path, reads: dict[str, int]) -> None:
    _long_log(tmp_path / "a.mcap", 3000, 5000)
    assert (tmp_path / "a.mcap").stat().st_size > 200e6
    calls = count_calls(lambda: open_log(tmp_path / "a.mcap").close())
    # Less than a call for each of its frames.
    assert reads["chunks"] == 2 and reads["bytes"] < 2e6 and calls < 5000


def test_every_committed_log_is_opened_by_its_index(reads: dict[str, int]) -> None:
    logs = sorted((Path(__file__).parent.parent / "logs").glob("g*/*.mcap"))
    for path in logs:
        open_log(path).close()
    assert logs and reads["chunks"] == 2 * len(logs)


def test_a_file_that_is_no_log_is_closed_again(tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(b"nothing of the kind")
    before = len(os.listdir("/proc/self/fd"))
    with pytest.raises(LogError):
        open_log(tmp_path / "a.mcap")
    assert len(os.listdir("/proc/self/fd")) == before


def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.mcap")
    for act in (open_log, verify, lambda path: recover(path, tmp_path / "out.mcap")):
        with pytest.raises(LogError, match="pipe"):
            act(tmp_path / "pipe.mcap")
    with pytest.raises(LogError, match="pipe"):
        open_log("/dev/null")


# -- sizes -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "options",
    [
        {"every": 1e-6, "variables": ["velocity", "displacement"]},
        {"variables": ["velocity"]},
        {"every": 2e-5, "variables": ["velocity"], "hash_every": 1, "snapshot_every": 1e-5},
        {"experiment": {"duration": 1e-3}},
    ],
)
def test_the_size_of_a_log_is_known_before(tmp_path: Path, options: dict[str, Any]) -> None:
    component = catalogue.make("chain", grains=300, radius=3e-3, material="steel")
    ticks = component.ticks_in(1e-3)
    estimate = estimated_bytes(component, ticks, **options)
    with record(component, tmp_path / "a.mcap", **options):
        component.reset(velocity={0: 1.0})
        component.step(1e-3)
    container = open_log(tmp_path / "a.mcap").records.container
    size = sum(len(message.data) for chunk in range(container.chunk_count) for message in container.messages(chunk))
    # Spheres of grains at rest take less in a preview.
    assert 0.7 < size / estimate < 1.06 or not (options.get("every") or options.get("experiment"))
    assert size < 1.06 * estimate


@pytest.mark.parametrize(
    ("experiment", "overrides"),
    [
        ("psakhie-2003/lamb-grid", {"duration": 2e-5}),
        ("psakhie-2003/lamb-symmetric", {"duration": 1e-5}),
        ("gato-shie-2010/shock-tube", {}),
        ("nesterenko-1983/3.4-piston", {}),
    ],
)
def test_the_size_is_right_for_every_medium(experiment: str, overrides: dict[str, Any], tmp_path: Path) -> None:
    ready = prepare(load_experiment(experiment, overrides))
    run(experiment, overrides=overrides, log=tmp_path / "a.mcap")
    container = open_log(tmp_path / "a.mcap").records.container
    size = sum(len(message.data) for chunk in range(container.chunk_count) for message in container.messages(chunk))
    assert recorded_bytes(ready, tmp_path) == pytest.approx(size, rel=0.05)
    assert (tmp_path / "a.mcap").stat().st_size < size


class Costly(Component):
    """A body on a spring whose part should make millions of steps in a tick; it makes one, so that the test is quick."""

    name = "costly"
    Parameters = Parameters
    steps = 4_166_667  # of the six words of the part: 25 million in a tick

    def _build(self) -> None:
        self.step_size = 0.01
        alone = Oscillator(step_size=self.step_size / self.steps)
        self._lay_out(part=("f8", alone.memory.shape))
        self.part = alone.clone(self._block["part"])
        self._include(self.part, "part", self.steps)

    def _declare(self) -> Iterator[Variable]:
        yield Variable("place", "output", "m", (), "position of the body")

    def _outputs(self) -> dict[str, Callable[[], Any]]:
        return {"place": lambda: self.part.peek("position")}

    def _start(self, seed: int | None, values: Mapping[str, Any]) -> Mapping[str, Any]:
        self.part.begin(None, {"position": np.float64(1.0)})
        return {}

    def _advance(self, ticks: int) -> int:
        self.part.adopt(self._tick, {})
        return self.part.advance(ticks)

    def _explain(self, status: int) -> StepError:
        return self.part.explain(status)

    def balances(self) -> tuple[Balance, ...]:
        return self.part.balances()


@pytest.fixture
def costly_log(tmp_path: Path) -> Log:
    """A run of 2000 ticks, as long as one of three minutes where such ticks were real."""
    component = Costly()
    with record(component, tmp_path / "a.mcap", every=1.0, variables=["place"]):
        component.reset()
        for _ in range(40):
            component.step(0.5)
    return open_log(tmp_path / "a.mcap", components={"costly": Costly})


def test_costly_ticks_have_many_snapshots(costly_log: Log) -> None:
    """500 million words are 20 ticks here, and a 32nd of the run is longer from tick 672 on."""
    found = [tick for _, tick in costly_log.snapshots]
    assert found[:34] == list(range(0, 680, 20)) and found[-1] == 2000
    assert np.diff(found).max() <= 2000 // 32
    assert found == [0, *_key_ticks(Schedule(100, 64, 4096, 0, 20), 2000), 2000]
    assert costly_log.records.header["options"]["least_snapshot_interval"] == 20
    assert verify(costly_log, components={"costly": Costly}).identical


def test_the_size_of_a_log_counts_the_snapshots_of_costly_ticks(costly_log: Log) -> None:
    component, path = Costly(), costly_log.path
    sizes = {
        every: estimated_bytes(component, 2000, every=1.0, variables=["place"], snapshot_every=every)
        for every in (None, 20.0)
    }  # fmt: skip
    # The start and the end are counted with any interval, and that of 20 s adds one more.
    assert sizes[None] - sizes[20.0] == (len(costly_log.snapshots) - 3) * component.state_bytes
    assert path.stat().st_size < sizes[None]


def test_an_interval_that_is_given_counts(tmp_path: Path) -> None:
    component = Costly()
    with record(component, tmp_path / "a.mcap", every=1.0, snapshot_every=5.0):
        component.step(20.0)
    with open_log(tmp_path / "a.mcap", components={"costly": Costly}) as log:
        assert [tick for _, tick in log.snapshots][:-1] == [0, 500, 1000, 1500, 2000]


def test_a_branch_of_a_log_has_snapshots_as_its_parent(costly_log: Log, tmp_path: Path) -> None:
    with costly_log.branch(15.0).run(tmp_path / "b.mcap") as child:
        ticks = [tick for _, tick in child.snapshots]
    assert ticks[0] == 1500 and ticks[-1] == 2000 and set(np.diff(ticks[:-1])) <= set(range(1500 // 32, 2000 // 32 + 1))


@pytest.mark.parametrize(
    ("words", "work", "interval"),
    [
        (100_000, 100_000, 4096),  # a grid of 40 x 40 nodes: 4096 ticks take a second
        (110_000, 2_170_000, 230),  # a tube of 1600 nodes with 20 steps in a tick
        (1_550_000, 17_000_000, 137),  # of 70,000 nodes with 11: 1500 steps, 24 s
        (13_000_000, 13_000_000, 1500),  # a grid of a million nodes: a minute
        (10, 10**12, 1),
    ],
)
def test_snapshots_are_some_seconds_apart_and_cost_little(words: int, work: int, interval: int) -> None:
    assert least_snapshot_interval(words, work) == interval


def test_snapshots_of_cheap_ticks_are_where_they_were() -> None:
    """4096 ticks apart, from 69,632 on a sixteenth of the run; and the header says no more than it did."""
    component = catalogue.make("chain", grains=300, radius=3e-3, material="steel")
    schedule = make_schedule(component, 1e-6, None, None, None, ["velocity"])
    assert schedule.options().keys() == {"frame_every", "doubling", "hash_every", "snapshot_every"}
    ticks = _key_ticks(schedule, 10**6)
    assert ticks[:17] == list(range(4096, 18 * 4096, 4096)) and ticks[17] == 17 * 4096 + (17 * 4096) // 16
    assert all(after == tick + max(4096, tick // 16) for tick, after in zip(ticks, ticks[1:], strict=False))


@pytest.mark.parametrize("interval", [None, 20])
def test_a_header_gives_the_schedule_back(interval: int | None) -> None:
    schedule = Schedule(3, 16, 64, 0) if interval is None else Schedule(3, 16, 64, 0, interval)
    assert schedule_from(schedule.options()) == schedule
    for wrong in (0, -1, 2.0, True, "20", None):
        with pytest.raises(LogError, match="when frames were taken"):
            schedule_from({**schedule.options(), "least_snapshot_interval": wrong})


def _key_ticks(schedule: Schedule, end: int) -> list[int]:
    """Return the ticks of snapshots between the start and the end of a run."""
    found, tick = [], 0
    while (tick := schedule.key_after(tick, tick)) < end:
        found.append(tick)
    return found


def test_frames_of_large_media_are_fewer() -> None:
    """At least ten; else so few that writing them takes about a twentieth of the run."""
    assert [frames_for(4000, numbers, 1_000_000) for numbers in (10_000, 500_000)] == [10, 10]
    assert [frames_for(ticks, 5_000_000, 10_000_000) for ticks in (100, 400, 4000, 10**6)] == [10, 20, 200, 5000]
    assert [doubling_for(numbers) for numbers in (100, 10_000, 2_000_000)] == [64, 16, 4]


def test_a_large_log_is_announced_and_its_size_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from granular_env.experiments import cost

    experiment, path = "nesterenko-1983/3.1-one-grain", tmp_path / "a.mcap"
    assert main(["run", experiment, "--log", str(path)]) == 0
    output = capsys.readouterr()
    assert "before compression" not in output.err
    assert f"log: {path} ({path.stat().st_size / 1e3:.3g} kB)" in output.out
    monkeypatch.setattr(cost, "LARGE_LOG", 100_000)
    monkeypatch.setattr(cost, "TOLD_LOG", 100_000)
    assert main(["check", experiment]) == 0 and "before compression" in capsys.readouterr().out
    assert main(["run", experiment, "--log", str(path), "--overwrite"]) == 0
    assert "note: the log takes up to " in capsys.readouterr().err
    assert main(["run", experiment, "--no-log"]) == 0 and "before compression" not in capsys.readouterr().err


def test_a_log_that_cannot_fit_is_refused_before_the_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    experiment, path = "nesterenko-1983/3.4-piston", tmp_path / "new" / "a.mcap"
    long = ["--set", "duration=1e9"]
    for arguments in (["check", experiment, *long], ["run", experiment, *long, "--log", str(path)]):
        assert main(arguments) == 2
        message = capsys.readouterr().err
        assert "duration: the log takes up to 4.98e+09 GB" in message
        assert "are free in" in message and "record.every" in message
    with pytest.raises(ExperimentError, match=r"the log takes up to 4\.98e\+09 GB"):
        run(experiment, overrides={"duration": 1e9}, log=path)
    assert not path.parent.exists()
    short = {"duration": 1e-6}
    assert run(experiment, overrides=short, log=tmp_path / "a.mcap").log == tmp_path / "a.mcap"


def test_a_log_that_fits_is_not_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Grains at rest take little: the log of a long chain has a sixteenth of its size before compression."""
    usage = shutil.disk_usage(tmp_path)._replace(free=4_000_000)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage)
    long = {"component.grains": 5000, "duration": 4e-4}
    done = run("nesterenko-1983/3.1-one-grain", overrides=long, log=tmp_path / "a.mcap")
    assert done.log is not None and done.log.stat().st_size < usage.free


# -- one writer --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("older", ["nothing", "log"])
def test_a_second_recorder_of_one_file_is_refused(tmp_path: Path, older: str) -> None:
    if older == "log":
        oscillator_log(tmp_path / "a.mcap")
    first, second = (catalogue.make("oscillator") for _ in range(2))
    with record(first, tmp_path / "a.mcap", overwrite=True):
        with pytest.raises(ParameterError, match=r"a\.mcap' is being written by another recorder"):
            record(second, tmp_path / "a.mcap", overwrite=True)
        first.step(1.0)
        time.sleep(0.2)
        with pytest.raises(ParameterError, match="is being written by another recorder"):
            record(second, tmp_path / "a.mcap", overwrite=True)
        first.step(1.0)
    assert verify(tmp_path / "a.mcap").identical and open_log(tmp_path / "a.mcap").end_tick == 200
    with record(second, tmp_path / "a.mcap", overwrite=True):
        second.step(0.5)
    assert open_log(tmp_path / "a.mcap").end_tick == 50
    assert [path.name for path in tmp_path.iterdir()] == ["a.mcap"]


_WRITER = """
import sys, time
from granular_env.components.catalogue import make
from granular_env.components.errors import GranularError
from granular_env.recording import record
component = make("oscillator")
try:
    with record(component, sys.argv[1], overwrite=True):
        for _ in range(40):
            component.step(0.01)
            time.sleep(0.01)
    print("closed")
except GranularError as error:
    print("refused" if "another recorder" in str(error) else error)
"""


def test_two_processes_never_write_one_file(tmp_path: Path) -> None:
    command = [sys.executable, "-c", _WRITER, str(tmp_path / "a.mcap")]
    writers = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(3)]
    said = sorted(writer.communicate(timeout=120)[0].strip() for writer in writers)
    assert said[0] == "closed" and set(said) <= {"closed", "refused"}
    assert verify(tmp_path / "a.mcap").identical and [path.name for path in tmp_path.iterdir()] == ["a.mcap"]


def test_an_older_log_stays_until_the_new_one_holds_a_step(tmp_path: Path) -> None:
    chain_log(tmp_path / "a.mcap")
    before = (tmp_path / "a.mcap").read_bytes()
    component = catalogue.make("oscillator")
    with record(component, tmp_path / "a.mcap", overwrite=True) as recorder:
        time.sleep(0.2)
        assert (tmp_path / "a.mcap").read_bytes() == before and not recorder.published
        component.step(0.5)
        end = time.monotonic() + 60.0
        while not recorder.published and time.monotonic() < end:
            time.sleep(0.01)
        assert recorder.published and open_log(tmp_path / "a.mcap").end_tick == 50, "a killed process leaves the new one"
    assert verify(tmp_path / "a.mcap").identical


def test_an_older_log_is_kept_where_the_new_one_cannot_be_written(tmp_path: Path) -> None:
    """The disk is full before the first step: a limit on the size of files."""
    chain_log(tmp_path / "a.mcap")
    before = (tmp_path / "a.mcap").read_bytes()
    script = (
        "import resource, signal, sys; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000));"
        "from granular_env.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    command = ["run", "nesterenko-1983/3.1-one-grain", "--log", str(tmp_path / "a.mcap"), "--overwrite"]
    done = subprocess.run([sys.executable, "-c", script, *command], capture_output=True, text=True, timeout=300)
    assert done.returncode == 2 and "is kept" in done.stderr and (tmp_path / "a.mcap").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["a.mcap"]


def test_only_a_log_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "e.toml").write_text("name = 'mine'\n")
    (tmp_path / "empty.mcap").touch()
    oscillator_log(tmp_path / "a.mcap")
    component = catalogue.make("oscillator")
    for act in (
        lambda: record(component, tmp_path / "e.toml", overwrite=True),
        lambda: recover(tmp_path / "a.mcap", tmp_path / "e.toml", overwrite=True),
        lambda: open_log(tmp_path / "a.mcap").branch(0.5).run(tmp_path / "e.toml", overwrite=True),
    ):
        with pytest.raises(ParameterError, match="only a log is replaced"):
            act()
    assert (tmp_path / "e.toml").read_text() == "name = 'mine'\n"
    for name in ("empty.mcap", "a.mcap"):
        with record(component, tmp_path / name, overwrite=True):
            component.step(0.5)
        assert verify(tmp_path / name).identical


def test_a_link_stays_one(tmp_path: Path) -> None:
    oscillator_log(tmp_path / "a.mcap")
    (tmp_path / "link.mcap").symlink_to("a.mcap")
    chain_log(tmp_path / "link.mcap", overwrite=True)
    assert (tmp_path / "link.mcap").is_symlink() and open_log(tmp_path / "a.mcap").metadata["component"] == "chain"


def test_runs_at_once_without_a_name_get_one_each(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from granular_env.cli.new_log_path import reserve_log

    monkeypatch.chdir(tmp_path)
    with reserve_log("a") as first, reserve_log("a") as second:
        assert first != second
        component = catalogue.make("oscillator")
        with record(component, first, overwrite=True):
            component.step(0.5)
    assert first.exists() and not second.exists(), "a name that was not used is free again"


def test_four_commands_at_once(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "granular_env", "run", "nesterenko-1983/3.1-one-grain", "--quiet"]
    running = [
        subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) for _ in range(4)
    ]
    said = [process.communicate(timeout=300) for process in running]
    assert [process.returncode for process in running] == [0] * 4, said
    assert len({out for out, _ in said}) == 4 == len(list((tmp_path / "logs").iterdir()))


# -- recorders that nobody closes --------------------------------------------------------------------------------------


def test_dropped_recorders_leave_no_thread_and_no_file_open(tmp_path: Path) -> None:
    gc.collect()
    threads, files = threading.active_count(), len(os.listdir("/proc/self/fd"))
    with pytest.warns(ResourceWarning, match="never closed") as told:
        for number in range(10):
            component = catalogue.make("oscillator")
            record(component, tmp_path / f"{number}.mcap")
            component.step(0.5)
            del component
        deadline = time.monotonic() + 20.0
        # A thread that is just writing holds its recorder until it is done.
        while threading.active_count() > threads and time.monotonic() < deadline:
            gc.collect()
            time.sleep(0.05)
    assert {number for number in range(10) if any(f"/{number}.mcap' was never closed" in str(w.message) for w in told)} == {
        *range(10)
    }
    assert threading.active_count() == threads and len(os.listdir("/proc/self/fd")) == files
    assert all(verify(tmp_path / f"{number}.mcap").identical for number in range(10))


def test_a_dropped_recorder_does_not_keep_its_path(tmp_path: Path) -> None:
    gc.disable()
    try:
        component = catalogue.make("oscillator")
        dropped = record(component, tmp_path / "a.mcap")
        component.step(0.5)
        del component, dropped
        time.sleep(0.2)  # a thread that is just writing holds its recorder until it is done
        with pytest.warns(ResourceWarning, match="never closed"):
            again = record(catalogue.make("oscillator"), tmp_path / "a.mcap", overwrite=True)
        again.close()
    finally:
        gc.enable()
    assert open_log(tmp_path / "a.mcap").end_tick == 0


def test_a_recorder_lives_as_long_as_its_component(tmp_path: Path) -> None:
    component = catalogue.make("oscillator")
    record(component, tmp_path / "a.mcap")
    gc.collect()
    component.step(0.5)
    (recorder,) = component._observers
    recorder.close()  # type: ignore[attr-defined]
    assert open_log(tmp_path / "a.mcap").end_tick == 50


def test_the_end_of_the_program_closes_what_is_open(tmp_path: Path) -> None:
    script = (
        "import sys, granular_env as ge; c = ge.make('oscillator'); r = ge.record(c, sys.argv[1]); c.step(0.5); sys.exit(0)"
    )
    subprocess.run([sys.executable, "-c", script, str(tmp_path / "a.mcap")], check=True, timeout=120)
    assert verify(tmp_path / "a.mcap").identical


# -- recovering --------------------------------------------------------------------------------------------------------


def test_half_of_a_short_log_holds_half_of_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    component = catalogue.make("chain", grains=60, radius=3e-3, material="steel")
    h = component.step_size
    with record(component, tmp_path / "a.mcap", every=h):
        component.reset(velocity=np.random.default_rng(2).normal(0.0, 0.1, 60))
        component.step(400 * h)
    data = (tmp_path / "a.mcap").read_bytes()
    assert len(data) < 1 << 20
    (tmp_path / "cut.mcap").write_bytes(data[: len(data) // 2])
    capsys.readouterr()
    assert main(["recover", str(tmp_path / "cut.mcap"), "-o", str(tmp_path / "b.mcap")]) == 0
    log = open_log(tmp_path / "b.mcap")
    assert log.end_tick == 400 and len(log.ticks("displacement")) > 100, "frames too"


def test_nothing_recovered_is_told_by_the_exit_status(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    oscillator_log(tmp_path / "a.mcap")
    offset, length = open_log(tmp_path / "a.mcap").records.container.places[0]
    (tmp_path / "cut.mcap").write_bytes((tmp_path / "a.mcap").read_bytes()[: offset + length + 40])
    assert main(["recover", str(tmp_path / "cut.mcap"), "-o", str(tmp_path / "b.mcap")]) == 1
    assert "nothing was recovered but the start" in capsys.readouterr().out


def test_a_folder_that_cannot_be_made_is_no_matter_of_space(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from granular_env.output_files import replacing

    (tmp_path / "file").write_text("")
    for act in (
        lambda: record(catalogue.make("oscillator"), tmp_path / "file" / "a.mcap"),
        lambda: replacing(tmp_path / "file" / "a.html").__enter__(),
    ):
        with pytest.raises(Exception, match="choose another path") as caught:
            act()
        assert "space" not in str(caught.value)


# -- work without end --------------------------------------------------------------------------------------------------


def _endless_tick():  # noqa: ANN202
    """A tick in which grains between two walls collide more often than anybody could wait for."""
    options = {"integrator": "dop853", "left": "plane", "right": "plane", "step_size": 1e4}
    component = catalogue.make("chain", grains=5, radius=3e-3, material="steel", **options)
    component.reset(velocity={0: 1.0})
    return component


def test_a_tick_that_would_take_for_ever_is_refused(tmp_path: Path) -> None:
    component = _endless_tick()
    before = component.save().data
    with pytest.raises(StepError, match=r"needs more than \d+ trial steps of 'dop853'.*smaller step_size") as first:
        component.step()
    with pytest.raises(StepError) as second:
        component.step()
    assert str(first.value) == str(second.value) and component.save().data == before


def test_a_log_of_such_a_tick_is_different_in_seconds(tmp_path: Path) -> None:
    """Made as somebody would who wants a verification never to end: a short run, with another step size in its header."""
    from support.recording_helpers import rewrite

    component = catalogue.make(
        "chain", grains=5, radius=3e-3, material="steel", integrator="dop853", left="plane", right="plane", step_size=1e-6
    )
    with record(component, tmp_path / "a.mcap"):
        component.reset(velocity={0: 1.0})
        component.step()
    other = _endless_tick()

    def change(old):  # noqa: ANN001, ANN202
        import dataclasses

        from granular_env.components.snapshot import Snapshot
        from granular_env.recording.format.records import HEADER, SNAPSHOTS

        if old.kind == HEADER:
            parameters = {**old.header["parameters"], "step_size": 1e4}
            header = {**old.header, "parameters": parameters, "step_size": 1e4, "identity": other.identity}
            return dataclasses.replace(old, header=header)
        if old.kind == SNAPSHOTS:
            snapshot = Snapshot.from_bytes(old.arrays["snapshot"].tobytes())
            snapshot.identity = other.identity
            return dataclasses.replace(old, arrays={"snapshot": np.frombuffer(snapshot.to_bytes(), dtype=np.uint8)})
        return old

    rewrite(tmp_path / "a.mcap", tmp_path / "b.mcap", change)
    result = verify(tmp_path / "b.mcap")
    assert not result.identical and result.variable == "step_size"


def test_ctrl_c_is_heard_within_a_step_of_many_long_ticks() -> None:
    script = """
import signal, sys, granular_env as ge
c = ge.make("chain", grains=5, radius=3e-3, material="steel", integrator="dop853", left="plane", right="plane", step_size=5e-3)
c.reset(velocity={0: 1.0})
c.step()
try:
    print("ready", flush=True)
    c.step(5e-3 * 10**7)
except KeyboardInterrupt:
    print("heard at tick", c.tick)
"""
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "ready\n"
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=60)[0] == "heard at tick 1\n"


@pytest.mark.parametrize("command", [["replay"], ["branch", "--at", "0", "--log", "out.mcap"]])
def test_the_caps_on_work_hold_for_every_command_that_runs(
    command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from granular_env.recording.replay import steps

    monkeypatch.chdir(tmp_path)
    oscillator_log(tmp_path / "a.mcap")
    monkeypatch.setattr(steps, "_TICKS", 100)
    assert main([command[0], "a.mcap", *command[1:]]) == 2
    told = capsys.readouterr().err
    assert "the number of ticks is 2" in told and "--allow-large" in told
    assert not (tmp_path / "out.mcap").exists()
    assert main([command[0], "a.mcap", *command[1:], "--allow-large"]) == 0


def test_a_file_of_no_bytes_is_called_empty_and_nothing_advises_to_recover_it(tmp_path: Path) -> None:
    (tmp_path / "empty.mcap").touch()
    for act in (open_log, verify, lambda path: recover(path, tmp_path / "out.mcap")):
        with pytest.raises(LogError, match="is empty; nothing was written") as caught:
            act(tmp_path / "empty.mcap")
        assert "granular-env recover" not in str(caught.value)


def test_a_damaged_log_is_not_called_complete_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    chain_log(tmp_path / "a.mcap")
    damaged = bytearray((tmp_path / "a.mcap").read_bytes())
    damaged[len(damaged) // 4] ^= 0xFF
    (tmp_path / "a.mcap").write_bytes(damaged)
    assert main(["check", str(tmp_path / "a.mcap")]) == 2
    assert "complete" not in capsys.readouterr().out
