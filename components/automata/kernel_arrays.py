"""Arrays for the kernels: those that are fixed, those that change, and those computed anew in each internal step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..support.float_arrays import FloatArray
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
        shear: G [Pa]; NaN where there are several materials, see `material_mixture.Mixture`.
        lame: lambda = K - 2 G / 3 [Pa]; likewise.
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


def make_body(
    packing: Packing, numbers: npt.NDArray[np.int64], *, density: FloatArray, shear: float, lame: float, thickness: float
) -> Body:
    """Return a packing made of one or several materials.

    Args:
        packing: the automata.
        numbers: material of each automaton, shape (n,).
        density: mass density of each material, shape (materials,) [kg/m^3].
        shear: G [Pa]; NaN of several materials, see `material_mixture.Mixture`.
        lame: lambda [Pa]; likewise.
        thickness: extent along z [m].
    """
    classes, diameter = packing.classes, packing.diameter
    cuts = len(classes.volume)
    cut, kind, of_kind = np.arange(cuts), packing.kind, np.zeros(cuts, np.int64)
    if len(density) > 1:
        # Automata of one kind are cut in the same way, and of one material.
        key, place = np.unique(numbers * cuts + packing.kind, return_inverse=True)
        cut, kind, of_kind = key % cuts, place.reshape(-1).astype(np.int32), key // cuts
    mass = density[of_kind] * classes.volume[cut] * thickness
    return Body(
        neighbours=packing.neighbours,
        kind=kind,
        directions=packing.lattice.directions,
        diameter=diameter,
        face=classes.face[cut] * thickness,
        share=classes.share[cut],
        missing=classes.missing[cut],
        volume=classes.volume[cut] * thickness,
        mass=mass,
        inertia=mass * diameter * diameter / 8.0,
        shear=shear,
        lame=lame,
    )


def make_scratch(count: int) -> Scratch:
    """Return scratch for so many automata."""
    return Scratch(np.zeros((count, 2)), np.zeros(count), np.zeros((count, 2)), np.zeros(count))
