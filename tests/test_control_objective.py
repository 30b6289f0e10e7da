"""Objectives: terms against the chain's outputs, the check of custom objectives, and error messages."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import granular_env as ge
from granular_env import Chain, ParameterError
from granular_env.components.chain.adjoint import evaluate_objective
from granular_env.components.chain.layout import MASS, PEAK, V
from granular_env.components.chain.objective import Objective
from granular_env.components.support.jit import jit
from granular_env.domains.chain.control import (
    Term,
    central_differences,
    check_objective,
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

LAWS: list[dict[str, Any]] = [
    {},
    {"law": {"name": "power", "exponent": 2.2}, "contact_stiffness": 1e12},
    {"law": {"name": "viscous", "dissipation": 30.0}},
    {"law": {"name": "kuwabara_kono", "dissipation": 2e4}},
]
DRIVE = np.array([[40.0, 0.0]] * 6 + [[10.0, 0.0]] * 6)


def chain_of(**parameters: Any) -> Chain:
    """Return a chain of seven grains with a plane at its end."""
    return Chain(**({"grains": 7, "right": "plane", "precompression": 20.0, "step_size": 5e-7} | parameters))


def worth(chain: Chain, term: Term) -> float:
    """Return the value of a term for the drive."""
    return float(evaluate_objective(chain, DRIVE[None], 3, total(chain, term))[0])


@pytest.mark.parametrize("parameters", LAWS)
def test_terms_are_what_the_chain_says(parameters: dict[str, Any]) -> None:
    """Final value, mean and peak of each quantity, against the outputs of the component's steps."""
    chain = chain_of(**parameters)
    twin = chain_of(**parameters)
    seen: dict[str, list[float]] = {name: [] for name in ("v", "u", "f", "e", "p", "all", "part")}
    for left, _ in DRIVE:
        twin.step(3 * twin.step_size, left_force=float(left))
        v, f = twin.get("velocity"), twin.get("contact_force")
        mass = twin.geometry.mass
        balances = twin.balance_values()
        for name, value in (
            ("v", v[2]), ("u", twin.get("displacement")[-1]), ("f", f[-1]), ("e", 0.5 * float(mass[1:4] @ v[1:4] ** 2)),
            ("p", float(mass @ v)), ("all", balances["kinetic_energy"] + balances["potential_energy"]),
        ):  # fmt: skip
            seen[name].append(float(value))
    quantities = {
        "v": velocity(2), "u": displacement(-1), "f": contact_force(-1), "e": kinetic_energy(1, 3), "p": momentum(),
    }  # fmt: skip
    for name, quantity in quantities.items():
        values = np.array(seen[name])
        assert worth(chain, quantity.at_end()) == pytest.approx(values[-1], rel=1e-13)
        assert worth(chain, quantity.mean()) == pytest.approx(values.mean(), rel=1e-12)
        assert worth(chain, quantity.mean(target=0.1)) == pytest.approx(np.mean((values - 0.1) ** 2), rel=1e-12)
        assert worth(chain, quantity.mean(begin=-4, end=-1)) == pytest.approx(values[-4:-1].mean(), rel=1e-12)
        largest = np.abs(values).max()
        peak = worth(chain, quantity.peak(scale=largest, power=16))
        assert peak == pytest.approx(np.sum(np.abs(values) ** 16.0) ** (1 / 16), rel=1e-12)
        assert largest <= peak <= largest * len(values) ** (1 / 16)
    # The other half of a wall contact's energy belongs to the wall.
    wall = worth(chain, energy(6, 6).at_end()) - worth(chain, kinetic_energy(6, 6).at_end())
    assert worth(chain, energy().at_end()) < seen["all"][-1] < worth(chain, energy().at_end()) + 2.0 * wall
    halves = worth(chain, energy(0, 3).at_end()) + worth(chain, energy(4, 6).at_end())
    assert worth(chain, energy().at_end()) == pytest.approx(halves, rel=1e-13)
    assert worth(chain, end_input("left").mean()) == pytest.approx(DRIVE[:, 0].mean(), rel=1e-14)


@pytest.mark.parametrize("parameters", LAWS)
def test_terms_have_the_derivatives_of_their_values(parameters: dict[str, Any]) -> None:
    """For each entry of the table."""
    chain = chain_of(**parameters)
    terms = (
        velocity(2).at_end(target=3.0), displacement(-1).mean(), contact_force(-1).peak(scale=60.0), energy(2, 4).mean(),
        kinetic_energy().at_end(), 2.0 * momentum(1, 3).mean(target=0.1), -1.0 * end_input("left").mean(target=0.0),
    )  # fmt: skip
    for term in terms:
        assert check_objective(total(chain, term), chain) < 1e-6
    assert check_objective(total(chain, *terms), chain) < 1e-6


def test_a_task_may_bring_its_objective() -> None:
    """Any object with objective(chain, steps)."""
    chain = chain_of()

    class Task:
        def objective(self, chain: Chain, steps: int) -> Objective:
            return total(chain, float(steps) * velocity(1).at_end())

    direct = value_and_grad(total(chain, float(len(DRIVE)) * velocity(1).at_end()), chain, DRIVE, ticks=2)
    asked = value_and_grad(Task(), chain, DRIVE, ticks=2)
    assert direct[0] == asked[0]
    assert np.array_equal(direct[1]["drive"], asked[1]["drive"])
    with pytest.raises(ParameterError, match="objective: got 3, expected an Objective, or a task with an objective"):
        value_and_grad(3, chain, DRIVE, ticks=2)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (lambda chain: total(chain), "terms: got none"),
        (lambda chain: total(chain, velocity(7).at_end()), r"velocity\[7\]: got 7, expected -7 to 6"),
        (lambda chain: total(chain, contact_force(8).at_end()), r"contact_force\[8\]: got 8, expected -8 to 7"),
        (lambda chain: total(chain, contact_force(0).at_end()), r"contact_force\[0\]: left is 'free', so there is no contact"),
        (lambda chain: velocity(1).peak(scale=1.0, power=3), "power: got 3, expected an even number"),
        (lambda chain: velocity(1).mean(begin=8, end=5), "begin, end: got 8 and 5"),
        (lambda chain: total(chain, velocity(1)), "terms: got Quantity"),
        (lambda chain: Objective(None, _value, _pullback), "objective.note: got None"),
    ],
)
def test_bad_terms(build: Any, said: str) -> None:
    """Invalid terms are refused when they are combined."""
    with pytest.raises(ParameterError, match=said):
        build(chain_of())


def test_terms_are_numbers_to_calculate_with() -> None:
    chain = chain_of()
    first, last = velocity(0).at_end(), velocity(-1).at_end()
    values = [
        evaluate_objective(chain, DRIVE[None], 2, total(chain, term))[0]
        for term in (first, last, -first, first / 4.0, first - last)
    ]
    np.testing.assert_allclose(values[2:], [-values[0], values[0] / 4.0, values[0] - values[1]], rtol=1e-15)


@pytest.mark.parametrize(
    ("term", "other", "said"),
    [
        (velocity(-1).at_end(), {"grains": 3}, "a chain of 7 grains, but this chain has 3"),
        (velocity(-1).mean(end=13), {}, "control step 12, but the drive has 12"),
    ],
)
def test_a_run_that_an_objective_does_not_fit_is_refused(term: Term, other: dict[str, Any], said: str) -> None:
    """Compiled code would read outside the arrays."""
    objective = total(chain_of(), term)
    with pytest.raises(ParameterError, match=said):
        value_and_grad(objective, chain_of(**other), DRIVE, ticks=2)
    with pytest.raises(ParameterError, match=said):
        evaluate_objective(chain_of(**other), DRIVE[None], 2, objective)


def test_bad_arguments_of_gradients_are_refused() -> None:
    chain = chain_of()
    objective = total(chain, velocity(-1).at_end())
    with pytest.raises(ParameterError, match="with_respect_to: got None"):
        value_and_grad(objective, chain, DRIVE, ticks=2, with_respect_to=None)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="drive: got"):
        value_and_grad(objective, chain, [[1.0, 2.0], [3.0]], ticks=2)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="chain: got .*, expected a Chain"):
        value_and_grad(objective, None, DRIVE, ticks=2)  # type: ignore[arg-type]
    for direction, said in (
        ({"radius": np.ones(5)}, r"direction: got radius of shape \(5,\)"),
        ({"drive": "up"}, "direction.drive"),
    ):
        with pytest.raises(ParameterError, match=said):
            central_differences(objective, chain, DRIVE, direction, ticks=2)
    with pytest.raises(ParameterError, match="step: got 0"):
        central_differences(objective, chain, DRIVE, {"drive": DRIVE}, ticks=2, step=0.0)


# -- custom objectives --------------------------------------------------------------------------------------------------


@jit
def _note(chain, step, steps, inputs, constants, sums):
    sums[0] += 0.5 * chain.rows[MASS, 6] * chain.rows[V, 6] ** 2 / steps


@jit
def _value(sums, constants, slopes):
    slopes[0] = 2.0 * sums[0]
    return sums[0] ** 2


@jit
def _pullback(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
    adjoint.rows[V, 6] += slopes[0] * chain.rows[MASS, 6] * chain.rows[V, 6] / steps
    adjoint.rows[MASS, 6] += slopes[0] * 0.5 * chain.rows[V, 6] ** 2 / steps


@jit
def _pullback_twice(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
    adjoint.rows[V, 6] += slopes[0] * 2.0 * chain.rows[MASS, 6] * chain.rows[V, 6] / steps
    adjoint.rows[MASS, 6] += slopes[0] * 0.5 * chain.rows[V, 6] ** 2 / steps


@jit
def _pullback_without_mass(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
    adjoint.rows[V, 6] += slopes[0] * chain.rows[MASS, 6] * chain.rows[V, 6] / steps


@jit
def _pullback_that_writes(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
    chain.rows[V, 6] = 0.0


@jit
def _value_of_wrong_slope(sums, constants, slopes):
    slopes[0] = 1.0
    return sums[0] ** 2


@jit
def _note_peak(chain, step, steps, inputs, constants, sums):
    if step == steps - 1:
        sums[0] += chain.rows[PEAK, 3]


def test_ones_own_objective_is_checked() -> None:
    """A correct objective passes; for a wrong one the message names the entry."""
    chain = chain_of()
    assert check_objective(Objective(_note, _value, _pullback), chain) < 1e-6
    for objective, said in (
        (Objective(_note, _value, _pullback_twice), r"objective.pullback: adjoint\[V, 6\] is .* quotient of note"),
        (Objective(_note, _value, _pullback_without_mass), r"objective.pullback: adjoint\[MASS, 6\] is 0 at step 0"),
        (Objective(_note, _value, _pullback_that_writes), "objective.pullback: it changes `chain`"),
        (Objective(_note, _value_of_wrong_slope, _pullback), r"objective.value: slopes\[0\] is 1, "),
        (Objective(_note_peak, _value, _pullback), "objective.note: it reads the row PEAK"),
    ):
        with pytest.raises(ParameterError, match=said):
            check_objective(objective, chain)


def test_plain_functions_are_compiled() -> None:
    """A missing decorator is harmless; the message names code that does not compile."""
    chain = chain_of()

    def note(chain, step, steps, inputs, constants, sums):
        sums[0] += chain.rows[V, 2] * constants[0]

    def pullback(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
        adjoint.rows[V, 2] += slopes[0] * constants[0]

    def no_code(chain, step, steps, inputs, constants, sums):
        sums[0] += chain.nothing

    found = value_and_grad(Objective(note, _value, pullback, np.array([2.0])), chain, DRIVE, ticks=2)
    assert found[0] > 0.0
    with pytest.raises(ParameterError, match=r"objective.note: it does not compile"):
        value_and_grad(Objective(no_code, _value, pullback), chain, DRIVE, ticks=2)


def test_differences_that_leave_what_a_chain_may_be_say_so() -> None:
    chain = Chain(grains=3, gap=0.0, step_size=1e-7)
    chain.reset(velocity={0: 1.0})
    drive = np.zeros((4, 2))
    with pytest.raises(ParameterError, match="gives an invalid chain: .*gap: got -.*smaller step") as caught:
        central_differences(total(chain, velocity(-1).at_end()), chain, drive, {"gap": 1e-9}, ticks=2)
    assert "shape" not in str(caught.value)


@pytest.mark.parametrize(
    "name",
    [
        "discs",
        "oscillator",
    ],
)
def test_a_component_without_gradients_is_refused_at_every_entry(name: str) -> None:
    other: Any = ge.make(name)
    at_rest = total(Chain(grains=3), velocity(0).at_end())
    drive = np.zeros((4, 2))
    for entry in (
        lambda: total(other, velocity(0).at_end()),
        lambda: value_and_grad(at_rest, other, drive, ticks=1),
        lambda: central_differences(at_rest, other, drive, {"drive": drive}, ticks=1),
        lambda: check_objective(at_rest, other),
    ):
        with pytest.raises(ParameterError, match="chain: got .*, expected a Chain; components with gradients: chain"):
            entry()
