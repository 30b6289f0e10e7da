"""Shapes of automata: holes, flats of a disc, two bodies in one shape, and regions of different strength."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.automata_tools import SOLID

from granular_env.components.automata import Automata

STRAIN = {"name": "strain", "tensile": 0.01}
PULLED = {"bottom": "fixed", "top": "velocity"}


def plate(*holes: dict[str, Any], columns: int = 16, rows: int = 16, **parameters: Any) -> Automata:
    """Return a square packing with holes."""
    shape = {"name": "rectangle", "width": float(columns), "height": float(rows), "holes": list(holes)}
    return Automata(**{"shape": shape, "diameter": 1.0, "packing": "square", "material": SOLID, **parameters})


def box(left: float, right: float, low: float, high: float) -> dict[str, Any]:
    """Return the table of a box."""
    return {"name": "box", "x": [left, right], "y": [low, high]}


def middles(automata: Automata) -> Any:
    """Return the midpoint of each pair, in the order of the output `linked`, shape (m, 2)."""
    pairs = automata.packing.pairs()
    return automata.packing.reference[pairs[:, 0]] + 0.5 * automata.packing.lattice.directions[pairs[:, 2]]


def test_a_hole_takes_its_area_and_leaves_half_cells() -> None:
    automata = plate(box(4.0, 8.0, 6.0, 10.0))
    assert automata.mass.sum() == pytest.approx(16.0 * 16.0 - 4.0 * 4.0, rel=1e-12)
    edge, corner = automata.packing.nearest_automaton(6.0, 6.0), automata.packing.nearest_automaton(4.0, 6.0)
    assert automata.mass[[edge, corner]].tolist() == pytest.approx([0.5, 0.75])
    assert automata.count == 17 * 17 - 3 * 3


def test_a_homogeneous_strain_pulls_at_the_sides_of_a_hole_alone() -> None:
    automata = plate(box(4.0, 8.0, 6.0, 10.0))
    gradient = np.array([[1e-6, 2e-7], [-3e-7, 4e-7]])
    automata.reset(displacement=automata.packing.reference @ gradient.T, rotation=0.5 * (gradient[1, 0] - gradient[0, 1]))
    automata.step()
    x, y = automata.packing.reference.T
    inside = (x > 0) & (x < 16) & (y > 0) & (y < 16)
    beside = (x >= 4) & (x <= 8) & (y >= 6) & (y <= 10)
    speed = automata.get("speed")
    # Strains are 1e-6, so nonlinear terms are below the bound.
    assert speed[inside & ~beside].max() <= 1e-5 * speed[beside].max()


def test_a_gap_makes_two_bodies_that_collide() -> None:
    automata = plate(box(5.0, 7.0, -1.0, 5.0), columns=12, rows=4, criterion={"name": "strain", "tensile": 1.0})
    right = automata.packing.reference[:, 0] > 6.0
    velocity = np.where(right[:, np.newaxis], [-0.02, 0.0], [0.0, 0.0])
    automata.reset(velocity=velocity)
    automata.step(160.0)
    assert automata.get("broken_links") == 0.0
    mass = automata.mass
    momentum = [(mass * automata.get("velocity")[:, 0])[side].sum() for side in (~right, right)]
    assert momentum[0] == pytest.approx(-0.02 * mass[right].sum(), rel=0.05), "equal bodies change their velocities, and ring"
    assert sum(momentum) == pytest.approx(-0.02 * mass[right].sum(), rel=1e-12)


def test_a_disc_may_be_cut_flat() -> None:
    shape = {"name": "disc", "radius": 10.0, "height": 18.0}
    disc = Automata(shape=shape, diameter=1.0, packing="square", material=SOLID)
    top = disc.packing.reference[:, 1] == 9.0
    assert np.ptp(disc.packing.reference[top, 0]) == 8.0  # 2 sqrt(10^2 - 9^2) = 8.7
    assert disc.packing.reference[:, 1].max() == 9.0
    round_one = Automata(shape={"name": "disc", "radius": 10.0}, diameter=1.0, packing="square", material=SOLID)
    assert disc.mass.sum() < round_one.mass.sum()


def test_a_weak_seam_breaks_first_at_its_own_strength() -> None:
    seam = {"area": box(-1.0, 17.0, 11.0, 12.0), "factor": 0.5}
    automata = plate(boundaries=PULLED, criterion=STRAIN, strength_regions=[seam])
    while automata.get("broken_links") < 15.0:
        automata.step(2.0, top_velocity=[0.0, 2e-3])
    assert all(event.limit == 0.5 * 0.01 for event in automata.events())
    assert np.ptp(middles(automata)[[event.index for event in automata.events()], 1]) == 0.0
