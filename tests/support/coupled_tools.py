"""Coupled media for several tests: unit cells, rho = mu = lambda = 1."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from granular_env.components.coupled import Coupled
from granular_env.components.grid import Grid
from granular_env.components.materials.elastic import Material
from granular_env.components.support.float_arrays import FloatArray

MEDIUM = Material(density=1.0, young=2.5, poisson=0.25)
P_SPEED, S_SPEED = MEDIUM.longitudinal_speed, MEDIUM.shear_speed
# Height of a row of the hexagonal packing, in diameters.
ROW = 0.5 * math.sqrt(3.0)
# Cells with the height of two rows.
TALL = [1.0, 2.0 * ROW]
# Displacements so small that the geometry changes by less than rounding, which makes the response linear.
SMALL = 1e-13


def cell_mesh(columns: int, rows: int, **more: Any) -> dict[str, Any]:
    """Return a rectangle of unit cells."""
    return {"name": "rectangle", "columns": columns, "rows": rows, "cell_size": 1.0, **more}


def make_coupled(grid: dict[str, Any], automata: dict[str, Any], n: int = 1, **parameters: Any) -> Coupled:
    """Return a grid and automata of one material; the automata have diameter 1 / n."""
    return Coupled(
        grid={"material": MEDIUM, **grid},
        automata={"diameter": 1.0 / n, "packing": "square", "material": MEDIUM, **automata},
        **parameters,
    )


def rectangle(width: float, height: float) -> dict[str, Any]:
    """Return the shape of automata."""
    return {"name": "rectangle", "width": width, "height": height}


def layers(packing: str = "square", n: int = 1, columns: int = 8, **parameters: Any) -> Coupled:
    """Return four rows of cells with about as many rows of automata on top."""
    height = 4.0 if packing == "square" else round(4.0 * n / ROW) * ROW / n
    automata = {"shape": rectangle(float(columns), height), "packing": packing}
    return make_coupled({"mesh": cell_mesh(columns, 4)}, automata, n, origin=[0.0, 4.0], **parameters)


def inclusion(n: int = 1, laws: Mapping[str, Any] | None = None, **parameters: Any) -> Coupled:
    """Return a block of cells with a hole filled by automata with these laws."""
    hole = {"name": "box", "x": [2.0, 5.0], "y": [2.0, 6.0]}
    automata = {"shape": rectangle(3.0, 4.0), **(laws or {})}
    return make_coupled({"mesh": cell_mesh(8, 8, holes=[hole])}, automata, n, origin=[2.0, 2.0], **parameters)


def corner(n: int = 1, **parameters: Any) -> Coupled:
    """Return a block of cells whose upper right quarter consists of automata."""
    hole = {"name": "box", "x": [4.0, 8.0], "y": [3.0, 7.0]}
    return make_coupled(
        {"mesh": cell_mesh(8, 7, holes=[hole])}, {"shape": rectangle(4.0, 4.0)}, n, origin=[4.0, 3.0], **parameters
    )


def cradle(n: int = 1, **parameters: Any) -> Coupled:
    """Return a block of cells enclosed by automata on three sides; the automata have three-quarter corners."""
    corners = [[-2, -2], [6, -2], [6, 3], [3, 3], [3, 0], [0, 0], [0, 3], [-2, 3]]
    return make_coupled({"mesh": cell_mesh(3, 3)}, {"shape": {"name": "polygon", "corners": corners}}, n, **parameters)


def make_sandwich(n: int = 1, **parameters: Any) -> Coupled:
    """Return two grids with automata between them, with an interface on each side."""
    gap = {"name": "box", "x": [3.0, 6.0], "y": [-1.0, 5.0]}
    return make_coupled(
        {"mesh": cell_mesh(10, 4, holes=[gap])}, {"shape": rectangle(3.0, 4.0)}, n, origin=[3.0, 0.0], **parameters
    )


def positions(medium: Coupled) -> tuple[FloatArray, FloatArray]:
    """Return the initial positions of nodes and automata [m]."""
    return medium.grid.mesh.nodes, medium.reference


def start_displaced(medium: Coupled, field: Any, rotation: float = 0.0) -> None:
    """Reset with displacements given as a function of position."""
    nodes, centres = positions(medium)
    medium.reset(grid_displacement=field(nodes), automata_displacement=field(centres), automata_rotation=rotation)


def start_noise(medium: Coupled, seed: int, part: float = 1.0) -> float:
    """Reset with a smooth motion plus noise (a fraction `part` of it); return the kinetic energy [J]."""
    random = np.random.default_rng(seed)

    def field(points: FloatArray) -> FloatArray:
        smooth = np.sin(2.0 * np.pi * points[:, ::-1] / 8.0)
        return SMALL * (smooth + part * random.standard_normal(points.shape))

    nodes, centres = positions(medium)
    medium.reset(grid_velocity=field(nodes), automata_velocity=field(centres))
    return medium.get("grid_kinetic_energy") + medium.get("automata_kinetic_energy")


def inner_masks(medium: Coupled, margin: float) -> tuple[FloatArray, FloatArray]:
    """Return a mask of the nodes and automata farther than a margin [m] from all free surfaces."""
    nodes, centres = positions(medium)
    mesh, shape = medium.grid.mesh, medium.automata.parameters.shape
    origin = np.array(medium.parameters.origin)

    corners = mesh.nodes[mesh.cells]
    half = 0.5 * np.ptp(corners, axis=1).max(axis=0)

    def is_inside(points: FloatArray) -> Any:
        return is_inside_cells(mesh.centres, half, points) | shape.contains(points - origin, 1e-9)

    found = []
    for points in (nodes, centres):
        around = [points + margin * np.array([math.cos(a), math.sin(a)]) for a in np.arange(16) * math.pi / 8]
        found.append(np.all([is_inside(ring) for ring in around], axis=0))
    return found[0], found[1]


def is_inside_cells(middles: FloatArray, half: FloatArray, points: FloatArray) -> Any:
    """Return a mask of the points inside any of the equal cells with given centres, half width and half height."""
    inside = np.zeros(len(points), dtype=bool)
    for middle in middles:
        inside |= (np.abs(points - middle) <= half + 1e-9).all(axis=1)
    return inside


def strip(packing: str, cells: int, automata: int, step: float = 0.2, n: int = 1) -> tuple[Coupled, int]:
    """Return a strip, periodic across, of cells followed by automata up to a rigid end; and its axis.

    Args:
        packing: packing of the automata.
        cells: number of cells along the strip.
        automata: approximate length of the automata part, in cells.
        step: internal step.
        n: automata per side of a cell.
    """
    if packing == "square":
        across = {"bottom": "periodic", "top": "periodic"}
        body = {"shape": rectangle(float(automata), 2.0), "boundaries": {**across, "right": "fixed"}}
        grid = {"mesh": cell_mesh(cells, 2), "boundaries": across}
        return make_coupled(grid, body, n, origin=[float(cells), 0.0], step_size=step), 0
    across = {"left": "periodic", "right": "periodic"}
    rows = 2 * round(n * automata / ROW / 2)
    body = {"shape": rectangle(4.0, rows * ROW / n), "packing": packing, "boundaries": {**across, "top": "fixed"}}
    grid = {"mesh": cell_mesh(4, cells), "boundaries": across}
    return make_coupled(grid, body, n, origin=[0.0, float(cells)], step_size=step), 1


def start_wave(
    medium: Coupled | Grid, axis: int, shape: Callable[[FloatArray], FloatArray], length: float, shear: bool
) -> None:
    """Start a plane wave along an axis: velocity SMALL x shape(coordinate), 0 from `length` on, and its displacement."""
    fine = np.linspace(0.0, length, 40001)
    steps = 0.5 * (shape(fine[1:]) + shape(fine[:-1])) * (fine[1] - fine[0])
    integral = np.concatenate([[0.0], np.cumsum(steps)])
    component, speed = (1 - axis, S_SPEED) if shear else (axis, P_SPEED)

    def fields(points: FloatArray) -> tuple[FloatArray, FloatArray]:
        # u = f(x - c t) and v = -c f', so f(x) is the integral of v / c from x to infinity.
        x, displacement, velocity = points[:, axis], np.zeros(points.shape), np.zeros(points.shape)
        displacement[:, component] = SMALL * (integral[-1] - np.interp(x, fine, integral)) / speed
        velocity[:, component] = SMALL * shape(x)
        return displacement, velocity

    if isinstance(medium, Grid):
        displacement, velocity = fields(medium.mesh.nodes)
        medium.reset(displacement=displacement, velocity=velocity)
        return
    (displacement, velocity), (moved, moving) = (fields(points) for points in positions(medium))
    medium.reset(grid_displacement=displacement, grid_velocity=velocity, automata_displacement=moved, automata_velocity=moving)
