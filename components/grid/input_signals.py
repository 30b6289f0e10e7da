"""Signals of the held inputs at nodes with conditions: numbers over time, each times a row of forces or velocities of nodes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..inputs import Held
from ..profiles import CompiledProfile
from ..support.float_arrays import FloatArray
from . import nodal_conditions
from .kernel_setup import Assembly


def make_drive(
    assembly: Assembly, held: Mapping[str, Held], static_force: FloatArray
) -> tuple[list[CompiledProfile], FloatArray]:
    """Return the profiles among the held inputs, and the drive: see `kernel_arrays.Conditions`.

    The first signal is 1 and holds all that does not change; the others are the profiles.

    Args:
        assembly: its nodes with conditions.
        held: the held inputs by name.
        static_force: on each side of the absorbing edges, half of it on each of its nodes, shape (k, 2) [N].
    """
    values = [held[one.variable.name] for one in assembly.inputs]
    profiles = [value for value in values if isinstance(value, CompiledProfile)]
    forces = np.zeros((1 + len(profiles), len(assembly.conditions.nodes), 2))
    velocities = np.zeros_like(forces)
    for end in (0, 1):
        np.add.at(forces[0], assembly.places[assembly.absorbing_sides[:, end]], 0.5 * static_force)
    signal = 0
    for one, value in zip(assembly.inputs, values, strict=True):
        profile = isinstance(value, CompiledProfile)
        signal += profile
        target, row = velocities if one.velocity else forces, signal if profile else 0
        target[row, assembly.places[one.nodes]] += one.act(value.pattern if profile else value)
    flags = assembly.conditions.prescribed > 0
    for row in range(len(forces)):
        led = np.take_along_axis(velocities[row], assembly.leaders, axis=0)
        forces[row] = np.where(flags, led, nodal_conditions.join_rows(forces[row], assembly.places, assembly.joined))
    return profiles, forces


def signal_factors(profiles: list[CompiledProfile], tick: int, ticks: int) -> FloatArray:
    """Return the mean of each signal over each of `ticks` ticks from `tick` on, shape (ticks, 1 + profiles); the first is 1."""
    factors = np.ones((ticks, 1 + len(profiles)))
    for place, profile in enumerate(profiles):
        factors[:, 1 + place] = profile.mean_factors(tick, ticks)
    return factors
