"""Specimens of several materials: layers, waves at a bond between two materials, cracking mixtures, and refusals."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from support.automata_tools import BOTH, block, forces_and_torques

import granular_env as ge
from granular_env.components.automata import Automata
from granular_env.components.automata.lattice import INERTIA
from granular_env.components.drawables import Links

SOFT = ge.Material(density=1.0, young=2.5, poisson=0.25)
HARD = ge.Material(density=2.0, young=10.0, poisson=0.1)
DENSE = ge.Material(density=3.0, young=2.5, poisson=0.25)
WEAK = {"name": "mohr_coulomb", "cohesion": 4e-3, "internal_friction": 0.5, "tensile": 3e-3}
STRONG = {"name": "mohr_coulomb", "cohesion": 2e-2, "internal_friction": 0.5, "tensile": 1.5e-2}
BOND = [{"materials": [0, 1], "criterion": WEAK}]
SHEAR, LAME = (np.array([getattr(one, name) for one in (SOFT, HARD)]) for name in ("shear_modulus", "first_lame"))


def upper_half(axis: int, middle: float) -> list[dict[str, Any]]:
    """Return the region of the second material: the half-space beyond a position on an axis."""
    sides = [[-1000.0, 1000.0], [-1000.0, 1000.0]]
    sides[axis][0] = middle
    return [{"area": {"name": "box", "x": sides[0], "y": sides[1]}, "material": 1}]


def mixed(packing: str, columns: int, rows: int, seed: int = 1, materials: int = 2, **parameters: Any) -> Automata:
    """Return a block of automata with randomly sampled materials."""
    count = block(packing, columns, rows).count
    numbers = np.random.default_rng(seed).integers(0, materials, count).tolist()
    given = [SOFT, HARD, ge.Material(density=0.5, young=0.4, poisson=0.45)][:materials]
    return block(packing, columns, rows, material=given, automaton_material=numbers, **parameters)


# -- layers -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("axis", [0, 1], ids=["upright", "level"])
@pytest.mark.parametrize(
    ("along", "across", "shear"), [(0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (1.0, 2.0, -1.0)],
    ids=["across", "along", "shear", "all"],
)  # fmt: skip
def test_layers_are_in_equilibrium_and_bear_what_both_materials_say(
    axis: int, along: float, across: float, shear: float
) -> None:
    """Apply a strain along layers, a stress across them and a shear stress: tractions are continuous, and both moduli exact."""
    size = 1e-13
    automata = block("square", 8, 8, material=[SOFT, HARD], regions=upper_half(axis, 4.2))
    place, beside = automata.packing.reference[:, axis], automata.packing.reference[:, 1 - axis]
    layer, middle = automata.automaton_material, 4.5
    stretch = (across - LAME * along) / (LAME + 2.0 * SHEAR)
    angle = shear / SHEAR
    displacement = np.zeros((automata.count, 2))
    for values, axis_of, also in ((stretch, axis, 0.0 * beside), (angle, 1 - axis, along * beside)):
        displacement[:, axis_of] = np.where(layer, values[0] * middle + values[1] * (place - middle), values[0] * place) + also
    # Zero torque requires rows to rotate by half of the shear angle.
    rotation = (-0.5 if axis == 1 else 0.5) * angle[layer]
    automata.reset(displacement=size * displacement, rotation=size * rotation)
    stress = automata.get("stress") / size
    force, torque = (one / size for one in forces_and_torques(automata, size * displacement, size * rotation))
    inside = (np.abs(automata.packing.reference - 4.0) < 3.5).all(axis=1)
    assert np.abs(force[inside]).max() <= 1e-12 * 10.0 and np.abs(torque[inside]).max() <= 1e-12 * 10.0
    np.testing.assert_allclose(stress[inside, axis], across, atol=1e-11)
    np.testing.assert_allclose(stress[inside, 2], shear, atol=1e-11)
    beside_stress = LAME * (along + stretch) + 2.0 * SHEAR * along
    np.testing.assert_allclose(stress[inside, 1 - axis], beside_stress[layer[inside]], atol=1e-11)


# -- energy, momentum, motion ---------------------------------------------------------------------------------------------


@BOTH
def test_forces_of_a_mixture_are_those_of_its_energy(packing: str) -> None:
    automata = mixed(packing, 8, 8, materials=3)
    random = np.random.default_rng(2)
    displacement, rotation = 1e-9 * random.standard_normal((automata.count, 2)), 1e-9 * random.standard_normal(automata.count)
    automata.reset(displacement=displacement, rotation=rotation)
    force, torque = forces_and_torques(automata, displacement, rotation)
    work = -0.5 * float((displacement * force).sum() + (rotation * torque).sum())
    assert work > 0.0 and automata.get("elastic_energy") == pytest.approx(work, rel=1e-7)
    assert np.abs(force.sum(axis=0)).max() <= 1e-13 * np.abs(force).max()
    # The stiffness is symmetric: the forces of one motion do the same work on another motion as vice versa.
    other, turn = 1e-9 * random.standard_normal((automata.count, 2)), 1e-9 * random.standard_normal(automata.count)
    there, back = forces_and_torques(automata, other, turn), (force, torque)
    assert float((displacement * there[0]).sum() + (rotation * there[1]).sum()) == pytest.approx(
        float((other * back[0]).sum() + (turn * back[1]).sum()), rel=1e-6
    )


@BOTH
def test_a_mixture_keeps_discrete_energy_and_momenta(packing: str) -> None:
    automata = mixed(packing, 6, 6)
    random = np.random.default_rng(3)
    automata.reset(velocity=1e-9 * random.standard_normal((automata.count, 2)))
    mass, inertia, h = automata.mass, automata.body.cells[INERTIA, automata.body.layout.place], automata.step_size
    found, momenta = [], []
    for _ in range(100):
        u, v = automata.get("displacement"), automata.get("velocity")
        turn, spin = automata.get("rotation"), automata.get("angular_velocity")
        force, torque = forces_and_torques(automata, u - 0.5 * h * v, turn - 0.5 * h * spin)
        motion = 0.5 * float((mass * (v**2).sum(axis=1)).sum() + (inertia * spin**2).sum())
        found.append(motion - 0.5 * float(((u + 0.5 * h * v) * force).sum() + ((turn + 0.5 * h * spin) * torque).sum()))
        momenta.append([*automata.get("momentum"), automata.get("angular_momentum")])
        automata.step()
    assert np.ptp(found) <= 1e-7 * max(found)
    assert np.ptp(momenta, axis=0).max() <= 1e-12 * 1e-9 * 6.0 * mass.sum()


# -- waves --------------------------------------------------------------------------------------------------------------


@BOTH
@pytest.mark.parametrize("second", [HARD, DENSE], ids=["harder", "denser"])
def test_a_wave_is_reflected_by_the_impedances_of_two_materials(packing: str, second: ge.Material) -> None:
    """Reflection and transmission of a pulse, 40 diameters long, at a bond between two materials agree with theory."""
    edges = {"bottom": "periodic", "top": "periodic"}
    automata = block(packing, 320, 4, material=[SOFT, second], regions=upper_half(0, 160.2), boundaries=edges)
    x, speed, length = automata.packing.reference[:, 0], math.sqrt(3.0), 40.0
    phase = np.clip((x - 110.0) / length, -0.5, 0.5)
    velocity = 1e-8 * np.cos(math.pi * phase) ** 2
    moved = -1e-8 / speed * length * (0.5 * phase + np.sin(2.0 * math.pi * phase) / (4.0 * math.pi) - 0.25)
    automata.reset(velocity=np.stack([velocity, 0.0 * x], axis=1), displacement=np.stack([moved, 0.0 * x], axis=1))
    automata.step(round(85.0 / speed / automata.step_size) * automata.step_size)
    seen = automata.get("velocity")[:, 0] / 1e-8
    one, other = speed, second.density * second.longitudinal_speed
    expected = (one - other) / (one + other), 2.0 * one / (one + other)
    back, on = seen[x < 155.0], seen[x > 165.0]
    got = back[np.argmax(np.abs(back))], on.max()
    np.testing.assert_allclose(got, expected, rtol=0.01)


# -- cracks -------------------------------------------------------------------------------------------------------------


@BOTH
@pytest.mark.parametrize(
    ("speed", "criteria"), [(0.005, [WEAK, "none", STRONG]), (-0.01, [WEAK, STRONG, WEAK])], ids=["pulled", "pressed"]
)
def test_a_mixture_that_breaks_and_rubs_closes_its_balance(packing: str, speed: float, criteria: list[Any]) -> None:
    edges = {"bottom": "fixed", "top": "velocity"}
    automata = mixed(packing, 10, 14, materials=3, criterion=criteria, boundaries=edges, strength_scatter=0.2)
    taken = [0.0]
    for _ in range(8):
        automata.step(12.5, top_velocity=[0.2 * speed, speed])
        taken.append(automata.get("fracture_energy"))
    assert automata.get("broken_links") > 40
    assert np.diff(taken).min() >= -1e-3 * taken[-1] and taken[-1] > 0.01 * automata.get("input_work")
    assert abs(automata.get("energy_residual")) <= 0.01 * automata.get("input_work")


def link_ends(automata: Automata) -> np.ndarray:
    """Return the two automata of each link, shape (links, 2)."""
    links = automata.drawables()[1]
    assert isinstance(links, Links)
    return links.pairs


def torn(**parameters: Any) -> tuple[Automata, list[set[int]]]:
    """Tear a strip of two materials apart; return it, and the materials at both ends of each broken link."""
    edges = {"left": "fixed", "right": "velocity"}
    strip = block("square", 16, 4, material=[SOFT, HARD], regions=upper_half(0, 8.2), boundaries=edges, **parameters)
    for _ in range(60):
        strip.step(4.0, right_velocity=[2e-4, 0.0])
        if strip.event_count:
            break
    pairs = link_ends(strip)
    return strip, [set(strip.automaton_material[pairs[event.index]].tolist()) for event in strip.events()]


def test_a_weak_interface_breaks_first_and_nothing_else() -> None:
    weaker = [{"materials": [1, 0], "criterion": {**WEAK, "tensile": 1e-3}}]
    strip, ends = torn(criterion=[WEAK, STRONG], interfaces=weaker)
    assert len(ends) > 0 and all(one == {0, 1} for one in ends)
    assert {event.limit for event in strip.events()} == {1e-3}


def test_a_contact_of_two_materials_is_two_halves_in_series() -> None:
    """Two blocks in contact: the force is that of springs k = 2 G + lambda / 2 in series, at the given overlap."""
    slit = {"name": "box", "x": [-1.0, 3.0], "y": [2.9, 3.1]}
    shape = {"name": "rectangle", "width": 2.0, "height": 6.0, "holes": [slit]}
    automata = block(
        "square", 2, 6, shape=shape, material=[SOFT, HARD], regions=upper_half(1, 3.2), criterion=STRONG, interfaces=BOND
    )
    upper, y = automata.automaton_material == 1, automata.packing.reference[:, 1]
    apart = np.stack([0.0 * y, np.where(upper, 2e-6 - 1.0, 0.0)], axis=1)
    automata.reset(displacement=apart, velocity=np.stack([0.0 * y, np.where(upper, -1e-5, 0.0)], axis=1))
    automata.step(10 * automata.step_size)
    before, h = automata.get("velocity")[:, 1], automata.step_size
    middle = automata.get("displacement")[:, 1] + 0.5 * h * before
    overlap = middle[y == 2.0] - middle[y == 4.0] - 1.0
    automata.step()
    spring = 2.0 * SHEAR + 0.5 * LAME
    force = 2.0 * spring.prod() / spring.sum() * overlap @ [0.5, 1.0, 0.5]  # one whole cell and two half cells
    gained = (automata.mass * (automata.get("velocity")[:, 1] - before))[upper].sum()
    assert automata.get("touching") == 3.0 and overlap.min() > 1e-6
    assert gained == pytest.approx(force * h, rel=1e-6)
