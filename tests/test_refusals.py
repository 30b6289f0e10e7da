"""Input that would be computed wrongly or ambiguously is refused: the message states location, received and expected."""

from __future__ import annotations

from typing import Any

import pytest

import granular_env as ge

HOLE = {"name": "box", "x": [0.0, 0.01], "y": [0.0, 0.04]}
CUT = {"name": "rectangle", "columns": 6, "rows": 4, "cell_size": 1e-2, "holes": [HOLE]}
SQUARE = {"name": "quadrilaterals", "nodes": [[0, 0], [1, 0], [1, 1], [0, 1]], "cells": [[0, 1, 2, 3]]}
SMALL = {"name": "rectangle", "width": 0.02, "height": 0.02}
PLATE = {"name": "plate", "length": 0.006, "width": 0.003, "along": 7, "across": 5}
TEARING = {"name": "principal_stress", "stress": 3e8}


def automata(**parameters: Any) -> dict[str, Any]:
    return {"shape": SMALL, "diameter": 0.005, "packing": "square", **parameters}


@pytest.mark.parametrize("boundary", ["fixed", "traction"])
def test_an_edge_whose_cells_are_all_cut_out_takes_no_condition(boundary: str) -> None:
    with pytest.raises(ge.ParameterError, match="boundaries.left: the holes remove all cells at this edge"):
        ge.make("grid", mesh=CUT, boundaries={"left": boundary})
    assert ge.make("grid", mesh=CUT, boundaries={"left": "free"}).time == 0.0


@pytest.mark.parametrize(
    ("name", "parameters", "words"),
    [
("grid", {"mesh": {**SQUARE, "edges": {"w": [0, 1, 0]}}}, "mesh.edges.w: contains the side between .* twice"),
(
            "automata",
            automata(shape={"name": "disc", "radius": 0.02, "height": 0.033}),
            "shape.height: 0.033 m is 6.6 rows of 0.005 m, expected an even number; use 0.03 m or 0.04 m",
        ),
(
            "automata",
            automata(boundaries={"left": "fixed"}, forced_automata=[7, 0]),
            r"forced_automata\[1\]: the motion of automaton 0 is prescribed along x and y",
        ),
("coupled", {"automata": automata(difameter=1.0)}, "automata.difameter: unknown; did you mean 'diameter'"),
(
            "shell",
            {"body": PLATE, "material": "thermoviscoplastic", "fracture": {**TEARING, "grip_length": 1e-3}},
            "fracture.grip_length: got 0.001 m, but no edge is clamped or moved",
        ),
],
)  # fmt: skip
def test_what_was_not_meant_so_is_named(name: str, parameters: dict[str, Any], words: str) -> None:
    with pytest.raises(ge.ParameterError, match=words):
        ge.make(name, **parameters)


def test_a_body_above_its_melting_temperature_is_cautioned() -> None:
    body = {"body": PLATE, "material": "thermoviscoplastic"}
    (caution,) = ge.make("shell", initial_temperature=2000.0, **body).cautions()
    assert caution.startswith("100% of the points are above 698.5 K")
    assert ge.make("shell", initial_temperature=300.0, **body).cautions() == []
