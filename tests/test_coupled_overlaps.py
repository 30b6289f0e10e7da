"""Automata that overlap cells of the grid are refused; touching parts are accepted."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from support.coupled_tools import (
    cell_mesh,
    corner,
    cradle,
    inclusion,
    layers,
    make_coupled,
    make_sandwich,
    rectangle,
    strip,
)

from granular_env.components.coupled import Coupled
from granular_env.components.errors import ParameterError

MEETING: list[Callable[[], Coupled]] = [
    lambda: layers(n=3),
    lambda: layers("hexagonal", 2),
    lambda: inclusion(4),
    lambda: corner(2),
    lambda: cradle(3),
    lambda: make_sandwich(4),
    lambda: strip("square", 6, 4)[0],
    lambda: strip("hexagonal", 4, 6)[0],
]


@pytest.mark.parametrize("make", MEETING)
def test_parts_that_meet_do_not_overlap(make: Callable[[], Coupled]) -> None:
    assert len(make().interface.nodes) > 1


@pytest.mark.parametrize(("n", "rows"), [(2, 1), (4, 1), (8, 1), (8, 3)])
def test_columns_of_automata_inside_the_last_cells_are_refused(n: int, rows: int) -> None:
    with pytest.raises(ParameterError, match=r"automata overlap cells .*: automaton .* overlaps cell 7 .* move `origin`"):
        make_coupled(
            {"mesh": cell_mesh(8, 4, cell_size=1.0)},
            {"shape": rectangle(4.0, 4.0), "packing": "square"},
            n,
            origin=[8.0 - rows / n, 0.0],
        )
