"""The front of a wave or shock in a chain: arrival times, position, speed, and the pressure behind it."""

from __future__ import annotations

import dataclasses

import numpy as np

from granular_env.components.errors import ParameterError
from granular_env.components.support.float_arrays import FloatArray
from granular_env.components.support.validation import positive_number
from granular_env.crests_and_crossings import crests, crossing_time

from .chain_history import Direction, History, direction_sign


def arrivals(history: History, above: float, direction: Direction = "right") -> FloatArray:
    """Return the time at which each grain's velocity first exceeds a threshold, shape (n,) [s]; NaN if it never does.

    A grain above the threshold in the first frame gets the time of that frame.

    Args:
        history: history of a chain.
        above: velocity threshold, greater than 0 [m/s].
        direction: the sign of the velocities that count.

    Raises:
        ParameterError: a threshold that is not positive, or an unknown direction.
    """
    above, velocity = positive_number("above", above), direction_sign(direction) * history.velocity
    passed = velocity > above
    found = np.full(history.grains, np.nan)
    for grain in np.flatnonzero(passed.any(axis=0)):
        frame = int(np.argmax(passed[:, grain]))
        found[grain] = crossing_time(history.time, velocity[:, grain], frame - 1, above) if frame else history.time[0]
    return found


def front_position(history: History, above: float, direction: Direction = "right") -> FloatArray:
    """Return the position of the front, where velocities first exceed a threshold, in the reference configuration, (T,) [m].

    The position is interpolated linearly in time between two grains. It is NaN before the first arrival and never decreases.

    Arguments and errors as for `arrivals`.
    """
    order = slice(None) if direction_sign(direction) > 0.0 else slice(None, None, -1)
    seen = arrivals(history, above, direction)[order]
    # A grain counts as reached as soon as any grain ahead of it is.
    passed = np.fmin.accumulate(seen[::-1])[::-1]
    there = np.isfinite(passed)
    if not there.any():
        return np.full(len(history.time), np.nan)
    return np.interp(history.time, passed[there], history.position[order][there], left=np.nan)


def front_speed(history: History, above: float, first: int, last: int, direction: Direction = "right") -> float:
    """Return the mean speed of the front between two grains, in the reference configuration [m/s].

    Args:
        history: history of a chain.
        above: velocity threshold that defines the front [m/s].
        first: grain at the start of the path.
        last: grain at the end of the path.
        direction: direction in which the front runs.

    Raises:
        ParameterError: an unknown grain or one that the front did not reach; or as `arrivals`.
    """
    first, last = history.valid_grain(first, "first"), history.valid_grain(last, "last")
    seen = arrivals(history, above, direction)
    for name, grain in (("first", first), ("last", last)):
        if np.isnan(seen[grain]):
            raise ParameterError(f"the front above {above:g} m/s does not reach grain {grain}", hint="run longer", at=name)
    if not (last - first) * direction_sign(direction) > 0.0 or not seen[last] > seen[first]:
        raise ParameterError(f"first, last: got {first} and {last}", expected="two grains that the front reaches in this order")
    return float(abs(history.position[last] - history.position[first]) / (seen[last] - seen[first]))


@dataclasses.dataclass(frozen=True, slots=True)
class PressureRatio:
    """The first maximum of the contact force at a front, and the settled force behind it.

    Attributes:
        first_maximum: first maximum of the contact force at the front, p_m [N].
        settled: mean contact force near the driven end, p_c [N].
    """

    first_maximum: float
    settled: float

    @property
    def ratio(self) -> float:
        """p_m / p_c."""
        return self.first_maximum / self.settled


def pressure_ratio(history: History, grain: int, near: int | None = None, direction: Direction = "right") -> PressureRatio:
    """Return the first maximum of the force behind a grain, and the mean force near the driven end from that time on.

    Nesterenko (1983), section 3.4, gives p_m/p_c = 2.24 for the front at grain 50. All grains are equal there, so that the
    ratio of the pressures is that of the contact forces.

    Args:
        history: history of a chain, with overlaps.
        grain: grain at which the front's first maximum is measured.
        near: grain whose rear contact gives the settled force; default the second from the driven end.
        direction: direction in which the front runs.

    Raises:
        ParameterError: an unknown grain or one without a contact behind it, no maximum, or no frames after the maximum.
        LogError: overlaps are unknown.
    """
    default = min(1, history.grains - 1) if direction_sign(direction) > 0.0 else max(history.grains - 2, 0)
    place = history.contact_behind(grain, direction)
    settled = history.contact_behind(default if near is None else history.valid_grain(near, "near"), direction)
    force = history.contact_force
    largest = float(force[:, place].max())
    found = crests(history.time, force[:, place], 0.5 * largest) if largest > 0.0 else []
    after = history.time > found[0].time if found else np.zeros(0, dtype=bool)
    if not after.any():
        raise ParameterError(f"the force behind grain {grain} has no maximum in this history", hint="run longer", at="grain")
    mean = float(force[after, settled].mean())
    if not mean > 0.0:
        raise ParameterError(
            f"the contact behind this grain carries no force after {found[0].time:g} s", expected="a driven chain", at="near"
        )
    return PressureRatio(found[0].height, mean)
