"""Exact gradients against central differences and a closed form; evaluated runs bitwise against the component's steps."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest

from granular_env import Chain, ParameterError, StepError
from granular_env.components.chain.adjoint import evaluate_objective, value_and_adjoint
from granular_env.components.chain.layout import U, V
from granular_env.components.chain.objective import Objective
from granular_env.components.support.jit import jit
from granular_env.domains.chain.control import (
    central_differences,
    contact_force,
    displacement,
    end_input,
    energy,
    kinetic_energy,
    momentum,
    total,
    value_and_grad,
    velocity,
)

# Bound of the gradient's error, relative to the change along a direction.
BOUND = 1e-7
TICKS = 3

POWER = {"law": {"name": "power", "exponent": 1.8}, "contact_stiffness": 1e10}
VISCOUS = {"law": {"name": "viscous", "dissipation": 20.0}}
KUWABARA_KONO = {"law": {"name": "kuwabara_kono", "dissipation": [0.0, 2e4, 3e4, 1e4, 2e4, 5e4, 1e3, 2e4, 2e4, 4e4, 0.0]}}
CASES: dict[str, dict[str, Any]] = {
    "free ends, pressed": {"precompression": 50.0},
    "free ends, at rest": {},
    "piston and rigid plane": {"left": "piston", "right": "rigid_plane", "precompression": 3.0},
    "two pistons, leapfrog": {"left": "piston", "right": "piston", "integrator": "leapfrog", "precompression": 5.0},
    "gaps": {"right": "piston", "gap": [0.0, 1e-7, 0.0, 3e-7, 0.0, 0.0, 2e-7, 1e-8, 0.0, 0.0, 0.0]},
    "fixed grain and plane, one stiffness": {
        "left": "fixed_grain", "right": "plane", "integrator": "leapfrog", "radius": 3e-3, "contact_stiffness": 6e9,
        "precompression": 10.0,
    },
    "hanging from a plane": {"right": "plane", "gravity": -40.0, "left": "piston", "precompression": 20.0, "mass": {3: 1e-3}},
    "standing on a plane": {"right": "plane", "gravity": 40.0, "precompression": 20.0},
    "pushed up by a piston": {"left": "piston", "gravity": 40.0, "precompression": 20.0},
    "between walls": {"left": "plane", "right": "plane", "gravity": -40.0, "precompression": 2.0},
    "power": {"right": "plane", "precompression": 30.0, **POWER},
    "power at rest, leapfrog": {"left": "piston", "integrator": "leapfrog", **POWER},
    "viscous": {"right": "plane", "precompression": 30.0, **VISCOUS},
    "viscous, leapfrog": {"left": "piston", "integrator": "leapfrog", "precompression": 30.0, **VISCOUS},
    "viscous, gaps": {"right": "plane", "gap": 2e-6, **VISCOUS},
    "viscous at rest, leapfrog": {"integrator": "leapfrog", **VISCOUS},
    "kuwabara_kono": {"right": "piston", "precompression": 30.0, **KUWABARA_KONO},
    "kuwabara_kono, falling, leapfrog": {
        "left": "piston", "gravity": 40.0, "precompression": 30.0, "integrator": "leapfrog", **KUWABARA_KONO,
    },
    "impurity": {
        "radius": 3e-3, "precompression": 50.0, "arrangement": {"name": "impurity", "index": 3, "radius": 2e-3, "mass": 4e-4},
    },
}  # fmt: skip
# Slow because of kernels that no other test needs. Gradients of these laws are tested above with the other integrator, or in
# test_chain_law_functions.py.
SLOW = ("kuwabara_kono", "power", "power at rest, leapfrog", "kuwabara_kono, falling, leapfrog", "viscous, leapfrog",
        "viscous at rest, leapfrog")  # fmt: skip
MARKED_CASES = [pytest.param(name, marks=[pytest.mark.slow] if name in SLOW else []) for name in CASES]


def task(name: str, seed: int, steps: int = 12) -> tuple[Chain, Any, Any]:
    """Return a chain in a random state, a random drive, and an objective that depends on all quantities."""
    rng = np.random.default_rng([seed, len(name)])
    parameters = {"grains": 10, "radius": list(3e-3 * (0.8 + 0.4 * rng.random(10))), "step_size": 5e-7} | CASES[name]
    chain = Chain(**parameters)
    pressed = chain.parameters.precompression > 0.0
    chain.reset(velocity=rng.normal(size=10) * (0.02 if pressed else 0.3), displacement=rng.normal(size=10) * 1e-8 * pressed)
    sizes = [0.1 if end == "piston" else 20.0 for end in (chain.parameters.left, chain.parameters.right)]
    drive = (0.5 + rng.random((steps, 2))) * np.array([sizes[0], -sizes[1]])
    terms = [
        velocity(-3).at_end(target=0.5), 1e6 * displacement(2).mean(), 1e3 * energy(1, 6).at_end(),
        1e3 * kinetic_energy().mean(begin=-5), 2e2 * momentum(0, 4).mean(target=1e-3),
        1e-3 * end_input("left").mean(target=0.3), 1e-2 * contact_force(-2).peak(scale=40.0, power=8),
    ]  # fmt: skip
    return chain, drive, total(chain, *terms)


def derivatives(chain: Chain) -> dict[str, Any]:
    """Return the names of this chain's gradients, each with a step size that has an effect and exceeds no limit."""
    p, g = chain.parameters, chain.geometry
    sizes: dict[str, Any] = {"drive": 1.0, "radius": 3e-5, "mass": 0.05 * g.mass, "velocity": 0.01, "displacement": 2e-8}
    sizes["contact_stiffness"] = 0.1 * (p.contact_stiffness or g.stiffness)
    if p.precompression > 0.0:
        sizes["precompression"] = 0.1 * p.precompression
    if isinstance(p.gap, list):
        sizes["gap"] = 0.5 * np.array(p.gap)
    if p.gravity != 0.0:
        sizes["gravity"] = 10.0
    if hasattr(p.law, "dissipation"):
        sizes["dissipation"] = 0.3 * np.asarray(p.law.dissipation)  # type: ignore[attr-defined]
    sizes["drive"] = np.array([{"piston": 0.02, "free": 5.0}.get(end, 0.0) for end in (p.left, p.right)])
    if not sizes["drive"].any():
        del sizes["drive"]
    return sizes


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", MARKED_CASES)
def test_gradients_agree_with_central_differences(name: str, seed: int) -> None:
    """Test every parameter along a random direction, if the difference is accurate enough."""
    chain, drive, objective = task(name, seed)
    sizes = derivatives(chain)
    value, exact = value_and_grad(objective, chain, drive, ticks=TICKS, with_respect_to=sizes)
    assert value == evaluate_objective(chain, drive[None], TICKS, objective)[0]
    rng, compared = np.random.default_rng(seed), 0
    for key, size in sizes.items():
        direction = rng.normal(size=exact[key].shape) * size
        change = exact[key] * direction
        found = central_differences(objective, chain, drive, {key: direction}, ticks=TICKS, step=0.05)
        scale = float(np.linalg.norm(change))
        if found.error <= BOUND * scale:
            assert abs(found.value - change.sum()) <= BOUND * scale, (key, found, change.sum(), scale)
            compared += scale > 0.0
    assert compared >= len(sizes) - 2


@pytest.mark.slow
def test_a_long_disordered_and_dissipative_run() -> None:
    """Forty grains, two thousand force evaluations, a reflected wave: all drive entries and radii together."""
    rng = np.random.default_rng(7)
    chain = Chain(
        grains=40, radius=list(3e-3 * (0.6 + 0.8 * rng.random(40))), right="plane", step_size=5e-7, precompression=50.0,
        law={"name": "kuwabara_kono", "dissipation": 5e3},
    )  # fmt: skip
    drive = np.zeros((170, 2))
    drive[:40, 0] = 30.0 * np.sin(np.pi * np.arange(40) / 40)
    objective = total(chain, kinetic_energy(20, 39).mean(), velocity(-1).at_end(target=0.2))
    names = ("drive", "radius", "dissipation")
    _, exact = value_and_grad(objective, chain, drive, ticks=TICKS, with_respect_to=names)
    for key, size in (("drive", np.array([1.0, 0.0])), ("radius", 3e-5), ("dissipation", 1e3)):
        direction = rng.normal(size=exact[key].shape) * size
        change = exact[key] * direction
        found = central_differences(objective, chain, drive, {key: direction}, ticks=TICKS)
        assert abs(found.value - change.sum()) <= BOUND * np.linalg.norm(change)


@pytest.mark.parametrize("integrator", ["pefrl", pytest.param("leapfrog", marks=pytest.mark.slow)])
def test_a_linear_chain_has_the_gradient_of_its_matrices(integrator: str) -> None:
    """Springs (power 1) that stay compressed: a step is a matrix, and the gradient is a product of matrices."""
    n, stiffness, h, steps = 6, 2e6, 1e-6, 20
    chain = Chain(
        grains=n, law={"name": "power", "exponent": 1.0}, contact_stiffness=stiffness, precompression=500.0, right="plane",
        step_size=h, integrator=integrator, radius=list(3e-3 + 1e-4 * np.arange(n)),
    )  # fmt: skip
    k = chain.geometry.stiffness
    matrix = np.zeros((n, n))
    for j in range(1, n):
        matrix[j - 1 : j + 1, j - 1 : j + 1] += k[j] * np.array([[1.0, -1.0], [-1.0, 1.0]])
    matrix[-1, -1] += k[n]
    inverse_mass = np.diag(1.0 / chain.geometry.mass)
    composition = chain._scheme.numbers
    one, zero = np.eye(n), np.zeros((n, n))
    step, push = np.eye(2 * n), np.zeros(2 * n)
    force = np.concatenate([np.zeros(n), inverse_mass[0]])
    for s, drift in enumerate(composition.drifts):
        moved = np.block([[one, drift * h * one], [zero, one]])
        step, push = moved @ step, moved @ push
        if s < len(composition.kicks):
            kick = composition.kicks[s] * h
            kicked = np.block([[one, zero], [-kick * inverse_mass @ matrix, one]])
            step, push = kicked @ step, kicked @ push + kick * force
    drive = np.zeros((steps, 2))
    drive[:, 0] = 50.0 * np.sin(np.arange(steps))
    # J = sum over time of 1000 u^2 / steps of the last grain, plus the final v of the first grain.
    states, state = [], np.zeros(2 * n)
    for t in range(steps):
        for _ in range(TICKS):
            state = step @ state + push * drive[t, 0]
        states.append(state)
    weights = np.zeros((steps, 2 * n))
    weights[:, n - 1] = 2e6 * np.array(states)[:, n - 1] / steps
    weights[-1, n] += 1.0
    expected, bar = np.zeros(steps), np.zeros(2 * n)
    for t in range(steps - 1, -1, -1):
        bar = bar + weights[t]
        for _ in range(TICKS):
            expected[t] += bar @ push
            bar = step.T @ bar
    objective = total(chain, 1e6 * displacement(-1).mean(target=0.0), velocity(0).at_end())
    value, exact = value_and_grad(objective, chain, drive, ticks=TICKS, with_respect_to=("drive", "displacement", "velocity"))
    assert value == pytest.approx(1e6 * np.mean(np.array(states)[:, n - 1] ** 2) + states[-1][n], rel=1e-9)
    assert exact["drive"][:, 0] == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())
    assert np.all(exact["drive"][:, 1] == 0.0)
    assert exact["displacement"] == pytest.approx(bar[:n], rel=1e-9, abs=1e-9 * np.abs(bar[:n]).max())
    assert exact["velocity"] == pytest.approx(bar[n:], rel=1e-9, abs=1e-9 * np.abs(bar[n:]).max())


# -- the same bits ------------------------------------------------------------------------------------------------------


@jit
def _note_state(chain, step, steps, inputs, constants, sums):
    """Store the state after the last control step."""
    if step == steps - 1:
        n = len(sums) // 2
        for i in range(n):
            sums[i], sums[n + i] = chain.rows[U, i + 1], chain.rows[V, i + 1]


def _pullback_nothing(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
    slopes[0] = slopes[0]


def _state_of_evaluate(chain: Chain, drive: Any) -> Any:
    seen: list[Any] = []

    def value(sums, constants, slopes):
        seen.append(sums.copy())
        return 0.0

    evaluate_objective(
        chain, drive[None], TICKS, Objective(_note_state, value, _pullback_nothing, count=2 * chain.parameters.grains)
    )
    return seen[0]


def _stepped(chain: Chain, drive: Any) -> Any:
    names = [name for name, variable in chain.variables.items() if variable.causality == "input"]
    for held in drive:
        inputs = {name: float(held[0 if name.startswith("left") else 1]) for name in names}
        chain.step(TICKS * chain.step_size, **inputs)
    return np.concatenate([chain.get("displacement"), chain.get("velocity")])


@pytest.mark.parametrize("name", MARKED_CASES)
def test_evaluate_has_the_bits_of_the_component(name: str) -> None:
    """The differentiated run is bitwise identical to the component's run, and the chain is not changed."""
    chain, drive, _ = task(name, seed=3)
    before = chain.save().to_bytes()
    evaluated = _state_of_evaluate(chain, drive)
    assert chain.save().to_bytes() == before
    assert np.array_equal(_stepped(chain, drive), evaluated)


def test_gradients_are_the_same_every_time_and_members_are_independent() -> None:
    """Repetitions are bitwise identical, a batch of drives equals single drives, and the chain is not changed."""
    chain, drive, objective = task("viscous", seed=5)
    before = chain.save().to_bytes()
    one, two = (value_and_adjoint(chain, drive, TICKS, objective) for _ in range(2))
    assert np.array_equal(one.table, two.table)
    assert np.array_equal(one.inputs, two.inputs)
    members = np.stack([drive, 0.5 * drive, drive])
    values = evaluate_objective(chain, members, TICKS, objective)
    assert values[0] == values[2] == one.value
    assert values[1] == evaluate_objective(chain, members[1:2], TICKS, objective)[0]
    assert chain.save().to_bytes() == before


def test_a_gradient_starts_from_the_present_state() -> None:
    """Half a run followed by the rest equals the whole run."""
    chain, drive, _ = task("power", seed=4)
    objective = total(chain, energy(2, 5).at_end())
    whole = value_and_adjoint(chain, drive, TICKS, objective)
    _stepped(chain, drive[:5])
    rest = value_and_adjoint(chain, drive[5:], TICKS, objective)
    assert rest.value == whole.value
    assert np.array_equal(rest.inputs, whole.inputs[5:])


# -- kinks, limits, refusals --------------------------------------------------------------------------------------------


DASHPOT = {"law": {"name": "viscous", "dissipation": 5.0}}


@pytest.mark.parametrize("integrator", ["pefrl", pytest.param("leapfrog", marks=pytest.mark.slow)])
@pytest.mark.parametrize("gap", [2.3e-6, 2.2871e-6])
def test_the_slope_of_a_dashpot_that_closes_goes_to_that_of_the_physics(integrator: str, gap: float) -> None:
    """Two grains collide freely: the time of the collision is irrelevant, so d(final velocity) / d(gap) = 0.

    A dashpot that acts only for whole steps would give a slope of -c / m = -5.2e3 1/s for every step size.
    """
    slopes = []
    for step_size in (2e-7, 5e-8, 1e-8):
        chain = Chain(grains=2, gap=gap, step_size=step_size, integrator=integrator, **DASHPOT)
        chain.reset(velocity={0: 1.0})
        objective, ticks = total(chain, velocity(-1).at_end()), round(4e-5 / step_size)
        _, gradient = value_and_grad(objective, chain, np.zeros((1, 2)), ticks=ticks, with_respect_to=["gap"])
        slopes.append(abs(gradient["gap"]))
    # With a step 20 times smaller, the slope is much smaller than at the larger steps.
    assert slopes[0] < 400.0 and slopes[2] < min(0.2 * max(slopes), 30.0)


def test_the_slope_of_a_driven_chain_of_dashpots_is_that_of_the_reference() -> None:
    """Six grains with gaps: d/d gap = 4.099e4 1/s from differences of runs with a small step (whole-step dashpot: 3.51e4)."""
    drive = np.zeros((20, 2))
    drive[:10, 0] = 50.0 * np.sin(0.1 * np.pi * np.arange(10)) + 10.0

    def last(gap: float) -> float:
        chain = Chain(grains=6, gap=gap, step_size=2e-9, **DASHPOT)
        for push, _ in drive:
            chain.step(5e-6, left_force=float(push))
        return float(chain.get("velocity")[-1])

    expected = (last(1e-6 + 2e-8) - last(1e-6 - 2e-8)) / 4e-8
    chain = Chain(grains=6, gap=1e-6, step_size=2e-8, **DASHPOT)
    objective = total(chain, velocity(-1).at_end())
    value, gradient = value_and_grad(objective, chain, drive, ticks=250, with_respect_to=["gap"])
    assert value == pytest.approx(last(1e-6), rel=1e-6)
    assert gradient["gap"] == pytest.approx(expected, rel=5e-3)


def test_differences_across_a_kink_say_what_they_are_worth() -> None:
    """Surfaces that just touch exert a force only if pushed together, which makes a kink."""
    chain = Chain(grains=3, gap=1e-6, step_size=5e-7)
    chain.reset(displacement={0: 1e-6})
    drive, objective = np.zeros((4, 2)), total(chain, 1e9 * velocity(1).at_end())
    found = central_differences(objective, chain, drive, {"displacement": [1e-9, 0.0, 0.0]}, ticks=1)
    assert found.error > 1e-3 * abs(found.value) > 0.0
    # Moving the third grain, which touches no other grain, changes no contact.
    apart = central_differences(objective, chain, drive, {"displacement": [0.0, 0.0, 1e-9]}, ticks=1)
    assert apart.value == 0.0


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({"integrator": "rk4"}, "integrator: integrator 'rk4' has no gradients; build the chain with integrator = 'pefrl' or"),
        ({"integrator": "hamming"}, "integrator: integrator 'hamming' has no gradients"),
        ({"law": {"name": "elastic_plastic", "yield_pressure": 1e9}}, "law: law 'elastic_plastic' has no gradients"),
    ],
)
def test_chains_without_an_adjoint_are_refused_by_name(parameters: dict[str, Any], said: str) -> None:
    """The message also names an alternative."""
    chain = Chain(grains=4, step_size=5e-7, **parameters)
    with pytest.raises(ParameterError, match=said):
        value_and_grad(total(chain, velocity(1).at_end()), chain, np.zeros((3, 2)), ticks=1)


def test_a_run_that_fails_names_its_control_step_and_leaves_the_chain() -> None:
    """The message is the component's message."""
    chain = Chain(grains=4, step_size=5e-7)
    drive = np.zeros((30, 2))
    drive[20:, 0] = 1e7
    before, objective = chain.save().to_bytes(), total(chain, velocity(1).at_end())
    with pytest.raises(StepError, match=r"control step 2\d of 30: (overlap|velocity)\[\d\]: reached") as caught:
        value_and_grad(objective, chain, drive, ticks=TICKS)
    assert caught.value.variable in ("overlap", "velocity")
    with pytest.raises(StepError, match="control step 2"):
        evaluate_objective(chain, drive[None], TICKS, objective)
    assert chain.save().to_bytes() == before


# -- memory -------------------------------------------------------------------------------------------------------------


def test_memory_grows_with_the_root_of_the_horizon() -> None:
    """Peak memory beyond the drive, its copy and its gradient at most doubles for four times the steps."""
    chain = Chain(grains=64, step_size=5e-7, precompression=10.0)
    objective = total(chain, velocity(60).at_end())

    def held(steps: int) -> int:
        drive = np.zeros((steps, 2))
        value_and_adjoint(chain, drive, TICKS, objective)
        tracemalloc.start()
        value_and_adjoint(chain, drive, TICKS, objective)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return peak - 2 * drive.nbytes

    sizes = [held(steps) for steps in (1000, 4000, 16_000)]
    assert sizes[1] <= 2.1 * sizes[0]
    assert sizes[2] <= 2.1 * sizes[1]
    # This is a small fraction of the memory for all states of the run.
    assert sizes[2] < 0.05 * 16_000 * TICKS * 4 * 66 * 8
