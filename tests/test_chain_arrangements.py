"""Arrangements of grains by name: construction, refusals, and round trips through files and logs."""

from __future__ import annotations

import numpy as np
import pytest
from support.chain_tools import state_hash

import granular_env as ge
from granular_env.components.materials.elastic import PRESETS

R = 3e-3
DIMER = {"name": "dimer", "radius": [R, 1.5e-3], "material": ["steel", "aluminium"]}
# Every arrangement, and the same chain with explicit parameters.
TWICE = {
    "uniform": (9, {"arrangement": "uniform", "radius": R}, {"radius": [R] * 9}),
    "dimer": (
        9,
        {"arrangement": DIMER},
        {"radius": [R, 1.5e-3] * 4 + [R], "material": ["steel", "aluminium"] * 4 + ["steel"]},
    ),
    "dimer 2:1": (
        8,
        {"arrangement": {"name": "dimer", "material": ["steel", "ptfe"], "counts": [2, 1]}, "radius": R},
        {"radius": R, "material": ["steel", "steel", "ptfe"] * 2 + ["steel", "steel"]},
    ),
    "tapered": (
        4,
        {"arrangement": {"name": "tapered", "first_radius": R, "taper": 0.1}},
        {"radius": [R, R * 0.9, R * 0.9 * 0.9, R * 0.9 * 0.9 * 0.9]},
    ),
    "decorated": (
        5,
        {
            "arrangement": {
                "name": "decorated", "radius": R, "decoration_radius": 5e-4, "taper": 0.5, "decoration_material": "brass"
            }
        },
        {"radius": [R, 5e-4, 0.5 * R, 5e-4, 0.25 * R], "material": ["steel", "brass"] * 2 + ["steel"]},
    ),
    "impurity": (
        5,
        {"arrangement": {"name": "impurity", "index": [1, 3], "radius": 1e-3, "material": "glass"}, "mass": {0: 1e-2}},
        {"radius": [R, 1e-3] * 2 + [R], "material": ["steel", "glass"] * 2 + ["steel"], "mass": {0: 1e-2}},
    ),
    "impurity of mass": (
        5,
        {"arrangement": {"name": "impurity", "index": 2, "mass": 1e-4}, "mass": {0: 1e-2}},
        {"mass": {0: 1e-2, 2: 1e-4}},
    ),
}  # fmt: skip


def ran(**parameters: object) -> ge.Chain:
    chain = ge.make("chain", **parameters)
    chain.reset(velocity={0: 0.1})
    chain.step(200 * chain.step_size)
    return chain


@pytest.mark.parametrize("case", TWICE)
def test_an_arrangement_gives_the_bits_of_the_same_chain_by_hand(case):
    grains, named, by_hand = TWICE[case]
    one, other = ran(grains=grains, **named), ran(grains=grains, **by_hand)
    for name in ("radius", "mass", "stiffness", "position", "yield_strength"):
        np.testing.assert_array_equal(getattr(one.geometry, name), getattr(other.geometry, name))
    assert one.get("velocity").tobytes() == other.get("velocity").tobytes()


@pytest.mark.parametrize("case", TWICE)
def test_parameters_read_back_as_they_were(case):
    grains, named, _ = TWICE[case]
    chain = ge.make("chain", grains=grains, **named)
    again = ge.make("chain", **chain.parameters.model_dump(mode="json"))
    assert again.identity == chain.identity
    assert state_hash(again) == state_hash(chain)


@pytest.mark.parametrize("case", TWICE)
def test_a_log_replays_and_branches(case, tmp_path):
    grains, named, _ = TWICE[case]
    chain = ge.make("chain", grains=grains, **named)
    with ge.record(chain, tmp_path / "run.mcap", every=20 * chain.step_size):
        chain.reset(velocity={0: 0.1})
        chain.step(200 * chain.step_size)
    result = ge.verify(tmp_path / "run.mcap")
    assert result.identical, result.message
    with ge.open_log(tmp_path / "run.mcap") as log:
        branch = log.branch(at=100 * chain.step_size)
        np.testing.assert_array_equal(branch.component.geometry.radius, chain.geometry.radius)


REFUSED = [
    (5, {"arrangement": "dimmer"}, "arrangement: got 'dimmer', expected a known name; did you mean 'dimer'?"),
    (5, {"arrangement": 3}, "arrangement: got 3, expected a name, or a table with the key name"),
    (5, {"arrangement": {"radius": R}}, "arrangement.name: missing; known: uniform, dimer,"),
    (5, {"arrangement": {**DIMER, "raduis": 1}}, "arrangement.raduis: unknown; did you mean 'radius'?"),
    (5, {"arrangement": "tapered"}, "arrangement.first_radius: missing; meaning: radius of the first grain"),
    (5, {"arrangement": "dimer"}, "arrangement.radius: both kinds of grain are the same"),
    (5, {"arrangement": {"name": "dimer", "radius": [R]}}, "arrangement.radius: got [0.003], expected"),
    (5, {"arrangement": {"name": "dimer", "radius": [R, -R]}}, "arrangement.radius[1]: got -0.003, expected greater than 0"),
    (5, {"arrangement": {"name": "dimer", "material": ["steel", "stell"]}}, "material[1]: got 'stell', expected the name"),
    (2, {"arrangement": {**DIMER, "counts": [2, 1]}}, "arrangement.counts: got [2, 1], a cell of 3 grains, but the chain"),
    (5, {"arrangement": DIMER, "radius": R}, "radius: the arrangement sets it too"),
    (5, {"arrangement": DIMER, "material": "steel"}, "material: the arrangement sets it too"),
    (5, {"radius": {"low": R, "high": 1e-3}}, "high: got 0.001 m, expected at least low"),
    (5, {"radius": {"low": R, "high": R, "seed": -1}}, "seed: got -1"),
    (5, {"arrangement": {"name": "tapered", "first_radius": R}}, "taper: got neither of taper and last_radius"),
    (5, {"arrangement": {"name": "tapered", "first_radius": R, "taper": 0.1, "last_radius": R}}, "taper: got both of"),
    (5, {"arrangement": {"name": "tapered", "first_radius": R, "taper": 1.0}}, "arrangement.taper: got 1.0, expected less"),
    (5, {"arrangement": {"name": "tapered", "first_radius": R, "taper": 0.999999}}, "arrangement.taper: from grain 3 on"),
    (10**8, {"arrangement": {"name": "tapered", "first_radius": R, "taper": 0.1}}, "the radii are too small"),
    (10**8, {"arrangement": {"name": "tapered", "first_radius": R, "taper": -0.1}}, "the radii are too large"),
    (1, {"arrangement": {"name": "tapered", "first_radius": R, "last_radius": 1e-3}}, "last_radius: a chain of one grain"),
    (6, {"arrangement": {"name": "decorated", "radius": R, "decoration_radius": 1e-3}}, "'decorated' does not fit 6 grains"),
    (1, {"arrangement": {"name": "decorated", "radius": R, "decoration_radius": 1e-3}}, "'decorated' does not fit 1 grains"),
    (9, {"arrangement": {"name": "decorated", "radius": R, "decoration_radius": 1e-3, "taper": 0.5}},
     "decoration_radius: got 0.001 m, expected at most the radius of the smallest large grain, 0.0001875 m"),
    (5, {"arrangement": {"name": "impurity", "index": 5, "mass": 1.0}}, "arrangement.index: got 5, expected 0 to 4"),
    (5, {"arrangement": {"name": "impurity", "index": -1, "mass": 1.0}}, "arrangement.index: got -1, expected greater"),
    (5, {"arrangement": {"name": "impurity", "index": [], "mass": 1.0}}, "arrangement.index: got []"),
    (5, {"arrangement": {"name": "impurity", "index": [2, 2], "mass": 1.0}}, "arrangement.index: got [2, 2]"),
    (5, {"arrangement": {"name": "impurity", "index": 2}}, "the impurity equals the other grains"),
    (5, {"arrangement": {"name": "impurity", "index": 2, "mass": 1.0}, "mass": {2: 1.0}}, "mass: the arrangement"),
    (5, {"arrangement": {"name": "impurity", "index": 2, "mass": 1.0}, "mass": 1.0}, "mass: the arrangement"),
]  # fmt: skip


@pytest.mark.parametrize(("grains", "parameters", "words"), REFUSED, ids=[words[:50] for _, _, words in REFUSED])
def test_refused_by_name(grains, parameters, words):
    with pytest.raises(ge.ParameterError) as caught:
        ge.make("chain", grains=grains, **parameters)
    assert words in str(caught.value)


def test_draws_do_not_depend_on_the_length():
    """The radius of grain i depends only on the seed and i."""
    short, long = (ge.make("chain", grains=n, radius={"low": 1e-3, "high": R, "seed": 4}).geometry.radius for n in (5, 50))
    np.testing.assert_array_equal(short, long[:5])
    assert len(np.unique(long)) == 50 and (1e-3 <= long).all() and (long <= R).all()


def test_an_arrangement_goes_with_walls_and_drives():
    chain = ge.make("chain", grains=7, arrangement=DIMER, left="piston", right="plane")
    assert chain.geometry.sound_speed[1] == PRESETS["aluminium"].longitudinal_speed
    chain.reset(velocity={0: 0.1})
    chain.step(50 * chain.step_size, left_velocity=0.1)
    assert chain.get("contact_force")[1] > 0.0
