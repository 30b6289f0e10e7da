"""The recorded variables, and the ticks of frames, hashes and snapshots, so that the same run is always recorded alike."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..components.component import Component
from ..components.drawables import drawn_outputs
from ..components.errors import ParameterError, nearest, one_line
from ..components.support.round_numbers import round_down_to_125, round_up_to_125
from ..components.support.validation import whole_number
from .preview.film import COUNTED, MOST_FRAMES, MOST_PICTURES, MOST_PLACES
from .records import damage

# Default distance of hashes [ticks]: they cost less than a hundredth of a run of any shipped component.
HASH_EVERY = 4096
# A run that was killed continues from its last snapshot. There is one each time the run has become a sixteenth longer, at least
# this many ticks apart.
_SNAPSHOT_TICKS, _SNAPSHOT_SHIFT = 4096, 4
# If ticks are costly, 4096 of them may be a whole run: snapshots are this much work apart, or this many steps of the whole
# state where that is more, since to write one takes as long as 5 to 16 steps of a grid (26 and 104 MB, 2 cores). Work is
# counted in words of state advanced by a step, which take 3 to 12 ns (grids, shells), and not in seconds: the same run has to
# have the same snapshots on any machine, and when it is resumed.
_SNAPSHOT_WORK, _SNAPSHOT_STEPS = 500_000_000, 1500
# Most frames of an experiment whose duration is known.
_FRAMES = 400
# Frames of more numbers than this cost more than the ticks between them: on a grid of a million nodes (2 cores, a state of
# 104 MB) a tick takes 0.04 s and a frame of 72 MB 0.8 s. 500 ticks for each frame as large as the state keep it to a twentieth.
_HUGE_FRAME, _TICKS_A_FRAME, _FEWEST_FRAMES = 1_000_000, 500, 10
# Without a known duration: frames between one doubling of the interval and the next, for frames of more numbers than these.
_FRAMES_A_DOUBLING = ((_HUGE_FRAME, 4), (8192, 16), (-1, 64))
# Bytes of a small log, and of the preview: of a place in a picture, and of a number with its name.
_LOG_BYTES, _PLACE_BYTES, _NUMBER_BYTES = 20_000, 16, 30


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

    def hash_after(self, tick: int) -> int:
        """Return the next tick for a hash."""
        return (tick // self.hash_every + 1) * self.hash_every

    def key_after(self, tick: int, elapsed: int) -> int:
        """Return the next tick for a snapshot."""
        return tick + (self.snapshot_every or max(self.least_snapshot_interval, elapsed >> _SNAPSHOT_SHIFT))


def schedule_from(options: Any) -> Schedule:
    """Return the schedule that a log's header holds; `LogError` where it holds none."""
    lowest = {"frame_every": 0, "doubling": 1, "hash_every": 1, "snapshot_every": 0, "least_snapshot_interval": 1}
    if not isinstance(options, dict) or options.keys() != lowest.keys() or not all(
        type(options[name]) is int and options[name] >= low for name, low in lowest.items()
    ):  # fmt: skip
        raise damage("it does not say when frames were taken", "header.options")
    return Schedule(**options)


def frame_interval(ticks: int, values: int, state: int) -> int:
    """Return an interval of 1, 2 or 5 x 10^k ticks that gives 160 to 400 frames in a run of `ticks`.

    Huge frames are fewer, but at least ten: to write one takes as long as tens to hundreds of ticks. `values` and `state` are
    the numbers of a frame and of the state.
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


# -- the arguments of a recording, checked before any file exists --------------------------------------------------------------


def names_to_record(component: Component, variables: Sequence[str] | None) -> list[str]:
    """Return the names to record: those given, the balances' entries, and the inputs that are one number.

    Default for those given: the state, the outputs of drawables, and every output that is one number.
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
    """Return when frames, hashes and snapshots are taken; arguments as for `record`, `names` are the recorded variables."""
    hashes = HASH_EVERY if hash_every is None else whole_number("hash_every", hash_every)
    duration = experiment.get("duration") if isinstance(experiment, Mapping) else None
    frame_every, values, words = 0, values_in(component, names), component.state_bytes // 8
    if every is not None:
        frame_every = component.ticks_in(every, "every")
    elif isinstance(duration, (int, float)) and duration > 0.0:
        frame_every = frame_interval(round(duration / component.step_size), values, words)
    doubling = next(count for least, count in _FRAMES_A_DOUBLING if values > least)
    if snapshot_every is not None:
        return Schedule(frame_every, doubling, hashes, component.ticks_in(snapshot_every, "snapshot_every"))
    return Schedule(frame_every, doubling, hashes, 0, least_snapshot_interval(words, component.work_in_tick))


def values_in(component: Component, names: Sequence[str]) -> int:
    """Return how many numbers a frame of some variables has."""
    return sum(math.prod(component.variables[name].shape) for name in names)


def estimated_bytes(component: Component, schedule: Schedule, names: Sequence[str], ticks: int) -> int:
    """Return about how many bytes the recording of a run takes at most, before compression."""
    frames, keys, tick = schedule.doubling * (1 + (ticks // schedule.doubling).bit_length()), 0, 0
    if schedule.frame_every:
        frames = ticks // schedule.frame_every + 1
    if schedule.snapshot_every:
        keys, tick = ticks // schedule.snapshot_every, ticks
    while (tick := schedule.key_after(tick, tick)) <= ticks:
        keys += 1
    numbers = sum(component.variables[name].shape == () for name in names)
    drawn = sum(min(len(getattr(one, COUNTED[type(one)])), MOST_PLACES) for one in component.drawables())
    hashed = 2 + sum(variable.state or variable.causality == "input" for variable in component.variables.values())
    # The drawables in the header take about as much as the state, of which there is a copy at the start and at the end.
    return (
        _LOG_BYTES
        + (3 + keys) * component.state_bytes
        + 8 * frames * (values_in(component, names) + len(names))
        + 8 * (ticks // schedule.hash_every) * hashed
        + _PLACE_BYTES * min(frames, MOST_PICTURES) * drawn
        + _NUMBER_BYTES * min(frames, MOST_FRAMES) * numbers
    )
