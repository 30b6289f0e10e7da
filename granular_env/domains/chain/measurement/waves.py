"""Waves that pass a grain: each one's arrival, amplitude, speed and width, the energy and momentum that it carries by."""

from __future__ import annotations

import dataclasses

import numpy as np

from granular_env.components.errors import ParameterError
from granular_env.crests_and_crossings import Crest, crests

from .chain_history import Direction, History, require_history
from .direction import sign

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
        speed: between the crests of the two neighbours (at an end, of the one), in the reference configuration [m/s];
            NaN where no neighbour has such a crest.
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


def waves_at(history: History, grain: int, above: float, separation: float = 1.0, direction: Direction = "right") -> list[Wave]:
    """Return the waves that pass a grain, in the order of their arrival; how many there are is ``len`` of it.

    A wave is a maximum of the grain's velocity. The pulses of Nesterenko (1983), sections 3.1 to 3.4, are counted so.

    Args:
        history: of a chain.
        grain: the first is 0.
        above: the least amplitude that counts, more than 0 [m/s].
        separation: two waves are told apart where the velocity falls below this part of the lower one's amplitude between
            them; 1 counts every maximum.
        direction: which way they run; grains in a wave of compression move the way that it runs.

    Raises:
        ParameterError: a grain that is not there, a threshold that is not positive, another separation or direction.
    """
    require_history("history", history)
    grain, towards = history.grain(grain), sign(direction)
    found = crests(history.time, towards * history.velocity[:, grain], above, separation)
    step = int(towards)
    behind, ahead = (_neighbour(history, grain + offset, towards, above, separation) for offset in (-step, step))
    waves = []
    for crest in found:
        speed = _speed(history, grain, crest, step, behind, ahead)
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


def _neighbour(history: History, grain: int, towards: float, above: float, separation: float) -> list[Crest]:
    if not 0 <= grain < history.grains:
        return []
    return crests(history.time, towards * history.velocity[:, grain], _SAME_WAVE * above, separation)


def _speed(history: History, grain: int, crest: Crest, step: int, behind: list[Crest], ahead: list[Crest]) -> float:
    """Return the mean speed from the last crest before it behind, to the first after it ahead."""
    least = _SAME_WAVE * crest.height
    before = [c.time for c in behind if c.time < crest.time and c.height >= least]
    after = [c.time for c in ahead if c.time > crest.time and c.height >= least]
    first = (grain - step, before[-1]) if before else (grain, crest.time)
    last = (grain + step, after[0]) if after else (grain, crest.time)
    if first[0] == last[0]:
        return float("nan")
    return float(abs(history.position[last[0]] - history.position[first[0]]) / (last[1] - first[1]))


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
    """Energy that a wave carries to its grain: the work of the contact behind it, from minimum to minimum of its force [J].

    Under precompression only the force above the static one counts.

    Raises:
        LogError: overlaps are not known.
        ParameterError: there is no contact behind the grain.
    """
    return _force_integral(history, wave, sign(wave.direction) * history.velocity[:, wave.grain])


def momentum_of(history: History, wave: Wave) -> float:
    """Momentum that a wave carries to its grain, in its direction: the impulse of the contact behind it [kg m/s].

    Args and errors as `energy_of`.
    """
    return _force_integral(history, wave, np.ones(len(history.time)))


def _force_integral(history: History, wave: Wave, factor: np.ndarray) -> float:
    """Integral of force x factor over the wave's pulse of force."""
    place = history.contact_behind(wave.grain, wave.direction)
    force = history.contact_force[:, place] - history.rest_force[place]
    pulse = _pulse(history, force, wave)
    own = slice(*np.searchsorted(history.time, (pulse.begin, pulse.end), side="left") + (0, 1))
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
