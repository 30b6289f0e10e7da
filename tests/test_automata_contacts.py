"""Contacts of automata: rest distances after plastic flow of links, dashpots, and relinking."""

from __future__ import annotations

import math
from typing import Any

import pytest
from support.automata_tools import BOTH, block, link_force_sums

import granular_env as ge
from granular_env.components.automata import Automata, theory

# -- contacts start without spurious energy -----------------------------------------------------------------------------------

RESPONSES = [
    {"name": "plastic", "yield_stress": 5e-3, "hardening": 0.05},
    {"name": "plastic", "yield_stress": 5e-3},
    {"name": "plastic_degrading", "yield_stress": 5e-3, "hardening": 0.05},
]


@BOTH
@pytest.mark.parametrize("response", RESPONSES, ids=["hardening", "ideal", "degrading"])
def test_what_flowed_together_and_breaks_gives_no_energy_away(packing: str, response: dict[str, Any]) -> None:
    """Compress with some shear: links flow, then break by their shear angle under pressure."""
    limits = {"name": "strain", "tensile": 4e-3, "shear": 0.01}
    edges = {"bottom": "fixed", "top": "velocity"}
    automata = block(packing, 10, 16, boundaries=edges, response=response, criterion=limits, friction=0.5)
    taken = [0.0]
    for _ in range(20):
        automata.step(5.0, top_velocity=[1e-3, -1e-2])
        taken.append(automata.get("fracture_energy"))
    work = automata.get("input_work")
    assert automata.get("broken_links") > 30 and automata.get("inelastic_energy") > 0.1 * work
    assert min(taken) >= 0.0 and taken[-1] > 0.0
    assert abs(automata.get("energy_residual")) <= 0.01 * work


@pytest.mark.parametrize(
    ("response", "overlap"),
    [
        ({"name": "linear"}, 1.0),
        # The mean stress K theta, K = 5/3, remains; its energy (G / 9 + lambda / 4) e^2 equals the contact's 2.5 o^2 / 2.
        ({"name": "plastic", "yield_stress": 1e-9}, math.sqrt(2.0 * (1.0 / 9.0 + 0.25) / 2.5)),
    ],
    ids=["elastic", "flowed"],
)
def test_a_contact_is_at_rest_where_its_link_would_be(response: dict[str, Any], overlap: float) -> None:
    """In uniaxial compression the contact's rest distance is a diameter after an elastic link, and less after plastic flow."""
    edges = {"left": "periodic", "right": "periodic", "bottom": "fixed", "top": "velocity"}
    automata = block(columns=4, rows=4, boundaries=edges, response=response, criterion={"name": "strain", "tensile": 1.0})
    automata.step(2000.0, top_velocity=[0.0, -4e-6])
    specimen: Any = automata.specimen
    specimen.medium.law.factors[1, automata.body.layout.place[5]] = 0.0  # break this link at any shear angle
    specimen.load_motion()
    specimen.update_forces()
    strain = 1.0 - (automata.get("displacement")[9, 1] - automata.get("displacement")[5, 1] + 1.0)
    specimen.update_links(automata.tick)
    assert automata._block["contacts"].tolist() == [[5, 9, 1, automata.tick]]
    assert automata._block["rest"][0] == pytest.approx(1.0 - strain + overlap * strain, abs=0.01 * strain)


@BOTH
def test_a_specimen_sheared_under_pressure_closes_its_energy(packing: str) -> None:
    """Links sheared by more than 30 degrees become contacts closer than a diameter, without an initial repulsion."""
    edges = {"left": "periodic", "right": "periodic", "bottom": "fixed", "top": "velocity"}
    strong = {"name": "mohr_coulomb", "cohesion": 0.0083, "internal_friction": 1.0, "tensile": 0.0042}
    automata = block(packing, 16, 12, boundaries=edges, criterion=strong, step_size=0.1)
    automata.step(40.0, top_velocity=[0.03, -0.012])
    automata.step(60.0, top_velocity=[0.03, 0.0])
    work = automata.get("input_work")
    assert automata.get("touching") > 50.0
    assert abs(automata.get("energy_residual")) <= 0.01 * work
    assert automata.get("fracture_energy") > 0.0


# -- dashpots --------------------------------------------------------------------------------------------------------------


def loose_pair(step: float, **parameters: Any) -> tuple[Automata, int, int]:
    """Return two unlinked whole automata far from the others, the second to the right of the first."""
    law = {"name": "strain", "tensile": 10.0}
    automata = block(columns=6, rows=6, criterion=law, step_size=step, **parameters)
    first, second = (automata.packing.nearest_automaton(x, 3.0) for x in (2.0, 4.0))
    automata.reset(displacement={first: (0.0, 20.0), second: (-0.9, 20.0)})
    automata._block["weight"][:] = 0.0  # remove all links
    return automata, first, second


@pytest.mark.parametrize("ratio", [0.05, 0.2, 0.5])
def test_a_collision_has_the_restitution_of_its_dashpot(ratio: float) -> None:
    automata, first, second = loose_pair(0.01, contact_damping=ratio)
    automata._block["velocity"][first] = (0.01, 0.0)
    automata._block["start"][:] = automata.specimen.momenta_and_energies()[3], *automata.specimen.momenta_and_energies()[:3]
    automata.step(120.0)
    velocity = automata.get("velocity")
    found = (velocity[second, 0] - velocity[first, 0]) / 0.01
    assert found == pytest.approx(theory.restitution(ratio), abs=0.01)
    assert automata.get("damping_energy") == pytest.approx(0.25 * 1e-4 * (1.0 - found**2), rel=1e-3)
    assert abs(automata.get("energy_residual")) <= 1e-3 * automata.get("damping_energy")
    assert abs(automata.get("momentum_residual")[0]) <= 1e-14


def test_the_link_force_of_a_broken_pair_is_that_of_its_contact() -> None:
    """Two halves of a strip collide without friction: what accelerates the right half goes through its broken pairs."""
    edges = {"left": "fixed", "right": "velocity"}
    parts = [{"area": {"name": "box", "x": [2.4, 2.6], "y": [-1.0, 3.0]}, "factor": 0.1}]
    automata = block(
        columns=6, rows=2, boundaries=edges, criterion={"name": "strain", "tensile": 0.02}, strength_regions=parts,
        friction=0.0, contact_damping=0.2,
    )  # fmt: skip
    automata.step(100.0, right_velocity=[5e-4, 0.0])
    assert automata.get("broken_links") == 3.0
    while automata.get("touching") < 3.0:
        automata.step(1.0, right_velocity=[-5e-3, 0.0])
    forces, broken = automata.get("link_force"), automata.get("linked") == 0.0
    right = automata.packing.reference[:, 0] > 2.5
    through = automata.specimen.forces()[right].sum(axis=0)
    assert forces[broken].sum() == pytest.approx(through[0], rel=1e-6)  # the lines of centres are nearly horizontal
    assert link_force_sums(automata)[right].sum(axis=0) == pytest.approx(through, abs=1e-12)
    # With dashpots the force is more than that of the springs while the halves approach.
    specimen: Any = automata.specimen
    assert (forces[broken] > 1.5 * specimen.contact_stiffness()[automata._pairs[broken, 0]] * specimen._overlaps()).all()


def crushed(packing: str, **parameters: Any) -> Automata:
    """Return a specimen that was crushed between two plates, which then stop."""
    edges = {"left": "periodic", "right": "periodic", "bottom": "fixed", "top": "velocity"}
    law = {"name": "strain", "tensile": 5e-3}
    automata = block(packing, boundaries=edges, criterion=law, strength_scatter=0.3, step_size=0.1, **parameters)
    automata.step(40.0, top_velocity=[0.0, 0.004])
    automata.step(80.0, top_velocity=[0.004, -0.006])
    return automata


@BOTH
def test_fragments_come_to_rest(packing: str) -> None:
    moving = {}
    for ratio in (0.0, 0.3):
        automata = crushed(packing, contact_damping=ratio)
        automata.step(400.0, top_velocity=0.0)
        moving[ratio] = automata.get("kinetic_energy") + automata.get("rotational_energy")
        assert abs(automata.get("energy_residual")) <= 0.01 * automata.get("input_work")
    assert automata.get("damping_energy") > 0.0 and automata.get("broken_links") > 10
    assert moving[0.3] < 0.1 * moving[0.0]


# -- relinking -------------------------------------------------------------------------------------------------------------


def strip(packing: str = "square", **parameters: Any) -> Automata:
    """Return a strip that breaks in tension and welds under pressure."""
    given: dict[str, Any] = {
        "boundaries": {"left": "fixed", "right": "velocity"}, "criterion": {"name": "strain", "tensile": 0.01},
        "relinking": {"name": "cold_welding", "pressure": 0.02, "slip_speed": 0.01}, "contact_damping": 0.2, **parameters,
    }  # fmt: skip
    return block(packing, 6, 2, **given)


def tear_and_press(automata: Automata, until: int = 0) -> None:
    """Pull a strip apart, then compress it until at most `until` broken links are left."""
    automata.step(160.0, right_velocity=[5e-4, 0.0])
    assert automata.get("broken_links") >= 3
    while automata.get("broken_links") > until and automata.time < 700.0:
        automata.step(10.0, right_velocity=[-5e-4, 0.0])


@pytest.mark.parametrize("packing", ["square", pytest.param("hexagonal", marks=pytest.mark.slow)])
def test_a_broken_strip_is_welded_by_pressure_and_pulls_again(packing: str) -> None:
    automata = strip(packing)
    tear_and_press(automata)
    broken = [event for event in automata.events() if event.kind == "stretch_break"]
    linked = [event for event in automata.events() if event.kind == "linked"]
    assert automata.get("broken_links") == 0.0 and {event.index for event in linked} == {event.index for event in broken}
    assert all(event.limit == 0.02 and event.value >= 0.02 for event in linked)
    work = automata.get("input_work")
    # The contact was compressed and hardly slid, so linking transfers no energy.
    assert abs(automata.get("linking_energy")) <= 1e-9 * work
    assert abs(automata.get("energy_residual")) <= 2e-3 * work
    # The strip carries tension, and breaks again at the same strain.
    automata.step(150.0, right_velocity=[5e-4, 0.0])
    while automata.get("broken_links") == 0.0 and automata.time < 1200.0:
        automata.step(1.0, right_velocity=[5e-4, 0.0])
    assert automata.get("broken_links") > 0.0
    supplied = automata.get("input_work") + automata.get("fracture_energy")
    assert abs(automata.get("energy_residual")) <= 0.01 * supplied


def seam(part: int) -> Automata:
    """Return a bar that was torn at its seam, compressed, welded and pulled, with the step divided by `part`."""
    beside = [
        {"area": {"name": "box", "x": x, "y": [-1.0, 1.0]}, "factor": 50.0} for x in ([0.0, 0.009], [0.0115, 1.0])
    ]  # fmt: skip
    bar: Any = ge.make(
        "automata", shape={"name": "rectangle", "width": 0.02, "height": 0.004}, diameter=2e-3, packing="square",
        material={"density": 2600.0, "young": 2.5e10, "poisson": 0.2}, criterion={"name": "strain", "tensile": 8e-4},
        strength_regions=beside, boundaries={"left": "fixed", "right": "velocity"}, step_size=2e-7 / part,
        relinking={"name": "cold_welding", "pressure": 1e6, "slip_speed": 1.0}, release_ticks=20 * part,
    )  # fmt: skip
    bar.step(1.8e-4, right_velocity=ge.Profile.table([0.0, 1e-5, 8e-5, 9e-5], [0.0, 0.4, 0.4, -0.4], after="hold") * [1.0, 0.0])
    return bar


def test_a_slipping_or_a_loose_contact_is_not_linked() -> None:
    automata = strip(relinking={"name": "cold_welding", "pressure": 0.02, "slip_speed": 1e-4}, friction=0.0)
    automata.step(160.0, right_velocity=[5e-4, 0.0])
    automata.step(280.0, right_velocity=[-5e-4, 3e-3])
    assert automata.get("touching") > 0.0 and all(event.kind != "linked" for event in automata.events())
    automata = strip()
    automata.step(160.0, right_velocity=[5e-4, 0.0])
    automata.step(200.0, right_velocity=0.0)
    assert automata.get("broken_links") > 0.0 and automata.get("linking_energy") == 0.0
