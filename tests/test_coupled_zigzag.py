"""A hexagonal packing that meets the grid along y: patches, corners, conserved quantities, frequencies, refusals."""

from __future__ import annotations

from collections.abc import Callable
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
    rectangle,
    start,
    start_noise,
)

from granular_env.components.automata import Automata
from granular_env.components.automata.zigzag_faces import Ties
from granular_env.components.coupled import Coupled
from granular_env.components.errors import ParameterError

# A stretch, a shear and a spin at once.
GRADIENT = np.array([[0.7, -1.1], [0.4, 0.3]])
SHAPES: list[Callable[..., Coupled]] = [beside_zigzag, hexagonal_inclusion, hexagonal_cradle]
every_shape = pytest.mark.parametrize("make", SHAPES, ids=lambda make: make.__name__)


def ties_of(medium: Coupled) -> Ties:
    ties = medium.automata.steps.ties
    assert ties is not None
    return ties


def start_patch(medium: Coupled) -> None:
    start(medium, lambda points: SMALL * points @ GRADIENT.T, 0.5 * SMALL * (GRADIENT[1, 0] - GRADIENT[0, 1]))


@pytest.mark.parametrize(("n", "rows"), [(1, 1), (2, 1), (3, 2)])
@every_shape
def test_a_homogeneous_strain_leaves_no_force(make: Callable[..., Coupled], n: int, rows: int) -> None:
    """In corners too, where a row and a zigzag meet; of these the torque alone is not 0."""
    medium = make(n, rows)
    start_patch(medium)
    nodes, automata = (inside.astype(bool) for inside in inner(medium, 2.1 * max(1.0, 0.55 * n)))
    forces, torques = medium.forces_on_automata()
    free = automata & (medium.interface.free > 0)
    assert nodes[medium.interface.nodes].any() and free.any()
    assert np.abs(medium.forces_on_nodes()[nodes]).max() <= 1e-12 * SMALL
    assert np.abs(forces[free]).max() <= 1e-12 * SMALL
    np.testing.assert_allclose(medium.get("automata_dilation")[automata], SMALL * GRADIENT.trace(), rtol=1e-12)
    corners = np.isin(np.arange(medium.automata.count), ties_of(medium).rows)
    assert np.abs(torques[automata & ~corners]).max() <= 1e-12 * SMALL
    stress = medium.get("automata_stress")[automata & ~corners]
    # lambda and 2 G are 1 and 2.
    np.testing.assert_allclose(stress[:, :2], SMALL * (1.0 + 2.0 * GRADIENT.diagonal()) + 0.0 * stress[:, :2], rtol=1e-11)
    np.testing.assert_allclose(stress[:, 2], SMALL * (GRADIENT[0, 1] + GRADIENT[1, 0]), rtol=1e-11)


def test_the_torque_in_a_corner_is_that_of_its_quarter() -> None:
    """(D^2 / 8) (s_yy - s_xx): the faces of a quarter of a cell do not lie around its centre."""
    medium = hexagonal_inclusion(2)
    start_patch(medium)
    torques = medium.forces_on_automata()[1]
    turned = np.flatnonzero(np.abs(torques) > 1e-11 * SMALL)
    inside = turned[(medium.interface.free[turned] == 0)]
    assert len(inside) == 4
    np.testing.assert_allclose(np.abs(torques[inside]), SMALL * 2.0 * 0.4 / 8.0, rtol=1e-9)


@every_shape
def test_lockstep_keeps_energy_momentum_and_its_moment(make: Callable[..., Coupled]) -> None:
    medium = make(2, micro_steps=1)
    energy = start_noise(medium, 1)
    mass = medium.get("mass")
    medium.step(400 * medium.step_size)
    assert abs(medium.get("energy_residual")) <= 1e-12 * energy
    assert np.abs(medium.get("momentum_residual")).max() <= 1e-15 * mass * SMALL
    assert abs(medium.get("angular_momentum_residual")) <= 1e-14 * mass * SMALL
    assert abs(medium.get("interface_work_on_grid")) > 1e-3 * energy
    assert abs(medium.get("interface_work_difference")) <= 1e-14 * energy
    assert abs(medium.get("mass_difference")) <= 1e-15 * mass


def test_a_turn_by_a_right_angle_costs_no_energy() -> None:
    """Strains of ties are those of pairs: no rigid motion changes them."""
    medium = beside_zigzag()

    def turn(points: Any) -> Any:
        return np.stack([-points[:, 1], points[:, 0]], axis=1) - points

    start(medium, turn, 0.5 * np.pi)
    assert medium.get("automata_elastic_energy") <= 1e-25
    assert np.abs(medium.forces_on_automata()[0]).max() <= 1e-12


def test_impulses_keep_the_energy_within_bounds() -> None:
    medium = hexagonal_inclusion(3, 2, micro_steps=2)
    assert medium.micro_steps > 1
    start_noise(medium, 3, 0.05)
    begin = medium.get("kinetic_energy")
    for _ in range(10):
        medium.step(50 * medium.step_size)
        stored = medium.balances()[0].stored
        assert 0.95 <= (sum(stored.values()) - stored["leapfrog_energy"]) / begin <= 1.08
    assert np.abs(medium.get("momentum_residual")).max() <= 1e-15 * medium.get("mass") * SMALL


def test_ties_count_in_the_largest_frequency() -> None:
    """Half a pair is twice as stiff as a pair: the automata beside the interface move faster than others."""
    medium = beside_zigzag()
    tied = medium.automata.largest_frequency
    assert tied == medium.automata.tied_frequency(ties_of(medium))
    assert tied > 1.001 * Automata(**medium.automata.parameters.model_dump()).largest_frequency
    part = medium.get("automata_step_part")
    assert part == pytest.approx(medium.step_size * tied / 2.0, rel=1e-12)
    assert medium.report()["automata: step over the largest stable one, at rest"] == pytest.approx(part, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"shape": rectangle(0.5, 4 * TALL[1])}, "no whole automaton"),
    ],
)
def test_what_is_not_built_is_refused_by_name(changes: dict[str, Any], words: str) -> None:
    automata = {"shape": rectangle(4.0, 4 * TALL[1]), "packing": "hexagonal", **changes}
    with pytest.raises(ParameterError, match=words):
        coupled({"mesh": mesh(4, 4, cell_size=TALL), "material": MEDIUM}, automata, origin=[4.0, 0.0])


def test_oblique_sides_are_refused() -> None:
    nodes = [[0.0, 0.0], [1.0, 0.0], [1.5, TALL[1]], [0.0, TALL[1]]]
    cells = {"name": "quadrilaterals", "nodes": nodes, "cells": [[0, 1, 2, 3]]}
    corners = [[1.0, 0.0], [5.0, 0.0], [5.5, TALL[1]], [1.5, TALL[1]]]
    with pytest.raises(ParameterError, match="neither x nor y"):
        coupled({"mesh": cells}, {"shape": {"name": "polygon", "corners": corners}, "packing": "hexagonal"})
