"""Automata that reach into cells of the grid are refused, by however little; parts that meet are not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from support.coupled_tools import (
    between,
    corner,
    coupled,
    cradle,
    inclusion,
    layers,
    mesh,
    rectangle,
    strip,
)

from granular_env.components.coupled import Coupled
from granular_env.components.coupled.overlaps import find_overlaps
from granular_env.components.coupled.places import Places
from granular_env.components.errors import ParameterError

# How to make each, and the way from its automata into its cells.
MEETING: list[tuple[Callable[[], Coupled], tuple[float, float]]] = [
    (lambda: layers(n=3), (0.0, -1.0)),
    (lambda: layers("hexagonal", 2), (0.0, -1.0)),
    (lambda: inclusion(4), (1.0, 0.0)),
    (lambda: corner(2), (-1.0, 0.0)),
    (lambda: cradle(3), (0.0, 1.0)),
    (lambda: between(4), (1.0, 0.0)),
    (lambda: strip("square", 6, 4)[0], (-1.0, 0.0)),
    (lambda: strip("hexagonal", 4, 6)[0], (0.0, -1.0)),
]


@pytest.mark.parametrize(("make", "way"), MEETING)
def test_parts_that_meet_do_not_overlap_and_do_once_they_are_moved(
    make: Callable[[], Coupled], way: tuple[float, float]
) -> None:
    medium = make()
    packing, parameters = medium.automata.packing, medium.automata.parameters
    corners = medium.grid.mesh.nodes[medium.grid.mesh.cells]

    def overlaps(moved: float) -> Any:
        origin = np.array(medium.parameters.origin) + moved * np.array(way)
        return find_overlaps(corners, packing, Places(packing, parameters.shape, origin, parameters.periodic))

    assert not len(overlaps(0.0).cells)
    for moved in (1e-5, 1e-3):
        found = overlaps(moved * packing.diameter)
        assert found.reach.max() == pytest.approx(moved * packing.diameter, rel=1e-6)
        assert (medium.interface.free[found.automata] == 0).any()


@pytest.mark.parametrize(("n", "rows"), [(2, 1), (3, 1), (4, 1), (8, 1), (8, 3)])
def test_columns_of_automata_inside_the_last_cells_are_refused_with_the_origin_that_fits(n: int, rows: int) -> None:
    reach = rows / n
    found = rf"automata reach up to {reach:.6g} m into cells .*: automaton .* cell 7, .*; move `origin` to \[8, 0\]"
    with pytest.raises(ParameterError, match=found):
        coupled(
            {"mesh": mesh(8, 4, cell_size=1.0)},
            {"shape": rectangle(4.0, 4.0), "packing": "square"},
            n,
            origin=[8.0 - reach, 0.0],
        )
