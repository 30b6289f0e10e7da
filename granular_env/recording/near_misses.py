"""Near misses: places where a quantity came closest to the limit at which an event happens; the log is run again for this."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ..components.component import Component
from ..components.errors import LogError, ParameterError
from ..components.events import Event, EventDetail
from .log import Log
from .replay import advance_to_tick, restore_snapshot

# Number of times at which the repeated run is examined, in addition to the times of the frames.
_INSTANTS = 1000


@dataclass(slots=True)
class EventRatio:
    """The largest ratio, over a run, of the quantity that decides an event to its limit, at one element (link, cell, ...).

    Attributes:
        kinds: kinds of events decided by the quantity.
        variable: name of the output with the ratio; see `events.EventDetail.ratio`.
        index: index of the element.
        time: time of the largest ratio [s].
        ratio: decisive quantity divided by its limit; 1 is an event.
        passed: number of elements at which such an event happened in the run or before the log.
        instants: number of examined times: frames, ends of segments, and a thousand more.
        all_instants: number of all times: the start, and the end of each internal step.
        nearest: the kind of event that came closest to its limit; "" if the component does not provide it.
        limited: False if there is no limit at this element, so that the event cannot happen.
        events: events at this element, of `kinds` and others, including those before the log.
    """

    kinds: tuple[str, ...]
    variable: str
    index: int = -1
    time: float = 0.0
    ratio: float = -np.inf
    passed: int = 0
    instants: int = 0
    all_instants: int = 0
    nearest: str = ""
    limited: bool = True
    events: tuple[Event, ...] = ()


def kinds_by_ratio(details: Mapping[str, EventDetail]) -> dict[str, tuple[str, ...]]:
    """Return, for each output with ratios of quantities to limits, the kinds of events that these ratios decide."""
    outputs = dict.fromkeys(detail.ratio for detail in details.values() if detail.ratio)
    return {name: tuple(kind for kind, detail in details.items() if detail.ratio == name) for name in outputs}


def find_near_misses(log: Log, index: int | None = None, kind: str | None = None) -> list[EventRatio]:
    """Return the nearest misses of a run: for each output with ratios, the place closest to an event that did not happen.

    Args:
        log: an open log; it is run again.
        index: index of a link, cell, ...; default: the nearest element without such an event.
        kind: only the output that decides this kind of event.

    Returns:
        One result per output with ratios and such a place.

    Raises:
        LogError: the log cannot be run again here, or contains no step.
        ParameterError: no output has this index.
    """
    component = log.component()
    # A component coupled from parts may not have all outputs of its parts.
    decided = kinds_by_ratio(component.event_details)
    kinds = {name: decided[name] for name in decided if name in component.variables and kind in (None, *decided[name])}
    sizes = {name: int(np.prod(component.variables[name].shape)) for name in kinds}
    if index is not None and sizes and not 0 <= index < max(sizes.values()):
        raise ParameterError(f"got {index}", expected=f"0 to {max(sizes.values()) - 1}", at="index")
    # The component is in the state at the log's start, which contains the earlier events.
    happened = [*component.events(), *log.events()]
    searches: list[tuple[EventRatio, np.ndarray]] = []
    for name, names in kinds.items():
        passed = {event.index for event in happened if event.kind in names and event.index is not None}
        places = np.arange(sizes[name])
        asked = np.setdiff1d(places, list(passed)) if index is None else places[places == index]
        if len(asked):
            nearest = names[0] if len(names) == 1 else ""
            searches.append((EventRatio(names, name, passed=len(passed), nearest=nearest), asked))
    instants = 0
    for tick in _replay_instants(log, component) if searches else ():
        instants += 1
        for found, asked in searches:
            ratios = np.ravel(component.peek(found.variable))[asked]
            place = int(ratios.argmax())
            if ratios[place] > found.ratio:
                found.ratio, found.index, found.time = float(ratios[place]), int(asked[place]), tick * log.step_size
                if len(found.kinds) > 1:
                    found.nearest = component.nearest_kind(found.variable, found.index)
    if searches and not instants:
        raise LogError("the log contains no step, so there are no near misses", at="steps", source=log.source)
    for found, _ in searches:
        found.instants, found.all_instants = instants, sum(one.end - one.start + 1 for one in log.segments)
        found.limited = component.has_limit(found.variable, found.index)
        # Include events of other kinds if their indices count the same elements (links, cells, ...).
        details, counts = component.event_details, component.event_details[found.kinds[0]].counts
        alike = {*found.kinds, *(kind for kind, detail in details.items() if counts and detail.counts == counts)}
        found.events = tuple(event for event in happened if event.index == found.index and event.kind in alike)
    # The ratio of an element without a limit, such as a cell that cannot yield, is always 0.
    return [found for found, _ in searches if found.ratio > 0.0 or index is not None]


def _replay_instants(log: Log, component: Component) -> Iterator[int]:
    """Run the log again, and yield each tick of the log at which the component must be examined."""
    frames = np.unique(np.concatenate([log.ticks(name) for name in log.variables] or [np.zeros(0, np.int64)]))
    for segment in log.segments:
        start = log.snapshot(segment, segment.start)
        restore_snapshot(component, start)
        changes = log.step_history(segment).input_changes(start.inputs)
        changes.reverse()
        before = segment.elapsed + log.start_tick - segment.start  # the log's tick minus the segment's
        ticks = frames - before
        further = np.linspace(segment.start, segment.end, _INSTANTS + 1).astype(np.int64)
        for tick in np.union1d(ticks[(ticks >= segment.start) & (ticks < segment.end)], further).tolist():
            advance_to_tick(component, changes, tick)
            yield tick + before
