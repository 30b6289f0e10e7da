"""Events of a log: `events`, which says what broke, when, and by how much."""

from __future__ import annotations

import dataclasses
import json
from collections import Counter
from typing import TYPE_CHECKING, Any

import click

from granular_env.cli.command import Status, command
from granular_env.cli.options import FILE, component_option, exclusive, json_option, large_option
from granular_env.output_files import count_of
from granular_env.terminal_text import columns, printable, wrap_text

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from granular_env.components.drawables import Drawable
    from granular_env.components.events import Event, EventDetail
    from granular_env.recording import Log
    from granular_env.recording.near_misses import EventRatio

_MOST = 40


@command("events")
@click.argument("log", help="A log.", type=FILE)
@click.option("--kind", metavar="KIND", help="Only events of this kind.")
@click.option("--index", metavar="N", type=int, help="Only those of this link, cell, ...")
@click.option(
    "--nearest",
    "near",
    is_flag=True,
    help="Run it again, and say how near it came where nothing happened; to this KIND alone, or at this N.",
)
@click.option("--all", "every", is_flag=True, help=f"List all of them, not only {_MOST}.")
@json_option()
@large_option()
@component_option()
@exclusive("near", "every")
def events(
    log: str,
    kind: str | None,
    index: int | None,
    near: bool,
    every: bool,
    for_programs: bool,
    allow_large: bool,
    components: dict[str, Any],
) -> int:
    """Say what happened in a run, when, and which limit was passed; or how near it came."""
    from granular_env.recording import open_log
    from granular_env.recording.event_places import event_table, listed_events, refuse_unknown_place
    from granular_env.recording.near_misses import kinds_by_ratio, nearest_to_events

    with open_log(log, allow_large=allow_large, components=components) as opened:
        found, kinds, step_size = opened.events(kind, index), opened.event_kinds, opened.step_size
        start = opened.start_tick * step_size
        earlier = opened.earlier_events(kind, index)
        details, drawables, conclusions = opened.event_details, opened.drawables, opened.metadata["conclusions"]
        refuse_unknown_place(opened, kind, index)
        if near:
            ratios = nearest_to_events(opened, index, kind)
            print(_for_programs(opened, ratios) if for_programs else _nearest(opened, ratios, kind))
            return Status.DONE
    if for_programs:
        rows, rows_before = ([_row(event, step_size, details, drawables) for event in some] for some in (found, earlier or []))
        before = {"earlier_events": None if earlier is None else rows_before}
        print(json.dumps({"kinds": kinds, "events": rows, **before, "conclusions": conclusions}, indent=2))
        return Status.DONE
    every_event = [*(earlier or []), *found]
    for text in conclusions:
        print(wrap_text(printable(str(text))))
    if not kinds:
        print("events: none; the component of this log declares no kind of event")
    elif not every_event:
        asked = "" if kind is None and index is None else " of that kind or index"
        further = ["--nearest says how near the run came"] if kinds_by_ratio(details) else []
        print("\n".join([f"events: none{asked}; it would be one when", *_meanings(kinds), *further]))
    else:
        shown = every_event if every else listed_events(found, earlier or [], _MOST)
        heads, rows = event_table(shown, opened)
        print(columns([tuple(heads), *(_cells(row) for row in rows)], ""))
        which = f"{len(shown)} of this log" if earlier and found else str(len(shown))
        rest = "" if len(shown) == len(every_event) else f"; the first {which} are listed, --all lists the others too"
        told = summary(found, earlier or [], start)
        print("\n".join([f"{told}{rest}", *_meanings({event.kind: kinds[event.kind] for event in every_event})]))
    if kinds and earlier is None:
        print(f"this log begins at {start:.9g} s; what happened before is known to its component, which cannot be made here")
    return Status.DONE


def _nearest(log: Log, ratios: list[EventRatio], kind: str | None) -> str:
    """Return the lines of `--nearest` for people."""
    from granular_env.recording.near_misses import kinds_by_ratio

    if not log.event_kinds:
        return "nearest: none; with the parameters of this log no kind of event can happen"
    if ratios:
        return "\n".join(wrap_text(_words_for(log, one)) for one in ratios)
    details = {name: detail for name, detail in log.event_details.items() if kind in (None, name)}
    if kinds_by_ratio(details):
        return "nearest: none; whatever has a limit passed it"
    what = "an event" if kind is None else printable(kind)
    return f"nearest: not known; the component of this log has no output that says how near {what} is"


def _words_for(log: Log, found: EventRatio) -> str:
    from granular_env.recording.event_places import place_of, position_words

    known = place_of(found.index, log.event_details.get(found.kinds[0]), log.drawables)
    place = f", {printable(known.elements)} at {position_words(known.position)} m," if known is not None else ""
    what, kinds = f"nearest: {printable(found.variable)}[{found.index}]{place}", printable(" or ".join(found.kinds))
    if not found.limited:
        return f"{what} has no limit: {kinds} cannot happen there"
    happened = "; ".join(f"{printable(one.kind)} happened there {_when(log, one)}" for one in found.events)
    others = f"{count_of(found.passed, 'other')} passed it" if found.passed else "nothing passed it"
    return (
        f"{what} reached {found.ratio:.6g} of its limit at {found.time:.9g} s (limit of {printable(found.nearest) or kinds}; "
        f"{happened or others}; {found.instants} of {count_of(found.all_instants, 'instant')} examined)"
    )


def _when(log: Log, event: Event) -> str:
    before = f", before this log begins at {log.start_tick * log.step_size:.9g} s" if event.tick <= log.start_tick else ""
    return f"at {event.tick * log.step_size:.9g} s{before}"


def _for_programs(log: Log, ratios: list[EventRatio]) -> str:
    rows = []
    for one in ratios:
        place = _facts(one.index, log.event_details.get(one.kinds[0]), log.drawables)
        events = [{"kind": event.kind, "time": event.tick * log.step_size} for event in one.events]
        rows.append({**dataclasses.asdict(one), **place, "events": events})
    return json.dumps(rows, indent=2)


def _row(event: Event, step_size: float, details: Mapping[str, EventDetail], drawables: Sequence[Drawable]) -> dict[str, Any]:
    """Return an event for programs."""
    place = _facts(event.index, details.get(event.kind), drawables)
    return {**dataclasses.asdict(event), "time": event.tick * step_size, **place}


def summary(found: Sequence[Event], earlier: Sequence[Event], start: float) -> str:
    """Return how many events there were of each kind.

    Args:
        found: those of a log, or of a run.
        earlier: those before it.
        start: where it begins [s].
    """
    if not earlier:
        return f"{count_of(len(found), 'event')}: {_kinds_in(found)}"
    here = f"{count_of(len(found), 'event')} in this log: {_kinds_in(found)}" if found else "no event in this log"
    return f"{here}; {len(earlier)} before it begins at {start:.9g} s: {_kinds_in(earlier)}"


def _kinds_in(found: Sequence[Event]) -> str:
    return ", ".join(f"{count} {printable(kind)}" for kind, count in Counter(event.kind for event in found).most_common())


def _cells(row: list[Any]) -> tuple[str, ...]:
    """Return a row of the table of events as text: the time to the tick, other numbers to six digits, and no -0."""
    words = [f"{one + 0.0:.6g}" if isinstance(one, float) else printable(str(one)) for one in row[1:]]
    return f"{row[0]:.9g}", *words


def _facts(index: int | None, detail: EventDetail | None, drawables: Sequence[Drawable]) -> dict[str, Any]:
    """Return unit and place of events with an index, for programs."""
    from granular_env.recording.event_places import place_of

    place = place_of(index, detail, drawables)
    unit = {"unit": detail.unit} if detail is not None and detail.unit else {}
    return unit if place is None else {**unit, "of": place.elements, "position": place.position}


def _meanings(kinds: dict[str, str]) -> list[str]:
    return [wrap_text(f"  {printable(kind)}: {printable(text)}") for kind, text in kinds.items()]
