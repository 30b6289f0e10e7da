"""A component that owns the memory of two others, whose states grow: one state, one snapshot, one undo."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from pydantic import Field
from support.component_examples import EXAMPLES, Example, of_component

import granular_env as ge
from granular_env.components.balances import Balance
from granular_env.components.component import Component
from granular_env.components.discs import Discs
from granular_env.components.errors import GranularError, StepError
from granular_env.components.state_block import Block
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.validation import Parameters
from granular_env.components.variables import Variable
from granular_env.recording import open_log, verify

STEP = 1e-5


class TwoRowsParameters(Parameters):
    """Two rows of discs."""

    first: int = Field(3, ge=2, description="discs in the first row", json_schema_extra={"unit": "1"})
    second: int = Field(4, ge=2, description="discs in the second row", json_schema_extra={"unit": "1"})


class TwoRows(Component):
    """Two rows of discs in boxes of their own, the one pulled at its ends by as much as the other is pushed."""

    name = "two-rows"
    Parameters = TwoRowsParameters
    parameters: TwoRowsParameters
    event_kinds = {"both_broken": "a link is broken in each row"}

    def _build(self) -> None:
        p, self.step_size = self.parameters, STEP
        alone = [Discs(rows=1, columns=columns, step_size=STEP, breaking_strain=0.004) for columns in (p.first, p.second)]
        sizes = {f"row{number}": ("f8", part.memory.shape) for number, part in enumerate(alone)}
        self._lay_out(told=("f8", ()), **sizes)
        self.parts = [part.clone(self._block[name]) for name, part in zip(sizes, alone, strict=True)]
        for name, part in zip(sizes, self.parts, strict=True):
            self._include(part, name)

    def _declare(self) -> Iterable[Variable]:
        yield Variable("pull", "input", "N", (), "force that pulls the ends apart", start=0.0)
        for name, part in zip(("a", "b"), self.parts, strict=True):
            shape = part.variables["velocity"].shape
            yield Variable(f"velocity_{name}", "output", "m/s", shape, "velocity", state=True)
            yield Variable(f"broken_{name}", "output", "1", (), "number of broken links")

    def _outputs(self) -> dict[str, Callable[[], Any]]:
        named = list(zip(("a", "b"), self.parts, strict=True))
        return {
            **{f"velocity_{name}": (lambda part=part: part.peek("velocity")) for name, part in named},
            **{f"broken_{name}": (lambda part=part: part.peek("broken_links")) for name, part in named},
        }

    def _start(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        for name, part in zip(("a", "b"), self.parts, strict=True):
            part.reset(**{"velocity": values[f"velocity_{name}"]} if f"velocity_{name}" in values else {})
        return {}

    def _advance(self, ticks: int) -> int:
        pull: Any = self._held["pull"]
        for tick in range(self._tick, self._tick + ticks):
            now = pull.value(tick, 0.5) if hasattr(pull, "value") else pull
            for sign, part in zip((1.0, -1.0), self.parts, strict=True):
                part.adopt(tick, {})
                force = np.zeros((part.parameters.columns, 2))
                force[0, 0], force[-1, 0] = -sign * now, sign * now
                try:
                    part.step(STEP, force=force)
                except StepError:
                    return 1
            if self._block["told"] == 0.0 and all(part.peek("broken_links") for part in self.parts):
                self._block["told"][...] = 1.0
                self._add_event(tick + 1, "both_broken", None, 2.0, 1.0)
        return 0

    def _explain(self, status: int) -> StepError:
        return StepError("too fast; pull less", time=self.time, variable="velocity_a", index=0, value=1e9, limit=1.0)

    def balances(self) -> tuple[Balance, ...]:
        found = [part.balances()[0] for part in self.parts]
        total = {name: sum(float(one.entries[name]) for one in found) for name in found[0].entries}
        stored = {name: total[name] for name in ("kinetic_energy", "potential_energy")}
        lost, start = {"fracture_energy": total["fracture_energy"]}, sum(float(one.initial) for one in found)
        return (Balance("energy", "J", stored, {"input_work": total["input_work"]}, lost, start),)


def torn() -> TwoRows:
    rows = TwoRows()
    rows.reset(velocity_b={0: (-0.2, 0.1)})
    rows.step(4e-3, pull=0.9)
    return rows


def test_one_snapshot_holds_the_lists_of_all_parts() -> None:
    rows = torn()
    assert rows.get("broken_a") > 0 and rows.get("broken_b") > 0
    assert len(rows.events()) == 1 + sum(part.event_count for part in rows.parts)
    lists = sum(part.state_bytes - part.memory.nbytes for part in rows.parts)
    assert rows.state_bytes == rows.memory.nbytes + lists + 5 * 8 == len(rows.save().data)
    other = TwoRows()
    other.restore(ge.Snapshot.from_bytes(rows.save().to_bytes()))
    assert [part.events() for part in other.parts] == [part.events() for part in rows.parts]
    for component in (rows, other):
        component.step(4e-3, pull=-0.5)
    assert other.save().to_bytes() == rows.save().to_bytes()


def test_the_events_of_parts_are_events_of_the_whole() -> None:
    rows = torn()
    events = rows.events()
    assert list(rows.event_kinds) == ["both_broken", "row0_link_broken", "row1_link_broken"]
    for number, part in enumerate(rows.parts):
        own = [event for event in events if event.kind == f"row{number}_link_broken"]
        assert own == [dataclasses.replace(event, kind=f"row{number}_link_broken") for event in part.events()]
    assert [event.tick for event in events] == sorted(event.tick for event in events)
    assert [row[0] for row in rows.event_rows(1)] == [event.tick for event in events[1:]] and rows.event_count == len(events)
    # What is known at a tick stays at the head of the list.
    again, seen = TwoRows(), []
    again.reset(velocity_b={0: (-0.2, 0.1)})
    for _ in range(400):
        again.step(STEP, pull=0.9)
        assert again.events()[: len(seen)] == seen
        seen = again.events()
    assert seen == events


@pytest.mark.parametrize("label", ["two-rows", "coupled", "tube"])
def test_a_part_is_not_changed_beside_its_whole(label: str) -> None:
    """A copy of the part can be; and the whole goes on as if nothing had been asked of it."""
    whole: Any = torn() if label == "two-rows" else of_component(label)[0].started()
    part: Component = {"two-rows": lambda: whole.parts[0], "coupled": lambda: whole.grid, "tube": lambda: whole.gas}[label]()
    saved = part.save()
    before, alone = whole.save().to_bytes(), copy.copy(part)
    calls = {
        "step": [part.step, lambda: part.step(300 * part.step_size)],
        "reset": [part.reset],
        "restore": [lambda: part.restore(saved)],
    }
    for name, ways in calls.items():
        for call in ways:
            told = f"^{name}: component '{part.name}' is a part of component '{whole.name}'.*; {name} the whole"
            with pytest.raises(GranularError, match=told):
                call()
    assert whole.save().to_bytes() == before
    alone.step()
    alone.restore(saved)
    assert whole.save().to_bytes() == before
    whole.step()
    whole.reset()


def test_any_partition_into_steps_gives_the_same_bits() -> None:
    once, often = torn(), TwoRows()
    often.reset(velocity_b={0: (-0.2, 0.1)})
    for number in range(40):
        often.step(1e-4, pull=0.9)
        if number == 20:
            saved = often.save()
            often.step(5e-4, pull=2.0)
            often.restore(saved)
    assert often.save().data == once.save().data


def test_a_step_that_fails_leaves_all_parts_as_they_were() -> None:
    rows = torn()
    before, broken = rows.save(), [part.events() for part in rows.parts]
    with pytest.raises(StepError):
        rows.step(2e-3, pull=1e6)
    assert rows.save().to_bytes() == before.to_bytes() and [part.events() for part in rows.parts] == broken


def test_it_is_recorded_verified_and_branched(tmp_path: Path) -> None:
    rows = TwoRows()
    with ge.record(rows, tmp_path / "a.mcap", every=1e-4, hash_every=10):
        rows.reset(velocity_b={0: (-0.2, 0.1)})
        rows.step(2e-3, pull=ge.Profile.half_sine(1.5, 4e-3))
        rows.step(2e-3, pull=0.9)
    own = {"two-rows": TwoRows}
    assert verify(tmp_path / "a.mcap", components=own).identical
    with open_log(tmp_path / "a.mcap", components=own) as log:
        assert [event.kind for event in log.events()] == [event.kind for event in rows.events()]
        branch = log.branch(2e-3)
        branch.run(tmp_path / "b.mcap")
    assert branch.component.save().data == rows.save().data


def test_a_part_elsewhere_is_refused() -> None:
    whole, part = Block(first=("f8", (4,))), Block(growing={"rows": ("f8", ())}, second=("f8", (2,)))
    with pytest.raises(ValueError, match="does not lie"):
        whole.include(part)


@pytest.mark.parametrize("count", [-1, 1, 10**6, 2**62])
def test_a_snapshot_whose_counts_lie_is_refused(count: int) -> None:
    rows = torn()
    words = np.array(rows.save().memory).view(np.int64)
    first = 1 + rows.parts[0].memory.size  # after `told` and the first row
    words[first - 1] += count
    lying = ge.Snapshot(rows.identity, rows.tick, words.tobytes(), rows.held_inputs)
    with pytest.raises(GranularError, match="sizes do not agree"):
        rows.restore(lying)


# -- a part of any component -----------------------------------------------------------------------------------------------


class Half(Component):
    """A component whose only part makes two steps in one of its own."""

    name = "half"
    Parameters = Parameters
    made: ClassVar[Callable[..., Component]]

    def _build(self) -> None:
        alone = self.made()
        self.step_size = 2.0 * alone.step_size
        self._lay_out(part=("f8", alone.memory.shape))
        self.part = alone.clone(self._block["part"])
        self._include(self.part, "part", 2)

    def _declare(self) -> Iterable[Variable]:
        for variable in self.part.declared():
            yield dataclasses.replace(variable, name=f"part_{variable.name}")

    def _outputs(self) -> dict[str, Callable[[], Any]]:
        outputs = [variable.name for variable in self.part.declared() if variable.causality == "output"]
        return {f"part_{name}": lambda name=name: self.part.peek(name) for name in outputs}

    def _start(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        self.part.reset(seed=seed, **{name.removeprefix("part_"): value for name, value in values.items()})
        return {f"part_{name}": value for name, value in self.part.held_inputs.items()}

    def _advance(self, ticks: int) -> int:
        self.part.adopt(2 * self._tick, {})
        inputs = {name.removeprefix("part_"): value for name, value in self._held.items()}
        self.part.step(ticks * self.step_size, **inputs)
        return 0

    def _explain(self, status: int) -> StepError:
        raise NotImplementedError

    def balances(self) -> tuple[Balance, ...]:
        return self.part.balances()


GROWING = [
    example
    for label in ("discs", "grid-von-mises-pinwheel", "automata-cracking")
    for example in EXAMPLES
    if example.label == label
]


@pytest.mark.parametrize("example", GROWING, ids=lambda example: example.label)
def test_every_component_that_grows_can_be_a_part(example: Example) -> None:
    whole = type("Half", (Half,), {"made": staticmethod(example.make)})()
    alone = example.started()
    whole.reset(**{f"part_{name}": value for name, value in example.start.items()})
    inputs = {f"part_{name}": value for name, value in example.inputs.items()}
    half = example.ticks // 4
    for count in (half, half):
        saved = whole.save()
        whole.step(count * whole.step_size, **inputs)
        alone.step(2 * count * alone.step_size, **example.inputs)
        after = whole.save().data
        assert whole.part.save().data == alone.save().data and whole.state_bytes == len(after)
        whole.restore(ge.Snapshot.from_bytes(saved.to_bytes()))
        whole.step(count * whole.step_size, **inputs)
        assert whole.save().data == after
    events = alone.events()
    assert not alone.event_kinds or events
    expected = [dataclasses.replace(e, tick=-(-e.tick // 2), kind=f"part_{e.kind}") for e in events]
    assert whole.events() == expected
    whole.reset()
    assert whole.events() == []
