"""Events of a log: `events`, which says what broke, when, and by how much."""

from __future__ import annotations

import dataclasses
import json
from collections import Counter
from typing import TYPE_CHECKING, Any

import click

from granular_env.cli.command import command
from granular_env.cli.completion import files
from granular_env.cli.exit_status import Status
from granular_env.cli.options import component_option, exclusive, json_option, large_option
from granular_env.output_files import count_of
from granular_env.terminal_text import columns, printable, wrap_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from granular_env.components.drawables import Drawable
    from granular_env.components.events import Event, EventDetail
    from granular_env.recording import Log
    from granular_env.recording.replay.near_misses import EventRatio

_MOST = 40


@command("events")
@click.argument("log", shell_complete=files)
@click.option("--kind", metavar="KIND", help="Only events of this kind.")
@click.option("--index", metavar="N", type=int, help="Only those of this link, cell, ...")
@click.option("--nearest", "near", is_flag=True, help="Run it again, and say how near it came where nothing happened.")
@click.option("--all", "every", is_flag=True, help=f"List all of them, not the first {_MOST}.")
@json_option()
@large_option()
@component_option()
@exclusive("near", "kind")
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
    from granular_env.recording.reader.event_places import event_table, refuse_unknown_place
    from granular_env.recording.replay.near_misses import kinds_by_ratio, nearest_to_events

    with open_log(log, allow_large=allow_large, components=components) as opened:
        found, kinds, step_size = opened.events(kind, index), opened.event_kinds, opened.step_size
        known, end = opened.events_end_tick, opened.end_tick
        details, drawables, conclusions = opened.event_details, opened.drawables, opened.metadata["conclusions"]
        refuse_unknown_place(index, [details.get(one) for one in kinds if kind in (None, one)], drawables)
        if near:
            ratios = nearest_to_events(opened, index)
            print(_for_programs(opened, ratios) if for_programs else _nearest(opened, ratios, index))
            return Status.DONE
    if for_programs:
        rows = [
            {
                **dataclasses.asdict(event),
                "time": event.tick * step_size,
                **_facts(event.index, details.get(event.kind), drawables),
            }
            for event in found
        ]
        print(json.dumps({"kinds": kinds, "events": rows, "conclusions": conclusions}, indent=2))
        return Status.DONE
    for text in conclusions:
        print(wrap_text(printable(str(text))))
    if not kinds:
        print("events: none; the component of this log declares no kind of event")
    elif not found:
        asked = "" if kind is None and index is None else " of that kind or index"
        further = ["--nearest says how near the run came"] if kinds_by_ratio(details) else []
        print("\n".join([f"events: none{asked}; it would be one when", *_meanings(kinds), *further]))
    else:
        shown = found if every else found[:_MOST]
        heads, rows = event_table(shown, step_size, details, drawables)
        print(columns([tuple(heads), *(_cells(row) for row in rows)], ""))
        rest = "" if len(shown) == len(found) else f"; the first {len(shown)} are listed, --all lists the others too"
        print("\n".join([f"{summary(found)}{rest}", *_meanings({event.kind: kinds[event.kind] for event in found})]))
    if kinds and known < end:
        print(f"the end of this log was lost: events after {known * step_size:.9g} s may be missing")
    return Status.DONE


def _nearest(log: Log, ratios: list[EventRatio], index: int | None) -> str:
    """Return the lines of `--nearest` for people."""
    from granular_env.recording.replay.near_misses import kinds_by_ratio

    if not log.event_kinds:
        return "nearest: none; with the parameters of this log nothing has a limit that it could come near to"
    if ratios:
        return "\n".join(wrap_text(_words_for(log, one, index)) for one in ratios)
    if kinds_by_ratio(log.event_details):
        return "nearest: none; whatever has a limit passed it"
    return "nearest: not known; the component of this log has no output that says how near an event is"


def _words_for(log: Log, found: EventRatio, index: int | None) -> str:
    from granular_env.recording.reader.event_places import place_of, position_words

    known = place_of(found.index, log.event_details.get(found.kinds[0]), log.drawables)
    place = f", {printable(known.elements)} at {position_words(known.position)} m," if known is not None else ""
    happened = [one for kind in found.kinds for one in log.events(kind, index)] if index is not None else []
    others = "".join(
        f"; {printable(one.kind)} happened there at {one.tick * log.step_size:.9g} s" for one in _other_events(log, found)
    )
    rest = (
        f"it happened there at {happened[0].tick * log.step_size:.9g} s" if happened
        else f"{count_of(found.passed, 'other')} passed it" if found.passed else "nothing passed it"
    )  # fmt: skip
    return (
        f"nearest: {printable(found.variable)}[{found.index}]{place} reached {found.ratio:.6g} of its limit at "
        f"{found.time:.9g} s (1 is {printable(found.nearest or ' or '.join(found.kinds))}; {rest}{others}; "
        f"{found.instants} of {count_of(found.all_instants, 'instant')} looked at)"
    )


def _other_events(log: Log, found: EventRatio) -> list[Event]:
    """Return what else happened to the link, point, ... that came nearest, such as a point that was torn before it parted."""
    details = log.event_details
    own = details.get(found.kinds[0])
    if own is None or not own.counts:
        return []
    alike = {kind for kind, detail in details.items() if detail.counts == own.counts and kind not in found.kinds}
    return [event for event in log.events(None, found.index) if event.kind in alike]


def _for_programs(log: Log, ratios: list[EventRatio]) -> str:
    facts = [
        {
            **_facts(one.index, log.event_details.get(one.kinds[0]), log.drawables),
            "other_events": [{"kind": event.kind, "time": event.tick * log.step_size} for event in _other_events(log, one)],
        }
        for one in ratios
    ]
    return json.dumps([{**dataclasses.asdict(one), **place} for one, place in zip(ratios, facts, strict=True)], indent=2)


def summary(found: list[Event]) -> str:
    """Return how many events there were of each kind."""
    kinds = ", ".join(f"{count} {printable(kind)}" for kind, count in Counter(event.kind for event in found).most_common())
    return f"{count_of(len(found), 'event')}: {kinds}"


def _cells(row: list[Any]) -> tuple[str, ...]:
    """Return a row of the table of events as text: the time to the tick, other numbers to six digits, and no -0."""
    words = [f"{one + 0.0:.6g}" if isinstance(one, float) else printable(str(one)) for one in row[1:]]
    return f"{row[0]:.9g}", *words


def _facts(index: int | None, detail: EventDetail | None, drawables: Sequence[Drawable]) -> dict[str, Any]:
    """Return unit and place of events with an index, for programs."""
    from granular_env.recording.reader.event_places import place_of

    place = place_of(index, detail, drawables)
    unit = {"unit": detail.unit} if detail is not None and detail.unit else {}
    return unit if place is None else {**unit, "of": place.elements, "position": place.position}


def _meanings(kinds: dict[str, str]) -> list[str]:
    return [wrap_text(f"  {printable(kind)}: {printable(text)}") for kind, text in kinds.items()]
