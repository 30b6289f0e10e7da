"""Snapshots of strangers: whatever their numbers are, they are refused, or stepped and read within the family of errors."""

from __future__ import annotations

import os
import random
from collections import Counter

import pytest
from support.component_examples import EXAMPLES, Example
from support.conformance_tools import drive
from support.forged_states import forge, outcomes, try_out

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="signals are told apart in forked processes")


def try_forgeries(example: Example, cases: int, seed: int) -> Counter[str]:
    """Forge so many states of an example, at its start and as far as it is driven; return how they ended."""
    component = example.started()
    states = [component.save()]
    drive(component, example, example.ticks)
    states.append(component.save())
    forged = example.make()

    def run(number: int) -> str:
        chance = random.Random(f"{example.label} {seed} {number}")
        return try_out(forged, forge(forged, states[chance.random() < 0.8], chance))

    found, bad = outcomes(cases, run)
    assert not bad, f"{example.label}: {len(bad)} of {cases}:\n" + "\n".join(bad[:10])
    return found


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.label)
def test_forged_states_are_refused_or_harmless(example: Example) -> None:
    found = try_forgeries(example, 10, seed=1)
    assert found["refused"]


@pytest.mark.slow
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.label)
def test_twenty_thousand_forged_states(example: Example) -> None:
    found = try_forgeries(example, 20_000 // len(EXAMPLES) + 1, seed=2)
    assert found["refused"] and found["failed"] + found["lasted"]
