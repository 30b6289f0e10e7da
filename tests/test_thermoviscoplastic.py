"""The thermo-elasto-viscoplastic law against its differential equations, closed forms, and rigid rotations."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from support.chain_tools import run_python
from support.solid_tools import make_callable

from granular_env.components.materials import finite_strain as finite
from granular_env.components.materials import tensors
from granular_env.components.materials import thermoviscoplastic as law_module
from granular_env.components.materials.tensors import SymmetricTensor
from granular_env.components.materials.thermoviscoplastic import Thermoviscoplastic
from granular_env.components.support.jit import jit
from granular_env.components.support.validation import validate_parameters

Tensor = np.ndarray
# A bar stretched at constant volume, for which the equivalent strain rate is the axial strain rate.
STRETCH = np.diag([1.0, -0.5, -0.5])
ROOM = 293.0


advance_stress, plastic_strain_increment, law_flow_stress = (
    make_callable(one) for one in (law_module.advance_stress, law_module.plastic_strain_increment, law_module.flow_stress)
)
strain_and_spin, rotate_tensor, nominal_stress = map(
    make_callable, (finite.strain_and_spin, finite.rotate_tensor, finite.nominal_stress)
)
equivalent_stress, largest_principal, elastic_energy_density = map(
    make_callable, (tensors.equivalent_stress, tensors.largest_principal, tensors.elastic_energy_density)
)


def six(tensor: Tensor) -> SymmetricTensor:
    """Return a symmetric tensor in the form used by the kernels."""
    return SymmetricTensor(*(float(tensor[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))))


def tensor(values: Iterable[float]) -> Tensor:
    xx, yy, zz, xy, yz, zx = values
    return np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])


def nine(matrix: Tensor) -> tensors.Tensor:
    return tensors.Tensor(*(float(value) for value in matrix.reshape(-1)))


def validated(**fields: Any) -> Thermoviscoplastic:
    return validate_parameters(Thermoviscoplastic, fields, "law")


@jit
def _strain_steadily(law, rate, tick, path):
    """Strain a point at a constant rate; fill rows of equivalent stress, plastic strain, temperature, flow rate."""
    stress, strain, temperature = SymmetricTensor(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), 0.0, 293.0
    increment = SymmetricTensor(
        tick * rate[0], tick * rate[1], tick * rate[2], tick * rate[3], tick * rate[4], tick * rate[5]
    )  # fmt: skip
    for step in range(path.shape[0]):
        before = strain
        stress, strain, temperature, _ = advance_stress(law, stress, increment, strain, temperature)
        path[step, 0] = equivalent_stress(stress)
        path[step, 1], path[step, 2], path[step, 3] = strain, temperature, (strain - before) / tick


def steady(law: Thermoviscoplastic, rate: float, strain: float, ticks: int) -> np.ndarray:
    """Return equivalent stress, plastic strain, temperature and flow rate of a bar stretched at constant volume."""
    tick, path = strain / rate / ticks, np.zeros((ticks, 4))
    _strain_steadily(law.constants(tick), np.array(six(rate * STRETCH)), tick, path)
    return path


# -- plain formulas ---------------------------------------------------------------------------------------------------------


def moduli(law: Thermoviscoplastic, temperature: float) -> tuple[float, float]:
    """Return bulk and shear modulus."""
    t = (temperature - law.reference_temperature) * law.temperature_dependent
    young = law.young - law.young_slope * t - law.young_curvature * t * t
    poisson = law.poisson + law.poisson_slope * t
    return young / (3.0 * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson))


def flow_stress(law: Thermoviscoplastic, strain: float, temperature: float) -> float:
    t = temperature - law.reference_temperature
    base = law.yield_stress - law.temperature_dependent * law.yield_curvature * t * t
    hardening = (1.0 + strain / law.reference_strain) ** law.hardening_exponent
    return base * hardening * (1.0 - law.softening * (math.exp(t / law.softening_temperature) - 1.0))


def solution(law: Thermoviscoplastic, motion: Callable[[float], Tensor], end: float, start: Tensor | None = None) -> np.ndarray:
    """Return final stress (six), plastic strain and temperature from a stiff integrator."""
    heating = law.heat_fraction / (law.density * law.specific_heat)

    def derivative(time: float, state: np.ndarray) -> np.ndarray:
        stress, strain, temperature = tensor(state[:6]) * law.yield_stress, state[6], state[7] * ROOM
        bulk, shear = moduli(law, temperature)
        deviator = stress - np.trace(stress) / 3.0 * np.eye(3)
        equivalent = math.sqrt(1.5 * float((deviator * deviator).sum()))
        rate, given = 0.0, motion(time)
        elastic = given
        if equivalent > 0.0:
            rate = law.reference_rate * (equivalent / flow_stress(law, strain, temperature)) ** law.rate_exponent
            elastic = given - 1.5 * rate / equivalent * deviator
        warming = heating * equivalent * rate
        expansion = law.expansion + law.temperature_dependent * law.expansion_slope * (temperature - law.reference_temperature)
        elastic = elastic - expansion * warming * np.eye(3)
        change = 2.0 * shear * elastic + (bulk - 2.0 * shear / 3.0) * np.trace(elastic) * np.eye(3)
        return np.array([*(np.array(six(change)) / law.yield_stress), rate, warming / ROOM])

    first = np.array([*(np.zeros(6) if start is None else np.array(six(start)) / law.yield_stress), 0.0, 1.0])
    # Longer steps would evaluate stresses at which the rate overflows.
    found = solve_ivp(derivative, (0.0, end), first, method="Radau", rtol=1e-9, atol=1e-12, max_step=5e-3 * end)
    assert found.success
    last = found.y[:, -1]
    return np.array([*last[:6] * law.yield_stress, last[6], last[7] * ROOM])


# -- the law ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rate", [1.0, 1e4])
def test_a_stretched_bar_follows_the_flow_law(rate: float) -> None:
    """During flow, q = g(e, T) (e' / e0')^(1/m); 3e-4 is the tolerance stated on the physics page."""
    law = Thermoviscoplastic()
    for stress, strain, temperature, flow in steady(law, rate, 0.3, 3000)[100::100]:
        expected = flow_stress(law, strain, temperature) * (flow / law.reference_rate) ** (1.0 / law.rate_exponent)
        assert stress == pytest.approx(expected, rel=3e-4)


def test_metals_that_harden_linearly_can_be_given() -> None:
    """Copper of the Taylor test: 400 MPa + 100 MPa e (n = 1, e0 = 4) at the reference rate."""
    law = validated(
        young=117e9, yield_stress=400e6, hardening_exponent=1.0, reference_strain=4.0, reference_rate=1e3, softening=0.0,
        temperature_dependent=False, heat_fraction=0.0,
    )  # fmt: skip
    for stress, strain, _, flow in steady(law, 1e3, 2.0, 4000)[1000::500]:
        assert stress == pytest.approx((400e6 + 100e6 * strain) * (flow / 1e3) ** 0.01, rel=1e-9)


def test_uniaxial_stress() -> None:
    """With free sides, the axial stress is the flow stress, and the lateral strain keeps the plastic volume constant."""
    law, tick, rate = Thermoviscoplastic(heat_fraction=0.0), 1e-7, 1e3
    constants, state = law.constants(tick), (six(np.zeros((3, 3))), 0.0, ROOM)

    def step(lateral: float) -> Any:
        return advance_stress(constants, state[0], SymmetricTensor(rate * tick, lateral, lateral, 0.0, 0.0, 0.0), *state[1:])

    sides = 0.0
    for _ in range(400):
        lateral = brentq(lambda given: step(given).stress.yy, -rate * tick, 0.0, xtol=1e-16)
        sides, before = sides + lateral, state[1]
        state = step(lateral)[:3]
    axial, strain = state[0].xx, state[1]
    flow = (strain - before) / tick
    assert axial == pytest.approx(flow_stress(law, strain, ROOM) * (flow / 1e-3) ** 0.01, rel=3e-4)
    assert rate * tick * 400 == pytest.approx(strain + axial / law.young, rel=1e-9)
    assert -sides == pytest.approx(0.5 * strain + law.poisson * axial / law.young, rel=1e-9)


def test_plastic_work_heats() -> None:
    """rho c dT = chi q de, with the integral computed from the results."""
    law = Thermoviscoplastic()
    path = steady(law, 1e4, 0.3, 6000)
    stress, strain, temperature = path[:, 0], path[:, 1], path[:, 2]
    integral = float(np.trapezoid(stress, strain))
    heated = temperature[-1] - temperature[0]
    assert heated > 40.0
    assert heated == pytest.approx(law.heat_fraction * integral / (law.density * law.specific_heat), rel=1e-4)


# -- the ticks --------------------------------------------------------------------------------------------------------------


def bent(time: float) -> Tensor:
    """Return a strain rate with a rotating direction."""
    shear = np.array([[0.0, 1.0, 0.2], [1.0, 0.0, 0.0], [0.2, 0.0, 0.0]])
    return 1e4 * (STRETCH + 2e5 * time * shear)


def end_of(law: Thermoviscoplastic, motion: Callable[[float], Tensor], end: float, ticks: int, start: Tensor) -> np.ndarray:
    tick, state = end / ticks, (six(start), 0.0, ROOM)
    constants = law.constants(tick)
    for step in range(ticks):
        state = advance_stress(constants, state[0], six(tick * motion((step + 0.5) * tick)), *state[1:])[:3]
    return np.array([*state[0], *state[1:]])


def orders(law: Thermoviscoplastic, motion: Callable[[float], Tensor], start: Tensor) -> tuple[list[float], float]:
    """Return the orders of stress, plastic strain and temperature, and the error of the stress at the finest step."""
    exact = solution(law, motion, 2e-6, start)
    errors = [np.abs(end_of(law, motion, 2e-6, ticks, start) - exact) for ticks in (100, 200)]
    stress = [float(np.linalg.norm(error[:6]) / np.linalg.norm(exact[:6])) for error in errors]
    rates = [math.log2(stress[0] / stress[1]), *(math.log2(errors[0][place] / errors[1][place]) for place in (6, 7))]
    return rates, stress[1]


@pytest.mark.parametrize(("motion", "error"), [("straight", 1e-4), ("bent", 1e-3)])
def test_a_tick_is_of_first_order(motion: str, error: float) -> None:
    """A law whose flow is resolved by the ticks: m = 5, started during flow."""
    law = validated(rate_exponent=5.0, reference_rate=1e3, temperature_dependent=False)
    found, last = orders(law, bent if motion == "bent" else lambda _: 1e4 * STRETCH, 1.2 * law.yield_stress * STRETCH / 1.5)
    assert found == pytest.approx([1.0] * 3, abs=0.15)
    assert last < error


def test_a_stiff_law_follows_its_equations() -> None:
    """m = 100 from rest through first yield, with temperature-dependent constants, at ticks of 20 ns."""
    law = Thermoviscoplastic()
    exact = solution(law, lambda _: 1e4 * STRETCH, 2e-5)
    found = end_of(law, lambda _: 1e4 * STRETCH, 2e-5, 1000, np.zeros((3, 3)))
    assert np.linalg.norm(found[:6] - exact[:6]) < 3e-4 * np.linalg.norm(exact[:6])
    assert found[6:] == pytest.approx(exact[6:], rel=3e-4)


def test_the_implicit_root_is_the_root() -> None:
    """Random states from creep to far above the flow stress, against bisection."""
    random = np.random.default_rng(7)
    for m in (1.0, 4.0, 30.0, 100.0):
        law = Thermoviscoplastic(rate_exponent=m, heat_fraction=0.0)
        for _ in range(60):
            tick, strain = 10.0 ** random.uniform(-9.0, -3.0), 10.0 ** random.uniform(-8.0, 0.0)
            stress = flow_stress(law, strain, ROOM)
            trial = stress * (1.0 + 10.0 ** random.uniform(-3.0, 1.0))
            begin = trial * random.uniform(0.0, 1.1)
            shear = moduli(law, ROOM)[1]

            def excess(log: float, trial=trial, strain=strain, shear=shear, law=law, tick=tick, m=m) -> float:
                flow = math.exp(log)
                over = flow_stress(law, strain + flow, ROOM) * (flow / (law.reference_rate * tick)) ** (1.0 / m)
                return trial - 3.0 * shear * flow - over

            flow = plastic_strain_increment(law.constants(tick), begin, trial, strain, ROOM, shear)
            exact = math.exp(brentq(excess, math.log(1e-30), math.log(trial / (3.0 * shear)), xtol=1e-14, rtol=1e-14))
            assert flow == pytest.approx(exact, rel=1e-9)


def test_far_above_the_flow_stress_and_far_too_hot() -> None:
    """No overflow or reverse flow; softening leaves at least a thousandth of the flow stress."""
    law = Thermoviscoplastic()
    constants = law.constants(1e-7)
    stress, *rest = advance_stress(constants, six(50.0 * law.yield_stress * STRETCH), six(1e-9 * STRETCH), 0.0, ROOM)
    assert all(map(math.isfinite, (*stress, *rest))) and rest[0] > 0.0 and stress.xx < 50.0 * law.yield_stress
    hot = law.melting_temperature
    assert hot is not None and hot == pytest.approx(293.0 + 500.0 * math.log1p(1.25))
    assert law_flow_stress(constants, 0.0, hot) == pytest.approx(1e-3 * law.yield_stress)
    assert law_flow_stress(constants, 0.0, hot - 20.0) > 5e-3 * law.yield_stress
    for temperature in (hot, 5000.0, 1e9):
        stress, *rest = advance_stress(constants, six(0.1 * law.yield_stress * STRETCH), six(1e-4 * STRETCH), 0.0, temperature)
        assert all(map(math.isfinite, (*stress, *rest))) and rest[0] >= 0.0


def test_below_the_flow_stress_it_is_elastic() -> None:
    law = Thermoviscoplastic()
    strain = 1e-3 * np.array([[0.5, 0.2, -0.3], [0.2, 0.4, 0.1], [-0.3, 0.1, -0.6]])
    stress, *rest = advance_stress(law.constants(1e-7), six(np.zeros((3, 3))), six(strain), 0.0, ROOM)
    bulk, shear = moduli(law, ROOM)
    expected = 2.0 * shear * strain + (bulk - 2.0 * shear / 3.0) * np.trace(strain) * np.eye(3)
    assert tensor(stress) == pytest.approx(expected, rel=1e-13)
    assert rest == [0.0, ROOM, 0.0]
    density = elastic_energy_density(stress, tensors.Moduli(bulk - 2.0 * shear / 3.0, shear))
    assert density == pytest.approx(0.5 * float((expected * strain).sum()), rel=1e-12)


# -- kinematics -------------------------------------------------------------------------------------------------------------


def rotation(angle: float) -> Tensor:
    """Return the rotation about a skew axis."""
    x, y, z = np.array([1.0, 2.0, -2.0]) / 3.0
    turn = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * turn + (1.0 - math.cos(angle)) * turn @ turn


def carried(stress: Tensor, motion: Callable[[float], Tensor], ticks: int, shear: float = 1.0, bulk: float = 2.0) -> Tensor:
    """Return the elastic stress after a motion F(s) with s from 0 to 1."""
    before = motion(0.0)
    for tick in range(ticks):
        after = motion((tick + 1) / ticks)
        given = strain_and_spin(nine(before), nine(after))
        strain = tensor(given.strain)
        turned = tensor(rotate_tensor(six(stress), given.spin))
        stress = turned + 2.0 * shear * strain + (bulk - 2.0 * shear / 3.0) * np.trace(strain) * np.eye(3)
        before = after
    return stress


STRESS = np.array([[3.0, 1.0, -0.5], [1.0, -2.0, 0.7], [-0.5, 0.7, 1.5]])


@pytest.mark.parametrize("ticks", [10, 1000])
def test_a_rigid_rotation_turns_the_stress_and_nothing_else(ticks: int) -> None:
    """A rotation by 90 degrees, also of a strained body, is exact to rounding for any step."""
    stretched = np.array([[1.1, 0.2, 0.0], [0.1, 0.9, 0.0], [0.0, 0.3, 1.05]])
    turned = carried(STRESS, lambda part: rotation(0.5 * math.pi * part) @ stretched, ticks)
    assert turned == pytest.approx(rotation(0.5 * math.pi) @ STRESS @ rotation(0.5 * math.pi).T, abs=1e-11)


def test_strain_and_rotation_together_are_of_second_order() -> None:
    """In a rotating frame, the stress is the rotated stress of the fixed frame; the error is 1e-6 with 1,000 ticks."""

    def strained(part: float) -> Tensor:
        return np.diag([1.0 + 0.2 * part, 1.0 - 0.1 * part, 1.0 + 0.05 * part])

    logarithm = np.diag(np.log(np.diag(strained(1.0))))
    end = rotation(0.5 * math.pi)
    exact = end @ (2.0 * logarithm + (2.0 - 2.0 / 3.0) * np.trace(logarithm) * np.eye(3)) @ end.T
    errors = []
    for ticks in (500, 1000):
        found = carried(np.zeros((3, 3)), lambda part: rotation(0.5 * math.pi * part) @ strained(part), ticks)
        errors.append(float(np.linalg.norm(found - exact) / np.linalg.norm(exact)))
    assert errors[1] < 1e-6
    assert math.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


def test_strain_spin_and_nominal_stress_in_matrices() -> None:
    random = np.random.default_rng(2)
    before, after = (np.eye(3) + 0.2 * random.normal(size=(3, 3)) for _ in range(2))
    gradient = 2.0 * (after - before) @ np.linalg.inv(after + before)
    found = strain_and_spin(nine(before), nine(after))
    spin = 0.5 * (gradient - gradient.T)
    turn = np.linalg.inv(np.eye(3) - 0.25 * spin) @ (np.eye(3) + 0.25 * spin)
    assert tensor(found.strain) == pytest.approx(turn @ (0.5 * (gradient + gradient.T)) @ turn.T, abs=1e-14)
    assert found.spin == pytest.approx([spin[0, 1], spin[1, 2], spin[2, 0]], abs=1e-14)
    nominal = nominal_stress(nine(after), six(STRESS))
    assert np.reshape(nominal, (3, 3)) == pytest.approx(np.linalg.inv(after) @ STRESS, abs=1e-12)


def test_the_largest_principal_stress() -> None:
    random = np.random.default_rng(3)
    cases = [tensor(random.normal(size=6)) * 10.0 ** random.uniform(-3.0, 9.0) for _ in range(200)]
    cases += [np.diag([1.0, 2.0, 3.0]), np.diag([5.0, 1.0, 5.0]), np.zeros((3, 3)), -np.eye(3), np.ones((3, 3))]
    for stress in cases:
        value, *along = largest_principal(six(stress))
        size = np.linalg.norm(stress)
        assert value == pytest.approx(np.linalg.eigvalsh(stress)[-1], abs=1e-14 * size)
        assert stress @ along == pytest.approx(value * np.array(along), abs=1e-13 * size)
        assert np.linalg.norm(along) == pytest.approx(1.0, abs=1e-14)
        deviator = stress - np.trace(stress) / 3.0 * np.eye(3)
        expected = math.sqrt(1.5 * float((deviator * deviator).sum()))
        assert equivalent_stress(six(stress)) == pytest.approx(expected, abs=1e-14 * size)


# -- bits ---------------------------------------------------------------------------------------------------------------------


def test_the_same_bits_without_the_compiler() -> None:
    code = (
        "from granular_env.components.materials.finite_strain import Spin, rotate_tensor\n"
        "from granular_env.components.materials.tensors import SymmetricTensor, largest_principal\n"
        "from granular_env.components.materials.thermoviscoplastic import Thermoviscoplastic, advance_stress\n"
        "from granular_env.components.support.jit import jit\n"
        "@jit\n"
        "def strained(law, strain, spin):\n"
        "    stress, plastic, temperature, work = SymmetricTensor(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), 0.0, 293.0, 0.0\n"
        "    for tick in range(60):\n"
        "        turned = rotate_tensor(stress, spin)\n"
        "        stress, plastic, temperature, work = advance_stress(law, turned, strain, plastic, temperature)\n"
        "    return stress, largest_principal(stress), plastic, temperature, work\n"
        "strain, spin = SymmetricTensor(3e-4, -2e-4, 1e-5, 1e-4, -3e-5, 2e-5), Spin(1e-3, -2e-3, 5e-4)\n"
        "stress, largest, *rest = strained(Thermoviscoplastic().constants(1e-7), strain, spin)\n"
        "assert rest[0] > 0.0\n"
        "print([float(value).hex() for value in (*stress, *largest, *rest)])"
    )
    assert run_python(code) == run_python(code, NUMBA_DISABLE_JIT="1")
