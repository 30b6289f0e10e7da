"""Arrays for the kernels: those that are fixed, those that change, and those computed anew in each internal step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.arrays import FloatArray
from .packing import Packing


class Body(NamedTuple):
    """The automata as they are packed and what they are made of; constant. SI units.

    Attributes:
        neighbours: of each automaton in each slot, itself where there is none, shape (n, slots), int32.
        kind: row of each automaton in the tables of this tuple, shape (n,), int32.
        directions: unit vectors to the neighbours before anything moves, shape (slots, 2).
        diameter: distance of neighbours [m].
        face: area of the face in each slot, 0 without a neighbour, shape (kinds, slots) [m^2].
        share: what the strain in each slot adds to the volumetric strain, shape (kinds, slots).
        missing: share of the free faces of a whole cell, shape (kinds,).
        volume: shape (kinds,) [m^3].
        mass: shape (kinds,) [kg].
        inertia: moment of inertia about the centre, m D^2 / 8, shape (kinds,) [kg m^2].
        shear: G [Pa].
        lame: lambda = K - 2 G / 3 [Pa].
    """

    neighbours: npt.NDArray[np.int32]
    kind: npt.NDArray[np.int32]
    directions: FloatArray
    diameter: float
    face: FloatArray
    share: FloatArray
    missing: FloatArray
    volume: FloatArray
    mass: FloatArray
    inertia: FloatArray
    shear: float
    lame: float


class Motion(NamedTuple):
    """The state that every packing has.

    Attributes:
        displacement: shape (n, 2) [m].
        velocity: shape (n, 2) [m/s].
        rotation: angles, counter-clockwise, shape (n,) [rad].
        spin: angular velocities, shape (n,) [rad/s].
    """

    displacement: FloatArray
    velocity: FloatArray
    rotation: FloatArray
    spin: FloatArray


class Scratch(NamedTuple):
    """Arrays that a force evaluation leaves behind.

    Attributes:
        half: cos - 1 and sin of half the rotation, shape (n, 2).
        dilation: volumetric strains theta, shape (n,).
        force: on each automaton, shape (n, 2) [N].
        torque: on each automaton, shape (n,) [N m].
    """

    half: FloatArray
    dilation: FloatArray
    force: FloatArray
    torque: FloatArray


def make_body(packing: Packing, *, density: float, shear: float, lame: float, thickness: float) -> Body:
    """Return a packing made of a material.

    Args:
        packing: the automata.
        density: mass density [kg/m^3].
        shear: G [Pa].
        lame: lambda [Pa].
        thickness: extent along z [m].
    """
    classes, diameter = packing.classes, packing.diameter
    mass = density * classes.volume * thickness
    return Body(
        neighbours=packing.neighbours,
        kind=packing.kind,
        directions=packing.lattice.directions,
        diameter=diameter,
        face=classes.face * thickness,
        share=classes.share,
        missing=classes.missing,
        volume=classes.volume * thickness,
        mass=mass,
        inertia=mass * diameter * diameter / 8.0,
        shear=shear,
        lame=lame,
    )


def make_scratch(count: int) -> Scratch:
    """Return scratch for so many automata."""
    return Scratch(np.zeros((count, 2)), np.zeros(count), np.zeros((count, 2)), np.zeros(count))
