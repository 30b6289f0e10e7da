"""Automata that reach into cells of the grid are refused, by however little; parts that meet are not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from support.coupled_tools import (
    TALL,
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


@pytest.mark.parametrize("packing", ["square", "hexagonal"])
@pytest.mark.parametrize(("n", "rows"), [(2, 1), (3, 1), (4, 1), (8, 1), (8, 3)])
def test_columns_of_automata_inside_the_last_cells_are_refused_with_the_origin_that_fits(
    packing: str, n: int, rows: int
) -> None:
    size, high = (1.0, 4.0) if packing == "square" else (TALL, 4 * TALL[1])
    reach = rows / n
    found = rf"automata reach up to {reach:.6g} m into cells .*: automaton .* cell 7, .*; move `origin` to \[8, 0\]"
    with pytest.raises(ParameterError, match=found):
        coupled(
            {"mesh": mesh(8, 4, cell_size=size)},
            {"shape": rectangle(4.0, high), "packing": packing},
            n,
            origin=[8.0 - reach, 0.0],
        )


@pytest.mark.parametrize("off", [0.05, 0.1, 0.25, 0.4])
@pytest.mark.parametrize("n", [1, 2, 4])
def test_a_hole_that_cells_fill_has_its_edges_on_their_sides(n: int, off: float) -> None:
    def plate(off: float) -> Coupled:
        hole = {"name": "box", "x": [2.0 + off, 5.0 - off], "y": [2.0, 5.0]}
        shape = {**rectangle(7.0, 7.0), "holes": [hole]}
        return coupled({"mesh": mesh(3, 3, centre=[3.5, 3.5])}, {"shape": shape}, n)

    assert plate(0.0).mass.sum() == pytest.approx(49.0, rel=1e-12)
    with pytest.raises(ParameterError, match="into cells of the grid") as refused:
        plate(off)
    between_rows = [] if (off * n) % 1.0 == 0.0 else ["automata.shape.holes[0].x[0]", "automata.shape.holes[0].x[1]"]
    assert [str(fault).partition(":")[0] for fault in refused.value.faults] == ["automata", *between_rows]


def test_a_cell_of_any_form_may_lie_beside_automata_but_not_reach_into_them() -> None:
    def beside(x: float) -> Coupled:
        nodes = [[-4.0, 0.0], [0.0, 0.0], [0.0, 2.0], [-4.0, 2.0], [x, 4.0], [-4.0, 4.0]]
        cells = {"name": "quadrilaterals", "nodes": nodes, "cells": [[0, 1, 2, 3], [3, 2, 4, 5]]}
        return coupled({"mesh": cells}, {"shape": rectangle(4.0, 4.0)})

    assert len(beside(-0.5).interface.nodes) == 2
    with pytest.raises(ParameterError, match="automata reach up to .* m into cells of the grid: automaton .* cell 1"):
        beside(0.01)


def test_automata_closed_on_themselves_reach_into_cells_at_either_side() -> None:
    """A column that stands for both sides is a whole one: its left half lies at the right."""
    closed = {"left": "periodic", "right": "periodic"}
    automata = {"shape": rectangle(4.0, 4.0), "boundaries": closed}
    hole = {"name": "box", "x": [0.0, 3.75], "y": [2.0, 6.0]}
    with pytest.raises(ParameterError, match="into cells of the grid: automaton .* cell"):
        coupled({"mesh": mesh(16, 6, cell_size=[0.25, 1.0], holes=[hole])}, automata, origin=[0.0, 2.0])
