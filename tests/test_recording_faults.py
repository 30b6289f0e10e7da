"""Kills, full disks, damaged and hostile files: an explicit error, or exactly the written values."""

from __future__ import annotations

import random
import subprocess
import sys
import time
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.endless_recording import record_endlessly
from support.forkserver import forkserver
from support.recording_helpers import chain_log, mutate_bytes, oscillator_log

import granular_env.components.catalogue as catalogue
from granular_env.components.errors import GranularError, LogError
from granular_env.components.snapshot import Snapshot
from granular_env.recording import open_log, record, recover, verify
from granular_env.recording.index import FIRST, SEGMENT
from granular_env.recording.records import SNAPSHOTS

# Largest loss of a killed process [s], in running time of the process. Running time is wall time except while the process
# waits on a busy machine, when it neither steps nor writes.
_LOST_SECONDS = 0.1


def _kill(path: Path, after: float, idle_at: int = -1) -> list[tuple[int, float]]:
    """Record in a process and kill it with SIGKILL after a time; return the reported ticks with their ages at the end [s]."""
    told = path.with_suffix(".told")
    told.write_text("")
    process = forkserver.Process(target=record_endlessly, args=(path, told, idle_at))
    process.start()
    while f"\n{idle_at} " not in told.read_text() if idle_at > 0 else not told.read_text().startswith("ready\n"):
        assert process.is_alive()
        time.sleep(0.005)
    time.sleep(after)
    process.kill()
    process.join()
    # Omit a last line that the kill truncated.
    lines = [line.split() for line in told.read_text().splitlines(keepends=True)[1:] if line.endswith("\n")]
    return [(int(tick), float(lines[-1][1]) - float(ran)) for tick, ran in lines]


def _check_killed(path: Path, told: list[tuple[int, float]]) -> None:
    log = open_log(path)
    assert not log.complete and log.header["component"] == "oscillator"
    safe = max((tick for tick, age in told if age > _LOST_SECONDS), default=0)
    assert log.end_tick >= safe, f"{safe - log.end_tick} ticks older than {_LOST_SECONDS} s were lost"
    result = verify(log)
    assert result.outcome == ("incomplete" if log.end_tick else "nothing was compared") and result.variable is None
    path.unlink()


def test_killed_at_random_moments(tmp_path: Path) -> None:
    chance = random.Random(1)
    for _ in range(8):
        _check_killed(tmp_path / "a.mcap", _kill(tmp_path / "a.mcap", chance.uniform(0.0, 0.4)))


def test_killed_while_the_script_sits_idle(tmp_path: Path) -> None:
    told = _kill(tmp_path / "a.mcap", 0.3, idle_at=500)
    assert told[-1][0] == 500
    log = open_log(tmp_path / "a.mcap")
    assert log.end_tick == 500
    whole = recover(tmp_path / "a.mcap", tmp_path / "whole.mcap")
    assert whole.complete and whole.end_tick == 500 and verify(whole).identical


def test_ctrl_c_leaves_a_complete_log(tmp_path: Path) -> None:
    component = catalogue.make("oscillator")
    with pytest.raises(KeyboardInterrupt), record(component, tmp_path / "a.mcap"):
        component.step(0.5)
        raise KeyboardInterrupt
    log = open_log(tmp_path / "a.mcap")
    assert log.complete and log.end_tick == 50 and verify(log).identical


# -- nowhere to write --------------------------------------------------------------------------------------------------


_FULL_DISK = """
import resource, signal, sys
import granular_env as ge
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
component, twin = ge.make("oscillator"), ge.make("oscillator")
recorder = ge.record(component, sys.argv[1], every=0.01)
resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
try:
    for _ in range(200_000):
        twin.step(0.01, force=0.3)
        component.step(0.01, force=0.3)
except ge.LogError as error:
    print(error)
    print(component.time, component.save().data == twin.save().data)
component.step(0.01)
try:
    recorder.close()
except ge.LogError:
    print("told once more")
"""


def test_a_full_disk_is_reported_and_the_state_kept(tmp_path: Path) -> None:
    """A limit on the file size simulates a full disk."""
    path = tmp_path / "full.mcap"
    done = subprocess.run([sys.executable, "-c", _FULL_DISK, str(path)], capture_output=True, text=True, timeout=120)
    told, after, again = done.stdout.splitlines()
    time, is_cached = after.split()
    assert "full.mcap' cannot be written any more" in told and "Recording has stopped" in told
    assert f"The step is complete: the component is at {float(time):.12g} s" in told and is_cached == "True"
    assert again == "told once more"
    assert 0 < open_log(path).end_tick <= round(float(time) / 0.01) and verify(path).outcome == "incomplete"


def test_a_disk_that_fails_at_the_end_of_a_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    component = catalogue.make("oscillator")
    recorder = record(component, tmp_path / "x.mcap")
    component.step(1.0)

    def fail(number: int) -> None:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr("granular_env.recording.writer.os.fsync", fail)
    with pytest.raises(LogError, match=r"x\.mcap.*cannot be written any more: Input/output"):
        recorder.close()
    monkeypatch.undo()
    oscillator_log(tmp_path / "a.mcap")
    monkeypatch.setattr("granular_env.recording.writer.os.fsync", fail)
    with pytest.raises(LogError, match=r"whole\.mcap'.*Input/output error"):
        recover(tmp_path / "a.mcap", tmp_path / "whole.mcap")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.mcap", "x.mcap"], "nothing is left behind"


@pytest.mark.parametrize(
    ("gigabytes", "grains", "fits"),
    [
        (128, 1e8, True),
        (2, 2e7, False),
    ],
)
def test_caps_go_with_the_memory(monkeypatch: pytest.MonkeyPatch, gigabytes: int, grains: float, fits: bool) -> None:
    """A machine does not refuse a log because of its size if it could have recorded the log."""
    from granular_env.components.chain.component import Chain
    from granular_env.recording import container, replay
    from granular_env.recording.replay import check_parameters

    for module in (container, replay):
        monkeypatch.setattr(module, "total_memory", lambda: gigabytes << 30)
    checks = container.Limits("a.mcap")
    for count in (grains, int(grains)):
        if fits:
            check_parameters({"grains": count}, Chain.Parameters, checks)
        else:
            with pytest.raises(LogError, match="allow_large=True"):
                check_parameters({"grains": count}, Chain.Parameters, checks)
    if fits:
        checks.check_chunk(int(grains) * 32)
    with pytest.raises(LogError, match="limit"):
        check_parameters({"grains": 100_000_001}, Chain.Parameters, checks)


# -- damage ------------------------------------------------------------------------------------------------------------


def _everything(path: Path) -> dict[str, Any]:
    """Return all contents of a log as bytes, with frames by tick, to compare the beginning of a log with the whole."""
    with open_log(path) as log:
        found: dict[str, Any] = {"header": (log.step_size, log.identity)}
        for name in log.variables:
            ticks, values = log.ticks(name), log.series(name)[1]
            for tick, value in zip(ticks.tolist(), values, strict=True):
                found[f"{name} {tick}"] = value.tobytes()
        for segment in log.segments:
            steps = log.step_history(segment)
            for place, (ticks, sets) in enumerate(steps):
                told = {
                    k: v if isinstance(v, float) else (v.ticks.tobytes(), v.coefficients.tobytes()) for k, v in sets.items()
                }
                found[f"step {segment.number} {place}"] = (ticks, told)
        for row in log.rows(SNAPSHOTS):
            found[f"snapshot {row[SEGMENT]} {row[FIRST]}"] = log.read_snapshot(row).to_bytes()
        return found


def _fuzz(folder: Path, count: int, seed: int) -> int:
    """Return the number of refused damaged logs; the others must give only original values."""
    oscillator_log(folder / "a.mcap", every=0.1)
    chain_log(folder / "b.mcap", every=6e-7)
    chance = random.Random(seed)
    originals = [(folder / name).read_bytes() for name in ("a.mcap", "b.mcap")]
    truths = [_everything(folder / name) for name in ("a.mcap", "b.mcap")]
    snapshots = [next(v for k, v in truth.items() if k.startswith("snapshot")) for truth in truths]
    refused = 0
    for number in range(count):
        which = number % 2
        damaged = mutate_bytes(originals[which], originals[1 - which], chance)
        (folder / "c.mcap").write_bytes(damaged)
        try:
            found = _everything(folder / "c.mcap")
        except LogError:
            refused += 1
        else:
            wrong = [key for key, value in found.items() if truths[which].get(key) != value]
            assert not wrong, f"damage {number}: {wrong[:3]}"
        damaged = mutate_bytes(snapshots[which], snapshots[1 - which], chance)
        try:
            again = Snapshot.from_bytes(damaged).to_bytes()
        except LogError:
            continue
        assert again in snapshots
    return refused


def test_damaged_logs_and_snapshots_are_refused_or_right(tmp_path: Path) -> None:
    refused = _fuzz(tmp_path, 500, seed=3)
    assert 100 < refused < 500


@pytest.mark.parametrize("content", [b"", b"x", b"\x89MCAP0\r\n", b"\x89MCAP0\r\n" * 9, b"PK\x03\x04" + bytes(500)])
def test_files_that_are_no_logs(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.mcap").write_bytes(content)
    for act in (open_log, verify, lambda path: recover(path, tmp_path / "out.mcap")):
        with pytest.raises(LogError, match=r"a\.mcap"):
            act(tmp_path / "a.mcap")
    assert not (tmp_path / "out.mcap").exists()
    with pytest.raises(LogError):
        open_log(tmp_path)
    with pytest.raises(LogError):
        open_log(tmp_path / "missing.mcap")


# -- hostile files -----------------------------------------------------------------------------------------------------


def test_a_bomb_is_not_unfolded(tmp_path: Path) -> None:
    """A chunk declared as small that expands to 512 MB, and a chunk declared as huge."""
    import lz4.frame

    bomb = lz4.frame.compress(bytes(512 << 20))
    for declared, message in ((1000, "damaged"), (2**40, "limit")):
        head = (0).to_bytes(8, "little") * 2 + declared.to_bytes(8, "little") + (1).to_bytes(4, "little")
        body = head + (3).to_bytes(4, "little") + b"lz4" + len(bomb).to_bytes(8, "little") + bomb
        (tmp_path / "a.mcap").write_bytes(b"\x89MCAP0\r\n\x06" + len(body).to_bytes(8, "little") + body)
        tracemalloc.start()
        with pytest.raises(LogError):
            open_log(tmp_path / "a.mcap")
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 32 << 20, message


def test_a_component_that_is_not_ours_is_only_run_when_handed_over(tmp_path: Path) -> None:
    from granular_env.components.chain.component import Chain

    class Theirs(Chain):
        name = "their_chain"

    component = Theirs(grains=12, radius=3e-3, material="steel")
    with record(component, tmp_path / "a.mcap"):
        component.reset(velocity={0: 1.0})
        component.step(20 * component.step_size)
    with pytest.raises(LogError, match="components="):
        verify(tmp_path / "a.mcap")
    assert verify(tmp_path / "a.mcap", components={"their_chain": Theirs}).identical


def test_every_error_is_of_the_family(tmp_path: Path) -> None:
    oscillator_log(tmp_path / "a.mcap")
    log = open_log(tmp_path / "a.mcap")
    for act in (
        lambda: log.get("velocity", "soon"),  # type: ignore[arg-type]
        lambda: log.get("velocitty", 0.0),
        lambda: log.get("velocity", float("nan")),
        lambda: log.series("mass"),
        lambda: log.branch(-1.0),
        lambda: log.branch(float("inf")),
        lambda: open_log(3),  # type: ignore[arg-type]
        lambda: recover(tmp_path / "a.mcap", tmp_path / "a.mcap", overwrite=True),
    ):
        with pytest.raises(GranularError):
            act()
    assert np.isfinite(log.get("velocity", 0.0))
