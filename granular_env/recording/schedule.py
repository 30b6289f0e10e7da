"""Choice of the recorded variables, and of the ticks (internal steps) of frames, hashes, snapshots; the same on any machine."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..components.component import Component
from ..components.drawables import drawn_outputs
from ..components.errors import ParameterError, one_line, spelling_hint
from ..components.support.round_numbers import round_down_to_125, round_up_to_125
from ..components.support.validation import whole_number
from .preview.clouds import COUNTED, MOST_PLACES
from .preview.film import MOST_FRAMES, MOST_PICTURES
from .records import damage_error

# Default interval between hashes of the state [ticks]; they cost less than 1 % of a run for all shipped components.
HASH_EVERY = 4096
# A killed run continues from its last snapshot. Snapshots are taken each time the run is longer by a sixteenth, at least this
# many ticks apart.
_SNAPSHOT_TICKS, _SNAPSHOT_SHIFT = 4096, 4
# For costly ticks, 4096 ticks may be a whole run. Snapshots are then this much work apart or, if that is more, this many steps
# of the whole state, because writing a snapshot takes as long as 5 to 16 steps of a grid (26 and 104 MB, 2 cores). Work is
# counted in words of state advanced by a step, which take 3 to 12 ns (grids, shells), not in seconds, because a run must
# have the same snapshots on any machine and after a resumption.
_SNAPSHOT_WORK, _SNAPSHOT_STEPS = 500_000_000, 1500
# Largest number of frames of an experiment with a known duration.
_FRAMES = 400
# Frames with more numbers than this cost more than the ticks between them: on a grid of a million nodes (2 cores, a state of
# 104 MB) a tick takes 0.04 s and a frame of 72 MB 0.8 s. 500 ticks per frame of the state's size limit the cost to a twentieth.
_HUGE_FRAME, _TICKS_A_FRAME, _FEWEST_FRAMES = 1_000_000, 500, 10
# Without a known duration: pairs (size, frames): if a frame has more numbers than size, the interval doubles every `frames`.
_FRAMES_A_DOUBLING = ((_HUGE_FRAME, 4), (8192, 16), (-1, 64))
# Sizes of a log without data, of one element in a picture of the preview, and of a message with a number [bytes].
_LOG_BYTES, _PLACE_BYTES, _NUMBER_BYTES = 20_000, 16, 75


@dataclass(frozen=True, slots=True)
class Schedule:
    """The intervals between frames, between hashes and between snapshots, in ticks.

    Attributes:
        frame_every: ticks between frames; 0 for the doubling rule: a frame at every tick at first, with the interval
            doubled each time the run has doubled in length.
        doubling: number of frames between two doublings of the interval.
        hash_every: ticks between hashes.
        snapshot_every: ticks between snapshots; 0 for a snapshot each time the run is longer by a sixteenth.
        least_snapshot_interval: least number of ticks between snapshots.
    """

    frame_every: int
    doubling: int
    hash_every: int
    snapshot_every: int
    least_snapshot_interval: int = _SNAPSHOT_TICKS

    def next_frame(self, tick: int, elapsed: int) -> int:
        """Return the tick of the next frame after `tick`; `elapsed` counts the ticks of the whole log."""
        interval = self.frame_every or 1 << max((elapsed // self.doubling).bit_length() - 1, 0)
        return (tick // interval + 1) * interval

    def next_hash(self, tick: int) -> int:
        """Return the tick of the next hash of the state after `tick`."""
        return (tick // self.hash_every + 1) * self.hash_every

    def next_snapshot(self, tick: int, elapsed: int) -> int:
        """Return the tick of the next snapshot after `tick`; `elapsed` counts the ticks of the whole log."""
        return tick + (self.snapshot_every or max(self.least_snapshot_interval, elapsed >> _SNAPSHOT_SHIFT))


def parse_schedule(options: Any) -> Schedule:
    """Return the schedule from the options in a log's header; raise `LogError` if it is missing or invalid."""
    lowest = {"frame_every": 0, "doubling": 1, "hash_every": 1, "snapshot_every": 0, "least_snapshot_interval": 1}
    if not isinstance(options, dict) or options.keys() != lowest.keys() or not all(
        type(options[name]) is int and options[name] >= low for name, low in lowest.items()
    ):  # fmt: skip
        raise damage_error("the schedule of the frames is missing or invalid", "header.options")
    return Schedule(**options)


def frame_interval(ticks: int, values: int, state: int) -> int:
    """Return an interval of 1, 2 or 5 x 10^k ticks that gives 160 to 400 frames in a run of `ticks`.

    Huge frames are fewer, but at least ten, because writing one takes as long as tens to hundreds of ticks. `values`
    and `state` are the counts of numbers in a frame and in the state.
    """
    interval = round_up_to_125(max(ticks / _FRAMES, 1.0))
    if values > _HUGE_FRAME:
        wanted = min(_TICKS_A_FRAME * values / state, ticks / _FEWEST_FRAMES)
        interval = max(interval, round_down_to_125(max(wanted, 1.0)))
    return int(interval)


def least_snapshot_interval(words: int, work: int) -> int:
    """Return the least number of ticks between snapshots: 4096, or fewer for costly ticks.

    Args:
        words: number of words of the state.
        work: number of words advanced in a tick; a part with several steps per tick counts for each of them.
    """
    wanted = max(_SNAPSHOT_WORK, _SNAPSHOT_STEPS * words)
    return min(_SNAPSHOT_TICKS, max(1, round(wanted / max(work, 1))))


def names_to_record(component: Component, variables: Sequence[str] | None) -> list[str]:
    """Return the names to record: the given names, the entries of the balances, and the scalar inputs.

    Default for the given names: the state, the outputs of drawables, and all scalar outputs.
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
            raise ParameterError(f"got {one_line(name)}", expected=expected, hint=spelling_hint(name, known), at=at)
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
    """Return the schedule of frames, hashes and snapshots; arguments as for `record`, `names` are the recorded variables."""
    hashes = HASH_EVERY if hash_every is None else whole_number("hash_every", hash_every)
    duration = experiment.get("duration") if isinstance(experiment, Mapping) else None
    frame_every, values, words = 0, value_count(component, names), component.state_bytes // 8
    if every is not None:
        frame_every = component.duration_ticks(every, "every")
    elif isinstance(duration, (int, float)) and duration > 0.0:
        frame_every = frame_interval(round(duration / component.step_size), values, words)
    doubling = next(count for least, count in _FRAMES_A_DOUBLING if values > least)
    if snapshot_every is not None:
        return Schedule(frame_every, doubling, hashes, component.duration_ticks(snapshot_every, "snapshot_every"))
    return Schedule(frame_every, doubling, hashes, 0, least_snapshot_interval(words, component.cost_per_tick))


def value_count(component: Component, names: Sequence[str]) -> int:
    """Return the count of numbers in one frame of the variables `names`."""
    return sum(math.prod(component.variables[name].shape) for name in names)


def estimate_bytes(component: Component, schedule: Schedule, names: Sequence[str], ticks: int) -> int:
    """Return an estimate of the largest size of a recording before compression [bytes]."""
    frames, keys, tick = schedule.doubling * (1 + (ticks // schedule.doubling).bit_length()), 0, 0
    if schedule.frame_every:
        frames = ticks // schedule.frame_every + 1
    if schedule.snapshot_every:
        keys, tick = ticks // schedule.snapshot_every, ticks
    while (tick := schedule.next_snapshot(tick, tick)) <= ticks:
        keys += 1
    numbers = sum(component.variables[name].shape == () for name in names)
    drawn = sum(min(len(getattr(one, COUNTED[type(one)])), MOST_PLACES) for one in component.drawables())
    hashed = 2 + sum(variable.state or variable.causality == "input" for variable in component.variables.values())
    # The drawables in the header are about as large as the state, which is stored at the start and at the end.
    return (
        _LOG_BYTES
        + (3 + keys) * component.state_bytes
        + 8 * frames * (value_count(component, names) + len(names))
        + 8 * (ticks // schedule.hash_every) * hashed
        + _PLACE_BYTES * min(frames, MOST_PICTURES) * drawn
        + _NUMBER_BYTES * min(frames, MOST_FRAMES) * numbers
    )
