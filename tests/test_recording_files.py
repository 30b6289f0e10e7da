"""The file of a log: size, exclusive writing, replacement of files, and closing."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.recording_helpers import chain_log, oscillator_log

import granular_env.components.catalogue as catalogue
from granular_env.cli import main
from granular_env.components.errors import LogError, ParameterError
from granular_env.experiments import load_experiment
from granular_env.experiments.cost import log_bytes
from granular_env.experiments.preparation import prepare_experiment
from granular_env.recording import open_log, record, recover, verify
from granular_env.recording.container import Container, Entry
from granular_env.recording.schedule import least_snapshot_interval
from granular_env.run_loop import run

# -- opening -----------------------------------------------------------------------------------------------------------


def test_opening_reads_the_first_and_the_last_chunk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    component, read, chunks = catalogue.make("chain", grains=1000, radius=3e-3, material="steel"), Container._read_chunk, []

    def counted(self: Container, offset: int, length: int) -> list[Entry]:
        chunks.append(offset)
        return read(self, offset, length)

    every = component.step_size
    with record(component, tmp_path / "a.mcap", every=every, variables=["velocity", "displacement", "position"]):
        component.reset(velocity=np.random.default_rng(1).normal(0.0, 0.1, 1000))
        component.step(300 * every)
    monkeypatch.setattr(Container, "_read_chunk", counted)
    log = open_log(tmp_path / "a.mcap")
    assert log.complete and len(log.container.places) > 10 and len(chunks) == 2
    log.get("velocity", log.duration / 2)
    assert len(chunks) <= 4, "one frame is in one chunk"


def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.mcap")
    for act in (open_log, verify, lambda path: recover(path, tmp_path / "out.mcap")):
        with pytest.raises(LogError, match="pipe"):
            act(tmp_path / "pipe.mcap")
    with pytest.raises(LogError, match="pipe"):
        open_log("/dev/null")


# -- sizes -------------------------------------------------------------------------------------------------------------


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
    ready = prepare_experiment(load_experiment(experiment, overrides))
    run(experiment, overrides=overrides, log=tmp_path / "a.mcap")
    container = open_log(tmp_path / "a.mcap").container
    size = sum(len(entry.message.data) for _, entry in container.all_messages())
    assert 0.9 * size < log_bytes(ready) < 1.35 * size
    assert (tmp_path / "a.mcap").stat().st_size < size


@pytest.mark.parametrize(
    ("words", "work", "interval"),
    [
        (100_000, 100_000, 4096),
        (110_000, 2_170_000, 230),
        (13_000_000, 13_000_000, 1500),
    ],
)
def test_snapshots_are_some_seconds_apart_and_cost_little(words: int, work: int, interval: int) -> None:
    assert least_snapshot_interval(words, work) == interval


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
    monkeypatch.setattr(cost, "NOTED_LOG", 100_000)
    assert main(["check", experiment]) == 0 and "before compression" in capsys.readouterr().out
    assert main(["run", experiment, "--log", str(path), "--overwrite"]) == 0
    assert "note: the log takes up to " in capsys.readouterr().err
    assert main(["run", experiment, "--no-log"]) == 0 and "before compression" not in capsys.readouterr().err


# -- one writer --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("older", ["nothing", "log"])
def test_a_second_recorder_of_one_file_is_refused(tmp_path: Path, older: str) -> None:
    if older == "log":
        oscillator_log(tmp_path / "a.mcap")
    first, second = (catalogue.make("oscillator") for _ in range(2))
    with record(first, tmp_path / "a.mcap", overwrite=True):
        with pytest.raises(ParameterError, match=r"a\.mcap': another recorder is writing it"):
            record(second, tmp_path / "a.mcap", overwrite=True)
        first.step(1.0)
        time.sleep(0.2)
        with pytest.raises(ParameterError, match="another recorder is writing it"):
            record(second, tmp_path / "a.mcap", overwrite=True)
        first.step(1.0)
    assert verify(tmp_path / "a.mcap").identical and open_log(tmp_path / "a.mcap").end_tick == 200
    with record(second, tmp_path / "a.mcap", overwrite=True):
        second.step(0.5)
    assert open_log(tmp_path / "a.mcap").end_tick == 50
    assert [path.name for path in tmp_path.iterdir()] == ["a.mcap"]


def test_an_older_log_stays_until_the_new_one_holds_a_step(tmp_path: Path) -> None:
    chain_log(tmp_path / "a.mcap")
    before = (tmp_path / "a.mcap").read_bytes()
    component = catalogue.make("oscillator")
    with record(component, tmp_path / "a.mcap", overwrite=True):
        time.sleep(0.2)
        assert (tmp_path / "a.mcap").read_bytes() == before
        component.step(0.5)
        end = time.monotonic() + 60.0
        while (tmp_path / "a.mcap").read_bytes() == before and time.monotonic() < end:
            time.sleep(0.01)
        assert open_log(tmp_path / "a.mcap").end_tick == 50, "a killed process leaves the new one"
    assert verify(tmp_path / "a.mcap").identical


def test_an_older_log_is_kept_where_the_new_one_cannot_be_written(tmp_path: Path) -> None:
    """A limit on the file size simulates a disk that is full before the first step."""
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
        with pytest.raises(ParameterError, match="only logs are replaced"):
            act()
    assert (tmp_path / "e.toml").read_text() == "name = 'mine'\n"
    for name in ("empty.mcap", "a.mcap"):
        with record(component, tmp_path / name, overwrite=True):
            component.step(0.5)
        assert verify(tmp_path / name).identical


def test_the_end_of_the_program_closes_what_is_open(tmp_path: Path) -> None:
    script = (
        "import sys, granular_env as ge; c = ge.make('oscillator'); r = ge.record(c, sys.argv[1]); c.step(0.5); sys.exit(0)"
    )
    subprocess.run([sys.executable, "-c", script, str(tmp_path / "a.mcap")], check=True, timeout=120)
    assert verify(tmp_path / "a.mcap").identical


# -- recovering --------------------------------------------------------------------------------------------------------


def test_nothing_recovered_is_told_by_the_exit_status(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    oscillator_log(tmp_path / "a.mcap")
    offset, length = open_log(tmp_path / "a.mcap").container.places[0]
    (tmp_path / "cut.mcap").write_bytes((tmp_path / "a.mcap").read_bytes()[: offset + length + 40])
    assert main(["recover", str(tmp_path / "cut.mcap"), "-o", str(tmp_path / "b.mcap")]) == 1
    assert "only the start was recovered" in capsys.readouterr().out


# -- limits on work ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", [["replay"], ["branch", "--at", "0", "--log", "out.mcap"]])
def test_the_caps_on_work_hold_for_every_command_that_runs(
    command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from granular_env.recording import replay

    monkeypatch.chdir(tmp_path)
    oscillator_log(tmp_path / "a.mcap")
    monkeypatch.setattr(replay, "_TICKS", 100)
    assert main([command[0], "a.mcap", *command[1:]]) == 2
    told = capsys.readouterr().err
    assert "the number of ticks is 2" in told and "--allow-large" in told
    assert not (tmp_path / "out.mcap").exists()
    assert main([command[0], "a.mcap", *command[1:], "--allow-large"]) == 0


def test_a_damaged_log_is_not_called_complete_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    chain_log(tmp_path / "a.mcap")
    damaged = bytearray((tmp_path / "a.mcap").read_bytes())
    damaged[len(damaged) // 4] ^= 0xFF
    (tmp_path / "a.mcap").write_bytes(damaged)
    assert main(["check", str(tmp_path / "a.mcap")]) == 2
    assert "complete" not in capsys.readouterr().out
