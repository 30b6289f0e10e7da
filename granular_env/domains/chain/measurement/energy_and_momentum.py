"""Energy and momentum of the whole chain: their partition, the momentum carried off, and the detached grains."""

from __future__ import annotations

import dataclasses

import numpy as np

from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray

from .chain_history import History


def kinetic_energy(history: History, piston: bool = True) -> FloatArray:
    """Return the kinetic energy of all grains, shape (T,) [J]; grains of prescribed velocity count only if `piston`."""
    return (0.5 * history.velocity**2 * _masses(history, piston)).sum(axis=1)


def potential_energy(history: History) -> FloatArray:
    """Return the energy of all contacts, without the grains' weight, shape (T,) [J]; `LogError` if it cannot be computed."""
    return history.contact_energy.sum(axis=1)


def momentum(history: History, piston: bool = True) -> FloatArray:
    """Return the momentum of all grains, shape (T,) [kg m/s]; grains of prescribed velocity count only if `piston`."""
    return (history.velocity * _masses(history, piston)).sum(axis=1)


def _masses(history: History, piston: bool) -> FloatArray:
    if piston or history.piston is None:
        return history.mass
    return np.where(history.piston, 0.0, history.mass)


@dataclasses.dataclass(frozen=True, slots=True)
class EnergyRatio:
    """Ratio of the kinetic to the potential energy of a chain in a time window.

    Attributes:
        mean: mean of the ratio over the frames of the window.
        least: smallest ratio in a frame.
        greatest: largest ratio in a frame.
        deviation: largest deviation from the mean, relative to the mean.
    """

    mean: float
    least: float
    greatest: float
    deviation: float


def energy_ratio(history: History, begin: float | None = None, end: float | None = None, piston: bool = True) -> EnergyRatio:
    """Return the ratio of kinetic to potential energy of the chain in a time window (Nesterenko 1983, section 3.4).

    For contact forces F = k d^p the virial theorem gives (p + 1)/2, i.e. 1.25 for Hertz's law.

    Args:
        history: history of a chain, with overlaps.
        begin: start of the window [s]; default the first frame.
        end: end of the window [s]; default the last frame.
        piston: whether the kinetic energy of a piston counts.

    Raises:
        ParameterError: a time outside the history, or a frame in which no contact is compressed.
        LogError: overlaps are unknown.
    """
    window = history.window(begin, end)
    potential = potential_energy(history)[window]
    if not (potential > 0.0).all():
        at = float(history.time[window][int(np.argmin(potential))])
        raise ParameterError(f"begin, end: no contact is compressed at {at:g} s", expected="a window with stored energy")
    ratio = kinetic_energy(history, piston)[window] / potential
    mean = float(ratio.mean())
    least, greatest = float(ratio.min()), float(ratio.max())
    return EnergyRatio(mean, least, greatest, max(greatest - mean, mean - least) / mean)


def momentum_carried_off(history: History, time: float | None = None) -> float:
    """Return the momentum of the grains that move backwards, as a fraction of the initial momentum (section 3.1).

    Args:
        history: history of a chain with non-zero initial momentum.
        time: time of the measurement [s]; default the last frame.

    Raises:
        ParameterError: the time is outside the history, or the momentum of the first frame is 0.
    """
    frame = len(history.time) - 1 if time is None else history.frame_number(time)
    start = float(momentum(history)[0])
    scale = float((np.abs(history.velocity[0]) * history.mass).sum())
    if not abs(start) > 1e-12 * scale:
        raise ParameterError("the momentum of the chain in its first frame is zero", at="history")
    own = history.mass * history.velocity[frame] * np.sign(start)
    return float(-own[own < 0.0].sum() / abs(start))


def detached_grains(history: History, time: float | None = None) -> np.ndarray:
    """Return the numbers of the grains with a gap on both sides, at a time [s]; default the last frame.

    Grains that just touch are not detached.

    Raises:
        ParameterError: the time is outside the history.
        LogError: overlaps are not known.
    """
    frame = len(history.time) - 1 if time is None else history.frame_number(time)
    touching = (history.overlap[frame] >= 0.0) & (history.stiffness > 0.0)
    return np.flatnonzero(~(touching[:-1] | touching[1:]))
