"""Chains drawn by hypothesis: radii, materials, gaps, ends, drives and integrators of every kind."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import granular_env as ge
from granular_env.components.chain.parameters import WALLS
from granular_env.components.snapshot import Snapshot

EXAMPLES = 200
TICKS = 60

ENDS = ("free", "piston", *WALLS)
SCHEMES = ("pefrl", "leapfrog", "rk4", "hamming")


@dataclass
class Case:
    """A chain with its start and inputs."""

    parameters: dict[str, Any]
    velocity: list[float]
    inputs: dict[str, Any] = field(default_factory=dict)

    def chain(self) -> ge.Chain:
        chain = ge.make("chain", **self.parameters)
        chain.reset(velocity=self.velocity)
        return chain

    def mirrored(self) -> Case:
        """Return the mirror image of the case."""
        turned = {}
        for name, value in self.parameters.items():
            other = {"left": "right", "right": "left"}.get(name.split("_")[0])
            name = name if other is None else other + name[len(name.split("_")[0]) :]
            turned[name] = value[::-1] if isinstance(value, list) else value
        inputs = {}
        for name, value in self.inputs.items():
            side, rest = name.split("_")
            opposite = ge.Profile(value.starts, -value.coefficients) if isinstance(value, ge.Profile) else -value
            inputs[f"{'right' if side == 'left' else 'left'}_{rest}"] = opposite
        return Case(turned, [-speed for speed in self.velocity[::-1]], inputs)


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_subnormal=False)


@st.composite
def signals(draw: st.DrawFn, size: float) -> Any:
    """Draw a number, or a profile of up to three pieces of degree up to 3 over about ten microseconds."""
    if draw(st.booleans()):
        return draw(numbers(-size, size))
    pieces = draw(st.integers(1, 3))
    starts = np.cumsum([draw(numbers(0.0, 1e-6))] + [draw(numbers(2e-6, 5e-6)) for _ in range(pieces - 1)])
    degree = draw(st.integers(0, 3))
    rows = [[draw(numbers(-size, size)) / (1e-5) ** power for power in range(degree + 1)] for _ in range(pieces)]
    return ge.Profile(starts, np.array(rows))


@st.composite
def cases(draw: st.DrawFn, schemes: tuple[str, ...] = SCHEMES) -> Case:
    grains = draw(st.integers(2, 8))
    left, right = draw(st.sampled_from(ENDS)), draw(st.sampled_from(ENDS))
    material = st.sampled_from(["steel", "aluminium", "brass", "glass"])
    parameters: dict[str, Any] = {
        "grains": grains,
        "radius": [draw(numbers(1e-3, 4e-3)) for _ in range(grains)],
        "material": [draw(material) for _ in range(grains)],
        "left": left,
        "right": right,
        "integrator": draw(st.sampled_from(schemes)),
        "overlap_limit": 0.3,
        "velocity_scale": 20.0,
    }
    for side, end in (("left", left), ("right", right)):
        if end in ("fixed_grain", "plane") and draw(st.booleans()):
            parameters[f"{side}_wall_material"] = draw(material)
    closed = draw(st.sampled_from(["touching", "pressed", "gaps"]))
    if closed == "pressed":
        parameters["precompression"] = draw(numbers(0.1, 100.0))
    elif closed == "gaps":
        touched = [left in WALLS, *[True] * (grains - 1), right in WALLS]
        parameters["gap"] = [draw(numbers(0.0, 2e-6)) if touches else 0.0 for touches in touched]
    velocity = [draw(numbers(-3.0, 3.0)) for _ in range(grains)]
    inputs = {}
    for side, end in (("left", left), ("right", right)):
        if end == "free" and draw(st.booleans()):
            inputs[f"{side}_force"] = draw(signals(100.0))
        if end == "piston" and draw(st.booleans()):
            inputs[f"{side}_velocity"] = draw(signals(2.0))
    return Case(parameters, velocity, inputs)


def stepped(chain: ge.Chain, ticks: int, **inputs: Any) -> None:
    """Step without warnings; reject examples that the guard refuses."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            chain.step(ticks * chain.step_size, **inputs)
        except ge.StepError:
            assume(False)


def samples(case: Case) -> tuple[ge.Chain, float, float]:
    """Return the chain after 60 steps, the run's largest sum |p| plus static impulse, and its largest energy and work."""
    chain, inputs = case.chain(), case.inputs
    momentum, energy = 0.0, 0.0
    for _ in range(TICKS // 5):
        stepped(chain, 5, **inputs)
        inputs = {}
        balances = chain.balance_values()
        momentum = max(momentum, float(np.abs(chain.geometry.mass * chain.get("velocity")).sum()))
        energy = max(energy, balances["kinetic_energy"] + balances["potential_energy"] + abs(balances["input_work"]))
    return chain, momentum + case.parameters.get("precompression", 0.0) * chain.time, energy


@settings(max_examples=EXAMPLES)
@given(cases())
def test_momentum_closes(case: Case) -> None:
    chain, size, _ = samples(case)
    assert abs(chain.get("momentum_residual")) <= 1e-13 * size


@settings(max_examples=EXAMPLES)
@given(cases(), st.lists(st.integers(1, 30), min_size=1, max_size=6))
def test_any_partition_of_steps_gives_the_same_bits(case: Case, parts: list[int]) -> None:
    whole, pieces = case.chain(), case.chain()
    stepped(whole, sum(parts), **case.inputs)
    inputs = case.inputs
    for ticks in parts:
        stepped(pieces, ticks, **inputs)
        inputs = {}
    assert whole.save().to_bytes() == pieces.save().to_bytes()


@settings(max_examples=EXAMPLES)
@given(cases(), st.integers(0, 20), st.integers(1, 20))
def test_a_snapshot_goes_on_bit_for_bit(case: Case, before: int, after: int) -> None:
    chain = case.chain()
    if before:
        stepped(chain, before, **case.inputs)
    data = chain.save().to_bytes()
    stepped(chain, after)
    other = ge.make("chain", **case.parameters)
    other.restore(Snapshot.from_bytes(data))
    assert other.save().to_bytes() == data
    stepped(other, after)
    assert other.save().to_bytes() == chain.save().to_bytes()
