"""A hexagonal packing that meets the grid along y, and whose links break, yield, or join several materials."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest
from support.coupled_tools import (
    MEDIUM,
    SMALL,
    TALL,
    beside_zigzag,
    coupled,
    hexagonal_cradle,
    hexagonal_inclusion,
    inner,
    mesh,
    mirror_images,
    rectangle,
    start,
    start_noise,
)

import granular_env as ge
from granular_env.components.automata.cracking_specimen import CrackingSpecimen
from granular_env.components.automata.link_histories import opposite_slot
from granular_env.components.coupled import Coupled
from granular_env.components.errors import ParameterError

WEAK = {"name": "mohr_coulomb", "cohesion": 0.004, "tensile": 0.003, "internal_friction": 0.5}
UNBREAKABLE = {"criterion": {"name": "strain", "tensile": 1e6, "shear": 1e6}}
PLASTIC = {"name": "plastic", "yield_stress": 0.006, "hardening": 0.2}
DEGRADING = {"name": "degrading", "onset": 0.006, "hardening": 0.2}
SOFT = {"density": 1.0, "young": 1.5, "poisson": 0.2}
SHAPES = [beside_zigzag, hexagonal_inclusion, hexagonal_cradle]
every_shape = pytest.mark.parametrize("make", SHAPES, ids=lambda make: make.__name__)


def core(n: int = 1, *, step: float = 0.2, micro: int = 1, **laws: Any) -> Coupled:
    """Return a block of cells, moved from above and held below, around a hexagonal core that breaks, 6 n diameters wide."""
    w, h = float(n), n * TALL[1]
    hole = {"name": "box", "x": [-3.0 * w, 3.0 * w], "y": [2.0 * h, 5.0 * h]}
    grid = {
        "mesh": mesh(10, 7, cell_size=[w, h], holes=[hole], centre=[0.0, 3.5 * h]),
        "boundaries": {"top": {"name": "velocity"}, "bottom": "fixed"},
    }
    # Release takes the same time whatever the step.
    automata = {"shape": rectangle(6.0 * w, 3.0 * h), "packing": "hexagonal", "criterion": WEAK, **laws}
    automata |= {"release_ticks": round(2.0 * micro / step)}
    return coupled(grid, automata, origin=[-3.0 * w, 2.0 * h], step_size=step, micro_steps=micro)


def push(medium: Coupled, until: float = 40.0, towards: tuple[float, float] = (0.02, -0.01)) -> float:
    """Shear and press the block until the core is in pieces; return the residual of the energy in parts of the work."""
    ticks = round((until - medium.time) / medium.step_size)
    medium.step(ticks * medium.step_size, grid_top_velocity=ge.Profile.half_sine(1.0, 30.0) * list(towards))
    energy = medium.balances()[0]
    return abs(float(energy.residual)) / float(energy.supplied["input_work"])


def specimen_of(medium: Coupled) -> CrackingSpecimen:
    steps = medium.automata.steps
    assert isinstance(steps, CrackingSpecimen) and steps.ties is not None
    return steps


# -- what holds ------------------------------------------------------------------------------------------------------------


@pytest.mark.slow  # fifteen seconds for the kernels of a body that cannot break
@pytest.mark.parametrize("micro_steps", [1, 2])
@every_shape
def test_links_that_never_break_move_as_those_that_cannot(make: Any, micro_steps: int) -> None:
    found = []
    for laws in (None, UNBREAKABLE):
        medium = make(micro_steps, micro_steps, laws, micro_steps=micro_steps)
        start_noise(medium, 2)
        medium.step(100 * medium.step_size)
        names = ("grid_velocity", "automata_velocity", "automata_rotation", "automata_stress", "automata_elastic_energy")
        found.append([np.array(medium.get(name)) for name in names])
    for linked, breakable in zip(*found, strict=True):
        assert np.abs(linked - breakable).max() <= 1e-13 * np.abs(linked).max()


@pytest.mark.slow  # ten seconds for kernels that no other test needs
def test_two_names_of_one_material_move_as_one() -> None:
    found = []
    for laws in (None, {"material": [MEDIUM, MEDIUM], "automaton_material": (np.arange(145) % 2).tolist()}):
        medium = hexagonal_inclusion(2, 2, laws)
        assert medium.automata.count == 145
        start_noise(medium, 4)
        medium.step(100 * medium.step_size)
        found.append([medium.get("grid_velocity"), medium.get("automata_velocity"), medium.get("automata_stress")])
    for one, two in zip(*found, strict=True):
        assert np.abs(one - two).max() <= 1e-12 * np.abs(one).max()


def test_a_homogeneous_strain_that_yields_stays_homogeneous() -> None:
    """Tied faces flow as links do: the stress of all automata inside is one, and so is what has flowed."""
    medium = hexagonal_inclusion(1, 1, {"response": {"name": "plastic", "yield_stress": 1.2 * SMALL, "hardening": 0.1}})
    gradient = np.array([[1.0, 0.2], [0.1, -0.4]])
    start(medium, lambda points: SMALL * points @ gradient.T, 0.5 * SMALL * (gradient[1, 0] - gradient[0, 1]))
    medium.step(medium.step_size)
    ties, bonds = specimen_of(medium).ties, specimen_of(medium).medium.bonds
    assert ties is not None
    # The stress of what stands in a corner is not that of the field, so it flows by another one.
    corners = medium.reference[ties.rows.reshape(-1)]
    away = (np.abs(medium.reference[:, None] - corners).max(axis=2) > 2.1).all(axis=1)
    inside = inner(medium, 2.1)[1].astype(bool) & away
    stress, flowed = medium.get("automata_stress")[inside], medium.get("automata_inelastic_strain")[inside]
    np.testing.assert_allclose(stress, np.broadcast_to(stress[0], stress.shape), atol=1e-11 * SMALL)
    np.testing.assert_allclose(flowed, flowed[0], rtol=1e-11)
    tied = inside[ties.automata]
    assert tied.any() and flowed[0] > 0.1 * SMALL
    np.testing.assert_allclose(bonds.inelastic[ties.automata, ties.slots][tied], flowed[0], rtol=1e-11)


# -- energy and forces of any state ------------------------------------------------------------------------------------------


def crack_at_random(make: Any, seed: int, laws: dict[str, Any]) -> CrackingSpecimen:
    """Return automata some of whose links and tied faces are broken, half released, have flowed and degraded; far from rest."""
    specimen, random = specimen_of(make(1, 1, laws)), np.random.default_rng(seed)
    bonds = specimen.medium.bonds
    for i, j, slot in specimen.packing.pairs().tolist():
        weight, plastic, softer = random.choice([1.0, 1.0, 0.6, 0.0]), random.normal(0.0, 0.05, 2), -0.5 * random.random()
        for one, own in ((i, slot), (j, opposite_slot(6, slot))):
            bonds.weight[one, own], bonds.plastic[one, own], bonds.stiffness[one, own] = weight, plastic, softer
    assert specimen.ties is not None
    for i, slot in zip(specimen.ties.automata, specimen.ties.slots, strict=True):
        bonds.plastic[i, slot], bonds.stiffness[i, slot] = random.normal(0.0, 0.05, 2), -0.5 * random.random()
    specimen.motion.displacement[:] = random.normal(0.0, 0.1, (specimen.count, 2))
    specimen.motion.rotation[:] = random.normal(0.0, 0.3, specimen.count)
    return specimen


@pytest.mark.parametrize(
    "laws",
    [
        pytest.param(UNBREAKABLE, id="one"),
        pytest.param({"material": [MEDIUM, SOFT], "automaton_material": None}, id="two", marks=pytest.mark.slow),
    ],
)
@every_shape
def test_forces_are_the_derivatives_of_the_energy_and_sum_to_nothing(make: Any, laws: dict[str, Any]) -> None:
    """Of any state of links: so energy, momentum and angular momentum are kept, however a run breaks."""
    if "material" in laws:
        count = make(1, 1).automata.count
        laws = {**laws, "automaton_material": (np.arange(count) // 3 % 2).tolist()}
    specimen = crack_at_random(make, 5, laws)
    ties = specimen.ties
    assert ties is not None

    def energy() -> float:
        return specimen.stored(0.0)["elastic_energy"]

    force, torque = specimen.forces().copy(), specimen.scratch.torque.copy()
    for i in np.unique(np.concatenate([ties.touched, ties.ends.reshape(-1)]))[::3]:
        for values, expected in (
            (specimen.motion.displacement[i, :1], force[i, 0]),
            (specimen.motion.displacement[i, 1:], force[i, 1]),
            (specimen.motion.rotation[i : i + 1], torque[i]),
        ):
            before, around = values.copy(), []
            for change in (1e-5, -1e-5):
                values[:] = before + change
                around.append(energy())
            values[:] = before
            assert (around[1] - around[0]) / 2e-5 == pytest.approx(expected, abs=1e-9 * np.abs(force).max() + 1e-9)
    places = specimen.packing.reference + specimen.motion.displacement
    assert np.abs(force.sum(axis=0)).max() <= 1e-14 * np.abs(force).sum()
    moment = (places[:, 0] * force[:, 1] - places[:, 1] * force[:, 0] + torque).sum()
    assert abs(moment) <= 1e-14 * np.abs(force).sum() * 10.0


@every_shape
def test_to_release_a_link_takes_energy_and_never_gives_any(make: Any) -> None:
    specimen = crack_at_random(make, 6, UNBREAKABLE)
    weight = specimen.medium.bonds.weight

    def energy() -> float:
        return specimen.stored(0.0)["elastic_energy"]

    whole = energy()
    for i, j, slot in specimen.packing.pairs().tolist():
        ends = (i, slot), (j, opposite_slot(6, slot))
        held = weight[ends[0]]
        for part in (0.7, 0.0):
            for end in ends:
                weight[end] = part * held
            assert energy() <= whole
        for end in ends:
            weight[end] = held


def test_a_tied_face_goes_with_the_links_beside_it() -> None:
    """All links of an automaton broken, its face bears nothing: it is free."""
    specimen = specimen_of(hexagonal_inclusion(2, 2, UNBREAKABLE))
    assert specimen.ties is not None
    i, bonds = int(specimen.ties.automata[0]), specimen.medium.bonds
    for slot in range(6):
        j = int(specimen.body.neighbours[i, slot])
        if j != i:
            bonds.weight[i, slot] = bonds.weight[j, opposite_slot(6, slot)] = 0.0
    specimen.motion.displacement[i] = [0.03, 0.02]
    specimen.forces()
    assert np.abs(specimen.scratch.force).max() == 0.0 and specimen.stored(0.0)["elastic_energy"] == 0.0


# -- runs that crack -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "parameters",
    [{}, pytest.param({"n": 2, "micro": 2}, marks=pytest.mark.slow), {"response": PLASTIC}, {"response": DEGRADING}],
    ids=["lockstep", "micro-steps", "plastic", "degrading"],
)
def test_a_core_that_breaks_closes_to_a_percent(parameters: dict[str, Any]) -> None:
    medium = core(**parameters)
    assert push(medium) <= 0.01 and not medium.cautions()
    work = medium.get("input_work")
    assert medium.get("automata_broken_links") >= 45 and medium.get("automata_touching") > 10
    assert medium.get("fracture_energy") > 0.01 * work
    assert np.abs(medium.get("momentum_residual")).max() <= 1e-13 * np.abs(medium.get("boundary_impulse")).max()
    assert abs(medium.get("angular_momentum_residual")) <= 1e-12 * abs(medium.get("boundary_angular_impulse"))
    assert abs(medium.get("interface_work_difference")) <= 1e-14 * abs(medium.get("interface_work_on_automata"))
    # Some of what broke stood at the zigzag.
    ties = specimen_of(medium).ties
    assert ties is not None and (medium.get("automata_damage")[ties.automata] > 0.0).any()


def test_the_energy_closes_at_second_order() -> None:
    assert 4.0 <= push(core()) / push(core(step=0.05)) <= 30.0


@pytest.mark.slow
@every_shape
def test_linked_automata_of_two_materials_keep_energy_momentum_and_its_moment(make: Any) -> None:
    count = make(2, 1).automata.count
    two = {"material": [MEDIUM, SOFT], "automaton_material": (np.arange(count) // 3 % 2).tolist()}
    medium = make(2, 1, two, micro_steps=1)
    energy = start_noise(medium, 1)
    mass = medium.get("mass")
    medium.step(200 * medium.step_size)
    assert abs(medium.get("energy_residual")) <= 1e-12 * energy
    assert np.abs(medium.get("momentum_residual")).max() <= 1e-15 * mass * SMALL
    assert abs(medium.get("angular_momentum_residual")) <= 1e-14 * mass * SMALL


@pytest.mark.slow
def test_several_materials_may_lie_at_the_zigzag_and_break() -> None:
    left = {"area": {"name": "box", "x": [-1.0, 2.2], "y": [-1.0, 9.0]}, "material": 1}
    medium = core(material=[MEDIUM, SOFT], response=["linear", PLASTIC], regions=[left])
    assert push(medium) <= 0.01
    assert medium.get("automata_broken_links") > 20 and medium.get("inelastic_energy") > 0.0
    assert abs(medium.get("mass_difference")) <= 1e-15 * medium.get("mass")


def test_a_mirrored_core_cracks_as_its_image() -> None:
    """Bit for bit in x = 0 while nothing touches: each side has its ties in the same order from below."""
    medium = core()
    images = mirror_images(medium)
    straight = partial(push, towards=(0.0, -0.03))
    for until in range(2, 26, 2):
        straight(medium, float(until))
        for name, image in zip(("grid_velocity", "automata_velocity"), images, strict=True):
            velocity = medium.get(name)
            found = velocity[image] * [-1.0, 1.0]
            if medium.get("automata_touching") == 0.0:
                np.testing.assert_array_equal(found, velocity)
            assert np.abs(found - velocity).max() <= 1e-9 * np.abs(velocity).max()
    assert medium.get("automata_broken_links") >= 20


@pytest.mark.parametrize("micro", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_run_goes_on_from_the_middle_of_cracking_with_the_same_bits(micro: int) -> None:
    def make_body() -> Coupled:
        return core(micro, micro=micro, response=PLASTIC)

    whole, again = make_body(), make_body()
    push(whole, 26.0)
    for until in (12.0, 15.0, 15.2, 26.0):
        pieces = make_body()
        pieces.restore(ge.Snapshot.from_bytes(again.save().to_bytes()))
        push(pieces, until)
        again = pieces
    assert 0.0 < whole.get("automata_broken_links")
    assert again.save().to_bytes() == whole.save().to_bytes() and again.events() == whole.events()


# -- linked again ----------------------------------------------------------------------------------------------------------

WELDING = {"relinking": {"name": "cold_welding", "pressure": 0.01, "slip_speed": 0.005}, "contact_damping": 0.2}


def tear_and_weld(medium: Coupled, until: float = 300.0) -> None:
    """Pull the block until its core is torn, and press it until pairs are linked again, slowly beside the waves."""
    for end, speed in ((80.0, 0.005), (300.0, -0.005)):
        ticks = round((min(until, end) - medium.time) / medium.step_size)
        if ticks > 0:
            medium.step(ticks * medium.step_size, grid_top_velocity=[0.0, speed])


def tied_weights(medium: Coupled) -> Any:
    """Return the weights of the tied faces."""
    specimen = specimen_of(medium)
    assert specimen.ties is not None
    beside = np.where(specimen.ties.slots[:, None] == 0, [[1, 5]], [[2, 4]])
    return specimen.medium.bonds.weight[specimen.ties.automata[:, None], beside].mean(axis=1)


@pytest.mark.parametrize(
    "parameters",
    [{}, {"n": 2, "micro": 2}, {"response": PLASTIC}],
    ids=["lockstep", "micro-steps", "plastic"],
)
@pytest.mark.slow
def test_a_core_is_torn_and_welded_beside_its_zigzag(parameters: dict[str, Any]) -> None:
    """Tied faces go with the links beside them: they bear again once these do, from the strains at which they bore nothing."""
    medium = core(**WELDING, **parameters)
    tear_and_weld(medium, 80.0)
    torn = tied_weights(medium)
    assert (torn == 0.0).any()
    tear_and_weld(medium)
    welded = tied_weights(medium)
    assert (welded[torn == 0.0] == 1.0).any()
    assert {"automata_linked"} <= {event.kind for event in medium.events()}
    energy = medium.balances()[0]
    turned_over = sum(abs(float(amount)) for amount in (*energy.supplied.values(), *energy.lost.values()))
    assert abs(float(energy.residual)) <= 0.01 * turned_over
    assert abs(float(energy.lost["linking_energy"])) <= 0.05 * turned_over
    assert np.abs(medium.get("momentum_residual")).max() <= 1e-12 * np.abs(medium.get("boundary_impulse")).max()
    assert abs(medium.get("angular_momentum_residual")) <= 1e-12 * turned_over


@pytest.mark.slow
def test_a_run_goes_on_from_the_middle_of_welding_with_the_same_bits() -> None:
    whole, again = core(**WELDING), core(**WELDING)
    tear_and_weld(whole, 150.0)
    for until in (79.0, 101.0, 101.2, 120.0, 150.0):
        pieces = core(**WELDING)
        pieces.restore(ge.Snapshot.from_bytes(again.save().to_bytes()))
        tear_and_weld(pieces, until)
        again = pieces
    assert "automata_linked" in {event.kind for event in whole.events()}
    assert again.save().to_bytes() == whole.save().to_bytes() and again.events() == whole.events()


@pytest.mark.slow
def test_a_mirrored_core_is_welded_as_its_image() -> None:
    """To rounding, until links that share an automaton are made in one step: each then finds the strains of those before it."""
    medium = core(**WELDING)
    images = mirror_images(medium)
    tear_and_weld(medium, 80.0)
    assert sum(event.kind == "automata_linked" for event in medium.events()) >= 6
    for name, image in zip(("grid_velocity", "automata_velocity"), images, strict=True):
        velocity = medium.get(name)
        assert np.abs(velocity[image] * [-1.0, 1.0] - velocity).max() <= 1e-9 * np.abs(velocity).max()


def test_dashpots_are_bounded_by_the_lighter_automata_at_the_zigzag() -> None:
    """Those with a tied face have three quarters of the mass of others."""
    with pytest.raises(ParameterError, match=r"contact_damping: got 0.7, expected at most 0\.645"):
        core(contact_damping=0.7)
    core(contact_damping=0.64)
    alone = rectangle(6.0, 3.0 * TALL[1])
    ge.make(
        "automata",
        shape=alone,
        diameter=1.0,
        packing="hexagonal",
        material=MEDIUM,
        criterion=WEAK,
        step_size=0.2,
        contact_damping=0.7,
    )
