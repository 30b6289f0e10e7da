"""Events: what happens at a point in time and should be found later."""

from __future__ import annotations

import dataclasses

from .state_block import LARGEST, Field

# Ticks and indices are whole numbers that a float holds.
MOST_INDEX = 2**53


def event_rows(kinds: int) -> Field:
    """Return the growing part `events` of a state: tick, number of the kind, index (-1 for none), value, limit."""
    return Field("f8", (5,), (0, 0, -1, -LARGEST, -LARGEST), (MOST_INDEX, kinds - 1, MOST_INDEX, LARGEST, LARGEST))


@dataclasses.dataclass(frozen=True, slots=True)
class Event:
    """Something that happened at a point in time: a link broke, a grain yielded, an assumption was left behind.

    Attributes:
        tick: at the end of which internal step.
        kind: one of the component's `event_kinds`.
        index: which link, grain, ...; None where that has no meaning.
        value: of the quantity that decided.
        limit: that it passed.
    """

    tick: int
    kind: str
    index: int | None
    value: float
    limit: float


@dataclasses.dataclass(frozen=True, slots=True)
class EventDetail:
    """The unit of a kind of events, what their indices count, and how near each of these is to one.

    Attributes:
        unit: of value and limit; "" where it is not said.
        counts: name of the drawable whose elements its indices count: points, links or cells; "" for none.
        ratio: name of the output that says of each index what decides over its limit, 1 being an event; "" for none.
        ends_validity: whether an assumption of the model fails at such an event, so that later results are not valid.
    """

    unit: str = ""
    counts: str = ""
    ratio: str = ""
    ends_validity: bool = False
