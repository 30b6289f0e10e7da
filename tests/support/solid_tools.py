"""Small solids for tests, and frequencies of oscillations."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import granular_env as ge
from granular_env.components.support.jit import jit

ALUMINIUM = {"young": 69e9, "poisson": 0.33, "density": 2719.0}
RADIUS, WALL = 0.01975, 0.00089


def ring(**changes: Any) -> Any:
    """Return a piece of the paper's tube with fixed length."""
    body = {"name": "tube", "length": 0.002, "along": 3, "around": 96}
    return ge.make("shell", **{"body": body, "boundaries": {"start": "symmetry", "end": "symmetry"}, **changes})


def strip(poisson: float, **changes: Any) -> Any:
    """Return a strip with the thickness of the paper's wall, clamped at one end."""
    body = {"name": "plate", "length": 0.02, "width": 0.003, "along": 21, "across": 4}
    material = {"name": "elastic", **ALUMINIUM, "poisson": poisson}
    return ge.make("shell", **{"body": body, "material": material, "boundaries": {"start": "clamped"}, **changes})


def frequency(values: np.ndarray, step: float) -> float:
    """Return the frequency of an oscillation around the mean of its extremes, from its first and last upward crossing."""
    centred = values - 0.5 * (values.max() + values.min())
    before = np.flatnonzero((centred[:-1] <= 0.0) & (centred[1:] > 0.0))
    at = before - centred[before] / (centred[before + 1] - centred[before])
    return (len(at) - 1) / ((at[-1] - at[0]) * step)


def displacement_history(solid: Any, node: int, direction: int, steps: int, ticks: int = 1, **inputs: Any) -> np.ndarray:
    """Return a component of a node's displacement parameter after each of `steps` steps."""
    found = []
    for _ in range(steps):
        solid.step(ticks * solid.step_size, **inputs)
        found.append(solid.peek("nodal_displacement")[node, direction])
    return np.array(found)


def make_callable(function: Any) -> Any:
    """Return a kernel that calls a function callable only from kernels."""

    @jit
    def call(*arguments):
        return function(*arguments)

    return call


def nodes_at_cracks(solid: Any) -> list[int]:
    """Return the nodes for which all points that have them in their support and carry stress are at cracks."""
    nodes, cracks = solid.tables().solid.nodes, solid._breaking.cracks
    found = []
    for node in range(len(solid.nodes)):
        seen = nodes.points[nodes.begin[node] : nodes.begin[node + 1]].tolist()
        bear = [point for point in seen if point not in cracks.eroded]
        if len(bear) > 2 and all(cracks.is_beside_crack(point) for point in bear):
            found.append(node)
    return found


# Bending vibrations of a slender cantilever (Euler-Bernoulli), and longitudinal vibrations of a bar.
#
# Valid for a length of more than ten thicknesses. Source: S. P. Timoshenko, Vibration Problems in Engineering
# (1937), 34, 53.

# The first root of cos(k) cosh(k) = -1.
_FIRST_ROOT = 1.8751040687119612


def cantilever_frequency(young: float, density: float, length: float, thickness: float) -> float:
    """Return the first bending frequency of a clamped strip with rectangular cross-section [Hz]."""
    wave_number = _FIRST_ROOT / length
    return wave_number**2 * math.sqrt(young * thickness**2 / (12.0 * density)) / (2.0 * math.pi)


def cantilever_shape(x: np.ndarray, length: float) -> np.ndarray:
    """Return the shape of the first bending mode, 0 at the clamped end and 1 at the free end."""
    k = _FIRST_ROOT
    share = (math.cosh(k) + math.cos(k)) / (math.sinh(k) + math.sin(k))
    s = k * x / length
    return 0.5 * (np.cosh(s) - np.cos(s) - share * (np.sinh(s) - np.sin(s)))


def clamped_bar_frequency(young: float, density: float, length: float) -> float:
    """Return the first longitudinal frequency of a bar clamped at one end [Hz]."""
    return math.sqrt(young / density) / (4.0 * length)
