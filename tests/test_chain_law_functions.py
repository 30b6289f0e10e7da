"""Every law with every integrator against plain Python: forces, one step, balances, derivatives; and refusals."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import product
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np
import pytest
from support.chain_tools import laws_and_integrators
from support.cubic_law import Cubic, Proportional

import granular_env as ge
from granular_env.components.chain import differentiable_quantities
from granular_env.components.chain.adjoint import evaluate_objective, parameter_gradient, value_and_adjoint
from granular_env.components.chain.adjoint.gradient import has_gradient
from granular_env.components.chain.laws import LAWS, Dissipative, Law, functions
from granular_env.components.chain.laws.hertz import HertzRest
from granular_env.components.chain.laws.law import missing_functions
from granular_env.components.chain.layout import LAW_CONSTANTS, REST_OVERLAP, STIFFNESS, U, V
from granular_env.components.chain.objective import Objective
from granular_env.components.chain.state import python_chain_state
from granular_env.components.errors import ParameterError
from granular_env.components.support.jit import jit

pytestmark = pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")

SPHERES = {"contact_stiffness": 5e9}
CASES: dict[str, dict[str, Any]] = {
    "hertz": {"law": "hertz", **SPHERES},
    "power": {"law": {"name": "power", "exponent": 1.8}, "contact_stiffness": 2e11},
    "viscous": {"law": {"name": "viscous", "dissipation": 20.0}, **SPHERES},
    "kuwabara_kono": {"law": {"name": "kuwabara_kono", "dissipation": 4e3}, **SPHERES},
    "elastic_plastic": {"law": {"name": "elastic_plastic", "yield_pressure": 2e9}, **SPHERES},
    "linear": {"law": {"name": "linear", "dissipation": 20.0}, "contact_stiffness": 1e7},
    "walton_braun": {"law": {"name": "walton_braun", "unloading_stiffness": 2.5e7}, "contact_stiffness": 1e7},
}


Formula = Callable[[ge.Chain, int, float, float], float]


def power_law(chain: ge.Chain, j: int, d: float, w: float) -> float:
    """Return k d^p + c w: elastic, or with a constant dashpot."""
    law: Any = chain.parameters.law
    return max(0.0, float(chain.geometry.stiffness[j]) * d**law.exponent + getattr(law, "dissipation", 0.0) * w)


def kuwabara_kono(chain: ge.Chain, j: int, d: float, w: float) -> float:
    """Return k d^(3/2) + c d^(1/2) w."""
    law: Any = chain.parameters.law
    return max(0.0, float(chain.geometry.stiffness[j]) * d**1.5 + law.dissipation * math.sqrt(d) * w)


def elastic_plastic(chain: ge.Chain, j: int, d: float, w: float) -> float:
    """Return Hertz's force up to yield, and its tangent beyond."""
    law: Any = chain.parameters.law
    k, reduced = float(chain.geometry.stiffness[j]), float(chain.geometry.reduced_radius[j])
    root = math.pi * law.yield_pressure * reduced / (1.5 * k)
    return k * d**1.5 if d < root**2 else k * root**3 + math.pi * law.yield_pressure * reduced * (d - root**2)


# Force of a contact at first loading, by the formula on each law's documentation page.
FORMULAS: dict[str, Formula] = {
    "hertz": power_law,
    "power": power_law,
    "viscous": power_law,
    "kuwabara_kono": kuwabara_kono,
    "elastic_plastic": elastic_plastic,
    "linear": power_law,
    "walton_braun": power_law,
}


def plain_force(chain: ge.Chain, j: int, d: float, w: float) -> float:
    """Return the force of contact j at overlap d and approach speed w, by the formula of its law."""
    return FORMULAS[chain.parameters.law.name](chain, j, d, w) if d > 0.0 else 0.0


def forces_on(chain: ge.Chain) -> np.ndarray:
    """Return the net force on each grain by the plain formulas."""
    velocity = np.concatenate([[0.0], chain.get("velocity"), [0.0]])
    speeds = velocity[:-1] - velocity[1:]
    force = [plain_force(chain, j, d, w) for j, (d, w) in enumerate(zip(chain.get("overlap"), speeds, strict=True))]
    return -np.diff(force)


def shaken(name: str, **parameters: Any) -> ge.Chain:
    """Return a chain between walls with closed and open contacts, some of them approaching or separating fast."""
    chain = ge.Chain(**({"grains": 7, "left": "plane", "right": "plane"} | CASES[name] | parameters))
    random = np.random.default_rng(3)
    chain.reset(velocity=random.uniform(-2.0, 2.0, 7), displacement=random.uniform(-8e-6, 8e-6, 7))
    return chain


@pytest.mark.parametrize("name", CASES)
def test_forces_are_those_of_the_formulas(name: str) -> None:
    chain = shaken(name, step_size=1e-8)
    overlap = chain.get("overlap")
    assert (overlap > 0.0).any() and (overlap < 0.0).any()
    velocity = np.concatenate([[0.0], chain.get("velocity"), [0.0]])
    expected = [plain_force(chain, j, overlap[j], velocity[j] - velocity[j + 1]) for j in range(8)]
    if chain.parameters.law.has_history:  # the start is the deepest state, where unloading and loading curves meet
        assert chain.get("contact_force") == pytest.approx(np.array(expected), rel=1e-12)
    else:
        np.testing.assert_allclose(chain.get("contact_force"), expected, rtol=1e-13)


@pytest.mark.parametrize("name", CASES)
def test_a_chain_begins_with_the_load_that_it_carries(name: str) -> None:
    chain = ge.Chain(grains=5, left="plane", right="plane", precompression=30.0, gravity=9.81, **CASES[name])
    loads = 30.0 + 9.81 * np.concatenate([[0.0], np.cumsum(chain.geometry.mass)])
    np.testing.assert_allclose(chain.get("contact_force"), loads, rtol=1e-9)


@pytest.mark.parametrize(("name", "integrator"), laws_and_integrators(CASES))
def test_a_step_is_force_times_time_over_mass(name: str, integrator: str) -> None:
    """In this short step, overlaps change by a relative 1e-5; rounding is 1e-9 of the change of velocity."""
    chain = shaken(name, integrator=integrator, step_size=1e-11)
    before, expected = chain.get("velocity"), forces_on(chain) * chain.step_size / chain.geometry.mass
    chain.step()
    assert np.abs(expected).max() > 1e-7
    np.testing.assert_allclose(chain.get("velocity") - before, expected, rtol=1e-3, atol=1e-4 * np.abs(expected).max())


@pytest.mark.parametrize(("name", "integrator"), laws_and_integrators(CASES))
def test_balances_close(name: str, integrator: str) -> None:
    """While contacts open, close and yield, energy closes to the error of the step and momentum to rounding."""
    chain = shaken(name, integrator=integrator, step_size=1e-8)
    energy = chain.get("kinetic_energy") + chain.get("potential_energy")
    chain.step(2e-5)
    assert abs(chain.get("energy_residual")) < 1e-5 * energy
    assert (chain.get("dissipated_energy") > 1e-4 * energy) == (not chain.parameters.law.conservative)
    assert abs(chain.get("momentum_residual")) < 1e-12 * float(np.abs(chain.geometry.mass * chain.get("velocity")).sum())


# -- derivatives --------------------------------------------------------------------------------------------------------

WITH_GRADIENT = [name for name, law in LAWS.items() if has_gradient(law)]


def differences(function: Any, a: np.ndarray, entries: list[tuple[int, int]]) -> np.ndarray:
    """Return the central differences of function(a) with respect to entries of the table."""
    found = []
    for row, column in entries:
        whole, h = a[row, column], 1e-6 * (abs(a[row, column]) or 1e-6)
        values = []
        for sign in (1.0, -1.0):
            a[row, column] = whole + sign * h
            values.append(function(a))
        a[row, column] = whole
        found.append((values[0] - values[1]) / (2.0 * h))
    return np.array(found)


@pytest.mark.parametrize("quantity", ["contact_force", "contact_energy", "energy_root"])
@pytest.mark.parametrize("name", WITH_GRADIENT)
def test_pullbacks_are_the_slopes_of_their_quantities(name: str, quantity: str) -> None:
    if quantity == "energy_root" and missing_functions(LAWS[name], functions.ENERGY_ROOT):
        pytest.skip("this law has none")
    chain = shaken(name, precompression=200.0, step_size=1e-8)
    a = chain.detached_table()
    j = int(np.argmax(chain.get("contact_force")[1:-1])) + 1
    adjoint = np.zeros_like(a)
    kind = chain.parameters.law.contacts
    getattr(differentiable_quantities, f"{quantity}_pullback")(
        python_chain_state(kind, a), python_chain_state(kind, adjoint), j, 0.7
    )
    entries = [(STIFFNESS, j), (REST_OVERLAP, j), (U, j), (U, j + 1), (V, j), (V, j + 1)]
    entries += [(LAW_CONSTANTS, j)] if isinstance(chain.parameters.law, Dissipative) else []
    value = getattr(differentiable_quantities, quantity)
    expected = 0.7 * differences(lambda table: value(python_chain_state(kind, table), j), a, entries)
    np.testing.assert_allclose([adjoint[entry] for entry in entries], expected, rtol=1e-6, atol=1e-12 * np.abs(expected).max())
    others = adjoint.copy()
    for entry in entries:
        others[entry] = 0.0
    assert not others.any()


@jit
def _note(chain, step, steps, inputs, constants, sums):
    if step == steps - 1:
        sums[0] += chain.rows[V, 3] * chain.rows[V, 3]


@jit
def _value(sums, constants, slopes):
    slopes[0] = 1.0
    return sums[0]


@jit
def _pullback(chain, adjoint, step, steps, inputs, input_adjoint, constants, slopes):
    if step == steps - 1:
        adjoint.rows[V, 3] += slopes[0] * 2.0 * chain.rows[V, 3]


# The pullbacks of all laws are tested above; these laws test the loops around them.
EVERYWHERE = ("hertz", "viscous")
OTHERS = [pytest.param(name, "pefrl", marks=pytest.mark.slow) for name in WITH_GRADIENT if name not in EVERYWHERE]


@pytest.mark.parametrize(("name", "integrator"), [*product(EVERYWHERE, ("pefrl", "leapfrog")), *OTHERS])
def test_gradients_are_the_differences_of_runs(name: str, integrator: str) -> None:
    """Gradients by drive, stiffness and, if any, dissipation of a precompressed chain with a travelling pulse."""
    shape = {"grains": 6, "right": "plane", "precompression": 100.0, "integrator": integrator, "step_size": 4e-7}
    objective, drive = Objective(_note, _value, _pullback), np.zeros((30, 2))
    drive[:10, 0] = 60.0 * np.sin(np.pi * np.arange(10) / 10.0)

    def value(change: dict[str, float], push: float = 1.0) -> float:
        case = dict(CASES[name])
        case["contact_stiffness"] *= change.get("contact_stiffness", 1.0)
        if "dissipation" in change:
            case["law"] = {**case["law"], "dissipation": case["law"]["dissipation"] * change["dissipation"]}
        return float(evaluate_objective(ge.Chain(**shape, **case), push * drive[None], 3, objective)[0])

    chain = ge.Chain(**shape, **CASES[name])
    found = value_and_adjoint(chain, drive, 3, objective)
    h = 1e-5
    names = ["contact_stiffness"] + (["dissipation"] if isinstance(chain.parameters.law, Dissipative) else [])
    for key in names:
        holder = chain.parameters if key == "contact_stiffness" else chain.parameters.law
        slope = (value({key: 1.0 + h}) - value({key: 1.0 - h})) / (2.0 * h * getattr(holder, key))
        assert parameter_gradient(chain, found, key) == pytest.approx(slope, rel=1e-6), key
    slope = (value({}, 1.0 + h) - value({}, 1.0 - h)) / (2.0 * h)
    assert float((found.inputs * drive).sum()) == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("precompression", [1.0, 100.0, 2e4])
def test_gradients_by_what_a_pressed_contact_rests_on_are_those_of_the_law(
    precompression: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The rest overlap follows k and the force by the law's formula, here k d + k3 d^3."""
    monkeypatch.setitem(LAWS, "cubic", Cubic)
    shape = {"grains": 6, "right": "plane", "step_size": 1e-7, "law": "cubic"}
    given = {"contact_stiffness": 1e7, "precompression": precompression}
    objective, drive = Objective(_note, _value, _pullback), np.zeros((30, 2))
    drive[:10, 0] = 60.0 * np.sin(np.pi * np.arange(10) / 10.0)

    def value(name: str, factor: float) -> float:
        return float(
            evaluate_objective(ge.Chain(**shape, **given | {name: given[name] * factor}), drive[None], 3, objective)[0]
        )

    found = value_and_adjoint(chain := ge.Chain(**shape, **given), drive, 3, objective)
    h = 1e-5
    for name in given:
        slope = (value(name, 1.0 + h) - value(name, 1.0 - h)) / (2.0 * h * given[name])
        assert parameter_gradient(chain, found, name) == pytest.approx(slope, rel=1e-6), name


def test_a_derivative_that_would_lack_the_part_of_the_constants_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(LAWS, "proportional", Proportional)
    chain = ge.Chain(grains=4, radius=2.0**-8, law="proportional", contact_stiffness=1e7, precompression=10.0)
    found = value_and_adjoint(chain, np.zeros((3, 2)), 1, Objective(_note, _value, _pullback))
    for name in ("contact_stiffness", "radius"):
        with pytest.raises(ParameterError, match=f"'{name}' has no derivative for law 'proportional', whose constants depend"):
            parameter_gradient(chain, found, name)
    assert np.isfinite(parameter_gradient(chain, found, "precompression"))


# -- refusals -----------------------------------------------------------------------------------------------------------


class UnfinishedContacts(NamedTuple):
    """Constants of a law without an energy."""

    stiffness: np.ndarray


@functions.force.register(UnfinishedContacts)
def unfinished_force(law, j, d):
    return law.stiffness[j] * d


def unfinished_contacts(kind, stiffness, constants, history):
    return UnfinishedContacts(stiffness)


class Unfinished(Law):
    """A law without an energy."""

    contacts: ClassVar[type] = UnfinishedContacts
    exponent: ClassVar[float] = 1.0
    name: Literal["unfinished"] = "unfinished"


def test_a_law_that_lacks_a_function_is_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(LAWS, "unfinished", Unfinished)
    with pytest.raises(
        ParameterError, match=r"law 'unfinished' lacks static_overlap, contact_law, energy in .*test_chain_law_functions"
    ):
        ge.Chain(grains=3, law="unfinished")


def test_a_law_without_derivatives_has_no_gradients_and_says_which_it_lacks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(LAWS, "unfinished", Unfinished)
    monkeypatch.setattr(Unfinished, "static_overlap", HertzRest.static_overlap)
    monkeypatch.setitem(functions.energy.implementations, UnfinishedContacts, unfinished_force)
    monkeypatch.setitem(functions.contact_law.implementations, UnfinishedContacts, unfinished_contacts)
    chain = ge.Chain(grains=3, law="unfinished", contact_stiffness=1e9)
    said = "law 'unfinished' has no gradients: it lacks force_pullback, energy_pullback; use hertz, "
    with pytest.raises(ParameterError, match=said):
        value_and_adjoint(chain, np.zeros((3, 2)), 1, Objective(_note, _value, _pullback))
