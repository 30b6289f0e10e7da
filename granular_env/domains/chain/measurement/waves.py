"""Waves that pass a grain: arrival, amplitude, speed, width, and the energy and momentum carried by each."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from granular_env.components.errors import ParameterError
from granular_env.components.support.validation import whole_number
from granular_env.crests_and_crossings import Crest, crests

from .chain_history import Direction, History, direction_sign, require_history

# A crest of a neighbour's velocity belongs to the same wave only if it is at least this fraction of the wave's amplitude.
_SAME_WAVE = 0.5


@dataclasses.dataclass(frozen=True, slots=True)
class Wave:
    """A wave as it passes a grain.

    Attributes:
        grain: number of the grain; the first is 0.
        direction: direction in which the wave runs, "right" or "left".
        time: time at which the grain's velocity has its crest (maximum) [s].
        amplitude: largest velocity of the grain in the wave's direction, v_m [m/s].
        speed: distance of the two neighbours (at an end of the chain: of the grain and its neighbour) in the reference
            configuration over the time between their crests [m/s]; NaN if these cannot be paired, see `waves_at`.
        duration: time for which the velocity exceeds half the amplitude [s]; NaN if it does not fall below half.
        width: duration x speed, full width at half the amplitude [m].
        begin: start of the wave: time of the smallest velocity since the previous crest, or of the last not positive [s].
        end: end of the wave: time of the smallest velocity before the next crest, or of the first not positive [s].
    """

    grain: int
    direction: Direction
    time: float
    amplitude: float
    speed: float
    duration: float
    width: float
    begin: float
    end: float


def waves_at(
    history: History, grain: int, above: float, separation: float = 1.0, direction: Direction = "right", period: int = 1
) -> list[Wave]:
    """Return the waves that pass a grain, in the order of their arrival.

    A wave is a maximum of the grain's velocity, as in the pulse counts of Nesterenko (1983), sections 3.1 to 3.4.

    Args:
        history: history of a chain.
        grain: the first is 0.
        above: smallest amplitude that counts, greater than 0 [m/s].
        separation: two maxima are separate waves if the velocity between them falls below this fraction of the lower
            amplitude; 1 counts every maximum.
        direction: direction in which the waves run; in a compression wave, grains move in the same direction.
        period: number of grains behind and ahead between which the speed is measured. For a periodic chain, give the number
            of grains per cell, so that equal grains are compared: unequal grains move differently in the same wave.

    The k-th crest of a neighbour is paired with the grain's k-th crest. The speed is NaN unless this crest is earlier at the
    neighbour behind and later at the neighbour ahead. A light grain between heavy ones has two or more crests in one pulse;
    ``separation=0.5`` counts them as one if the velocity between them does not fall below half of the lower crest.

    Raises:
        ParameterError: an unknown grain, a threshold that is not positive, an invalid separation or direction, or a period
            below 1.
    """
    require_history("history", history)
    grain, towards, period = history.valid_grain(grain), direction_sign(direction), whole_number("period", period, 1)
    found = crests(history.time, towards * history.velocity[:, grain], above, separation)
    step = int(towards) * period
    behind, ahead = (_neighbour_crests(history, grain + offset, towards, above, separation) for offset in (-step, step))
    waves = []
    for crest in found:
        speed = _wave_speed(history, grain, step, crest, (behind, found, ahead))
        waves.append(
            Wave(
                grain,
                direction,
                crest.time,
                crest.height,
                speed,
                crest.duration,
                crest.duration * speed,
                crest.begin,
                crest.end,
            )  # fmt: skip
        )
    return waves


def _neighbour_crests(history: History, grain: int, towards: float, above: float, separation: float) -> list[Crest] | None:
    """Return the crests of the velocity of grain number `grain`; None if that is beyond the end of the chain."""
    if not 0 <= grain < history.grains:
        return None
    return crests(history.time, towards * history.velocity[:, grain], _SAME_WAVE * above, separation)


def _wave_speed(
    history: History, grain: int, step: int, crest: Crest, crests: tuple[list[Crest] | None, list[Crest], list[Crest] | None]
) -> float:
    """Return the speed from the times of a wave's crest in `crests` (neighbour behind, grain, neighbour ahead), or NaN."""
    behind, own, ahead = crests

    def crest_times(found: list[Crest]) -> list[float]:
        return [one.time for one in found if one.height >= _SAME_WAVE * crest.height]

    def arrival_time(found: list[Crest], lead: int) -> float:
        """Return the time of the crest at a neighbour; NaN unless exactly `lead` more than at the grain have passed there."""
        others = crest_times(found)
        passed = sum(time < crest.time for time in others)
        return others[number] if passed == number + lead and number < len(others) else math.nan

    number = crest_times(own).index(crest.time)
    first, begin = (grain, crest.time) if behind is None else (grain - step, arrival_time(behind, 1))
    last, end = (grain, crest.time) if ahead is None else (grain + step, arrival_time(ahead, 0))
    if first == last:
        return math.nan
    return float(abs(history.position[last] - history.position[first]) / (end - begin))


def overlap_of(history: History, wave: Wave) -> Crest:
    """Return the pulse of the overlap, minus that at rest, in the contact behind a wave's grain: a `Crest` in m and s.

    Its ``duration`` times the wave's ``speed`` is the full width at half maximum of the overlap, the width used by the theory.

    Raises:
        LogError: overlaps are not known.
        ParameterError: there is no contact behind the grain.
    """
    place = history.contact_behind(wave.grain, wave.direction)
    return _matching_crest(history, history.overlap[:, place] - max(history.rest_overlap[place], 0.0), wave)


def _matching_crest(history: History, values: np.ndarray, wave: Wave) -> Crest:
    """Return the crest of a contact's curve that belongs to a wave: the last before (or just after) the velocity's crest."""
    largest = float(np.max(values))
    if largest > 0.0:
        found = [c for c in crests(history.time, values, 1e-3 * largest) if c.begin <= wave.time and c.end >= wave.begin]
        found = [c for c in found if c.time <= wave.time] or found
        if found:
            return max(found, key=lambda c: (c.time, c.height))
    raise ParameterError(f"the contact behind grain {wave.grain} is not compressed at {wave.time:g} s", at="wave")


def energy_of(history: History, wave: Wave) -> float:
    """Return the energy that a wave transmits to its grain: the work of the contact behind the grain [J].

    The work is integrated between two minima of the contact force. If the grain's velocity does not fall to 0 between two
    crests, the integral ends at the velocity's minimum, so that each crest has its part of the energy of the force pulse.
    Under precompression only the force above that at rest counts.

    Raises:
        LogError: overlaps are not known.
        ParameterError: there is no contact behind the grain.
    """
    return _force_integral(history, wave, direction_sign(wave.direction) * history.velocity[:, wave.grain])


def momentum_of(history: History, wave: Wave) -> float:
    """Return the momentum that a wave transmits to its grain, in its direction: the impulse of the contact behind [kg m/s].

    The interval and the errors are those of `energy_of`.
    """
    return _force_integral(history, wave, np.ones(len(history.time)))


def _force_integral(history: History, wave: Wave, factor: np.ndarray) -> float:
    """Return the time integral of `factor` times the force (minus that at rest) behind the wave's grain, over its pulse."""
    place = history.contact_behind(wave.grain, wave.direction)
    force = history.contact_force[:, place] - history.rest_force[place]
    pulse = _matching_crest(history, force, wave)
    velocity = direction_sign(wave.direction) * history.velocity[:, wave.grain]
    # Limits: those of the force pulse where the velocity falls to 0, otherwise the velocity's minimum between two crests.
    shared = velocity[np.searchsorted(history.time, (wave.begin, wave.end))] > 0.0
    ends = np.where(shared, (wave.begin, wave.end), (pulse.begin, pulse.end))
    own = slice(*np.searchsorted(history.time, ends) + (0, 1))
    return float(np.trapezoid(force[own] * factor[own], history.time[own]))


@dataclasses.dataclass(frozen=True, slots=True)
class Shift:
    """The change of a wave by a collision: how much earlier it arrives [s], and the relative change of its amplitude."""

    advance: float
    amplitude_change: float


def phase_shifts(
    history: History, reference: History, grain: int, above: float, separation: float = 1.0, direction: Direction = "right"
) -> list[Shift]:
    """Return for each wave at a grain its shift relative to a run without a collision (Nesterenko 1983, section 3.2).

    Waves are paired in the order of arrival; surplus waves of one run are ignored.

    Args:
        history: run with a collision.
        reference: run without the collision.
        grain: the first is 0.
        above: smallest amplitude that counts [m/s].
        separation: as in `waves_at`.
        direction: as in `waves_at`.

    Raises:
        ParameterError: no wave passes the grain in one of the runs; or as `waves_at`.
    """
    require_history("history", history)
    require_history("reference", reference)
    seen = [waves_at(run, grain, above, separation, direction) for run in (history, reference)]
    for name, waves in zip(("history", "reference"), seen, strict=True):
        if not waves:
            raise ParameterError(
                f"no wave above {above:g} m/s passes grain {grain}", hint="lower the threshold or run longer", at=name
            )
    return [Shift(old.time - new.time, new.amplitude / old.amplitude - 1.0) for new, old in zip(*seen, strict=False)]
