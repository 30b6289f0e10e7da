"""Waves that pass a grain: each one's arrival, amplitude, speed and width, the energy and momentum that it carries by."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from granular_env.components.errors import ParameterError
from granular_env.components.support.validation import whole_number
from granular_env.crests_and_crossings import Crest, crests

from .chain_history import Direction, History, require_history, sign

# A crest at a neighbour is the same wave only if it is at least so high, in the wave's amplitude.
_SAME_WAVE = 0.5


@dataclasses.dataclass(frozen=True, slots=True)
class Wave:
    """A wave as it passes a grain.

    Attributes:
        grain: which one, the first is 0.
        direction: "right" or "left".
        time: arrival of the crest of the grain's velocity [s].
        amplitude: largest velocity of the grain in the wave's direction, v_m [m/s].
        speed: from the crest of the neighbour behind to that of the neighbour ahead (at an end of the chain: to or from the
            grain's own crest), in the reference configuration [m/s]; NaN where they do not show the same crest, see `waves_at`.
        duration: how long the velocity is above half the amplitude [s]; NaN where it does not fall so far.
        width: duration x speed, full width at half the amplitude [m].
        begin: time of the minimum of the velocity before the crest, or of its last sample that is not positive [s].
        end: the same after it [s].
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
    """Return the waves that pass a grain, in the order of their arrival; how many there are is ``len`` of it.

    A wave is a maximum of the grain's velocity. The pulses of Nesterenko (1983), sections 3.1 to 3.4, are counted so.

    Args:
        history: of a chain.
        grain: the first is 0.
        above: the least amplitude that counts, more than 0 [m/s].
        separation: two waves are told apart where the velocity falls below this part of the lower one's amplitude between
            them; 1 counts every maximum.
        direction: which way they run; grains in a wave of compression move the way that it runs.
        period: the speed is measured between the grains so many places behind and ahead. In a chain of equal cells give the
            number of grains in a cell, so that like grains are compared: unlike ones move differently in the same wave.

    The speed is NaN where the two neighbours do not show a crest of the same number, one before and one after that of the
    grain. A light grain between heavy ones has two crests or more in one pulse; ``separation=0.5`` counts them as one if the
    velocity does not fall below half of the lower one between them.

    Raises:
        ParameterError: a grain that is not there, a threshold that is not positive, another separation or direction, a period
            below 1.
    """
    require_history("history", history)
    grain, towards, period = history.grain(grain), sign(direction), whole_number("period", period, 1)
    found = crests(history.time, towards * history.velocity[:, grain], above, separation)
    step = int(towards) * period
    behind, ahead = (_neighbour(history, grain + offset, towards, above, separation) for offset in (-step, step))
    waves = []
    for crest in found:
        speed = _speed(history, grain, step, crest, (behind, found, ahead))
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


def _neighbour(history: History, grain: int, towards: float, above: float, separation: float) -> list[Crest] | None:
    """Return the crests of a neighbour; None beyond the end of the chain."""
    if not 0 <= grain < history.grains:
        return None
    return crests(history.time, towards * history.velocity[:, grain], _SAME_WAVE * above, separation)


def _speed(
    history: History, grain: int, step: int, crest: Crest, seen: tuple[list[Crest] | None, list[Crest], list[Crest] | None]
) -> float:
    """Return the mean speed between the crests of the same number in `seen`: behind, at the grain, and ahead; or NaN."""
    behind, own, ahead = seen

    def times(found: list[Crest]) -> list[float]:
        return [one.time for one in found if one.height >= _SAME_WAVE * crest.height]

    def arrival(found: list[Crest], lead: int) -> float:
        """Return the time of the crest of the same number, if by now `lead` crests more have passed than before here."""
        others = times(found)
        passed = sum(time < crest.time for time in others)
        return others[number] if passed == number + lead and number < len(others) else math.nan

    number = times(own).index(crest.time)
    first, begin = (grain, crest.time) if behind is None else (grain - step, arrival(behind, 1))
    last, end = (grain, crest.time) if ahead is None else (grain + step, arrival(ahead, 0))
    if first == last:
        return math.nan
    return float(abs(history.position[last] - history.position[first]) / (end - begin))


def overlap_of(history: History, wave: Wave) -> Crest:
    """Return the overlap in the contact behind a wave's grain, above the static one, as the wave passes: a `Crest` in m and s.

    Its ``duration`` x the wave's ``speed`` is the full width at half maximum of the overlap, the theory's width.

    Raises:
        LogError: overlaps are not known.
        ParameterError: there is no contact behind the grain.
    """
    place = history.contact_behind(wave.grain, wave.direction)
    return _pulse(history, history.overlap[:, place] - max(history.rest_overlap[place], 0.0), wave)


def _pulse(history: History, values: np.ndarray, wave: Wave) -> Crest:
    """Return the crest of a curve that belongs to a wave: the last one before the velocity's crest; a contact lags slightly."""
    largest = float(np.max(values))
    if largest > 0.0:
        found = [c for c in crests(history.time, values, 1e-3 * largest) if c.begin <= wave.time and c.end >= wave.begin]
        found = [c for c in found if c.time <= wave.time] or found
        if found:
            return max(found, key=lambda c: (c.time, c.height))
    raise ParameterError(f"the contact behind grain {wave.grain} is not pressed at {wave.time:g} s", at="wave")


def energy_of(history: History, wave: Wave) -> float:
    """Return the energy that a wave carries to its grain: the work of the contact behind it [J].

    The work is counted from minimum to minimum of the contact's force; where the grain's velocity does not fall to 0 between
    two crests, up to its minimum between them, so that crests that share a pulse of force share its energy. Under
    precompression only the force above the static one counts.

    Raises:
        LogError: overlaps are not known.
        ParameterError: there is no contact behind the grain.
    """
    return _force_integral(history, wave, sign(wave.direction) * history.velocity[:, wave.grain])


def momentum_of(history: History, wave: Wave) -> float:
    """Return the momentum that a wave carries to its grain, in its direction: the impulse of the contact behind it [kg m/s].

    The interval and the errors are those of `energy_of`.
    """
    return _force_integral(history, wave, np.ones(len(history.time)))


def _force_integral(history: History, wave: Wave, factor: np.ndarray) -> float:
    """Integral of force x factor over the wave's pulse of force."""
    place = history.contact_behind(wave.grain, wave.direction)
    force = history.contact_force[:, place] - history.rest_force[place]
    pulse = _pulse(history, force, wave)
    velocity = sign(wave.direction) * history.velocity[:, wave.grain]
    # A crest ends at 0, or at the minimum before the next crest.
    shared = velocity[np.searchsorted(history.time, (wave.begin, wave.end))] > 0.0
    ends = np.where(shared, (wave.begin, wave.end), (pulse.begin, pulse.end))
    own = slice(*np.searchsorted(history.time, ends) + (0, 1))
    return float(np.trapezoid(force[own] * factor[own], history.time[own]))


@dataclasses.dataclass(frozen=True, slots=True)
class Shift:
    """The change of a wave: how much earlier it arrives [s], and its amplitude's relative change."""

    advance: float
    amplitude_change: float


def phase_shifts(
    history: History, reference: History, grain: int, above: float, separation: float = 1.0, direction: Direction = "right"
) -> list[Shift]:
    """Return how waves arrive at a grain, against a run in which nothing happened to them (Nesterenko 1983, section 3.2).

    The first wave is compared with the first, the second with the second, as many as both have.

    Args:
        history: the run with a collision.
        reference: the run without.
        grain: the first is 0.
        above: the least amplitude that counts [m/s].
        separation: as in `waves_at`.
        direction: as in `waves_at`.

    Raises:
        ParameterError: no wave passes the grain in one of them; or as `waves_at`.
    """
    require_history("history", history)
    require_history("reference", reference)
    seen = [waves_at(run, grain, above, separation, direction) for run in (history, reference)]
    for name, waves in zip(("history", "reference"), seen, strict=True):
        if not waves:
            raise ParameterError(
                f"no wave above {above:g} m/s passes grain {grain}", hint="lower the threshold or look longer", at=name
            )
    return [Shift(old.time - new.time, new.amplitude / old.amplitude - 1.0) for new, old in zip(*seen, strict=False)]
