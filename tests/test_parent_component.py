"""A component that contains another with a growing state: one state, one snapshot, one undo."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar

import pytest
from support.component_examples import EXAMPLES, Example, load_examples

import granular_env as ge
from granular_env.components.balances import Balance
from granular_env.components.component import Component
from granular_env.components.errors import GranularError, StepError
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.validation import Parameters
from granular_env.components.variables import Variable


@pytest.mark.parametrize("label", ["coupled", "tube"])
def test_a_part_is_not_changed_beside_its_whole(label: str) -> None:
    """A copy of the part can be restored, and the refusal does not affect the parent."""
    whole: Any = load_examples(label)[0].make_started()
    part: Component = whole.grid if label == "coupled" else whole.gas
    saved = part.save()
    before, alone = whole.save().to_bytes(), copy.copy(part)
    calls = {
        "step": [part.step, lambda: part.step(300 * part.step_size)],
        "reset": [part.reset],
        "restore": [lambda: part.restore(saved)],
    }
    for name, ways in calls.items():
        for call in ways:
            told = f"^{name}: component '{part.name}' is a part of component '{whole.name}'.*; call {name} of the whole"
            with pytest.raises(GranularError, match=told):
                call()
    assert whole.save().to_bytes() == before
    alone.step()
    alone.restore(saved)
    assert whole.save().to_bytes() == before
    whole.step()
    whole.reset()


# -- any component as a part -----------------------------------------------------------------------------------------------


class Half(Component):
    """A component with a single part that makes two steps per step."""

    name = "half"
    Parameters = Parameters
    made: ClassVar[Callable[..., Component]]

    def _build_system(self) -> None:
        alone = self.made()
        self.step_size = 2.0 * alone.step_size
        self._define_state(part=("f8", alone.memory.shape))
        self.part = alone.clone(self._block["part"])
        self._include_part(self.part, "part", 2)

    def _declare_variables(self) -> Iterable[Variable]:
        for variable in self.part.declared_variables():
            yield dataclasses.replace(variable, name=f"part_{variable.name}")

    def _output_readers(self) -> dict[str, Callable[[], Any]]:
        outputs = [variable.name for variable in self.part.declared_variables() if variable.causality == "output"]
        return {f"part_{name}": lambda name=name: self.part.peek(name) for name in outputs}

    def _write_start_state(self, seed: int | None, values: Mapping[str, FloatArray]) -> Mapping[str, Any]:
        self.part.reset(seed=seed, **{name.removeprefix("part_"): value for name, value in values.items()})
        return {f"part_{name}": value for name, value in self.part.held_inputs.items()}

    def _advance_state(self, ticks: int) -> int:
        self.part.set_progress(2 * self._tick, {})
        inputs = {name.removeprefix("part_"): value for name, value in self._held.items()}
        self.part.step(ticks * self.step_size, **inputs)
        return 0

    def _step_error(self, status: int) -> StepError:
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
    alone = example.make_started()
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
