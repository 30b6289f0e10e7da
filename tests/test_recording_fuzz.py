"""Damaged and inconsistent logs of a component in the plane: array inputs, events and a growing state."""

from __future__ import annotations

import random
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.hostile_logs import ACTIONS, corrupt_record, count_refusals
from support.recording_helpers import change_arrays, mutate_bytes, rewrite_log

import granular_env as ge
from granular_env.components.errors import GranularError
from granular_env.recording import open_log, verify
from granular_env.recording.records import SNAPSHOTS, Record

APART = np.array([[-1.0, 0.5], [0.0, 0.0], [0.0, 0.0], [1.0, -0.5]])


def torn_log(path: Path) -> Path:
    """Record discs torn apart by an array profile and by arrays, with a reset, snapshots, and events in each part."""
    discs = ge.make("discs", rows=2, columns=2, clearance=0.01, breaking_strain=0.003, step_size=1e-4)
    with ge.record(discs, path, every=1e-3, hash_every=7, snapshot_every=2e-3):
        discs.step(3e-3, force=ge.Profile.half_sine(2.0, 3e-3) * APART)
        discs.reset(velocity={0: (-0.3, 0.2)})
        for number in range(6):
            discs.step(5e-4, force=0.5 * number * APART)
    return path


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, bytes]:
    folder = tmp_path_factory.mktemp("fuzz")
    log = open_log(torn_log(folder / "a.mcap"))
    assert len(log.events()) >= 3 and len(log.segments) == 2 and verify(folder / "a.mcap").identical
    with ge.record(ge.make("oscillator"), folder / "other.mcap") as recorder:
        del recorder
    return folder / "a.mcap", (folder / "other.mcap").read_bytes()


def write_lying(source: Path, out: Path, chance: random.Random) -> None:
    """Write the log with one false record, and with valid checksums, sizes and index."""
    victim, number = chance.randrange(24), 0

    def change(record: Record) -> Record:
        nonlocal number
        number += 1
        return corrupt_record(record, chance) if number - 1 == victim else record

    rewrite_log(source, out, change)


def try_lies(
    logs: tuple[Path, bytes], folder: Path, seed: int, cases: int, actions: dict[str, Any] = ACTIONS
) -> tuple[int, int]:
    """Return the number of cases that could be written, and the number refused by at least one of two actions."""
    source, other = logs
    chance, written, refused = random.Random(seed), 0, 0
    for case in range(cases):
        if case % 2:
            (folder / "b.mcap").write_bytes(mutate_bytes(source.read_bytes(), other, chance))
        else:
            try:
                write_lying(source, folder / "b.mcap", chance)
            except (GranularError, KeyError, ValueError, TypeError, AttributeError, OverflowError):
                continue  # the tests' writer cannot write this change
        written += 1
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                chosen = [actions[name] for name in chance.sample(sorted(actions), 2)]
                refused += bool(count_refusals(folder / "b.mcap", chosen))
            except Exception as error:
                kept = folder / f"case-{seed}-{case}.mcap"
                kept.write_bytes((folder / "b.mcap").read_bytes())
                raise AssertionError(f"{type(error).__name__} came out of case {case} of seed {seed}: {kept}") from error
    return written, refused


@pytest.mark.parametrize("seed", range(2))
def test_lies_and_damage_are_refused_or_harmless(logs: tuple[Path, bytes], tmp_path: Path, seed: int) -> None:
    written, refused = try_lies(logs, tmp_path, seed, 60)
    assert written > 40 and refused > 10


@pytest.mark.parametrize("count", [-1, 1, 99, 2**40, 2**62])
def test_a_list_of_another_length_than_its_count_is_refused(logs: tuple[Path, bytes], tmp_path: Path, count: int) -> None:
    discs = open_log(logs[0]).component()
    fixed = len(discs.memory)

    def change(record: Record) -> Record:
        if record.kind != SNAPSHOTS:
            return record
        snapshot = ge.Snapshot.from_bytes(record.arrays["snapshot"].tobytes())
        words = np.array(snapshot.memory).view(np.int64)
        words[fixed - 1] = count
        lying = ge.Snapshot(snapshot.identity, snapshot.tick, words.tobytes(), snapshot.inputs)
        return change_arrays(record, snapshot=np.frombuffer(lying.to_bytes(), np.uint8))

    rewrite_log(logs[0], tmp_path / "b.mcap", change)
    with pytest.raises(GranularError, match="with inconsistent sizes"):
        verify(tmp_path / "b.mcap")
    count_refusals(tmp_path / "b.mcap")
