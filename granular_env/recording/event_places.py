"""Places of events: which elements of a drawable an index counts, and where they were before anything moved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..components.drawables import Cells, Drawable, Links, Points, element_count
from ..components.errors import ParameterError
from ..components.events import Event, EventDetail
from ..components.support.float_arrays import FloatArray


@dataclass(frozen=True, slots=True)
class EventPlace:
    """The elements that an event concerns, and their place.

    Attributes:
        elements: what it concerns, such as "automata 12 and 13" for a link.
        position: the middle of these before anything moved [m].
    """

    elements: str
    position: tuple[float, ...]


def place_of(index: int | None, detail: EventDetail | None, drawables: Sequence[Drawable]) -> EventPlace | None:
    """Return where events with an index take place; None where their kind does not say what it counts.

    Args:
        index: of the events; None for none.
        detail: that of their kind.
        drawables: of the component.
    """
    by_name = {one.name: one for one in drawables}
    drawn = by_name.get(detail.counts) if detail is not None else None
    if index is None or drawn is None or index >= element_count(drawn):
        return None
    match drawn:
        case Links():
            points, ends = by_name[drawn.points], drawn.pairs[index]
            assert isinstance(points, Points)
            first, way = points.reference[ends[0]].ravel(), points.ways(ends[None])[0]
            return EventPlace(f"{points.name} {ends[0]} and {ends[1]}", tuple((first + 0.5 * way).tolist()))
        case Points():
            return EventPlace(f"{drawn.name} {index}", _middle(drawn.reference[index : index + 1]))
        case Cells():
            return EventPlace(f"cell {index} of {drawn.name}", _middle(drawn.nodes[drawn.connectivity[index]]))
        case _:
            return None


def listed_events(found: Sequence[Event], earlier: Sequence[Event], most: int) -> Sequence[Event]:
    """Return the events that a table shows: where there are too many, the first of those in the log, if there are any.

    Args:
        found: the events in a log.
        earlier: those before it begins.
        most: how many may be shown.
    """
    every = [*earlier, *found]
    return every if len(every) <= most else (found or every)[:most]


def event_table(
    events: Sequence[Event], step_size: float, details: Mapping[str, EventDetail], drawables: Sequence[Drawable]
) -> tuple[list[str], list[list[Any]]]:
    """Return the heads and the rows of a table of events: when, what, with which numbers, and where.

    Columns of which nothing is known are left out.

    Args:
        events: of a component.
        step_size: of it [s].
        details: of its kinds of events.
        drawables: of it.
    """
    heads = ["time [s]", "event", "index", "value", "limit", "unit", "of", "at [m]"]
    rows: list[list[Any]] = []
    for event in events:
        detail = details.get(event.kind)
        place = place_of(event.index, detail, drawables)
        rows.append([
            event.tick * step_size, event.kind, "" if event.index is None else event.index, event.value, event.limit,
            "" if detail is None else detail.unit, "" if place is None else place.elements,
            "" if place is None else position_words(place.position),
        ])  # fmt: skip
    known = [column for column in range(len(heads)) if any(row[column] != "" for row in rows)]
    return [heads[column] for column in known], [[row[column] for column in known] for row in rows]


def position_words(position: Sequence[float]) -> str:
    """Return coordinates for people."""
    return f"({', '.join(f'{one:.4g}' for one in position)})"


def refuse_unknown_place(index: int | None, details: Sequence[EventDetail | None], drawables: Sequence[Drawable]) -> None:
    """Raise `ParameterError` where no kind of event counts anything that has such an index.

    Args:
        index: of a link, cell, ...; None is none, and refused by none.
        details: of the kinds of events that are asked for.
        drawables: of the component.
    """
    by_name = {one.name: one for one in drawables}
    counted = [by_name.get(detail.counts) if detail is not None else None for detail in details]
    if index is None or not counted or None in counted:
        return
    sizes = {one.name: element_count(one) for one in counted if one is not None}
    if index >= max(sizes.values()):
        expected = " or ".join(f"0 to {size - 1} ({name})" for name, size in sizes.items())
        raise ParameterError(f"got {index}", expected=expected, at="index")


def _middle(points: FloatArray) -> tuple[float, ...]:
    """Return the mean of points, shape (k,) or (k, d) [m]."""
    return tuple(points.reshape(len(points), -1).mean(axis=0).tolist())
