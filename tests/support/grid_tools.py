"""Grids for several tests."""

from __future__ import annotations

from typing import Any

import numpy as np

from granular_env.components.grid import Grid
from granular_env.components.materials.elastic import Material
from granular_env.components.support.float_arrays import FloatArray

# lambda = mu = rho = 1, so the wave speeds are sqrt(3) and 1.
MEDIUM = Material(density=1.0, young=2.5, poisson=0.25)
P_SPEED, S_SPEED = MEDIUM.longitudinal_speed, MEDIUM.shear_speed
# Displacements so small that the geometry changes by less than rounding, which makes the response linear.
SMALL = 1e-14


def block(columns: int, rows: int, **parameters: Any) -> Grid:
    """Return a rectangle of unit cells about the origin."""
    mesh = {"name": "rectangle", "columns": columns, "rows": rows, "cell_size": 1.0, "centre": [0.0, 0.0]}
    return Grid(**{"mesh": mesh, "material": MEDIUM, **parameters})


def bar(columns: int, **parameters: Any) -> Grid:
    """Return a strip of unit cells along x from 0, two cells high, for plane waves."""
    mesh = {"name": "rectangle", "columns": columns, "rows": 2, "cell_size": 1.0}
    edges = {"bottom": "periodic", "top": "periodic", **parameters.pop("boundaries", {})}
    return Grid(**{"mesh": mesh, "material": MEDIUM, "step_size": 0.5, "boundaries": edges, **parameters})


def distorted_block(columns: int, rows: int, seed: int = 1, **parameters: Any) -> Grid:
    """Return a rectangle whose inner nodes are shifted by up to a quarter of a cell."""
    grid = block(columns, rows)
    nodes = grid.mesh.nodes.copy()
    inner = (np.abs(nodes[:, 0]) < 0.5 * columns) & (np.abs(nodes[:, 1]) < 0.5 * rows)
    nodes[inner] += np.random.default_rng(seed).uniform(-0.25, 0.25, (int(inner.sum()), 2))
    mesh = {"name": "quadrilaterals", "nodes": nodes, "cells": grid.mesh.cells}
    return Grid(**{"mesh": mesh, "material": MEDIUM, **parameters})


def inner_nodes(grid: Grid) -> FloatArray:
    """Return a mask of the nodes that are not on a boundary."""
    inner = np.ones(len(grid.mesh.nodes), dtype=bool)
    inner[np.unique(grid.mesh.sides)] = False
    return inner


def pulse(x: FloatArray, length: float) -> FloatArray:
    """Return a smooth pulse from 0 to `length`, of height 1."""
    inside = (x > 0.0) & (x < length)
    return np.where(inside, np.sin(np.pi * np.clip(x / length, 0.0, 1.0)) ** 4, 0.0)


def start_pulse(grid: Grid, length: float, begin: float, *, shear: bool = False) -> None:
    """Start a plane wave along +x: velocity SMALL x pulse(x - begin), and the corresponding displacement."""
    x = grid.mesh.nodes[:, 0] - begin
    fine = np.linspace(0.0, length, 20001)
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (pulse(fine[1:], length) + pulse(fine[:-1], length)))]) * (
        fine[1] - fine[0]
    )
    # u = f(x - c t) and v = -c f', so f(x) is the integral of v / c from x to infinity.
    ahead = integral[-1] - np.interp(np.clip(x, 0.0, length), fine, integral)
    velocity, displacement = np.zeros((len(x), 2)), np.zeros((len(x), 2))
    velocity[:, int(shear)] = SMALL * pulse(x, length)
    displacement[:, int(shear)] = SMALL * ahead / (S_SPEED if shear else P_SPEED)
    grid.reset(velocity=velocity, displacement=displacement)


def axis_values(grid: Grid, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return abscissas and values of the nodes of the lowest row, sorted by abscissa."""
    low = np.flatnonzero(grid.mesh.nodes[:, 1] == grid.mesh.nodes[:, 1].min())
    order = low[np.argsort(grid.mesh.nodes[low, 0])]
    return grid.mesh.nodes[order, 0], values[order]
