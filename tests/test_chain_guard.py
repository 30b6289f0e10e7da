"""What the chain refuses: contacts seen too seldom, too deep, too fast; senseless parameters and inputs. No tension, ever."""

from __future__ import annotations

import copy
import math
import warnings

import numpy as np
import pytest
from support.chain_tools import INTEGRATORS, advance, unit_chain

import granular_env as ge
from granular_env.components.chain import Chain
from granular_env.components.materials.elastic import PRESETS
from granular_env.components.profiles import Profile


def test_seldom_seen_contacts_are_warned_of_once() -> None:
    chain = unit_chain(5, step_size=0.3)
    chain.reset(velocity={0: 1.0})
    with pytest.warns(ge.GranularWarning, match=r"fewer than the 60 force evaluations that pefrl wants.*step_size") as caught:
        advance(chain, 12.0)
    assert len(caught) == 1
    assert any("force evaluations" in sentence for sentence in chain.cautions())


def test_a_warning_changes_no_bits() -> None:
    seen = []
    for pieces in (1, 40):
        chain = unit_chain(5, step_size=0.3)
        chain.reset(velocity={0: 1.0})
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for _ in range(pieces):
                chain.step(12.0 / pieces)
        seen.append(chain.save().to_bytes())
    assert seen[0] == seen[1]


@pytest.mark.parametrize("scheme", ["pefrl", "leapfrog", "rk4", "hamming"])
def test_contacts_hardly_seen_are_refused_and_the_state_is_unharmed(scheme: str) -> None:
    chain = unit_chain(5, step_size=2.0, integrator=scheme)
    chain.reset(velocity={0: 1.0})
    before = chain.save().to_bytes()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(ge.StepError, match="force evaluations: take a smaller step_size") as caught:
            chain.step(40.0)
    assert caught.value.variable == "overlap" and caught.value.value > caught.value.limit
    assert chain.save().to_bytes() == before


def test_the_reference_resolves_by_itself() -> None:
    chain = unit_chain(5, step_size=4.0, integrator="dop853")
    chain.reset(velocity={0: 1.0})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        chain.step(40.0)
    assert chain.get("momentum") == pytest.approx(1.0, rel=1e-13)
    assert abs(chain.get("energy_residual")) <= 1e-10


@pytest.mark.parametrize("scheme", INTEGRATORS)
def test_too_deep(scheme: str) -> None:
    chain = ge.make("chain", grains=4, radius=3e-3, overlap_limit=1e-3, integrator=scheme, step_size=1e-7)
    chain.reset(velocity={0: 5.0})
    before = chain.save().to_bytes()
    with pytest.raises(ge.StepError, match=r"overlap\[\d\]: reached .* radii, contact laws.*overlap_limit"):
        chain.step(1e-5)
    assert chain.save().to_bytes() == before


def test_too_fast() -> None:
    chain = ge.make("chain", grains=2)
    with pytest.raises(ge.ParameterError, match=r"velocity\[1\].*sound speed"):
        chain.reset(velocity={1: 1e4})
    before = chain.save().to_bytes()
    with pytest.raises(ge.StepError, match="right|velocity|overlap") as caught:
        chain.step(1e-3, right_force=1e6)
    assert caught.value.variable == "velocity" and caught.value.index == 1
    assert chain.save().to_bytes() == before
    assert chain.get("right_force") == 0.0


def test_a_start_too_deep_is_refused_at_once() -> None:
    chain = ge.make("chain", grains=3)
    before = chain.save().to_bytes()
    with pytest.raises(ge.ParameterError, match=r"start.overlap\[1\]"):
        chain.reset(displacement={0: 1e-3})
    assert chain.save().to_bytes() == before


@pytest.mark.parametrize("scheme", INTEGRATORS)
def test_no_tension(scheme: str) -> None:
    """Grains that are pulled apart fly apart freely."""
    chain = ge.make("chain", grains=4, left="plane", right="plane", integrator=scheme, step_size=1e-7)
    chain.reset(displacement=[1e-6, 3e-6, 1e-6, -2e-6], velocity=[1.0, 5.0, -5.0, -1.0])
    for _ in range(200):
        chain.step(5e-7)
        force, overlap = chain.get("contact_force"), chain.get("overlap")
        assert (force >= 0.0).all() and np.array_equal(force > 0.0, overlap > 0.0)
        assert chain.get("left_wall_force") >= 0.0 >= chain.get("right_wall_force")
    assert chain.get("potential_energy") >= 0.0


GOOD = {"grains": 4}
REFUSED = [
    ({}, "grains"),
    ({"grains": 0}, "grains"),
    ({"grains": 2.5}, "grains"),
    ({"grains": 10**12}, "grains"),
    (GOOD | {"radius": -1e-3}, "radius"),
    (GOOD | {"radius": 0.0}, "radius"),
    (GOOD | {"radius": math.nan}, "radius"),
    (GOOD | {"radius": [1e-3, 1e-3, 1e-3]}, "radius: got 3 values, expected one for all or 4"),
    (GOOD | {"radius": [1e-3, 1e-3, -1e-3, 1e-3]}, "radius"),
    (GOOD | {"radius": {"low": 2e-3, "high": 1e-3}}, "high"),
    (GOOD | {"material": "steal"}, "did you mean 'steel'"),
    (GOOD | {"material": ["steel"]}, "material: got 1 values"),
    (GOOD | {"material": {"density": 7800.0, "young": 2e11, "poisson": 0.5}}, "poisson"),
    (GOOD | {"mass": [1.0]}, "mass: got 1 values"),
    (GOOD | {"mass": {4: 1.0}}, "mass: got index 4, expected 0 to 3"),
    (GOOD | {"mass": {0: -1.0}}, "mass"),
    (GOOD | {"contact_stiffness": -1.0}, "contact_stiffness"),
    (GOOD | {"contact_stiffness": [1.0] * 3}, "contact_stiffness: got 3 values, expected one for all or 5, one for each place"),
    (GOOD | {"contact_stiffness": [1.0] * 5}, "contact_stiffness[0]: got 1, expected 0: left is 'free'"),
    (
        GOOD | {"left": "plane", "contact_stiffness": [0.0, 1.0, 1.0, 1.0, 0.0]},
        "contact_stiffness[0]: got 0, expected more than 0: a contact is there",
    ),
    (GOOD | {"right": "piston", "gap": [0.0, 0.0, 0.0, 0.0, 1e-6]}, "gap[4]: got 1e-06, expected 0: right is 'piston'"),
    (GOOD | {"gap": -1e-6}, "gap"),
    (GOOD | {"gap": [1e-6]}, "gap: got 1 values"),
    (GOOD | {"gap": 1e-6, "precompression": 1.0}, "gap: a precompressed chain has none"),
    (GOOD | {"precompression": -1.0}, "precompression"),
    (GOOD | {"precompression": math.inf}, "precompression"),
    (GOOD | {"left": "pistn"}, "left"),
    (GOOD | {"left_wall_material": "steel"}, "left_wall_material: there is no wall"),
    (GOOD | {"right": "piston", "right_wall_material": "steel"}, "right_wall_material: there is no wall"),
    (GOOD | {"right": "rigid_plane", "right_wall_material": "steel"}, "right_wall_material: a rigid plane has none"),
    ({"grains": 1, "left": "piston"}, "grains: got 1, expected at least 2"),
    (GOOD | {"integrator": "euler"}, "integrator"),
    (GOOD | {"step_size": 0.0}, "step_size"),
    (GOOD | {"velocity_scale": -1.0}, "velocity_scale"),
    (GOOD | {"tolerance": 1.0}, "tolerance"),
    (GOOD | {"overlap_limit": 0.0}, "overlap_limit"),
    (GOOD | {"raduis": 1e-3}, "did you mean 'radius'"),
]


@pytest.mark.parametrize(
    ("parameters", "words"), REFUSED, ids=[f"{number}-{words[:12]}" for number, (_, words) in enumerate(REFUSED)]
)
def test_bad_parameters(parameters: dict[str, object], words: str) -> None:
    with pytest.raises(ge.ParameterError) as caught:
        ge.make("chain", **parameters)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("parameters", "inputs", "words"),
    [
        ({}, {"left_velocity": 1.0}, "left_velocity"),
        ({"left": "piston"}, {"left_force": 1.0}, "left_force"),
        ({"right": "plane"}, {"right_force": 1.0}, "right_force"),
        ({"right": "plane"}, {"right_velocity": 1.0}, "right_velocity"),
        ({}, {"left_force": math.nan}, "left_force"),
        ({}, {"left_force": math.inf}, "left_force"),
        ({}, {"left_force": [1.0, 2.0]}, "left_force"),
        ({}, {"left_force": "3"}, "left_force"),
    ],
)
def test_bad_inputs(parameters: dict[str, object], inputs: dict[str, object], words: str) -> None:
    chain = ge.make("chain", grains=4, **parameters)
    before = chain.save().to_bytes()
    with pytest.raises(ge.ParameterError) as caught:
        chain.step(**inputs)
    assert words in str(caught.value)
    assert chain.save().to_bytes() == before


def test_a_duration_that_is_no_multiple() -> None:
    chain = ge.make("chain", grains=4)
    with pytest.raises(ge.ParameterError, match="whole number"):
        chain.step(1.5 * chain.step_size)


@pytest.mark.parametrize(
    "start", [{"velocity": [1.0, 2.0]}, {"velocity": math.nan}, {"velocity": {9: 1.0}}, {"overlap": 0.0}, {"speed": 1.0}]
)
def test_bad_starts(start: dict[str, object]) -> None:
    with pytest.raises(ge.ParameterError, match=next(iter(start))):
        ge.make("chain", grains=4).reset(**start)


def test_a_piston_keeps_its_start_velocity_until_it_is_told_another() -> None:
    chain = ge.make("chain", grains=4, left="piston")
    chain.reset(velocity={0: 2.0})
    assert chain.get("left_velocity") == 2.0
    chain.step(1e-5)
    assert chain.get("velocity")[0] == 2.0
    assert chain.get("displacement")[0] == pytest.approx(2e-5, rel=1e-12)
    chain.step(1e-5, left_velocity=Profile(np.array([1e-5]), np.array([[2.0, -1e5]])))
    assert chain.get("velocity")[0] == pytest.approx(1.0, rel=1e-12)
    assert chain.get("displacement")[0] == pytest.approx(3.5e-5, rel=1e-12)


@pytest.mark.parametrize("integrator", ["pefrl", "leapfrog", "rk4", "hamming", "dop853"])
def test_a_passing_excess_of_speed_is_refused_however_the_step_is_cut(integrator: str) -> None:
    """A push takes one grain above its material's sound speed, a pull back below it, all inside one long step."""

    def shot() -> tuple[ge.Chain, ge.Profile]:
        chain = ge.Chain(grains=1, integrator=integrator, step_size=1e-6)
        push = 1.2 * chain.geometry.sound_speed[0] * chain.geometry.mass[0] / 1e-4
        return chain, ge.Profile.piecewise([0.0, 1e-4, 2e-4], [[push], [-push], [0.0]])

    whole, force = shot()
    with pytest.raises(ge.StepError) as at_once:
        whole.step(3e-4, left_force=force)
    assert whole.tick == 0 and whole.get("velocity")[0] == 0.0
    single, force = shot()
    with pytest.raises(ge.StepError) as one_by_one:
        for _ in range(300):
            single.step(1e-6, left_force=force)
    assert one_by_one.value.time == at_once.value.time == pytest.approx(8.4e-5)


@pytest.mark.parametrize("amplitude", [1e-3, 1e-9, 1e-14])
def test_dop853_stops_refining_at_the_rounding_of_the_overlaps(amplitude: float) -> None:
    """A tolerance that rounding cannot meet once made it take a billionth of a step at a time."""
    parameters = {"grains": 20, "precompression": 100.0, "left": "plane", "right": "plane"}
    reference = ge.Chain(**parameters, integrator="dop853", tolerance=1e-15)
    chain = ge.Chain(**parameters, step_size=reference.step_size / 8)
    for one in (reference, chain):
        one.reset(velocity={5: amplitude})
        one.step(100 * reference.step_size)
    # An overlap of 10 um is rounded to 1e-21 m; contacts turn that over 1e5 times a second.
    rounding = 1e-21 * 1e5 * 100
    assert reference.get("velocity") == pytest.approx(chain.get("velocity"), abs=1e-11 * amplitude + 10 * rounding, rel=0.0)


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"density": 7800.0, "young": 2e11, "poisson": 30.0}, "^Material: poisson: got 30.0, expected less than 0.5$"),
        ({"poisson": 0.3}, "density: missing; it is mass density\nMaterial: young: missing"),
        ({"E": 2e11, "nu": 0.3, "density": 7800.0}, "E: unknown; it is called 'young' here"),
        ({"density": 7800.0, "young": 2e11, "poisson": 0.3, "yeild_strength": 1e9}, "did you mean 'yield_strength'"),
    ],
)
def test_a_slip_in_a_material_is_one_sentence_of_the_family(fields: dict[str, float], said: str) -> None:
    with pytest.raises(ge.ParameterError, match=said) as caught:
        ge.Material(**fields)
    assert len(str(caught.value).splitlines()) == len(caught.value.faults) and "pydantic" not in str(caught.value)


KK = {"name": "kuwabara_kono", "dissipation": 3e5}
LINEAR = {"name": "power", "exponent": 1.0}
PAPER_STIFFNESS = 5.6e12 * 8.8216e-4
ORDINARY = {
    "strikers": ({"grains": 30, "contact_stiffness": PAPER_STIFFNESS}, {0: 5.0, 1: 5.0}, 2e-4),
    "many collisions": ({"grains": 12, "velocity_scale": 3.0}, {0: 3.0, 3: -2.0, 5: 1.0, 8: -3.0}, 2e-4),
    "gaps": ({"grains": 20, "gap": 2.3e-6, "velocity_scale": 5.0}, {0: 5.0}, 1e-4),
    "pressed": ({"grains": 30, "precompression": 100.0, "velocity_scale": 1.0}, {0: 0.5}, 1e-4),
    "pressed, Kuwabara-Kono": (
        {"grains": 10, "precompression": 1000.0, "velocity_scale": 0.01, "law": KK}, {0: 0.01}, 5e-5,
    ),
    "dashpots": (
        {"grains": 12, "velocity_scale": 3.0, "law": {"name": "viscous", "dissipation": 5.0}}, {0: 3.0, 3: -2.0, 5: 1.0}, 2e-4,
    ),
    "linear": (
        {"grains": 12, "contact_stiffness": 1e7, "velocity_scale": 5.0, "law": LINEAR}, {0: 5.0}, 2e-4,
    ),
}  # fmt: skip


@pytest.mark.parametrize("scheme", [name for name in INTEGRATORS if name != "dop853"])
@pytest.mark.parametrize("case", ORDINARY)
def test_no_integrator_doubts_the_step_that_it_suggests(scheme: str, case: str) -> None:
    """It neither warns nor refuses, and velocities are right to 4e-4 of the largest (against a thirtieth of the step)."""
    parameters, velocity, duration = ORDINARY[case]
    speed = max(abs(value) for value in velocity.values())
    found = []
    for part in (1.0, 1.0 / 30.0):
        usual = ge.make("chain", integrator=scheme, **parameters)
        chain = usual if part == 1.0 else ge.make("chain", integrator=scheme, step_size=part * usual.step_size, **parameters)
        chain.reset(velocity=velocity)
        with warnings.catch_warnings():
            warnings.simplefilter("error", ge.GranularWarning)
            chain.step(round(duration / usual.step_size) * usual.step_size)
        assert not any("force evaluations" in said or "dissipation" in said for said in chain.cautions())
        found.append(chain.get("velocity"))
    assert np.abs(found[0] - found[1]).max() <= 4e-4 * speed


def test_leapfrog_speaks_up_where_its_error_is_of_percents() -> None:
    """A second-order scheme wants twice as many force evaluations as one of fourth order."""
    chain = ge.make("chain", grains=20, integrator="leapfrog", step_size=2e-7)
    chain.reset(velocity={0: 3.0, 1: 3.0})
    with pytest.warns(ge.GranularWarning, match="fewer than the 120 force evaluations that leapfrog wants"):
        chain.step(1e-4)


def test_a_start_whose_static_overlap_dissipates_too_much_is_refused_with_that_reason() -> None:
    with pytest.raises(ge.ParameterError, match=r"start.overlap.*dissipation would stop .* take a smaller step_size"):
        ge.make("chain", grains=5, precompression=1000.0, law=KK, integrator="rk4", step_size=5e-7)


def test_linear_springs_keep_their_energy_over_a_hundred_thousand_default_steps() -> None:
    chain = ge.make(
        "chain", grains=4, left="rigid_plane", right="rigid_plane", law=LINEAR, contact_stiffness=1e7, velocity_scale=2.0,
    )  # fmt: skip
    chain.reset(velocity=[1.0, -0.7, 0.4, 0.2])
    start = chain.get("kinetic_energy")
    chain.step(100_000 * chain.step_size)
    assert abs(chain.get("energy_residual")) < 2e-4 * start


def test_steep_laws_take_the_stiffness_that_they_need_and_messages_have_its_unit() -> None:
    """10 N at 1 um is k = 1e61 N/m^10."""
    chain = ge.make("chain", grains=2, law={"name": "power", "exponent": 10.0}, contact_stiffness=1e61, precompression=10.0)
    assert chain.get("overlap")[1] == pytest.approx(1e-6, rel=1e-12)
    with pytest.raises(ge.ParameterError, match=r"N/m\^3, expected"):
        ge.make("chain", grains=2, law={"name": "power", "exponent": 3.0}, contact_stiffness=1e90)


def test_the_end_of_a_scan_of_mass_ratios_is_a_dimer_too() -> None:
    equal = ge.make("chain", grains=6, arrangement={"name": "dimer", "radius": [3e-3, 3e-3]})
    assert np.array_equal(equal.geometry.mass, ge.make("chain", grains=6, radius=3e-3).geometry.mass)
    with pytest.raises(ge.ParameterError, match="both kinds of grain are the same"):
        ge.make("chain", grains=6, arrangement="dimer")


def test_a_sampling_that_does_not_fit_is_told_a_step_that_does() -> None:
    chain = ge.make("chain", grains=5, step_size=2e-7)
    with pytest.raises(ge.ParameterError, match=r"use 4e-07 s or 6e-07 s, or give step_size = 1e-07 \(s\)"):
        chain.ticks_in(5e-7, "every")
    assert ge.make("chain", grains=5, step_size=1e-7).ticks_in(5e-7) == 5


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        (
            {"law": "viscous", "dissipation": 2.0},
            "dissipation: unknown; it belongs to law 'viscous', 'kuwabara_kono' or 'linear': "
            'give law = {"name": "viscous", "dissipation": 2.0}',
        ),
        ({"radius": {0: 6e-3}}, "radius: got {0: 0.006}, expected one value for all or a list with one each; only mass takes"),
        ({"gap": {1: 1e-6}}, "gap: got {1: 1e-06}, expected one value for all or a list with one each"),
    ],
)  # fmt: skip
def test_what_is_in_the_wrong_place_is_told_the_right_one(parameters: dict[str, object], said: str) -> None:
    with pytest.raises(ge.ParameterError) as caught:
        ge.make("chain", grains=4, **parameters)
    assert said in str(caught.value)


def test_millimetres_and_grams_are_noticed() -> None:
    large = ge.make("chain", grains=2, radius=2.38)
    assert any("radius of 2.38 m: radius is in metres" in said for said in large.cautions())
    light = ge.make("chain", grains=2, material=ge.Material(density=7.8, young=2e11, poisson=0.29))
    assert any("weighs 7.8 kg/m^3" in said for said in light.cautions())
    assert ge.make("chain", grains=2, radius=0.1).cautions() == []
    heavy = ge.make("chain", grains=3, mass=0.88)
    assert any("7.781e+06 kg/m^3, far more than any solid: mass is in kg" in said for said in heavy.cautions())
    soft = ge.make("chain", grains=3, material={"density": 7800.0, "young": 2e5, "poisson": 0.29})
    assert any("5.797 m/s, less than in any solid: young is in Pa" in said for said in soft.cautions())
    soft.reset(velocity={0: 1.0})
    with pytest.raises(ge.StepError, match="young is in Pa"):
        soft.step(2000 * soft.step_size)


def test_chains_and_snapshots_say_what_they_are() -> None:
    chain = ge.make("chain", grains=4, left="piston")
    assert repr(chain) == "<chain of 4 grains, law hertz, ends piston and free, at 0 s>"
    assert repr(chain.save()).startswith("<snapshot at tick 0, ")


def test_the_presets_are_told_with_their_constants() -> None:
    told = ge.make("chain", grains=2).variables["material"].description
    for name, one in PRESETS.items():
        assert f"{name}: {one.density:g} kg/m^3, {one.young / 1e9:g} GPa, nu {one.poisson:g}" in told


def accepted_pushes(chain: Chain, force: float, ticks: int) -> tuple[int, str]:
    """Push the first grain in steps of so many ticks until one is refused; return how many were not, and the message."""
    chain.reset()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for done in range(60 // ticks):
            try:
                chain.step(ticks * chain.step_size, left_force=force)
            except ge.StepError as error:
                return done, str(error)
    return 60 // ticks, ""


@pytest.mark.parametrize("scheme", ["pefrl", "leapfrog", "rk4", "hamming"])
def test_what_is_refused_does_not_depend_on_earlier_cautions(scheme: str) -> None:
    """A used chain, which has issued its caution, refuses what a fresh one and a copy of it refuse, in the same tick."""

    def make() -> Chain:
        return Chain(grains=16, radius=3e-3, step_size=5e-7, integrator=scheme)

    used = make()
    accepted_pushes(used, 1e5, 1)
    refused = 0
    for force in np.geomspace(8e3, 1e5, 40):
        fresh = make()
        found = accepted_pushes(fresh, force, 3)
        refused += bool(found[1])
        assert accepted_pushes(used, force, 3) == found
        assert accepted_pushes(fresh, force, 3) == found
        assert accepted_pushes(fresh.clone(), force, 3) == found
        assert accepted_pushes(copy.deepcopy(used), force, 3) == found
        ticks, message = accepted_pushes(make(), force, 1)
        assert (ticks // 3, message) == found, "whatever the length of a step"
    assert refused > 10
