"""Command `events`: list the events of a log, with their times and exceeded limits."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import click

from granular_env.cli.command import Status, command, print_json
from granular_env.cli.options import FILE, allow_large_option, component_option, exclusive_options, json_option
from granular_env.output_files import count_text
from granular_env.terminal_text import align_columns, printable_text, wrap_text

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
@click.option("--index", metavar="N", type=int, help="Only events of this link, cell or other element.")
@click.option(
    "--nearest",
    "near",
    is_flag=True,
    help="Run the log again and print, for each kind of event, the place that came closest to its limit.",
)
@click.option("--all", "every", is_flag=True, help=f"List all events, not only {_MOST}.")
@json_option()
@allow_large_option()
@component_option()
@exclusive_options("near", "every")
def events(
    log: str,
    kind: str | None,
    index: int | None,
    near: bool,
    every: bool,
    as_json: bool,
    allow_large: bool,
    components: dict[str, Any],
) -> int:
    """List the events of a run with their times and exceeded limits, or the places that came closest to an event."""
    from granular_env.recording import open_log
    from granular_env.recording.event_places import event_summary, event_table, listed_events, refuse_unknown_place
    from granular_env.recording.near_misses import find_near_misses, kinds_by_ratio

    with open_log(log, allow_large=allow_large, components=components) as opened:
        found, kinds, step_size = opened.events(kind, index), opened.event_kinds, opened.step_size
        start = opened.start_tick * step_size
        earlier = opened.earlier_events(kind, index)
        details, drawables, conclusions = opened.event_details, opened.drawables, opened.metadata["conclusions"]
        refuse_unknown_place(opened, kind, index)
        if near:
            ratios = find_near_misses(opened, index, kind)
            print_json(_ratio_rows(opened, ratios)) if as_json else print(_near_miss_text(opened, ratios, kind))
            return Status.DONE
    if as_json:
        rows = [_event_row(event, step_size, details, drawables) for event in found]
        rows_before = [_event_row(event, step_size, details, drawables) for event in earlier or []]
        before = {"earlier_events": None if earlier is None else rows_before}
        print_json({"kinds": kinds, "events": rows, **before, "conclusions": conclusions})
        return Status.DONE
    every_event = [*(earlier or []), *found]
    for text in conclusions:
        print(wrap_text(printable_text(str(text))))
    if not kinds:
        print("events: none; the component of this log declares no kind of event")
    elif not every_event:
        asked = "" if kind is None and index is None else " of that kind or index"
        further = ["--nearest prints how close the run came to an event"] if kinds_by_ratio(details) else []
        print("\n".join([f"events: none{asked}; possible events are", *_kind_descriptions(kinds), *further]))
    else:
        shown = every_event if every else listed_events(found, earlier or [], _MOST)
        heads, rows = event_table(shown, opened)
        print(align_columns([tuple(heads), *(_table_cells(row) for row in rows)], ""))
        which = f"{len(shown)} of this log" if earlier and found else str(len(shown))
        rest = "" if len(shown) == len(every_event) else f"; the first {which} are listed, --all lists all"
        summary = printable_text(event_summary(found, earlier or [], start))
        print("\n".join([f"{summary}{rest}", *_kind_descriptions({event.kind: kinds[event.kind] for event in every_event})]))
    if kinds and earlier is None:
        print(f"this log begins at {start:.9g} s; earlier events are stored in its component, which cannot be built here")
    return Status.DONE


def _near_miss_text(log: Log, ratios: list[EventRatio], kind: str | None) -> str:
    """Return the text that `--nearest` prints: for each kind of event, the place that came closest to its limit."""
    from granular_env.recording.near_misses import kinds_by_ratio

    if not log.event_kinds:
        return "nearest: none; with the parameters of this log no kind of event can happen"
    if ratios:
        return "\n".join(wrap_text(_near_miss_sentence(log, one)) for one in ratios)
    details = {name: detail for name, detail in log.event_details.items() if kind in (None, name)}
    if kinds_by_ratio(details):
        return "nearest: none; every element with a limit exceeded it"
    what = "an event" if kind is None else printable_text(kind)
    return f"nearest: unknown; no output of this component gives the ratio to the limit of {what}"


def _near_miss_sentence(log: Log, ratio: EventRatio) -> str:
    from granular_env.recording.event_places import event_place, position_text

    known = event_place(ratio.index, log.event_details.get(ratio.kinds[0]), log.drawables)
    place = f", {printable_text(known.elements)} at {position_text(known.position)} m," if known is not None else ""
    what, kinds = f"nearest: {printable_text(ratio.variable)}[{ratio.index}]{place}", printable_text(" or ".join(ratio.kinds))
    if not ratio.limited:
        return f"{what} has no limit: {kinds} cannot happen there"
    happened = "; ".join(f"{printable_text(one.kind)} happened there {_event_time_text(log, one)}" for one in ratio.events)
    others = f"{count_text(ratio.passed, 'other')} exceeded it" if ratio.passed else "none exceeded it"
    limited = printable_text(ratio.nearest) or kinds
    return (
        f"{what} reached {ratio.ratio:.6g} of its limit at {ratio.time:.9g} s (limit of {limited}; "
        f"{happened or others}; {ratio.instants} of {count_text(ratio.all_instants, 'instant')} examined)"
    )


def _event_time_text(log: Log, event: Event) -> str:
    before = f", before this log begins at {log.start_tick * log.step_size:.9g} s" if event.tick <= log.start_tick else ""
    return f"at {event.tick * log.step_size:.9g} s{before}"


def _ratio_rows(log: Log, ratios: list[EventRatio]) -> list[dict[str, Any]]:
    rows = []
    for one in ratios:
        place = _place_facts(one.index, log.event_details.get(one.kinds[0]), log.drawables)
        events = [{"kind": event.kind, "time": event.tick * log.step_size} for event in one.events]
        rows.append({**dataclasses.asdict(one), **place, "events": events})
    return rows


def _event_row(
    event: Event, step_size: float, details: Mapping[str, EventDetail], drawables: Sequence[Drawable]
) -> dict[str, Any]:
    """Return one event (time, kind, index, value, limit, place) as JSON values."""
    place = _place_facts(event.index, details.get(event.kind), drawables)
    return {**dataclasses.asdict(event), "time": event.tick * step_size, **place}


def _table_cells(row: list[Any]) -> tuple[str, ...]:
    """Return an event's table row as text: the time precise to a tick, other numbers to six digits, and 0 instead of -0."""
    words = [f"{one + 0.0:.6g}" if isinstance(one, float) else printable_text(str(one)) for one in row[1:]]
    return f"{row[0]:.9g}", *words


def _place_facts(index: int | None, detail: EventDetail | None, drawables: Sequence[Drawable]) -> dict[str, Any]:
    """Return, for the events of one kind at one index, the unit of their values and their place, as JSON values."""
    from granular_env.recording.event_places import event_place

    place = event_place(index, detail, drawables)
    unit = {"unit": detail.unit} if detail is not None and detail.unit else {}
    return unit if place is None else {**unit, "of": place.elements, "position": place.position}


def _kind_descriptions(kinds: dict[str, str]) -> list[str]:
    return [wrap_text(f"  {printable_text(kind)}: {printable_text(text)}") for kind, text in kinds.items()]
