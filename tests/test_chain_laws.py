"""Contact laws: what a collision does, orders, ledgers, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.chain_tools import python

import granular_env as ge
from granular_env.components.chain import theory
from granular_env.components.errors import GranularWarning, ParameterError

pytestmark = pytest.mark.filterwarnings(f"ignore::{GranularWarning.__module__}.{GranularWarning.__name__}")

KUWABARA_KONO = {"name": "kuwabara_kono", "dissipation": 2e3}
VISCOUS = {"name": "viscous", "dissipation": 5.0}
PLASTIC = {"name": "elastic_plastic", "yield_pressure": 1.2e9}
LAWS = {"kuwabara_kono": KUWABARA_KONO, "viscous": VISCOUS, "elastic_plastic": PLASTIC}
RUBBER = ge.Material(density=1e3, young=1e7, poisson=0.49)
INTEGRATORS = ("pefrl", "leapfrog", "rk4", "hamming", "dop853")


def collided(speed: float, law: object, **parameters: object) -> ge.Chain:
    """Two steel grains after they have met at a relative speed."""
    still = ge.Chain(grains=2)
    duration = theory.collision_duration(0.5 * still.geometry.mass[0], still.geometry.stiffness[1], speed)
    step_size = duration / 2000.0
    chain = ge.Chain(**{"grains": 2, "law": law, "step_size": step_size, "overlap_limit": 0.5} | parameters)
    chain.reset(velocity={0: 0.5 * speed, 1: -0.5 * speed})
    # A dissipative contact lasts longer than an elastic one.
    chain.step(round(2.0 * duration / chain.step_size) * chain.step_size)
    assert chain.get("contact_force")[0] == 0.0
    return chain


def restitution(speed: float, law: object, **parameters: object) -> float:
    """Relative speed after over before."""
    velocity = collided(speed, law, **parameters).get("velocity")
    return float(velocity[1] - velocity[0]) / speed


def pressed(law: object, integrator: str, step_size: float, grains: int = 30, **parameters: object) -> ge.Chain:
    """A pressed chain in which a pulse runs, all contacts closed."""
    chain = ge.Chain(
        grains=grains, law=law, integrator=integrator, step_size=step_size,
        **{"precompression": 200.0, "right": "plane", "tolerance": 1e-14} | parameters,
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
    losses = np.array([1.0 - restitution(v, {"name": law, "dissipation": damping}, integrator="dop853") for v in speeds])
    assert np.all((losses > 1e-4) & (losses <= 0.02))
    slope = np.polyfit(np.log(speeds), np.log(losses), 1)[0]
    assert slope == pytest.approx(exponent, abs=0.01)
    chain = ge.Chain(grains=2)
    mass, stiffness = 0.5 * chain.geometry.mass[0], chain.geometry.stiffness[1]
    assert losses == pytest.approx([loss(mass, stiffness, damping, v) for v in speeds], rel=0.015)


@pytest.mark.parametrize("speed", [1.0, 3.0, 10.0, 40.0])
def test_plastic_restitution_is_thorntons(speed: float) -> None:
    """C. Thornton, J. Appl. Mech. 64 (1997) 383, equation (55): e of a collision faster than the yield speed."""
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


def test_a_slow_collision_is_elastic_whatever_could_yield() -> None:
    assert restitution(1e-3, PLASTIC) == pytest.approx(1.0, abs=1e-6)
    assert collided(1e-3, PLASTIC).get("dissipated_energy") == 0.0


def test_a_yielded_contact_reloads_along_its_unloading_curve() -> None:
    """A second, weaker blow costs nothing, and leaves the residual overlap as it is."""
    chain = ge.Chain(grains=2, law=PLASTIC, right="fixed_grain")
    chain.reset(velocity={0: 2.0})
    chain.step(60e-6)
    lost = chain.get("dissipated_energy")
    assert lost > 0.0
    state = chain.get("displacement") + 0.0
    chain.step(100e-6)
    assert chain.get("dissipated_energy") >= lost
    assert np.all(np.isfinite(state))


def test_exponent_3_halves_is_hertz_and_1_is_a_spring() -> None:
    stiffness = float(ge.Chain(grains=2).geometry.stiffness[1])
    hertz, power = (
        collided(2.0, law, step_size=1e-7, contact_stiffness=stiffness) for law in ("hertz", {"name": "power", "exponent": 1.5})
    )
    assert power.get("velocity") == pytest.approx(hertz.get("velocity"), rel=1e-12)
    spring = ge.Chain(grains=2, law={"name": "power", "exponent": 1.0}, contact_stiffness=1e7, step_size=1e-8)
    spring.reset(velocity={0: 1.0})
    half_period = math.pi * math.sqrt(0.5 * spring.geometry.mass[0] / 1e7)
    spring.step(math.floor(half_period / 1e-8) * 1e-8)
    assert spring.get("contact_force")[1] > 0.0
    spring.step(2e-8)
    assert spring.get("contact_force")[1] == 0.0
    assert spring.get("velocity") == pytest.approx([0.0, 1.0], abs=1e-4)


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


# -- orders and ledgers -------------------------------------------------------------------------------------------------

STEPS = (4e-7, 2e-7, 1e-7, 5e-8)


@pytest.mark.parametrize("law", ["kuwabara_kono", "viscous"])
@pytest.mark.parametrize(("integrator", "order"), [("pefrl", 2.0), ("leapfrog", 2.0), ("rk4", 4.0)])
def test_dissipative_chains_have_the_stated_order(law: str, integrator: str, order: float) -> None:
    """While all contacts stay closed: velocities, and for the symplectic schemes the ledger too."""
    reference = pressed(LAWS[law], "dop853", 2e-7).get("velocity")
    chains = [pressed(LAWS[law], integrator, h) for h in STEPS]
    errors = np.array([np.abs(chain.get("velocity") - reference).max() for chain in chains])
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(np.full(3, order), abs=0.05)
    if order == 2.0:
        residuals = np.array([abs(chain.get("energy_residual")) for chain in chains])
        assert np.log2(residuals[:-1] / residuals[1:]) == pytest.approx(np.full(3, order), abs=0.05)


def test_plastic_chains_converge_with_second_order_at_least() -> None:
    """Where the peak of an overlap falls between two steps is chance: the bound goes down as h^2, not each error."""
    reference = pressed(PLASTIC, "pefrl", 3.125e-9).get("velocity")
    for integrator in ("pefrl", "leapfrog", "rk4"):
        steps = np.array([4e-7, 2e-7, 1e-7, 5e-8, 2.5e-8, 1.25e-8])
        errors = np.array([np.abs(pressed(PLASTIC, integrator, h).get("velocity") - reference).max() for h in steps])
        assert np.all(errors <= 6e7 * steps**2), (integrator, errors)
        assert np.polyfit(np.log(steps), np.log(errors), 1)[0] > 1.8


@pytest.mark.parametrize("wall", ["fixed_grain", "plane", "rigid_plane"])
@pytest.mark.parametrize("law", ["viscous", "kuwabara_kono", "linear"])
def test_a_wall_takes_what_two_grains_of_twice_the_mass_take(law: str, wall: str) -> None:
    """Reduced mass, stiffness and dissipation are the same, and so is the relative motion, to rounding."""
    given = {
        "law": {"name": law, "dissipation": 500.0 if law == "kuwabara_kono" else 2.0},
        "contact_stiffness": 5e9,
        "step_size": 1e-8,
    }
    if law == "linear":
        given["contact_stiffness"] = 1e7
    single = ge.Chain(grains=1, mass=1e-3, right=wall, **given)
    pair = ge.Chain(grains=2, mass=2e-3, **given)
    for chain in (single, pair):
        chain.reset(velocity={0: 1.0})
        chain.step(1e-4)
    first, second = pair.get("velocity")
    assert 0.0 < -single.get("velocity")[0] < 1.0
    assert -single.get("velocity")[0] == pytest.approx(second - first, rel=1e-9)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("ends", [("free", "free"), ("piston", "rigid_plane"), ("fixed_grain", "piston")])
def test_ledgers_close_while_contacts_open_and_close(law: str, integrator: str, ends: tuple[str, str]) -> None:
    """To a part of what is at stake; dissipation never gives anything back; no contact ever pulls."""
    left, right = ends
    chain = ge.Chain(grains=12, law=LAWS[law], integrator=integrator, left=left, right=right, step_size=5e-8)
    chain.reset(velocity={0: 1.0, 7: -0.5})
    inputs = {
        f"{side}_velocity": speed for side, end, speed in (("left", left, 1.0), ("right", right, -0.5)) if end == "piston"
    }
    lost = 0.0
    for _ in range(20):
        chain.step(5e-6, **inputs)
        balances = chain.balance_values()
        at_stake = balances["kinetic_energy"] + balances["potential_energy"] + balances["dissipated_energy"]
        assert abs(balances["energy_residual"]) < {"leapfrog": 1e-4}.get(integrator, 2e-6) * at_stake
        scale = np.abs(chain.get("velocity") * chain.geometry.mass).sum()
        assert abs(balances["momentum_residual"]) < 1e-13 * scale
        assert balances["dissipated_energy"] >= lost
        assert chain.get("contact_force").min() >= 0.0
        lost = balances["dissipated_energy"]
    assert lost > 0.0


def test_integrators_agree_on_every_law() -> None:
    for law in LAWS.values():
        velocities = []
        for integrator in INTEGRATORS:
            chain = ge.Chain(grains=15, law=law, integrator=integrator, step_size=2e-8)
            chain.reset(velocity={0: 1.0})
            chain.step(6e-5)
            velocities.append(chain.get("velocity"))
        for velocity in velocities[:-1]:
            assert velocity == pytest.approx(velocities[-1], abs=2e-5)


@pytest.mark.parametrize(("law", "dissipation"), [("kuwabara_kono", 1e9), ("viscous", 1e5)])
def test_grains_stick_where_dissipation_is_strong(law: str, dissipation: float) -> None:
    """Collisions end within a step: an explicit scheme would blow up, the midpoint rule would throw the grains back."""
    chain = ge.Chain(grains=4, law={"name": law, "dissipation": dissipation}, step_size=2e-7)
    chain.reset(velocity={0: 1.0})
    chain.step(1e-4)
    balances = chain.balance_values()
    assert chain.get("velocity") == pytest.approx(np.full(4, 0.25), abs=0.01)
    assert balances["dissipated_energy"] == pytest.approx(3.0 * balances["kinetic_energy"], rel=0.01)
    assert abs(balances["energy_residual"]) < 1e-3 * balances["dissipated_energy"]


def test_a_step_that_dissipation_outruns_is_told() -> None:
    def told(step_size: float) -> tuple[float, str]:
        chain = ge.Chain(grains=3, law={"name": "viscous", "dissipation": 1e3}, step_size=step_size)
        chain.reset(velocity={0: 1.0})
        chain.step(1e-6)
        return chain.report()["dissipation in a step (c h / m*)"], " ".join(chain.cautions())

    mass = 0.5 * ge.Chain(grains=3).geometry.mass[0]
    figure, sentence = told(5e-7)
    assert figure == pytest.approx(1e3 * 5e-7 / mass) and "dissipation would stop 1.1 times" in sentence
    figure, sentence = told(5e-8)
    assert figure == pytest.approx(1e3 * 5e-8 / mass) and "dissipation" not in sentence


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("law", [{"name": "viscous", "dissipation": 3000.0}, {"name": "kuwabara_kono", "dissipation": 1e7}])
def test_the_suggested_step_resolves_the_dissipation(law: dict, integrator: str) -> None:
    chain = ge.Chain(grains=12, law=law, integrator=integrator, right="plane", velocity_scale=1.0)
    chain.reset(velocity={0: 1.0})
    chain.step(1e-5)
    balances = chain.balance_values()
    assert abs(balances["energy_residual"]) < 2e-3 * balances["dissipated_energy"]
    assert "dissipation" not in " ".join(chain.cautions())


@pytest.mark.parametrize("integrator", ["rk4", "hamming"])
def test_an_explicit_scheme_refuses_a_dissipation_that_would_blow_it_up(integrator: str) -> None:
    chain = ge.Chain(
        grains=12, law={"name": "viscous", "dissipation": 3000.0}, integrator=integrator, step_size=5e-7, right="plane"
    )
    chain.reset(velocity={0: 1.0})
    with pytest.raises(ge.StepError, match="dissipation would stop 3.4 times .* smaller step_size"):
        chain.step(2e-4)
    assert chain.time == 0.0


def test_reports_are_those_of_the_law() -> None:
    """Only spheres have a contact pressure, and plastic ones none above that at which they yield."""
    cone = ge.Chain(grains=12, law={"name": "power", "exponent": 2.5}, contact_stiffness=1e13, right="plane")
    plastic = ge.Chain(grains=12, law={"name": "elastic_plastic", "yield_pressure": 1e9})
    for chain in (cone, plastic):
        chain.reset(velocity={0: 1.0})
        chain.step(1e-4)
    assert math.isnan(cone.validity().peak_pressure) and "pressure" not in " ".join(cone.cautions())
    assert cone.validity().forces_per_contact > 60.0
    assert plastic.validity().peak_pressure == pytest.approx(1e9)
    assert plastic.validity().pressure_to_yield > 1.0 and "deform plastically" not in " ".join(plastic.cautions())


def test_no_dissipation_is_hertz() -> None:
    plain, damped = (
        ge.Chain(grains=10, law=law, step_size=1e-7) for law in ("hertz", {"name": "kuwabara_kono", "dissipation": 0.0})
    )
    for chain in (plain, damped):
        chain.reset(velocity={0: 1.0})
        chain.step(5e-5)
    assert damped.get("velocity") == pytest.approx(plain.get("velocity"), abs=1e-9)
    assert damped.get("dissipated_energy") == pytest.approx(0.0, abs=1e-18)


def test_a_weakly_dissipative_piston_front_tends_to_the_shock_speed() -> None:
    """Nesterenko's argument: with weak losses the front settles; its speed is D1 = V v_1^.2-ratio of a stationary shock."""
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
    # Mass and momentum across the front: the strain s and force k (2R s)^1.5 behind it give D1 with no regard to its shape.
    stiffness, mass, diameter = float(chain.geometry.stiffness[1]), float(chain.geometry.mass[0]), 6e-3
    overlap = (mass * 1.0**2 / stiffness) ** 0.4
    assert speed == pytest.approx(1.0 / (overlap / diameter), rel=5e-3)


# -- the same bits ------------------------------------------------------------------------------------------------------


def test_the_same_bits_without_the_compiler() -> None:
    code = """
import granular_env as ge, warnings
warnings.simplefilter("ignore")
for law in ({"name": "kuwabara_kono", "dissipation": 2e3}, {"name": "viscous", "dissipation": 5.0},
            {"name": "elastic_plastic", "yield_pressure": 1e9}, {"name": "power", "exponent": 1.7}):
    for integrator in ("pefrl", "leapfrog", "rk4"):
        chain = ge.Chain(grains=5, law=law, integrator=integrator, step_size=1e-7, right="plane", gravity=9.81,
                         contact_stiffness=1e10, precompression=10.0)
        chain.reset(velocity={0: 1.0})
        chain.step(3e-6)
        print(chain.save().data.hex())
"""
    assert python(code) == python(code, NUMBA_DISABLE_JIT="1")


def test_tiles_leave_no_trace_in_a_general_exponent(monkeypatch) -> None:  # noqa: ANN001
    """17,000 grains are advanced tile by tile, and their first 3000 have the bits of a chain of 3000 while nothing arrives."""

    def moved(grains: int) -> np.ndarray:
        chain = ge.Chain(grains=grains, law={"name": "power", "exponent": 1.7}, contact_stiffness=1e10, precompression=1.0)
        chain.reset(velocity={0: 1.0, 1000: -0.5})
        chain.step(40 * chain.step_size)
        return chain.get("velocity")[:2000]

    assert moved(17_000).tobytes() == moved(3000).tobytes()


POWER = {"name": "power", "exponent": 1.7}


@pytest.mark.parametrize("law", ["hertz", POWER, *LAWS.values()], ids=str)
def test_walls_feel_the_force_of_their_contacts(law: object) -> None:
    """To the bit, moving grains and dissipation included; nothing where there is no wall."""
    walls = {"left": "plane", "right": "fixed_grain", "precompression": 50.0, "step_size": 1e-8}
    chain = ge.Chain(grains=5, law=law, contact_stiffness=4.9e9, **walls)
    chain.reset(velocity=[0.1, -0.2, 0.0, 0.3, 0.2])
    chain.step(1e-6)
    forces = chain.get("contact_force")
    assert forces[0] > 0.0 and chain.get("left_wall_force") == forces[0]
    assert forces[-1] > 0.0 and chain.get("right_wall_force") == -forces[-1]
    free = ge.Chain(grains=5, law=law, contact_stiffness=4.9e9, precompression=50.0, step_size=1e-8)
    assert free.get("left_wall_force") == free.get("right_wall_force") == 0.0


# -- what tells one law from another ------------------------------------------------------------------------------------


def test_laws_of_like_parameters_are_not_confused() -> None:
    """A snapshot of one law must not go on in another."""
    viscous, kuwabara_kono = (
        ge.Chain(grains=4, law={"name": name, "dissipation": 5.0}, step_size=1e-7) for name in ("viscous", "kuwabara_kono")
    )
    assert viscous.identity != kuwabara_kono.identity
    with pytest.raises(ParameterError, match="identity"):
        kuwabara_kono.restore(viscous.save())


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_a_law_keeps_its_name_where_defaults_are_left_out(law: dict) -> None:
    assert ge.Chain(grains=4, law=law).parameters.model_dump(mode="json", exclude_defaults=True)["law"] == law


# -- what is refused ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({"law": "hertzz"}, "nearest is 'hertz'|did you mean 'hertz'|hertz"),
        ({"law": {"name": "power", "exponent": 0.9}, "contact_stiffness": 1e9}, "exponent.*0.9.*1"),
        ({"law": {"name": "power", "exponent": 1.5}}, "contact_stiffness.*power"),
        ({"law": "power", "contact_stiffness": 1e9}, "exponent"),
        ({"law": {"name": "viscous", "dissipation": -1.0}}, "dissipation.*-1"),
        ({"law": {"name": "kuwabara_kono", "dissipation": [1.0, 2.0]}}, "dissipation: got 2 values.*5"),
        ({"law": {"name": "kuwabara_kono", "dissipation": math.nan}}, "dissipation"),
        ({"law": {"name": "kuwabara_kono", "disipation": 1.0}}, "dissipation"),
        ({"law": {"name": "elastic_plastic", "yield_pressure": 0.0}}, "yield_pressure"),
        (
            {"law": "elastic_plastic", "material": ge.Material(density=1e3, young=1e9, poisson=0.3)},
            "yield_pressure.*yield_strength",
        ),
        ({"law": 3.0}, "law"),
        ({"law": {}}, "law.*name"),
    ],
)
def test_bad_laws_are_named(parameters: dict, said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        ge.Chain(**{"grains": 4} | parameters)


@pytest.mark.parametrize("gap", [0.0, 1.1e-6])
@pytest.mark.parametrize("step_size", [1e-6, 2e-7])
def test_the_reference_controls_the_error_of_the_loss_too(step_size: float, gap: float) -> None:
    """Where dissipation is cut off the contact carries nothing, but gives up its energy: grains do not tell that error."""

    def lost(step: float, tolerance: float) -> float:
        law = {"name": "kuwabara_kono", "dissipation": 2e3}
        chain = ge.Chain(grains=2, law=law, integrator="dop853", step_size=step, tolerance=tolerance, gap=gap)
        chain.reset(velocity={0: 1.0})
        chain.step(1e-4)
        return chain.get("dissipated_energy")

    exact = lost(1e-8, 1e-14)
    assert lost(step_size, 1e-12) == pytest.approx(exact, rel=1e-7)
    assert lost(step_size, 1e-14) == pytest.approx(exact, rel=1e-11)
