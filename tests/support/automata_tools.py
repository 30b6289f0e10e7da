"""Specimens of automata for tests, with density = shear modulus = lambda = diameter = 1."""

from __future__ import annotations

import math

import numpy as np
import pytest

import granular_env as ge
from granular_env.components.automata import Automata
from granular_env.components.automata.lattice import FORCE_Y, TORQUE, load_motion

ROW = 0.5 * math.sqrt(3.0)
SOLID = ge.Material(density=1.0, young=2.5, poisson=0.25)
BOTH = pytest.mark.parametrize("packing", ["square", "hexagonal"])


def block(packing: str = "square", columns: int = 8, rows: int = 8, **parameters: object) -> Automata:
    """Return a rectangle of automata."""
    shape = {"name": "rectangle", "width": float(columns), "height": rows * (ROW if packing == "hexagonal" else 1.0)}
    return Automata(**{"shape": shape, "diameter": 1.0, "packing": packing, "material": SOLID, **parameters})


def link_force_sums(automata: Automata) -> np.ndarray:
    """Return the sum of the output `link_force` on each automaton, as vectors along the lines of centres, shape (n, 2)."""
    points, links = automata.drawables()
    first, second = links.pairs.T
    centres, total = points.reference + automata.get("displacement"), np.zeros((automata.count, 2))
    ways = centres[second] - centres[first]
    pushes = (automata.get("link_force") / np.linalg.norm(ways, axis=1))[:, np.newaxis] * ways
    np.add.at(total, second, pushes)
    np.subtract.at(total, first, pushes)
    return total


def forces_and_torques(automata: Automata, displacement: np.ndarray, rotation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the forces and torques on automata at given displacements, shape (n, 2), and rotations, shape (n,)."""
    specimen, place = automata.specimen, automata.body.layout.place
    load_motion(
        automata.body.layout, displacement, np.zeros_like(displacement), rotation, np.zeros_like(rotation), specimen.motion
    )
    specimen.update_forces()
    cells = specimen.scratch.cells
    return cells[: FORCE_Y + 1, place].T, cells[TORQUE, place]
