"""Energy and momentum of the whole chain: how they are shared, what is carried off, and which grains have come loose."""

from __future__ import annotations

import dataclasses

import numpy as np

from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray

from .chain_history import History


def kinetic_energy(history: History, piston: bool = True) -> FloatArray:
    """Return that of all grains, shape (T,) [J]; without those whose velocity is prescribed unless `piston`."""
    return (0.5 * history.velocity**2 * _masses(history, piston)).sum(axis=1)


def potential_energy(history: History) -> FloatArray:
    """Return that of all contacts, without the grains' weight, shape (T,) [J]; `LogError` where frames do not tell it."""
    return history.contact_energy.sum(axis=1)


def momentum(history: History, piston: bool = True) -> FloatArray:
    """Return that of all grains, shape (T,) [kg m/s]; without those whose velocity is prescribed unless `piston`."""
    return (history.velocity * _masses(history, piston)).sum(axis=1)


def _masses(history: History, piston: bool) -> FloatArray:
    if piston or history.piston is None:
        return history.mass
    return np.where(history.piston, 0.0, history.mass)


@dataclasses.dataclass(frozen=True, slots=True)
class EnergyRatio:
    """Ek/Ep in a window of time.

    Attributes:
        mean: over its frames.
        least: in any of its frames.
        greatest: in any of its frames.
        deviation: the farthest from the mean, relative to it.
    """

    mean: float
    least: float
    greatest: float
    deviation: float


def energy_ratio(history: History, begin: float | None = None, end: float | None = None, piston: bool = True) -> EnergyRatio:
    """Kinetic over potential energy of the chain, in a window of time (Nesterenko 1983, section 3.4).

    The virial theorem gives (p + 1)/2 for F = k d^p: 1.25 for Hertz's law.

    Args:
        history: of a chain, with overlaps.
        begin: of the window [s]; default the first frame.
        end: of the window [s]; default the last frame.
        piston: whether the kinetic energy of a piston counts.

    Raises:
        ParameterError: a time outside of the history, or a frame in which no contact is pressed.
        LogError: overlaps are not known.
    """
    window = history.window(begin, end)
    potential = potential_energy(history)[window]
    if not (potential > 0.0).all():
        at = float(history.time[window][int(np.argmin(potential))])
        raise ParameterError(f"begin, end: no contact is pressed at {at:g} s", expected="a window in which energy is stored")
    ratio = kinetic_energy(history, piston)[window] / potential
    mean = float(ratio.mean())
    least, greatest = float(ratio.min()), float(ratio.max())
    return EnergyRatio(mean, least, greatest, max(greatest - mean, mean - least) / mean)


def momentum_carried_off(history: History, time: float | None = None) -> float:
    """Momentum of the grains that move backwards, as a part of the chain's at the first frame (section 3.1).

    Args:
        history: of a chain whose momentum at the start is not 0.
        time: when to look [s]; default the last frame.

    Raises:
        ParameterError: the time is outside of the history, or there was no momentum at its first frame.
    """
    frame = len(history.time) - 1 if time is None else history.frame(time)
    start = float(momentum(history)[0])
    scale = float((np.abs(history.velocity[0]) * history.mass).sum())
    if not abs(start) > 1e-12 * scale:
        raise ParameterError("the chain has no momentum at its first frame, of which a part could be carried off", at="history")
    own = history.mass * history.velocity[frame] * np.sign(start)
    return float(-own[own < 0.0].sum() / abs(start))


def detached_grains(history: History, time: float | None = None) -> np.ndarray:
    """Numbers of the grains with a gap on either side, at a time [s]; default the last frame.

    Grains that rest side by side, just touching, are not detached.

    Raises:
        ParameterError: the time is outside of the history.
        LogError: overlaps are not known.
    """
    frame = len(history.time) - 1 if time is None else history.frame(time)
    touching = (history.overlap[frame] >= 0.0) & (history.stiffness > 0.0)
    return np.flatnonzero(~(touching[:-1] | touching[1:]))
