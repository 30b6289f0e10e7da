"""Helpers of the conformance suite that read, drive and observe a component."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from granular_env.components.component import Component
from granular_env.components.errors import GranularWarning, StepError
from support.component_examples import EXAMPLES, Example

every_example = pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.label)
# Examples for mechanisms common to all components: one with scalar inputs, one with kernels, one with arrays and growing lists.
THREE = [example for example in EXAMPLES if example.label in ("oscillator-forced", "chain-pefrl", "discs")]
on_three_components = pytest.mark.parametrize("example", THREE, ids=lambda example: example.label)


def state_bits(component: Component) -> bytes:
    """Return the complete changing state as bytes."""
    return component.save().to_bytes()


def variable_bytes(component: Component) -> dict[str, bytes]:
    """Return all variables except the parameters as bytes."""
    return {
        name: np.asarray(component.get(name)).tobytes()
        for name, variable in component.variables.items()
        if variable.causality != "parameter"
    }


def drive_component(component: Component, example: Example, ticks: int) -> None:
    """Step one tick at a time with held numbers, then with changed numbers, then with profiles."""
    half = {name: 0.5 * value for name, value in example.inputs.items()}
    profiles = example.all_profiles(component)
    changes = {0: example.inputs, ticks // 4: half, ticks // 2: profiles}
    for tick in range(ticks):
        component.step(None, **changes.get(tick, {}))


# For `load_until_refused`: ticks per call, calls until the full load, and largest number of calls.
CALL_TICKS, GROWING_CALLS, MOST_CALLS = 3, 20, 60


def growing_load(example: Example, call: int) -> dict[str, object]:
    """Return the destructive inputs of a call: they grow by four decades, then stay constant."""
    assert example.breaks is not None
    scale = 10.0 ** min(0.0, 4.0 * call / (GROWING_CALLS - 1) - 4.0)
    return {name: scale * value for name, value in example.breaks[2].items()}


def load_until_refused(component: Component, example: Example, first: int = 0, last: int = MOST_CALLS) -> tuple[int, str]:
    """Step under a growing load until a call is refused; return its number and the message, or `last` and ""."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GranularWarning)
        for call in range(first, last if example.breaks else first):
            try:
                component.step(CALL_TICKS * component.step_size, **growing_load(example, call))
            except StepError as error:
                return call, str(error)
    return last, ""


class Watcher:
    """An observer that reads all variables every `every` ticks and counts its notifications."""

    def __init__(self, every: int) -> None:
        self.every, self.next_tick, self.looks, self.calls = every, 0, [], []

    def on_reset(self, component: Component) -> None:
        self.next_tick = component.tick + self.every
        self.calls.append("on_reset")

    def on_sample(self, component: Component) -> None:
        self.looks.append(component.tick)
        variable_bytes(component), component.save(), component.report(), component.conclusions(), component.cautions()
        self.next_tick = component.tick + self.every

    def on_step(self, component: Component, ticks: int, inputs: dict) -> None:
        self.calls.append(ticks)

    def on_failure(self, component: Component, error: BaseException) -> None:
        self.calls.append(type(error).__name__)
