"""Untrusted snapshots: with any numbers they are refused, or step and are read with no error but GranularError."""

from __future__ import annotations

import os
import random
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.component_examples import EXAMPLES, Example
from support.conformance_tools import drive_component
from support.forged_states import forge_snapshot, outcomes, try_snapshot
from support.hostile_logs import ACTIONS, count_refusals
from support.recording_helpers import change_arrays, rewrite_log

import granular_env as ge
from granular_env.components.errors import LogError, ParameterError
from granular_env.components.state_block import Block
from granular_env.recording.records import SNAPSHOTS, Record

BY_LABEL = {example.label: example for example in EXAMPLES}
forking = pytest.mark.skipif(not hasattr(os, "fork"), reason="signals are told apart in forked processes")
every_example = pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.label)


def try_forgeries(example: Example, cases: int, seed: int) -> Counter[str]:
    """Forge states of an example at its start and after its drive; return their outcomes."""
    component = example.make_started()
    states = [component.save()]
    drive_component(component, example, example.ticks)
    states.append(component.save())
    forged = example.make()

    def run(number: int) -> str:
        chance = random.Random(f"{example.label} {seed} {number}")
        return try_snapshot(forged, forge_snapshot(forged, states[chance.random() < 0.8], chance))

    return _counted(cases, run)


def recorded(example: Example, path: Path) -> ge.Component:
    """Record an example with intermediate snapshots; return it."""
    component = example.make_started()
    ticks = component.step_size * (example.ticks // 3)
    with ge.record(component, path, every=ticks, snapshot_every=ticks):
        drive_component(component, example, example.ticks)
    return component


def try_forged_logs(example: Example, folder: Path, cases: int, seed: int) -> Counter[str]:
    """Forge snapshots in copies of a log of an example; verify, recover and branch the copies."""
    path, out = folder / "a.mcap", folder / "b.mcap"
    forged = recorded(example, path)
    actions = [ACTIONS[name] for name in ("verify", "recover", "branch", "events", "series")]

    def run(number: int) -> str:
        chance = random.Random(f"{example.label} {seed} {number}")

        def change(record: Record) -> Record:
            if record.kind != SNAPSHOTS or (record.arrays and chance.random() < 0.3):
                return record
            snapshot = ge.Snapshot.from_bytes(record.arrays["snapshot"].tobytes())
            return change_arrays(record, snapshot=np.frombuffer(forge_snapshot(forged, snapshot, chance).to_bytes(), np.uint8))

        rewrite_log(path, out, change)
        return "refused" if count_refusals(out, actions) else "lasted"

    return _counted(cases, run)


def _counted(cases: int, run: Callable[[int], str]) -> Counter[str]:
    found, bad = outcomes(cases, run)
    assert not bad, f"{len(bad)} of {cases}:\n" + "\n".join(bad[:10])
    return found


@forking
@every_example
def test_forged_states_are_refused_or_harmless(example: Example) -> None:
    try_forgeries(example, 8, seed=1)


@forking
def test_logs_with_forged_states_are_refused_or_harmless(tmp_path: Path) -> None:
    assert try_forged_logs(BY_LABEL["grid-von-mises-pinwheel"], tmp_path, 6, seed=1)["refused"]


@forking
@pytest.mark.slow
@every_example
def test_twenty_thousand_forged_states(example: Example) -> None:
    found = try_forgeries(example, 20_000 // len(EXAMPLES) + 1, seed=2)
    assert found["refused"] and found["failed"] + found["lasted"]


@forking
@pytest.mark.slow
@every_example
def test_many_logs_with_forged_states(example: Example, tmp_path: Path) -> None:
    try_forged_logs(example, tmp_path, 20, seed=2)


# -- refusals -------------------------------------------------------------------------------------------------------------


def torn_discs() -> ge.Component:
    discs = ge.make("discs", rows=2, columns=2, breaking_strain=0.003, step_size=1e-4)
    discs.step(3e-3, force=np.array([[-1.0, 0.5], [0.0, 0.0], [0.0, 0.0], [1.0, -0.5]]))
    assert discs.event_count
    return discs


def with_values(component: ge.Component, name: str, change: Callable[[np.ndarray], None]) -> ge.Snapshot:
    """Return the snapshot of a component with an array or a list of its state changed in place."""
    snapshot, block = component.save(), component._block  # noqa: SLF001
    data = np.frombuffer(snapshot.data, np.uint8).copy()
    change(block.state_arrays(data, block)[name])  # type: ignore[arg-type] - views of what can be written
    return ge.Snapshot(snapshot.identity, snapshot.tick, data.tobytes(), snapshot.inputs)


@pytest.mark.parametrize(
    ("name", "place", "value", "text"),
    [
        ("broken", 0, -1, r"snapshot.broken\[0\]: got -1, expected 0 to 3"),
        ("velocity", (3, 1), np.nan, r"snapshot.velocity\[3,1\]: got nan, expected a finite number"),
        ("events", (0, 2), 4.0, "snapshot.events: got invalid events, expected events with indices of existing elements"),
        ("events", (0, 0), 2.0**40, "snapshot.events: got invalid events, .* ticks that do not decrease, up to 30"),
    ],
)
def test_values_out_of_their_range_are_refused_by_name(name: str, place: Any, value: float, text: str) -> None:
    discs = torn_discs()

    def change(array: np.ndarray) -> None:
        array[place] = value

    forged, before = with_values(discs, name, change), discs.save()
    for _ in range(2):
        with pytest.raises(ParameterError, match=text):
            discs.restore(forged)
        assert discs.save().to_bytes() == before.to_bytes()
    with pytest.raises(ParameterError, match=text):
        discs.refuse_foreign_snapshot(forged)


def test_a_cell_yields_once() -> None:
    example = BY_LABEL["grid-von-mises-pinwheel"]
    grid = example.make_started()
    drive_component(grid, example, example.ticks)
    assert grid.event_count

    def change(strain: np.ndarray) -> None:
        strain[:] = 0.0

    with pytest.raises(ParameterError, match=r"snapshot: got 0 yielded cells, but \d+ events"):
        grid.restore(with_values(grid, "plastic_strain", change))


def test_a_part_is_checked_by_its_own_ranges(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    medium: Any = recorded(BY_LABEL["coupled-cracking"], path)

    def change(record: Record) -> Record:
        if record.kind != SNAPSHOTS:
            return record
        words = np.array(ge.Snapshot.from_bytes(record.arrays["snapshot"].tobytes()).memory)
        words[medium._block._first_word(medium.grid._block)] = np.nan  # noqa: SLF001
        forged = ge.Snapshot(medium.identity, record.first, words.tobytes(), medium.held_inputs)
        return change_arrays(record, snapshot=np.frombuffer(forged.to_bytes(), np.uint8))

    rewrite_log(path, tmp_path / "b.mcap", change)
    with pytest.raises(LogError, match=r"snapshots.grid.displacement\[0,0\]: got nan, expected a finite number"):
        ge.verify(tmp_path / "b.mcap")


def test_what_may_be_infinite_is_declared() -> None:
    block = Block(first=("f8", (2,), 0.0, np.inf), second=("f8", (1,)))
    block["first"][:] = np.inf
    block.refuse_out_of_range(block.views, ("snapshot",))
    block["second"][:] = np.inf
    with pytest.raises(ParameterError, match=r"snapshot.second\[0\]: got inf, expected a finite number"):
        block.refuse_out_of_range(block.views, ("snapshot",))
    block["second"][:], block["first"][1] = 0.0, -1.0
    with pytest.raises(ParameterError, match=r"snapshot.first\[1\]: got -1, expected 0 or more"):
        block.refuse_out_of_range(block.views, ("snapshot",))
