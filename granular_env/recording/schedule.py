"""What is recorded, and when: rules in ticks only, so that the same run is recorded in the same way."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ..components.component import Component
from ..components.drawables import drawn_outputs
from ..components.errors import ParameterError, nearest, one_line
from ..components.support.round_numbers import round_down_to_125, round_up_to_125
from .records import damage

# Default distance of hashes; at this distance they cost less than a hundredth of any component seen so far [ticks].
HASH_EVERY = 4096
# A run that was killed goes on from its last snapshot. There is one each time the run has become a sixteenth longer, at least
# this many ticks apart.
_SNAPSHOT_TICKS, _SNAPSHOT_SHIFT = 4096, 4
# Where ticks are costly, 4096 of them may be a whole run: snapshots are this much work apart, or this many steps of the whole
# state where that is more, since to write one takes as long as 5 to 16 steps of a grid (26 and 104 MB, 2 cores). Work is
# counted in words of state advanced by a step, which take 3 to 12 ns (grids, shells), and not in seconds: the same run has to
# have the same snapshots on any machine, and when it is resumed.
_SNAPSHOT_WORK, _SNAPSHOT_STEPS = 500_000_000, 1500
# Frames of an experiment whose duration is known: at most so many.
_FRAMES = 400
# Without a known duration: frames between one doubling of the interval and the next; fewer where a frame is large.
_FRAMES_A_DOUBLING, _LARGE_FRAMES_A_DOUBLING = 64, 16
_LARGE_FRAME = 8192
# Frames of more numbers than this cost more than the ticks between them: on a grid of a million nodes (2 cores, a state of
# 104 MB) a tick takes 0.04 s and a frame of 72 MB 0.8 s. 500 ticks for each frame as large as the state keep it to a twentieth.
_HUGE_FRAME, _HUGE_FRAMES_A_DOUBLING = 1_000_000, 4
_TICKS_A_FRAME, _FEWEST_FRAMES = 500, 10


@dataclass(frozen=True, slots=True)
class Schedule:
    """Intervals in ticks.

    Attributes:
        frame_every: ticks between frames; 0 for the doubling rule: one at every tick at first, half as many each time the
            run has become twice as long.
        doubling: frames per doubling.
        hash_every: ticks between hashes.
        snapshot_every: ticks between snapshots; 0 for one each time the run has become a sixteenth longer.
        least_snapshot_interval: ticks between these at least.
    """

    frame_every: int
    doubling: int
    hash_every: int
    snapshot_every: int
    least_snapshot_interval: int = _SNAPSHOT_TICKS

    def frame_after(self, tick: int, elapsed: int) -> int:
        """Return the next tick for a frame; `elapsed` counts the ticks of the whole log."""
        interval = self.frame_every or 1 << max((elapsed // self.doubling).bit_length() - 1, 0)
        return (tick // interval + 1) * interval

    def is_frame(self, tick: int, elapsed: int) -> bool:
        """Return whether a segment that starts at this tick starts with a frame."""
        return self.frame_after(tick - 1, elapsed) == tick

    def hash_after(self, tick: int) -> int:
        """Return the next tick for a hash."""
        return (tick // self.hash_every + 1) * self.hash_every

    def key_after(self, tick: int, elapsed: int) -> int:
        """Return the next tick for a snapshot."""
        return tick + (self.snapshot_every or max(self.least_snapshot_interval, elapsed >> _SNAPSHOT_SHIFT))

    def options(self) -> dict[str, int]:
        """Return what a log's header holds of it: `schedule_from` gives it back."""
        return asdict(self)


def schedule_from(options: Any) -> Schedule:
    """Return the schedule that a log's header holds; `LogError` where it holds none."""
    lowest = {"frame_every": 0, "doubling": 1, "hash_every": 1, "snapshot_every": 0, "least_snapshot_interval": 1}
    if not isinstance(options, dict) or options.keys() != lowest.keys() or not all(
        type(options[name]) is int and options[name] >= low for name, low in lowest.items()
    ):  # fmt: skip
        raise damage("it does not say when frames were taken", "header.options")
    return Schedule(**options)


class Agenda:
    """The next ticks at which something is due.

    Attributes:
        frame, hash, key: the next tick for each.
    """

    def __init__(self, schedule: Schedule) -> None:
        self._schedule = schedule
        self.frame = self.hash = self.key = 0

    def restart(self, tick: int, elapsed: int) -> int:
        """Set all anew after a tick, `elapsed` counting the ticks of the whole log; return the nearest."""
        self.frame = self.hash = self.key = tick
        return self.after(tick, elapsed)

    def after(self, tick: int, elapsed: int) -> int:
        """Move on what was due at a tick; return the nearest that is due next."""
        if self.frame <= tick:
            self.frame = self._schedule.frame_after(tick, elapsed)
        if self.hash <= tick:
            self.hash = self._schedule.hash_after(tick)
        if self.key <= tick:
            self.key = self._schedule.key_after(tick, elapsed)
        return min(self.frame, self.hash, self.key)


def frames_for(ticks: int, values: int, state: int) -> int:
    """Return an interval of 1, 2 or 5 x 10^k ticks that gives 160 to 400 frames in a run of so many ticks.

    Where frames are huge there are fewer, but at least ten: to write one takes as long as tens to hundreds of ticks.

    Args:
        ticks: of the run.
        values: numbers of a frame.
        state: numbers of the state.
    """
    interval = round_up_to_125(max(ticks / _FRAMES, 1.0))
    if values > _HUGE_FRAME:
        wanted = min(_TICKS_A_FRAME * values / state, ticks / _FEWEST_FRAMES)
        interval = max(interval, round_down_to_125(max(wanted, 1.0)))
    return int(interval)


def least_snapshot_interval(words: int, work: int) -> int:
    """Return how many ticks snapshots are apart at least: 4096, or fewer where a tick does much work.

    Args:
        words: of the state.
        work: words that are advanced in a tick, counted again at every step of a part.
    """
    wanted = max(_SNAPSHOT_WORK, _SNAPSHOT_STEPS * words)
    return min(_SNAPSHOT_TICKS, max(1, round(wanted / max(work, 1))))


def doubling_for(values: int) -> int:
    """Frames per doubling for frames of so many numbers."""
    if values > _HUGE_FRAME:
        return _HUGE_FRAMES_A_DOUBLING
    return _LARGE_FRAMES_A_DOUBLING if values > _LARGE_FRAME else _FRAMES_A_DOUBLING


# -- the arguments of a recording, checked before any file exists --------------------------------------------------------------


def names_to_record(component: Component, variables: Sequence[str] | None) -> list[str]:
    """Return the names to record: those given, the balances' entries, and the inputs that are one number.

    Default for those given: the state, what viewers draw, and every output that is one number.
    """
    given, all_variables = variables is not None, component.variables.values()
    inputs = [v.name for v in all_variables if v.causality == "input" and v.shape == ()]
    if variables is None:
        numbers = (v.name for v in all_variables if v.causality == "output" and v.shape == ())
        variables = [*(v.name for v in all_variables if v.state), *drawn_outputs(component.drawables()), *numbers]
    if isinstance(variables, str):
        expected = f"a list of names, such as [{variables!r}]"
        raise ParameterError(f"got the text {variables!r}", expected=expected, at="variables")
    known = [v.name for v in all_variables if v.causality != "parameter"]
    for place, name in enumerate(variables):
        at = ("variables", place)
        if name not in known:
            expected = f"an output or input of component {component.name!r}"
            raise ParameterError(f"got {one_line(name)}", expected=expected, hint=nearest(name, known), at=at)
        if given and name in variables[:place]:
            raise ParameterError(f"got {name!r} again", expected="each name once", at=at)
    return list(dict.fromkeys([*variables, *component.balance_names, *inputs]))


def make_schedule(
    component: Component,
    every: float | None,
    hash_every: int | None,
    snapshot_every: float | None,
    experiment: Any,
    names: list[str],
) -> Schedule:
    """Return when frames, hashes and snapshots are taken."""
    if hash_every is not None and (
        not isinstance(hash_every, (int, np.integer)) or isinstance(hash_every, bool) or hash_every < 1
    ):
        raise ParameterError(f"got {hash_every!r}", expected="a whole number of ticks, at least 1", at="hash_every")
    duration = experiment.get("duration") if isinstance(experiment, Mapping) else None
    frame_every, values = 0, sum(math.prod(component.variables[name].shape) for name in names)
    if every is not None:
        frame_every = component.ticks_in(every, "every")
    elif isinstance(duration, (int, float)) and duration > 0.0:
        frame_every = frames_for(round(duration / component.step_size), values, _words(component))
    schedule = Schedule(frame_every, doubling_for(values), int(hash_every or HASH_EVERY), 0)
    if snapshot_every is not None:
        return replace(schedule, snapshot_every=component.ticks_in(snapshot_every, "snapshot_every"))
    least = least_snapshot_interval(_words(component), component.work_in_tick)
    return replace(schedule, least_snapshot_interval=least)


def _words(component: Component) -> int:
    return component.state_bytes // 8
