"""Places of events: the elements of a drawable to which the index of an event refers, and their initial positions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from ..components.drawables import Drawable, Links, Points, element_count, element_positions
from ..components.errors import ParameterError
from ..components.events import Event, EventDetail
from ..output_files import count_text

if TYPE_CHECKING:
    from .log import Log


class EventPlace(NamedTuple):
    """The elements at which an event happened ("grain 12", "automata 12 and 13"), and their mean initial position [m]."""

    elements: str
    position: tuple[float, ...]


def event_place(index: int | None, detail: EventDetail | None, drawables: Sequence[Drawable]) -> EventPlace | None:
    """Return the place of the events that have this index; None if events of this kind refer to no drawable."""
    by_name = {one.name: one for one in drawables}
    drawn = by_name.get(detail.counts) if detail is not None else None
    if index is None or drawn is None or index >= element_count(drawn):
        return None
    words = drawn.name.replace("_", " ")
    elements = f"cell {index} of {words}"
    if isinstance(drawn, Links):
        elements = f"{drawn.points.replace('_', ' ')} {' and '.join(map(str, drawn.pairs[index]))}"
    elif isinstance(drawn, Points):
        elements = f"{words.replace('automata', 'automaton').removesuffix('s')} {index}"
    return EventPlace(elements, tuple(element_positions(drawn, drawables, [index])[0].tolist()))


def listed_events(events: Sequence[Event], earlier: Sequence[Event], max_count: int) -> Sequence[Event]:
    """Return at most `max_count` events for a table: all events or, if there are more, the first events of the log."""
    every = [*earlier, *events]
    return every if len(every) <= max_count else (events or every)[:max_count]


def event_table(events: Sequence[Event], log: Log) -> tuple[list[str], list[list[Any]]]:
    """Return the headings and the rows of a table of events, with the columns time, kind, value, limit and place.

    Empty columns are omitted.
    """
    heads = ["time [s]", "event", "index", "value", "limit", "unit", "element", "position [m]"]
    details = log.event_details
    rows: list[list[Any]] = []
    for event in events:
        detail = details.get(event.kind)
        place = event_place(event.index, detail, log.drawables)
        where = ["", ""] if place is None else [place.elements, position_text(place.position)]
        index, unit = "" if event.index is None else event.index, "" if detail is None or detail.unit == "1" else detail.unit
        rows.append([event.tick * log.step_size, event.kind, index, event.value, event.limit, unit, *where])
    known = [column for column in range(len(heads)) if any(row[column] != "" for row in rows)]
    return [heads[column] for column in known], [[row[column] for column in known] for row in rows]


def event_summary(events: Sequence[Event], earlier: Sequence[Event], start: float) -> str:
    """Return the number of events of each kind as text; `earlier` are those before the log, which begins at `start` [s]."""
    if not earlier:
        return f"{count_text(len(events), 'event')}: {_kind_counts(events)}"
    here = f"{count_text(len(events), 'event')} in this log: {_kind_counts(events)}" if events else "no event in this log"
    return f"{here}; {len(earlier)} before it begins at {start:.9g} s: {_kind_counts(earlier)}"


def _kind_counts(events: Sequence[Event]) -> str:
    return ", ".join(f"{count} {kind}" for kind, count in Counter(event.kind for event in events).most_common())


def position_text(position: Sequence[float]) -> str:
    """Return coordinates as text."""
    return f"({', '.join(f'{one:.4g}' for one in position)})"


def refuse_unknown_place(log: Log, kind: str | None, index: int | None) -> None:
    """Raise `ParameterError` if an index is invalid for a kind of event or, without a kind, for all kinds."""
    details, sizes = log.event_details, {one.name: element_count(one) for one in log.drawables}
    counted = {details[one].counts if one in details else "" for one in log.event_kinds if kind in (None, one)}
    if index is not None and counted and counted <= sizes.keys() and index >= max(sizes[name] for name in counted):
        expected = " or ".join(f"0 to {sizes[name] - 1} ({name})" for name in sorted(counted))
        raise ParameterError(f"got {index}", expected=expected, at="index")
