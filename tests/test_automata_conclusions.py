"""What automata, alone and with a grid, say of their links and pieces, against counts by hand."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from support.automata_tools import block
from support.coupled_tools import between, coupled, inclusion, mesh, rectangle

import granular_env as ge
from granular_env.cli import main
from granular_env.components.automata.conclusions import describe_pieces
from granular_env.components.coupled import Coupled
from granular_env.components.drawables import Points
from granular_env.recording.near_misses import nearest_to_events

EDGES = {"left": "fixed", "right": {"name": "velocity"}}
WEAK = {"name": "mohr_coulomb", "cohesion": 0.004, "tensile": 0.003, "internal_friction": 0.5}


def notched_bar() -> Any:
    """A bar 8 diameters long whose links are weak about x = 4.5, between two columns."""
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
    assert f"automata {ends[0]} and {ends[1]} at (" in said and said.endswith(f"is at {ratio.max():.3g} of its limit now")
    bar.step(100.0, right_velocity=[2e-4, 0.0])
    links, pieces = bar.conclusions()
    first = bar.events()[0]
    assert links.startswith(f"{len(bar.events())} of {len(ratio)} links broke; the first was a stretch break of automata ")
    assert f" at {1e6 * first.tick * bar.step_size:.4g} us: {first.value:.6g} > {first.limit:.6g}" in links
    assert "at (4.5, " in links
    # Of 9 columns, of which the outer ones are halves, 5 are left of the weak links: 4.5 diameters of 8.
    assert pieces == "2 pieces; the largest has 56.25 % of the mass"


def test_links_that_were_made_again_are_told() -> None:
    welding = {"name": "cold_welding", "pressure": 1e-6, "slip_speed": 1.0}
    criterion = {"name": "strain", "tensile": 1e-3}
    bar = block(columns=8, rows=2, boundaries=EDGES, criterion=criterion, relinking=welding, step_size=0.05, release_ticks=4)
    while not bar.events():
        bar.step(0.05, right_velocity=[1e-3, 0.0])
    bar.step(40.0, right_velocity=[-2e-3, 0.0])
    broke = {one.index for one in bar.events("stretch_break")}
    held = len(broke) - int(bar.get("broken_links"))
    assert (
        held > 0
        and f"{len(broke)} of {len(bar.get('linked'))} links broke, {held} of which hold again; " in bar.conclusions()[0]
    )


def test_automata_that_cannot_break_say_nothing() -> None:
    assert block().conclusions() == []
    assert block(response={"name": "plastic", "yield_stress": 0.1, "hardening": 0.1}).conclusions() == []
    assert inclusion().conclusions() == []


@pytest.mark.parametrize("make", [inclusion, between], ids=lambda make: make.__name__)
def test_a_whole_body_is_one_piece(make: Callable[..., Coupled]) -> None:
    medium = make()
    criterion = {"name": "strain", "tensile": 1e6, "shear": 1e6}
    automata = {**medium.parameters.automata.model_dump(), "criterion": criterion}
    medium = Coupled(**{**medium.parameters.model_dump(), "automata": automata})
    assert describe_pieces(medium._held_pairs(), medium.mass) == "1 piece"
    assert medium.conclusions()[0].startswith("automata: none of ")


def test_a_core_that_comes_off_is_a_piece_of_grid_and_automata() -> None:
    """A bar of a grid, automata and a grid, periodic across, is pulled apart at the first column of free automata."""
    gap = {"name": "box", "x": [3.0, 6.0], "y": [-1.0, 5.0]}
    across = {"bottom": "periodic", "top": "periodic"}
    seam = [{"area": {"name": "box", "x": [1.2, 1.8], "y": [-1.0, 5.0]}, "factor": 0.05}]
    medium = coupled(
        {"mesh": mesh(10, 4, holes=[gap]), "boundaries": {"left": "fixed", "right": "velocity", **across}},
        {
            "shape": rectangle(3.0, 4.0), "criterion": {"name": "strain", "tensile": 0.01}, "boundaries": across,
            "strength_regions": seam,
        },
        origin=[3.0, 0.0], step_size=0.1,
    )  # fmt: skip
    medium.step(60.0, grid_right_velocity=[1e-3, 0.0])
    links, pieces = medium.conclusions()
    # Four rows of automata: four links across the middle of the core, and no other.
    assert links.startswith("automata: 4 of ") and "a stretch break of automata " in links and " at (4.5, " in links
    # All but the half core and the grid on its left side.
    assert pieces == "grid and automata: 2 pieces; the largest has 55 % of the mass"
    assert {one.colour for one in medium.drawables() if isinstance(one, Points)} == {"grid_speed", "automata_speed"}


@pytest.mark.parametrize(("motion", "cause"), [([1e-5, 0.0], "tension_break"), ([0.0, 1e-5], "shear_break")])
def test_a_log_says_by_which_cause_a_link_was_near(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], motion: list[float], cause: str
) -> None:
    # Between smooth plates along x the block is sheared, and pulled across.
    bar = block(columns=2, rows=8, boundaries={"left": "fixed", "right": "velocity"}, criterion=WEAK, step_size=0.05)
    with ge.record(bar, tmp_path / "near.mcap", every=10.0):
        bar.step(100.0, right_velocity=motion)
    with ge.open_log(tmp_path / "near.mcap") as log:
        (found,) = nearest_to_events(log)
    assert found.nearest == cause and found.kinds == ("shear_break", "tension_break") and found.all_instants == 2001
    assert main(["events", str(tmp_path / "near.mcap"), "--nearest"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert f"(limit of {cause}; nothing passed it; {found.instants} of 2001 instants examined)" in told
