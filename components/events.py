"""Events: occurrences at a point in time, recorded for later analysis."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Any

import numpy as np

from .errors import ParameterError, one_line, spelling_hint
from .state_block import LARGEST, Field
from .support.float_arrays import FloatArray
from .support.validation import whole_number

# Ticks and indices are integers, which floats represent exactly up to this limit.
MOST_INDEX = 2**53


def event_list_field(kinds: int) -> Field:
    """Return the declaration of the growing list `events` with columns tick, kind number, index (-1: none), value, limit."""
    return Field("f8", (5,), (0, 0, -1, -LARGEST, -LARGEST), (MOST_INDEX, kinds - 1, MOST_INDEX, LARGEST, LARGEST))


@dataclasses.dataclass(frozen=True, slots=True)
class Event:
    """An event at a point in time: a link broke, a grain yielded, an assumption was violated.

    Attributes:
        tick: number at the end of the internal step.
        kind: one of the component's `event_kinds`.
        index: index of the link, grain, ...; None if not applicable.
        value: value of the decisive quantity.
        limit: limit that this quantity passed.
    """

    tick: int
    kind: str
    index: int | None
    value: float
    limit: float


@dataclasses.dataclass(frozen=True, slots=True)
class EventDetail:
    """Properties of a kind of event: unit, meaning of its indices, and the output with the distance from the limit.

    Attributes:
        unit: unit of `value` and `limit`; "" if unspecified.
        counts: name of the drawable whose elements (points, links or cells) the indices refer to; "" for none.
        ratio: name of the output with the decisive quantity over its limit, for each index (1 = event); "" for none.
        ends_validity: whether an assumption of the model fails at such an event, so that later results are not valid.
    """

    unit: str = ""
    counts: str = ""
    ratio: str = ""
    ends_validity: bool = False


def decode_events(rows: FloatArray, kinds: Iterable[str], kind: str | None, index: int | None, source: str) -> list[Event]:
    """Return events from rows with kinds numbered in alphabetical order.

    Args:
        rows: shape (events, 5), see `event_list_field`.
        kinds: all kinds that can occur.
        kind: return only this kind.
        index: return only events of this link, grain, ...
        source: name of the component or log, for messages.

    Raises:
        ParameterError: there is no such kind, or the index is not valid.
    """
    refuse_unknown_events(kinds, kind, index, source)
    names = sorted(kinds)
    return [
        Event(int(tick), names[int(number)], None if place < 0 else int(place), value, limit)
        for tick, number, place, value, limit in rows.tolist()
        if kind in (None, names[int(number)]) and index in (None, int(place))
    ]


def refuse_unknown_events(kinds: Iterable[str], kind: Any, index: Any, source: str) -> None:
    """Raise `ParameterError` for a kind of event that cannot occur, or for an invalid index."""
    known = list(kinds)
    if kind is not None and kind not in known:
        hint = spelling_hint(str(kind), known)
        raise ParameterError(f"got {one_line(kind)}", expected="a kind of event", hint=hint, at="kind", source=source)
    if index is not None:
        whole_number("index", index, 0)


def renumber_kinds(rows: FloatArray, names: list[str], kinds: Iterable[str]) -> FloatArray:
    """Renumber, in place, the kinds of rows from the order of `names` to the alphabetical order of all `kinds`."""
    order = sorted(kinds)
    rows[:, 1] = np.array([order.index(name) for name in names], dtype=np.float64)[rows[:, 1].astype(np.int64)]
    return rows
