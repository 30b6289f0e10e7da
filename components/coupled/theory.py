"""Plane waves at normal incidence on the interface: reflection by two materials, and by grid and packing of one material.

No step calls these.
"""

from __future__ import annotations

import math

from ..automata.theory import lattice_frequencies
from ..grid.theory import mesh_frequencies
from ..materials.elastic import Material


def reflection(first: Material, second: Material, *, shear: bool = False) -> float:
    """Return the velocity amplitude of the reflected wave over that of the incident wave from `first`.

    (Z1 - Z2) / (Z1 + Z2) with Z = density x speed, for P or S waves that are long compared with cells and automata.
    """
    one, two = (material.density * _wave_speed(material, shear) for material in (first, second))
    return (one - two) / (one + two)


def transmission(first: Material, second: Material, *, shear: bool = False) -> float:
    """Return the velocity amplitude of the transmitted wave in `second` over that of the incident wave from `first`."""
    return 1.0 + reflection(first, second, shear=shear)


def grid_speed(material: Material, wavelength: float, cell_size: float, *, shear: bool = False) -> float:
    """Return the phase speed of a wave along an axis of a grid of square cells, for exact time integration [m/s].

    Args:
        material: the material of the cells.
        wavelength: [m].
        cell_size: length of a cell along the wave [m].
        shear: whether it is an S wave.
    """
    number = 2.0 * math.pi / wavelength
    return mesh_frequencies((number, 0.0), cell_size, material)[int(shear)] / number


def automata_speed(
    material: Material, wavelength: float, diameter: float, packing: str, *, axis: str = "x", shear: bool = False
) -> float:
    """Return the phase speed of a wave along an axis of a packing, for exact time integration [m/s].

    Args:
        material: of the automata.
        wavelength: [m].
        diameter: of the automata [m].
        packing: "square" or "hexagonal".
        axis: direction of propagation; rows of the hexagonal packing lie along x.
        shear: whether it is an S wave.
    """
    number, slow = 2.0 * math.pi / wavelength, _wave_speed(material, shear)
    vector = (number, 0.0) if axis == "x" else (0.0, number)
    frequencies = lattice_frequencies(
        packing, vector, density=material.density, shear=material.shear_modulus, lame=material.first_lame, diameter=diameter
    )
    return min((float(one) / number for one in frequencies), key=lambda speed: abs(speed - slow))


def lattice_reflection(
    material: Material, wavelength: float, cell_size: float, diameter: float, packing: str, *, axis: str = "x",
    shear: bool = False,
) -> float:  # fmt: skip
    """Return an estimate of the reflection coefficient between grid and automata of one material; it falls as wavelength^-2.

    The estimate is (c1 - c2) / (c1 + c2) with the phase speeds of grid and automata, as for two continua with these speeds. It
    ignores the arrangement of automata next to the interface. Measured reflections are 1.1 (P) and 1.7 (S) times the estimate
    for the square packing, 3 and 0.6 times for hexagonal rows, 1.2 and 2.3 times for hexagonal zigzags. If automata are smaller
    than cells, up to (2 pi cell_size / wavelength)^2 / 16 is reflected: masses h apart have the impedance Z cos(k h / 2).
    """
    one = grid_speed(material, wavelength, cell_size, shear=shear)
    two = automata_speed(material, wavelength, diameter, packing, axis=axis, shear=shear)
    return (one - two) / (one + two)


def _wave_speed(material: Material, shear: bool) -> float:
    return material.shear_speed if shear else material.longitudinal_speed
