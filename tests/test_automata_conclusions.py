"""Conclusions on links and pieces of automata, alone and with a grid, against manual counts."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from support.automata_tools import block
from support.coupled_tools import cell_mesh, inclusion, make_coupled, make_sandwich, rectangle

from granular_env.components.automata.conclusions import describe_pieces
from granular_env.components.coupled import Coupled
from granular_env.components.drawables import Points

EDGES = {"left": "fixed", "right": {"name": "velocity"}}


def notched_bar() -> Any:
    """Return a bar, 8 diameters long, with weak links around x = 4.5, between two columns."""
    seam = [{"area": {"name": "box", "x": [4.2, 4.8], "y": [-1.0, 3.0]}, "factor": 0.1}]
    criterion = {"name": "strain", "tensile": 0.01}
    return block(columns=8, rows=2, boundaries=EDGES, criterion=criterion, strength_regions=seam, step_size=0.05)


def test_a_bar_that_parts_says_where_and_in_which_pieces() -> None:
    bar = notched_bar()
    assert bar.conclusions() == [f"none of {len(bar.get('linked'))} links broke"]
    bar.step(20.0, right_velocity=[2e-5, 0.0])
    (said,) = bar.conclusions()
    ratio = bar.get("criterion_ratio")
    ends = bar.packing.pairs()[ratio.argmax(), :2]
    assert f"automata {ends[0]} and {ends[1]} at (" in said and said.endswith(f"is now at {ratio.max():.3g} of its limit")
    bar.step(100.0, right_velocity=[2e-4, 0.0])
    links, pieces = bar.conclusions()
    first = bar.events()[0]
    assert links.startswith(f"{len(bar.events())} of {len(ratio)} links broke; the first was a stretch break of automata ")
    assert f" at {1e6 * first.tick * bar.step_size:.4g} us: {first.value:.6g} > {first.limit:.6g}" in links
    assert "at (4.5, " in links
    # There are 9 columns, the outer two of half width. 5 columns are left of the weak links, i.e. 4.5 of 8 diameters.
    assert pieces == "2 pieces; the largest has 56.25 % of the mass"


def test_automata_that_cannot_break_say_nothing() -> None:
    assert block().conclusions() == []
    assert block(response={"name": "plastic", "yield_stress": 0.1, "hardening": 0.1}).conclusions() == []
    assert inclusion().conclusions() == []


@pytest.mark.parametrize("make", [inclusion, make_sandwich], ids=lambda make: make.__name__)
def test_a_whole_body_is_one_piece(make: Callable[..., Coupled]) -> None:
    medium = make()
    criterion = {"name": "strain", "tensile": 1e6, "shear": 1e6}
    automata = {**medium.parameters.automata.model_dump(), "criterion": criterion}
    medium = Coupled(**{**medium.parameters.model_dump(), "automata": automata})
    assert describe_pieces(medium._connected_pairs(), medium.mass) == "1 piece"
    assert medium.conclusions()[0].startswith("automata: none of ")


def test_a_core_that_comes_off_is_a_piece_of_grid_and_automata() -> None:
    """A bar of grid, automata and grid, periodic across, is pulled apart at the first column of free automata."""
    gap = {"name": "box", "x": [3.0, 6.0], "y": [-1.0, 5.0]}
    across = {"bottom": "periodic", "top": "periodic"}
    seam = [{"area": {"name": "box", "x": [1.2, 1.8], "y": [-1.0, 5.0]}, "factor": 0.05}]
    medium = make_coupled(
        {"mesh": cell_mesh(10, 4, holes=[gap]), "boundaries": {"left": "fixed", "right": "velocity", **across}},
        {
            "shape": rectangle(3.0, 4.0), "criterion": {"name": "strain", "tensile": 0.01}, "boundaries": across,
            "strength_regions": seam,
        },
        origin=[3.0, 0.0], step_size=0.1,
    )  # fmt: skip
    medium.step(60.0, grid_right_velocity=[1e-3, 0.0])
    links, pieces = medium.conclusions()
    # Four rows of automata: exactly four links break, across the middle of the core.
    assert links.startswith("automata: 4 of ") and "a stretch break of automata " in links and " at (4.5, " in links
    # All but the half core and the grid on its left side.
    assert pieces == "grid and automata: 2 pieces; the largest has 55 % of the mass"
    assert {one.colour for one in medium.drawables() if isinstance(one, Points)} == {"grid_speed", "automata_speed"}
