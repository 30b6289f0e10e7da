"""Plane waves in an unbounded packing, from its energy: each automaton has two displacements and a rotation.

For q exp(i k.x), q = (u_x, u_y, w), the strains of the pair along N are

    eps = N.u (e - 1) / D,   gamma = T.u (e - 1) / D - w (1 + e) / 2,   e = exp(i D k.N),

and the energy of a cell is (1/2) q* K q with K = sum over slots S D G (eps* eps + gamma* gamma) + V lambda theta* theta.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from ...errors import ParameterError
from ..packing import LATTICES


def lattice_frequencies(
    packing: str, wave_vector: Any, *, density: float, shear: float, lame: float, diameter: float
) -> npt.NDArray[np.float64]:
    """Return the three angular frequencies of a wave vector, in increasing order, shape (3,) [rad/s].

    Args:
        packing: "square" or "hexagonal".
        wave_vector: shape (2,) [rad/m].
        density: [kg/m^3].
        shear: G [Pa].
        lame: lambda [Pa].
        diameter: of the automata [m].
    """
    if packing not in LATTICES:
        raise ParameterError(f"got {packing!r}", expected=f"one of {', '.join(LATTICES)}", at="packing")
    lattice, k = LATTICES[packing], np.asarray(wave_vector, dtype=np.float64)
    face, volume = lattice.face * diameter, lattice.volume * diameter**2
    stiffness, dilation = np.zeros((3, 3), complex), np.zeros(3, complex)
    for nx, ny in lattice.directions:
        phase = np.exp(1j * diameter * (k[0] * nx + k[1] * ny))
        eps = np.array([nx, ny, 0.0]) * (phase - 1.0) / diameter
        gamma = np.array([-ny, nx, 0.0]) * (phase - 1.0) / diameter - np.array([0.0, 0.0, 0.5]) * (1.0 + phase)
        stiffness += face * diameter * shear * (np.outer(eps.conj(), eps) + np.outer(gamma.conj(), gamma))
        dilation += face * diameter / (2.0 * volume) * eps
    stiffness += volume * lame * np.outer(dilation.conj(), dilation)
    mass = density * volume * np.array([1.0, 1.0, diameter**2 / 8.0])
    squares = np.linalg.eigvalsh(stiffness / np.sqrt(np.outer(mass, mass)))
    return np.sqrt(np.maximum(squares, 0.0))


def rotation_frequency(density: float, shear: float, diameter: float) -> float:
    """Return the frequency at which all automata rotate to and fro in step, sqrt(32 G / rho) / D, of both packings [rad/s]."""
    return math.sqrt(32.0 * shear / density) / diameter


def leapfrog_frequency(frequency: float, step: float) -> float:
    """Return the frequency with which leapfrog integrates an oscillation: sin(w h / 2) = W h / 2 [rad/s].

    Args:
        frequency: W of the exact motion [rad/s].
        step: h, below 2 / W [s].
    """
    if not 0.0 < frequency * step < 2.0:
        raise ParameterError(f"got {step:g} s", expected=f"less than 2 / frequency = {2.0 / frequency:g} s", at="step")
    return 2.0 / step * math.asin(0.5 * frequency * step)
