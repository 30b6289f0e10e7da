"""Kills, full disks, damaged and hostile files: an error that says so, or exactly the values that were written."""

from __future__ import annotations

import contextlib
import dataclasses
import os
import random
import time
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import CompressionType, Writer
from support.endless_recording import record_for_ever
from support.forkserver import forkserver
from support.recording_helpers import chain_log, mutated, oscillator_log, rewrite

import granular_env.components.catalogue as catalogue
from granular_env.components.errors import GranularError, LogError, ParameterError
from granular_env.components.snapshot import Snapshot
from granular_env.recording import open_log, record, recover, verify
from granular_env.recording.container import PROFILE
from granular_env.recording.format.record_index import CHUNK
from granular_env.recording.format.records import HEADER, STEPS, Record
from granular_env.recording.recorder import log_file
from granular_env.recording.recorder.recorder import Recorder
from granular_env.recording.recorder.sampling import Schedule

# What a killed process may lose [s]. Counted in the time that the process has been running, which is that of the clock on
# the wall unless a busy machine makes it wait: then it neither steps nor writes.
_LOST_SECONDS = 0.1


def _kill(path: Path, after: float, idle_at: int = -1) -> list[tuple[int, float]]:
    """Record in a process, kill it -9 some time after it is ready; the ticks that it told, each with its age at the end [s]."""
    told = path.with_suffix(".told")
    told.write_text("")
    process = forkserver.Process(target=record_for_ever, args=(path, told, idle_at))
    process.start()
    while f"\n{idle_at} " not in told.read_text() if idle_at > 0 else not told.read_text().startswith("ready\n"):
        assert process.is_alive()
        time.sleep(0.005)
    time.sleep(after)
    process.kill()
    process.join()
    # A last line that the kill cut off is left out.
    lines = [line.split() for line in told.read_text().splitlines(keepends=True)[1:] if line.endswith("\n")]
    return [(int(tick), float(lines[-1][1]) - float(ran)) for tick, ran in lines]


def _check_killed(path: Path, told: list[tuple[int, float]]) -> None:
    log = open_log(path)
    assert not log.complete and log.records.header["component"] == "oscillator"
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


@pytest.mark.slow
def test_killed_a_thousand_times(tmp_path: Path) -> None:
    chance = random.Random(2)
    for _ in range(1000):
        _check_killed(tmp_path / "a.mcap", _kill(tmp_path / "a.mcap", chance.uniform(0.0, 0.5)))


def test_ctrl_c_leaves_a_complete_log(tmp_path: Path) -> None:
    component = catalogue.make("oscillator")
    with pytest.raises(KeyboardInterrupt), record(component, tmp_path / "a.mcap"):
        component.step(0.5)
        raise KeyboardInterrupt
    log = open_log(tmp_path / "a.mcap")
    assert log.complete and log.end_tick == 50 and verify(log).identical


def test_an_interrupt_between_step_and_record_starts_a_new_segment(tmp_path: Path) -> None:
    component = catalogue.make("oscillator")
    with record(component, tmp_path / "a.mcap") as recorder:
        component.reset(velocity=1.0)
        component.step(0.1)
        component.ignore(recorder)
        component.step(0.05)
        component._observers.append(recorder)
        component.step(0.2)
        component.step(0.2)
    log = open_log(tmp_path / "a.mcap")
    assert [(s.start, s.end) for s in log.segments] == [(0, 10), (35, 55)] and verify(log).identical


# -- nowhere to write --------------------------------------------------------------------------------------------------


class _FullDisk:
    """A file on a disk with so many bytes left."""

    published = True

    def __init__(self, room: int) -> None:
        self.room = room

    def write(self, data: Any) -> int:
        self.room -= len(data)
        if self.room < 0:
            raise OSError(28, "No space left on device")
        return len(data)

    def flush(self) -> None:
        pass

    def sync(self) -> None:
        pass

    def close(self) -> None:
        pass


@pytest.mark.parametrize("room", [5000, 9000, 20000])
def test_a_full_disk_is_reported_and_the_state_kept(room: int) -> None:
    component = catalogue.make("oscillator")
    twin = catalogue.make("oscillator")
    recorder = Recorder(component, Path("full/disk.mcap"), _FullDisk(room), ["velocity"], Schedule(1, 64, 64, 0))  # type: ignore[arg-type]
    with pytest.raises(LogError, match=r"full/disk\.mcap.*No space left") as caught:
        for _ in range(200000):
            twin.step(0.01, force=0.3)
            component.step(0.01, force=0.3)
    told = str(caught.value)
    assert f"at {component.time:.12g} s" in told and "The step is complete" in told and "Recording has stopped" in told
    assert component.tick == twin.tick and component.save().memory.tobytes() == twin.save().memory.tobytes()
    component.step(0.01)
    with pytest.raises(LogError, match="No space left"):
        recorder.close()
    recorder.close()


def test_a_full_disk_at_the_very_end() -> None:
    component, disk = catalogue.make("oscillator"), _FullDisk(1 << 30)
    recorder = Recorder(component, Path("x.mcap"), disk, ["velocity"], Schedule(1, 64, 64, 0))  # type: ignore[arg-type]
    component.step(100.0)
    disk.room = 0
    with pytest.raises(LogError, match="No space left"):
        recorder.close()
    assert component.tick == 10000


def test_a_disk_that_fails_while_it_takes_a_long_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The system tells the error of a disk once, to whoever asks first."""
    monkeypatch.setattr(log_file, "_SYNC_BYTES", 20_000)
    asked: list[int] = []

    def failing_once(number: int) -> None:
        asked.append(number)
        if len(asked) == 1:
            raise OSError(5, "Input/output error")

    monkeypatch.setattr(log_file.os, "fsync", failing_once)
    component = catalogue.make("oscillator")
    recorder = record(component, tmp_path / "x.mcap", every=0.01)
    with pytest.raises(
        LogError, match=r"x\.mcap.: its disk did not confirm that it has what was written: Input/output error"
    ) as caught:
        for _ in range(1000):  # told while the run goes on, not at its end alone
            component.step(10.0)
    assert "another disk; if it is incomplete, `granular-env recover`" in str(caught.value)
    assert "do not repeat this step" in str(caught.value)
    assert asked and not component.is_observed
    with contextlib.suppress(LogError):
        recorder.close()


def test_a_disk_that_fails_at_the_end_of_a_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    component = catalogue.make("oscillator")
    recorder = record(component, tmp_path / "x.mcap")
    component.step(1.0)

    def fail(number: int) -> None:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(log_file.os, "fsync", fail)
    with pytest.raises(LogError, match=r"x\.mcap.: its disk did not confirm that it has what was written: Input/output"):
        recorder.close()
    assert open_log(tmp_path / "x.mcap").complete


def test_recovering_onto_a_full_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    oscillator_log(tmp_path / "a.mcap")
    before = (tmp_path / "a.mcap").read_bytes()
    monkeypatch.setattr("granular_env.recording.replay.recovery.create", lambda path, overwrite: _FullDisk(5000))
    with pytest.raises(LogError, match=r"whole\.mcap'.*No space left.*a\.mcap' is as it was") as caught:
        recover(tmp_path / "a.mcap", tmp_path / "whole.mcap")
    assert ".part" not in str(caught.value) and "granular-env recover" not in str(caught.value)
    assert [path.name for path in tmp_path.iterdir()] == ["a.mcap"] and (tmp_path / "a.mcap").read_bytes() == before


@pytest.mark.parametrize(("gigabytes", "grains", "fits"), [(23, 2e7, True), (128, 1e8, True), (4, 1e7, True), (2, 2e7, False)])
def test_caps_go_with_the_memory(monkeypatch: pytest.MonkeyPatch, gigabytes: int, grains: float, fits: bool) -> None:
    """A log that a machine could record is not refused by it for its size."""
    from granular_env.components.chain.component import Chain
    from granular_env.recording.container import limits
    from granular_env.recording.reader import component_from_header
    from granular_env.recording.reader.component_from_header import check_parameters

    for module in (limits, component_from_header):
        monkeypatch.setattr(module, "whole_memory", lambda: gigabytes << 30)
    checks = limits.Limits("a.mcap")
    for count in (grains, int(grains)):
        if fits:
            check_parameters({"grains": count}, Chain.Parameters, checks)
        else:
            with pytest.raises(LogError, match="allow_large=True"):
                check_parameters({"grains": count}, Chain.Parameters, checks)
    if fits:
        checks.chunk(int(grains) * 32)
    with pytest.raises(LogError, match="limit"):
        check_parameters({"grains": 100_000_001}, Chain.Parameters, checks)


@pytest.mark.parametrize("kind", ["device", "pipe", "folder"])
def test_only_a_file_is_written(tmp_path: Path, kind: str) -> None:
    """A pipe would make the program wait for ever; that a folder exists is no reason to offer overwriting it."""
    path = {"device": Path("/dev/null"), "pipe": tmp_path / "pipe", "folder": tmp_path}[kind]
    if kind == "pipe":
        os.mkfifo(path)
    for overwrite in (False, True):
        with pytest.raises(ParameterError, match=r"folder|device, a pipe") as caught:
            record(catalogue.make("oscillator"), path, overwrite=overwrite)
        assert repr(str(path)) in str(caught.value) and "overwrite" not in str(caught.value)


def test_a_folder_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    component = catalogue.make("oscillator")
    with pytest.raises(LogError, match="file"):
        record(component, tmp_path / "file" / "a.mcap")
    component.step(0.01)


def test_another_error_is_not_hidden_by_the_disk(tmp_path: Path) -> None:
    component = catalogue.make("oscillator")
    disk = _FullDisk(1_000_000)
    recorder = Recorder(component, Path("x.mcap"), disk, ["velocity"], Schedule(1, 64, 64, 0))  # type: ignore[arg-type]
    with pytest.raises(ZeroDivisionError), recorder:
        component.step(100.0)
        disk.room = 0  # from here on: the thread that writes could also be told of it while the step lasts
        raise ZeroDivisionError
    assert disk.room < 0


# -- damage ------------------------------------------------------------------------------------------------------------


def _everything(path: Path) -> dict[str, Any]:
    """All that a log gives, as bytes; frames by tick, so that the front of a log can be compared with the whole."""
    with open_log(path) as log:
        found: dict[str, Any] = {"header": (log.step_size, log.identity)}
        for name in log.variables:
            ticks, values = log.ticks(name), log.to_numpy(name)
            for tick, value in zip(ticks.tolist(), values, strict=True):
                found[f"{name} {tick}"] = value.tobytes()
        for segment in log.segments:
            steps = log.steps_of(segment)
            for place, (ticks, sets) in enumerate(steps):
                told = {
                    k: v if isinstance(v, float) else (v.ticks.tobytes(), v.coefficients.tobytes()) for k, v in sets.items()
                }
                found[f"step {segment.number} {place}"] = (ticks, told)
        for segment, tick in log.snapshots:
            found[f"snapshot {segment.number} {tick}"] = log.snapshot(segment, tick).to_bytes()
        return found


def _fuzz(folder: Path, count: int, seed: int) -> int:
    """How many of the damaged logs were refused; the others must give the original values and nothing else."""
    oscillator_log(folder / "a.mcap", every=0.1)
    chain_log(folder / "b.mcap", every=6e-7)
    chance = random.Random(seed)
    originals = [(folder / name).read_bytes() for name in ("a.mcap", "b.mcap")]
    truths = [_everything(folder / name) for name in ("a.mcap", "b.mcap")]
    snapshots = [next(v for k, v in truth.items() if k.startswith("snapshot")) for truth in truths]
    refused = 0
    for number in range(count):
        which = number % 2
        damaged = mutated(originals[which], originals[1 - which], chance)
        (folder / "c.mcap").write_bytes(damaged)
        try:
            found = _everything(folder / "c.mcap")
        except LogError:
            refused += 1
        else:
            wrong = [key for key, value in found.items() if truths[which].get(key) != value]
            assert not wrong, f"damage {number}: {wrong[:3]}"
        damaged = mutated(snapshots[which], snapshots[1 - which], chance)
        try:
            again = Snapshot.from_bytes(damaged).to_bytes()
        except LogError:
            continue
        assert again in snapshots
    return refused


def test_damaged_logs_and_snapshots_are_refused_or_right(tmp_path: Path) -> None:
    refused = _fuzz(tmp_path, 500, seed=3)
    assert 100 < refused < 500


@pytest.mark.slow
def test_twenty_thousand_damaged_logs_and_snapshots(tmp_path: Path) -> None:
    assert _fuzz(tmp_path, 20_000, seed=4) > 4000


def _size(path: Path) -> int:
    return path.stat().st_size if path.exists() else 0


def _wait_for_growth(path: Path, before: int) -> None:
    """Until a log that is being written has grown and stands still: what was recorded is in it, in a chunk of its own."""
    size, end = -1, time.monotonic() + 60.0
    while (now := _size(path)) <= before or now != size:
        assert time.monotonic() < end, "nothing was written in a minute"
        size = now
        time.sleep(0.15)


def test_damage_in_the_middle_names_recover_and_recover_saves_the_front(tmp_path: Path) -> None:
    component = catalogue.make("oscillator")
    with record(component, tmp_path / "a.mcap", every=0.01):
        component.reset(velocity=1.0)
        for _ in range(4):
            before = _size(tmp_path / "a.mcap")
            component.step(1.0)
            _wait_for_growth(tmp_path / "a.mcap", before)
    whole = open_log(tmp_path / "a.mcap")
    middle = whole.records.index.select(STEPS)[2]
    offset, length = whole.records.container.places[middle[CHUNK]]
    data = bytearray((tmp_path / "a.mcap").read_bytes())
    data[offset + length // 2] ^= 0xFF
    (tmp_path / "b.mcap").write_bytes(data)
    with pytest.raises(LogError, match="recover"):
        open_log(tmp_path / "b.mcap").to_numpy("velocity")
    saved = recover(tmp_path / "b.mcap", tmp_path / "c.mcap")
    assert 0 < saved.end_tick < whole.end_tick and verify(saved).identical
    kept = saved.to_numpy("velocity")
    assert len(kept) and kept.tobytes() == whole.to_numpy("velocity")[: len(kept)].tobytes()
    assert saved.incidents[-1]["bytes_lost"] > 0


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


def test_a_message_of_another_log_is_noticed(tmp_path: Path) -> None:
    """Whole messages exchanged between two logs of the same run, every container checksum right."""
    for name, every in (("a", 0.1), ("b", 0.05)):
        oscillator_log(tmp_path / name, every=every)
    contents = []
    for name in "ab":
        from granular_env.recording.container.limits import Limits
        from granular_env.recording.container.reader import McapReader

        container = McapReader(tmp_path / name, Limits(name))
        contents.append([[(m.topic, bytes(m.data)) for m in container.messages(c)] for c in range(container.chunk_count)])
    with (tmp_path / "c").open("wb") as file:
        writer = Writer(file, compression=CompressionType.LZ4)
        writer.start(PROFILE, "")
        schema = writer.register_schema("s", "protobuf", b"")
        topics = sorted({topic for chunk in contents[0] for topic, _ in chunk})
        channels = {topic: writer.register_channel(topic, "protobuf", schema) for topic in topics}
        foreign = next(data for chunk in contents[1] for topic, data in chunk if topic == "granular/steps")
        for chunk in contents[0]:
            for topic, data in chunk:
                writer.add_message(channels[topic], 0, foreign if topic == "granular/steps" else data, 0)
            writer.flush()
        writer.finish()
    with pytest.raises(LogError, match="another log"):
        open_log(tmp_path / "c").steps_of(open_log(tmp_path / "c").segments[0])


# -- hostile files -----------------------------------------------------------------------------------------------------


def test_a_bomb_is_not_unfolded(tmp_path: Path) -> None:
    """A chunk that says it is small and unfolds to 512 MB, and one that says it is huge."""
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


def _with_header(tmp_path: Path, **values: Any) -> Path:
    chain_log(tmp_path / "a.mcap", steps=4)

    def change(old: Record) -> Record:
        return dataclasses.replace(old, header={**old.header, **values}) if old.kind == HEADER else old

    rewrite(tmp_path / "a.mcap", tmp_path / "b.mcap", change)
    return tmp_path / "b.mcap"


@pytest.mark.parametrize(
    "values",
    [
        {"component": "os"},
        {"component": ["chain"]},
        {"parameters": {"grains": 10**12, "radius": 1e-3, "material": "steel"}},
        {"parameters": {"grains": 1e12, "radius": 1e-3, "material": "steel"}},
        {"parameters": None},
        {"parameters": {"grains": -1}},
        {"inputs": []},
        {"step_size": -1.0},
        {"step_size": "0.1"},
        {"variables": [{"name": "velocity"}]},
        {"variables": 3},
        {"format": 99},
    ],
)
def test_headers_that_lie(tmp_path: Path, values: dict[str, Any]) -> None:
    path = _with_header(tmp_path, **values)
    tracemalloc.start()
    with pytest.raises(LogError):
        verify(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # A component of 10^12 grains would take all memory; refusing takes none.
    assert peak < 32 << 20


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
