"""What held inputs do to the nodes with conditions: signals of time, each times a force or a velocity for each node."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..inputs import Held
from ..profiles import CompiledProfile
from ..support.arrays import FloatArray
from . import conditions
from .assembly import Assembly
from .conditions import EdgeInput
from .mesh import IntArray


def make_drive(assembly: Assembly, held: Mapping[str, Held]) -> tuple[list[CompiledProfile], FloatArray]:
    """Return the profiles among the held inputs, and the drive: see `layout.Conditions`.

    The first signal is 1 and holds all that does not change; the others are the profiles.
    """
    values = [held[one.variable.name] for one in assembly.inputs]
    profiles = [value for value in values if isinstance(value, CompiledProfile)]
    forces = np.zeros((1 + len(profiles), len(assembly.conditions.nodes), 2))
    velocities = np.zeros_like(forces)
    signal = 0
    for one, value in zip(assembly.inputs, values, strict=True):
        profile = isinstance(value, CompiledProfile)
        signal += profile
        row, places = signal if profile else 0, assembly.places[one.nodes]
        given = one.act(value.pattern if profile else value)
        if one.velocity:
            _prescribe(velocities[row], assembly, one, places, given)
        else:
            forces[row, places] += given
    flags = assembly.conditions.prescribed > 0
    for row in range(len(forces)):
        shared = conditions.join_rows(forces[row], assembly.places, assembly.joined)
        forces[row] = np.where(flags, _share_velocities(velocities[row], assembly), shared)
    return profiles, forces


def _prescribe(target: FloatArray, assembly: Assembly, one: EdgeInput, places: IntArray, given: FloatArray) -> None:
    """Write velocities where this edge is the one that prescribes them."""
    edge = one.variable.name.removesuffix("_velocity")
    for component in (0, 1):
        own = [assembly.prescribed.get(node, {}).get(component) == edge for node in one.nodes.tolist()]
        target[places[own], component] = given[own, component]


def _share_velocities(velocities: FloatArray, assembly: Assembly) -> FloatArray:
    """Return velocities with those of joined nodes set to the one that is prescribed for the first of them."""
    shared = velocities.copy()
    for group in assembly.joined:
        members = group[group >= 0]
        for component in (0, 1):
            own = [node for node in members.tolist() if component in assembly.prescribed.get(node, {})]
            if own:
                shared[assembly.places[members], component] = velocities[assembly.places[own[0]], component]
    return shared


def signal_factors(profiles: list[CompiledProfile], tick: int, ticks: int) -> FloatArray:
    """Return the signals in the middle of each of so many ticks, shape (ticks, 1 + profiles); the first is 1."""
    factors = np.ones((ticks, 1 + len(profiles)))
    for place, profile in enumerate(profiles):
        factors[:, 1 + place] = _profile_factors(profile, tick, ticks)
    return factors


def _profile_factors(profile: CompiledProfile, tick: int, ticks: int) -> FloatArray:
    now = np.arange(tick, tick + ticks)
    piece = np.searchsorted(profile.ticks, now, side="right") - 1
    rows = profile.coefficients[np.maximum(piece, 0)]
    since = (now - profile.ticks[np.maximum(piece, 0)]).astype(np.float64) + 0.5
    value = np.zeros(ticks)
    for power in range(rows.shape[1] - 1, -1, -1):
        value = value * since + rows[:, power]
    return np.where(piece < 0, 0.0, value)
