"""The largest ratio of a run to the limit of an event, found by running its log again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from operator import itemgetter

import numpy as np

from ...components.component import Component
from ...components.errors import LogError
from .log import Log
from .steps import advance, restore


@dataclass(frozen=True, slots=True)
class EventRatio:
    """The largest part of its limit that what decides an event reached.

    Attributes:
        variable: the output that says it; see `contract.Physics.event_ratio`.
        index: of which link, cell, ...
        time: when [s].
        ratio: what decided over its limit; 1 is an event.
        instants: how many instants were looked at: those of the frames, and the ends of segments.
    """

    variable: str
    index: int
    time: float
    ratio: float
    instants: int


def largest_event_ratio(log: Log, components: Mapping[str, type[Component]] | None = None) -> EventRatio | None:
    """Return how near the run came to an event, at the instants of its frames; None where its component cannot tell.

    Args:
        log: an open log; its run is repeated.
        components: classes of components that are not ours, by name.

    Raises:
        LogError: the log cannot be run again here.
    """
    component = log.component(components)
    if not component.event_ratio:
        return None
    found = list(_ratios(log, component))
    if not found:
        raise LogError("it holds no step, so nothing can be said", at="steps", source=f"log {str(log.path)!r}")
    ratio, index, tick = max(found, key=itemgetter(0))
    return EventRatio(component.event_ratio, index, tick * log.step_size, ratio, len(found))


def _ratios(log: Log, component: Component) -> Iterator[tuple[float, int, int]]:
    """Yield the largest ratio at each instant, its index, and the tick of the log."""
    frames = np.unique(np.concatenate([log.ticks(name) for name in log.variables] or [np.zeros(0, np.int64)]))
    for segment in log.segments:
        start = log.snapshot(segment, segment.start)
        restore(component, start)
        changes = log.steps_of(segment).changes(start.inputs)
        changes.reverse()
        before = segment.elapsed + log.start_tick - segment.start  # the log's tick minus the segment's
        ticks = frames - before
        for tick in np.union1d(ticks[(ticks >= segment.start) & (ticks < segment.end)], segment.end).tolist():
            advance(component, changes, tick)
            ratios = np.ravel(component.peek(component.event_ratio))
            place = int(ratios.argmax())
            yield float(ratios[place]), place, tick + before
