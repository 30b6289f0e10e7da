"""Refusals of the chain: unresolved, too deep or too fast contacts, invalid parameters and inputs; and no tension."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from support.chain_tools import INTEGRATORS, advance_chain, unit_chain

import granular_env as ge


def test_seldom_seen_contacts_are_warned_of_once() -> None:
    chain = unit_chain(5, step_size=0.3)
    chain.reset(velocity={0: 1.0})
    with pytest.warns(
        ge.GranularWarning, match=r"fewer than the 60 force evaluations that pefrl requires.*step_size"
    ) as caught:
        advance_chain(chain, 12.0)
    assert len(caught) == 1
    assert any("force evaluations" in sentence for sentence in chain.cautions())


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


@pytest.mark.parametrize("scheme", INTEGRATORS)
def test_too_deep(scheme: str) -> None:
    chain = ge.make("chain", grains=4, radius=3e-3, overlap_limit=1e-3, integrator=scheme, step_size=1e-7)
    chain.reset(velocity={0: 5.0})
    before = chain.save().to_bytes()
    with pytest.raises(ge.StepError, match=r"overlap\[\d\]: reached .* radii, but contact laws.*overlap_limit"):
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
    """Grains that are pulled apart separate freely."""
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
    (GOOD | {"radius": [1e-3, 1e-3, 1e-3]}, "radius: got 3 values, expected one value for all, or 4"),
    (GOOD | {"radius": [1e-3, 1e-3, -1e-3, 1e-3]}, "radius"),
    (GOOD | {"radius": {"low": 2e-3, "high": 1e-3}}, "high"),
    (GOOD | {"material": "steal"}, "did you mean 'steel'"),
    (GOOD | {"material": ["steel"]}, "material: got 1 values"),
    (GOOD | {"material": {"density": 7800.0, "young": 2e11, "poisson": 0.5}}, "poisson"),
    (GOOD | {"mass": [1.0]}, "mass: got 1 values"),
    (GOOD | {"mass": {4: 1.0}}, "mass: got index 4, expected 0 to 3"),
    (GOOD | {"mass": {0: -1.0}}, "mass"),
    (GOOD | {"contact_stiffness": -1.0}, "contact_stiffness"),
    (
        GOOD | {"contact_stiffness": [1.0] * 3},
        "contact_stiffness: got 3 values, expected one value for all, or 5, one for each place",
    ),
    (GOOD | {"contact_stiffness": [1.0] * 5}, "contact_stiffness[0]: got 1, expected 0: left is 'free'"),
    (
        GOOD | {"left": "plane", "contact_stiffness": [0.0, 1.0, 1.0, 1.0, 0.0]},
        "contact_stiffness[0]: got 0, expected more than 0: this place has a contact",
    ),
    (GOOD | {"right": "piston", "gap": [0.0, 0.0, 0.0, 0.0, 1e-6]}, "gap[4]: got 1e-06, expected 0: right is 'piston'"),
    (GOOD | {"gap": -1e-6}, "gap"),
    (GOOD | {"gap": [1e-6]}, "gap: got 1 values"),
    (GOOD | {"gap": 1e-6, "precompression": 1.0}, "gap: a precompressed chain has no gaps"),
    (GOOD | {"precompression": -1.0}, "precompression"),
    (GOOD | {"precompression": math.inf}, "precompression"),
    (GOOD | {"left": "pistn"}, "left"),
    (GOOD | {"left_wall_material": "steel"}, "left_wall_material: left is 'free', which has no material"),
    (GOOD | {"right": "piston", "right_wall_material": "steel"}, "right_wall_material: right is 'piston', which has"),
    (GOOD | {"right": "rigid_plane", "right_wall_material": "steel"}, "right_wall_material: right is 'rigid_plane', which has"),
    ({"grains": 1, "left": "piston"}, "grains: got 1, expected at least 2"),
    (GOOD | {"integrator": "euler"}, "integrator"),
    (GOOD | {"step_size": 0.0}, "step_size"),
    (GOOD | {"velocity_scale": -1.0}, "velocity_scale"),
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


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_passing_excess_of_speed_is_refused_however_the_step_is_cut(integrator: str) -> None:
    """Within one long step, a push accelerates a grain above its material's sound speed and a pull slows it again."""

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


LINEAR = {"name": "power", "exponent": 1.0}


def test_linear_springs_keep_their_energy_over_a_hundred_thousand_default_steps() -> None:
    chain = ge.make(
        "chain", grains=4, left="rigid_plane", right="rigid_plane", law=LINEAR, contact_stiffness=1e7, velocity_scale=2.0,
    )  # fmt: skip
    chain.reset(velocity=[1.0, -0.7, 0.4, 0.2])
    start = chain.get("kinetic_energy")
    chain.step(100_000 * chain.step_size)
    assert abs(chain.get("energy_residual")) < 2e-4 * start
