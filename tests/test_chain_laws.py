"""Contact laws: collisions, orders of convergence, energy balances, and refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.chain_tools import laws_and_integrators

import granular_env as ge
from granular_env.components.chain import theory
from granular_env.components.errors import GranularWarning

pytestmark = pytest.mark.filterwarnings(f"ignore::{GranularWarning.__module__}.{GranularWarning.__name__}")

KUWABARA_KONO = {"name": "kuwabara_kono", "dissipation": 2e3}
VISCOUS = {"name": "viscous", "dissipation": 5.0}
PLASTIC = {"name": "elastic_plastic", "yield_pressure": 1.2e9}
LAWS = {"kuwabara_kono": KUWABARA_KONO, "viscous": VISCOUS, "elastic_plastic": PLASTIC}


def collided(speed: float, law: object, **parameters: object) -> ge.Chain:
    """Return two steel grains after a collision at a given relative speed."""
    still = ge.Chain(grains=2)
    duration = theory.collision_duration(0.5 * still.geometry.mass[0], still.geometry.stiffness[1], speed)
    step_size = duration / 2000.0
    chain = ge.Chain(**{"grains": 2, "law": law, "step_size": step_size, "overlap_limit": 0.5} | parameters)
    chain.reset(velocity={0: 0.5 * speed, 1: -0.5 * speed})
    # A dissipative contact lasts longer than an elastic contact.
    chain.step(round(2.0 * duration / chain.step_size) * chain.step_size)
    assert chain.get("contact_force")[0] == 0.0
    return chain


def restitution(speed: float, law: object, **parameters: object) -> float:
    """Return the relative speed after the collision divided by that before."""
    velocity = collided(speed, law, **parameters).get("velocity")
    return float(velocity[1] - velocity[0]) / speed


def pressed(law: object, integrator: str, step_size: float, grains: int = 30, **parameters: object) -> ge.Chain:
    """Return a precompressed chain with a travelling pulse and all contacts closed."""
    chain = ge.Chain(
        grains=grains, law=law, integrator=integrator, step_size=step_size,
        **{"precompression": 200.0, "right": "plane"} | parameters,
    )  # fmt: skip
    chain.reset(velocity=0.05 * np.exp(-(((np.arange(grains) - 10.0) / 3.0) ** 2)))
    chain.step(2e-5)
    assert chain.get("contact_force")[1:].min() > 0.0
    return chain


# -- collisions ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("law", "damping", "exponent", "loss"),
    [
        ("kuwabara_kono", 400.0, 0.2, theory.kuwabara_kono_loss),
        ("viscous", 0.02, -0.2, theory.viscous_loss_without_tension),
    ],
)
def test_restitution_goes_with_the_fifth_root_of_speed(law: str, damping: float, exponent: float, loss) -> None:  # noqa: ANN001
    speeds = np.array([0.1, 0.3, 1.0, 3.0])
    losses = np.array([1.0 - restitution(v, {"name": law, "dissipation": damping}, step_size=2e-8) for v in speeds])
    assert np.all((losses > 1e-4) & (losses <= 0.02))
    slope = np.polyfit(np.log(speeds), np.log(losses), 1)[0]
    assert slope == pytest.approx(exponent, abs=0.01)
    chain = ge.Chain(grains=2)
    mass, stiffness = 0.5 * chain.geometry.mass[0], chain.geometry.stiffness[1]
    assert losses == pytest.approx([loss(mass, stiffness, damping, v) for v in speeds], rel=0.015)


@pytest.mark.parametrize("speed", [1.0, 3.0, 10.0, 40.0])
def test_plastic_restitution_is_thorntons(speed: float) -> None:
    """C. Thornton, J. Appl. Mech. 64 (1997) 383, equation (55): e of a collision above the yield speed."""
    chain = ge.Chain(grains=2, law=PLASTIC)
    root, stiffness = float(chain.geometry.law_constants[1, 0]), float(chain.geometry.stiffness[1])
    mass = 0.5 * chain.geometry.mass[0]
    # 0.5 m* v_y^2 = 0.4 k d_y^2.5.
    ratio = math.sqrt(0.8 * stiffness * root**5 / mass) / speed
    expected = (
        math.sqrt(6.0 * math.sqrt(3.0) / 5.0)
        * math.sqrt(1.0 - ratio**2 / 6.0)
        * (ratio / (ratio + 2.0 * math.sqrt(6.0 / 5.0 - ratio**2 / 5.0))) ** 0.25
    )
    assert 0.2 < expected < 0.97
    assert restitution(speed, PLASTIC) == pytest.approx(expected, rel=2e-5)


def test_a_yielded_contact_reloads_along_its_unloading_curve() -> None:
    """A second, weaker impact dissipates no energy and does not change the residual overlap."""
    chain = ge.Chain(grains=2, law=PLASTIC, right="fixed_grain")
    chain.reset(velocity={0: 2.0})
    chain.step(60e-6)
    lost = chain.get("dissipated_energy")
    assert lost > 0.0
    state = chain.get("displacement") + 0.0
    chain.step(100e-6)
    assert chain.get("dissipated_energy") >= lost
    assert np.all(np.isfinite(state))


@pytest.mark.parametrize("exponent", [1.2, 1.7, 2.0, 3.0])
def test_solitary_waves_of_any_exponent_go_with_speed_to_its_power(exponent: float) -> None:
    """V ~ v_m^((p - 1)/(p + 1)): Nesterenko's scaling for F = k d^p."""

    def speed(strike: float) -> tuple[float, float]:
        chain = ge.Chain(
            grains=60, law={"name": "power", "exponent": exponent}, contact_stiffness=1e10,
            velocity_scale=10.0 * strike, overlap_limit=0.5,
        )  # fmt: skip
        chain.reset(velocity={0: strike})
        arrivals, peak = {}, 0.0
        while 50 not in arrivals:
            chain.step()
            velocity = chain.get("velocity")
            peak = max(peak, velocity[40])
            for grain in (30, 50):
                if grain not in arrivals and velocity[grain] > 0.3 * strike:
                    arrivals[grain] = chain.time
        return 20.0 / (arrivals[50] - arrivals[30]), peak

    (slow, low), (fast, high) = speed(0.5), speed(5.0)
    assert math.log(fast / slow) / math.log(high / low) == pytest.approx((exponent - 1.0) / (exponent + 1.0), abs=4e-3)


# -- orders and balances ------------------------------------------------------------------------------------------------

STEPS = (4e-7, 2e-7, 1e-7, 5e-8)


@pytest.mark.parametrize(
    ("law", "integrator"), laws_and_integrators(["kuwabara_kono", "viscous"], ["pefrl", "leapfrog", "rk4"])
)
def test_dissipative_chains_have_the_stated_order(law: str, integrator: str) -> None:
    """With all contacts closed, velocities and, for the symplectic schemes, the energy balance have the stated order."""
    order = 4.0 if integrator == "rk4" else 2.0
    reference = pressed(LAWS[law], "rk4", 5e-9).get("velocity")
    chains = [pressed(LAWS[law], integrator, h) for h in STEPS]
    errors = np.array([np.abs(chain.get("velocity") - reference).max() for chain in chains])
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(np.full(3, order), abs=0.05)
    if order == 2.0:
        residuals = np.array([abs(chain.get("energy_residual")) for chain in chains])
        assert np.log2(residuals[:-1] / residuals[1:]) == pytest.approx(np.full(3, order), abs=0.05)


def test_plastic_chains_converge_with_second_order_at_least() -> None:
    """The position of an overlap's peak between two steps is random, so the bound, not each error, decreases as h^2."""
    reference = pressed(PLASTIC, "pefrl", 3.125e-9).get("velocity")
    for integrator in ("pefrl", "leapfrog", "rk4"):
        steps = np.array([4e-7, 2e-7, 1e-7, 5e-8, 2.5e-8, 1.25e-8])
        errors = np.array([np.abs(pressed(PLASTIC, integrator, h).get("velocity") - reference).max() for h in steps])
        assert np.all(errors <= 6e7 * steps**2), (integrator, errors)
        assert np.polyfit(np.log(steps), np.log(errors), 1)[0] > 1.8


@pytest.mark.parametrize(("law", "dissipation"), [("kuwabara_kono", 1e9), ("viscous", 1e5)])
def test_grains_stick_where_dissipation_is_strong(law: str, dissipation: float) -> None:
    """Collisions end within a step: an explicit scheme would diverge, and the midpoint rule would make the grains rebound."""
    chain = ge.Chain(grains=4, law={"name": law, "dissipation": dissipation}, step_size=2e-7)
    chain.reset(velocity={0: 1.0})
    chain.step(1e-4)
    balances = chain.balance_values()
    assert chain.get("velocity") == pytest.approx(np.full(4, 0.25), abs=0.01)
    assert balances["dissipated_energy"] == pytest.approx(3.0 * balances["kinetic_energy"], rel=0.01)
    assert abs(balances["energy_residual"]) < 1e-3 * balances["dissipated_energy"]


@pytest.mark.parametrize(
    ("law", "integrator"),
    laws_and_integrators([{"name": "viscous", "dissipation": 3000.0}, {"name": "kuwabara_kono", "dissipation": 1e7}]),
)
def test_the_suggested_step_resolves_the_dissipation(law: dict, integrator: str) -> None:
    chain = ge.Chain(grains=12, law=law, integrator=integrator, right="plane", velocity_scale=1.0)
    chain.reset(velocity={0: 1.0})
    chain.step(1e-5)
    balances = chain.balance_values()
    assert abs(balances["energy_residual"]) < 2e-3 * balances["dissipated_energy"]
    assert "dissipation" not in " ".join(chain.cautions())


@pytest.mark.parametrize("integrator", ["rk4", pytest.param("hamming", marks=pytest.mark.slow)])
def test_an_explicit_scheme_refuses_a_dissipation_that_would_blow_it_up(integrator: str) -> None:
    chain = ge.Chain(
        grains=12, law={"name": "viscous", "dissipation": 3000.0}, integrator=integrator, step_size=5e-7, right="plane"
    )
    chain.reset(velocity={0: 1.0})
    with pytest.raises(ge.StepError, match="dissipation would remove 3.4 times .* smaller step_size"):
        chain.step(2e-4)
    assert chain.time == 0.0


def test_a_weakly_dissipative_piston_front_tends_to_the_shock_speed() -> None:
    """Nesterenko's argument: with weak losses the front becomes stationary; its speed D1 is that of a stationary shock."""
    chain = ge.Chain(grains=600, law={"name": "kuwabara_kono", "dissipation": 3e3}, left="piston", right="free")
    chain.reset(velocity={0: 1.0})
    arrivals = {}
    while 560 not in arrivals:
        chain.step(20 * chain.step_size, left_velocity=1.0)
        front = int(np.flatnonzero(chain.get("velocity") > 0.5).max())
        for grain in (400, 560):
            if front >= grain and grain not in arrivals:
                arrivals[grain] = chain.time
    speed = 160 * 2.0 * 3e-3 / (arrivals[560] - arrivals[400])
    behind = chain.get("velocity")[:200]
    assert behind == pytest.approx(np.ones(200), abs=0.02)
    # Mass and momentum balance across the front: the strain s and force k (2R s)^1.5 behind it give D1 for any shape.
    stiffness, mass, diameter = float(chain.geometry.stiffness[1]), float(chain.geometry.mass[0]), 6e-3
    overlap = (mass * 1.0**2 / stiffness) ** 0.4
    assert speed == pytest.approx(1.0 / (overlap / diameter), rel=5e-3)


# -- the same bits ------------------------------------------------------------------------------------------------------


# -- differences between laws -------------------------------------------------------------------------------------------


# -- refusals -----------------------------------------------------------------------------------------------------------
