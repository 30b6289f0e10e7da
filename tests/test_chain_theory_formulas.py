"""Closed forms that need no run: the long-wave equations against the lattice, scales, collisions, restitution."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.chain_tools import RADIUS

import granular_env as ge
from granular_env.components.chain import theory

# -- (2.2), (2.3), (2.4) against (2.1) --------------------------------------------------------------------------------


def test_order_of_the_anharmonic_approximation() -> None:
    """(2.2) neglects the third power of the change of overlap."""
    shape = np.sin(1.3 * np.arange(12.0))
    errors = []
    for size in (1e-2, 5e-3, 2.5e-3):
        exact = theory.lattice_acceleration(size * shape, 3.0, 0.7)
        errors.append(np.abs(theory.anharmonic_acceleration(size * shape, 3.0, 0.7) - exact).max())
    assert [math.log2(errors[i] / errors[i + 1]) for i in range(2)] == pytest.approx([3.0, 3.0], abs=0.05)


def waves_of(place: np.ndarray, height: float) -> np.ndarray:
    """Return u = height sin x and its first four derivatives, shape (5, n)."""
    sine, cosine = height * np.sin(place), height * np.cos(place)
    return np.array([sine, cosine, -sine, -cosine, sine])


def test_order_of_the_long_wave_equation() -> None:
    """(2.4), as printed, neglects (a/L)^4 for any wave height, here for strains from 0.2 to 1.8."""
    errors = []
    for diameter in (0.1, 0.05, 0.025):
        place = diameter * np.arange(round(6.0 / diameter))
        u, *derivatives = waves_of(place, 0.8)
        derivatives[0] = derivatives[0] - 1.0
        exact = theory.lattice_acceleration(u - place, diameter**-2.5, 0.0)
        found = theory.nesterenko_acceleration(derivatives, diameter**-2.5, diameter)[1:-1]
        errors.append(np.abs(found - exact).max())
    assert [math.log2(errors[i] / errors[i + 1]) for i in range(2)] == pytest.approx([4.0, 4.0], abs=0.1)


@pytest.mark.parametrize(
    ("diameters", "heights", "order"), [((0.4, 0.2, 0.1), (1e-6,) * 3, 4.0), ((1e-3,) * 3, (0.1, 0.05, 0.025), 3.0)]
)
def test_orders_of_the_weakly_nonlinear_equation(diameters, heights, order: float) -> None:
    """(2.3) neglects (a/L)^4 of the linear term, and the third power of the strain's change."""
    errors = []
    for diameter, height in zip(diameters, heights, strict=True):
        place = diameter * np.arange(round(6.0 / diameter))
        u, *derivatives = waves_of(place, height)
        exact = theory.lattice_acceleration(u, 1.0, diameter)
        found = theory.long_wave_acceleration(derivatives, 1.0, diameter, diameter)[1:-1]
        errors.append(np.abs(found - exact).max() / diameter**2.5)
    assert [math.log2(errors[i] / errors[i + 1]) for i in range(2)] == pytest.approx([order, order], abs=0.1)


@pytest.mark.parametrize("rise", [0.01, 0.3])
def test_the_soliton_solves_the_weakly_nonlinear_equation(rise: float) -> None:
    """u_tt = V^2 u_xx for u(x - Vt), with u_x = -e xi_0 sech^2: exact in (2.3)."""
    place = np.linspace(-4.0, 4.0, 801) / math.sqrt(rise)
    shape = theory.korteweg_de_vries_shape(place, rise)
    rate = math.sqrt(0.5 * rise)
    tangent = np.tanh(rate * place)
    first = -2.0 * rate * shape * tangent
    second = 2.0 * rate**2 * shape * (2.0 - 3.0 * shape)
    third = first * (4.0 * rate**2 - 12.0 * rate**2 * shape)
    slopes = -rise * np.array([shape, first, second, third])  # a = delta0 = 1, so xi_0 = 1
    speed = theory.sound_speed(1.0, 1.0, 1.0) * theory.korteweg_de_vries_speed_ratio(rise)
    found = theory.long_wave_acceleration(slopes, 1.0, 1.0, 1.0)
    assert found == pytest.approx(speed**2 * slopes[1], abs=1e-12 * rise)


# -- scales -----------------------------------------------------------------------------------------------------------


def test_the_paper_s_constants() -> None:
    """A is 6.391e12 for the paper's steel (it prints 5.6e12), and c^2 = 2E/(pi rho (1 - nu^2)) is A a^(5/2)."""
    steel = (2e11, 0.29, 7800.0)
    constant = theory.contact_constant(*steel, RADIUS)
    assert constant == pytest.approx(6.391e12, rel=1e-4)
    chain = ge.make("chain", grains=2, radius=RADIUS, material="steel").geometry
    assert constant == pytest.approx(chain.stiffness[1] / chain.mass[0], rel=1e-12)
    speed = theory.contact_speed(constant, 2.0 * RADIUS)
    assert speed == pytest.approx(theory.nesterenko_speed(*steel), rel=1e-12)
    assert speed == pytest.approx(math.sqrt(2.0 * 2e11 / (math.pi * 7800.0 * (1.0 - 0.29**2))), rel=1e-12)
    # v0 = D1 xi_c, with mass and momentum balance across the shock.
    shock = theory.shock_speed(constant, 2.0 * RADIUS, 5.0)
    assert shock * theory.shock_strain(shock / speed) == pytest.approx(5.0, rel=1e-12)
    assert 1.0 / theory.time_scale(1.0, 5.6e12, 5.0) == pytest.approx(173408.0, rel=1e-5)


# -- binary collisions ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0, 3.2])
def test_the_tangent_is_the_slope_of_the_force(exponent: float) -> None:
    stiffness, force, part = 3e9, 20.0, 1e-5
    overlap = (force / stiffness) ** (1.0 / exponent)
    rise = [stiffness * (overlap * (1.0 + sign * part)) ** exponent for sign in (-1.0, 1.0)]
    slope = (rise[1] - rise[0]) / (2.0 * part * overlap)
    assert theory.tangent_stiffness(stiffness, force, exponent) == pytest.approx(slope, rel=1e-9)


def test_tapers() -> None:
    assert theory.tapered_ratio(0.1) == pytest.approx(2.0 / (1.0 + 0.9**3), rel=1e-15)
    assert theory.tapered_velocities(0.1, 6) == pytest.approx(theory.tapered_ratio(0.1) ** np.arange(6.0), rel=1e-12)


# -- restitution ------------------------------------------------------------------------------------------------------


def loss(damping: float, power: float, speed: float, *, tension: bool = False) -> float:
    """Return 1 - e of d'' = -(d^1.5 + damping d^power d'), m* = k = 1, up to zero overlap or, without tension, zero force."""

    def force(state: np.ndarray) -> float:
        depth = max(state[0], 0.0)
        return depth**1.5 + damping * (depth**power if power else 1.0) * state[1]

    def ends(_: float, state: np.ndarray) -> float:
        return state[0] if tension or state[1] > 0.0 else force(state)

    ends.terminal, ends.direction = True, -1.0
    found = solve_ivp(
        lambda _, state: [state[1], -force(state)], (0.0, 50.0 * speed**-0.2), [1e-14, speed],
        method="DOP853", rtol=1e-12, atol=1e-15, events=ends,
    )  # fmt: skip
    return 1.0 + found.y[1, -1] / speed


@pytest.mark.parametrize("speed", [0.01, 1.0, 30.0])
@pytest.mark.parametrize("wanted", [0.02, 0.002])
def test_restitution_of_kuwabara_and_kono(wanted: float, speed: float) -> None:
    """The leading order plus the next term, -(3/5)(1 - e)^2, agree within the remainder."""
    damping = wanted / theory.kuwabara_kono_loss(1.0, 1.0, 1.0, speed)
    assert theory.KUWABARA_KONO_COEFFICIENT == pytest.approx(1.15344, abs=3e-5)
    assert loss(damping, 0.5, speed) == pytest.approx(wanted - 0.6 * wanted**2, abs=2.0 * wanted**2.5)


@pytest.mark.parametrize("speed", [0.01, 1.0, 30.0])
@pytest.mark.parametrize("wanted", [0.02, 0.002])
def test_restitution_of_a_dashpot(wanted: float, speed: float) -> None:
    """Without tension, a contact loses less by a relative (1 - e)^(2/3), which the second formula contains."""
    damping = wanted / theory.viscous_loss(1.0, 1.0, 1.0, speed)
    assert theory.VISCOUS_COEFFICIENT == pytest.approx(1.7878, abs=5e-5)
    assert loss(damping, 0.0, speed, tension=True) == pytest.approx(wanted, rel=3.0 * wanted)
    clipped = theory.viscous_loss_without_tension(1.0, 1.0, damping, speed)
    assert loss(damping, 0.0, speed) == pytest.approx(clipped, rel=3.0 * wanted)
    assert clipped < wanted
