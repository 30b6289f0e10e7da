"""The tables of a report: balances, events, validity, parameters, experiment, machine, and replay commands."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Any

import numpy as np
from markupsafe import Markup

from granular_env.components.errors import GranularError
from granular_env.components.support.parameter_fields import absent_meaning, field_unit
from granular_env.documents import to_toml
from granular_env.recording.event_places import event_summary, event_table, listed_events
from granular_env.recording.header import header_table

from ..html_page import parts
from ..scene_data import SceneData
from ..unit_labels import typeset_unit

_LONGEST_LIST = 8
_MOST_EVENTS = 200
_INCIDENTS = {
    "recovered": "Recovered from another log; lost",
    "resumed": "The run was resumed: its process had been killed or interrupted before",
    "unrecorded": "Steps are missing",
    "failed": "A step failed",
    "interrupted": "A step was interrupted",
}


def balance_table(scene_data: SceneData) -> Markup:
    """Return tables of the balances (such as of energy): entries at the start and the end, and the size of each residual."""
    rows: list[list[Any]] = []
    sentences = []
    for balance in scene_data.balances:
        names = balance.entries, [name for name in scene_data.curves if name.startswith(balance.residual)]
        entries, residuals = map(scene_data.named_curves, names)
        for one in (*entries, *residuals):
            first, last, most = (float(value) + 0.0 for value in (one.values[0], one.values[-1], np.abs(one.values).max()))
            rows.append([one.name.replace("_", " "), typeset_unit(one.unit), first, last, most])
        if names[1]:
            entry, residual = (max((np.abs(one.values).max() for one in own), default=0.0) for own in (entries, residuals))
            quantity = balance.quantity.replace("_", " ")
            sentences.append(f"{quantity} {residual:.2g} of {entry:.2g} {typeset_unit(balance.unit)}")
    if not sentences:
        return Markup()
    table = parts.table(["entry", "unit", "start", "end", "largest magnitude"], rows) if rows else Markup()
    words = (
        f"Largest residuals, which are numerical errors, and entries: {'; '.join(sentences)}. Entries that stay 0 are omitted."
    )
    return table + parts.paragraph(words)


def incident_sentences(log: Any) -> list[str]:
    """Return a sentence on each incident of the recording, and one on the segments if the log has several."""
    sentences = []
    for incident in log.incidents:
        words = [_INCIDENTS.get(str(incident.get("incident")), "Incident")]
        words += [str(incident[key]) for key in ("kind", "message", "lost") if incident.get(key)]
        undone = incident.get("undone_ticks", 0)
        after = f"; internal steps written to the log and then undone: {undone}" if undone else ""
        sentences.append(f"{': '.join(words)}{after}.")
    if (count := len(log.segments)) > 1:
        why = "the component was reset, restored or returned to an earlier state between them"
        sentences.append(f"The log has {count} segments, concatenated in time: {why}.")
    return sentences


def event_section(log: Any) -> Markup:
    """Return the report's parts on the events of the run and, for a branch, before it; empty if no event can occur."""
    kinds = log.event_kinds
    if not kinds:
        return Markup()
    found, earlier = log.events(), log.earlier_events()
    start, before = log.start_tick * log.step_size, earlier or []
    happened = {event.kind for event in (*found, *before)} or kinds
    meanings = "; ".join(f"{kind.replace('_', ' ')}: {text}" for kind, text in kinds.items() if kind in happened)
    summary = event_summary(found, before, start).replace("_", " ") if found or before else "no event"
    sentences = [f"{summary.capitalize()}.", f"Kinds of events: {meanings}."]
    if earlier is None:
        sentences.append(f"This log begins at {start:.9g} s; earlier events are unknown.")
    shown = listed_events(found, before, _MOST_EVENTS)
    if (count := len(found) + len(before)) > len(shown):
        sentences.append(f"The table has {len(shown)} of {count} events; `granular-env events` prints all.")
    heads, rows = event_table(shown, log)
    rows = [[time, kind.replace("_", " "), *others] for time, kind, *others in rows]
    return (parts.table(heads, rows) if rows else Markup()) + parts.paragraph(" ".join(sentences))


def validity_section(log: Any) -> Markup:
    """Return the report's parts on the validity of the model's assumptions in this run."""
    cautions = log.metadata["cautions"]
    rows = [[typeset_unit(name), "unknown" if value is None else value] for name, value in log.metadata["report"].items()]
    words = parts.bullets(cautions, "cautions") if cautions else parts.paragraph("No cautions.")
    return parts.table(["figure", "value"], rows) + words if rows else words


def parameter_table(log: Any) -> Markup:
    """Return all parameters with their values, including defaults; parameters in tables are named TABLE.PARAMETER."""
    model = None
    with suppress(GranularError):
        model = log.component().parameters
    values = {**log.metadata["parameters"], "step_size": log.step_size}
    return parts.table(["parameter", "value", "unit", "meaning"], list(_parameter_rows("", values, model)))


def _parameter_rows(prefix: str, values: Mapping[str, Any], model: Any) -> Iterator[list[Any]]:
    """Yield a table row for each parameter, including those in tables; `model` (or None) has their units and meanings."""
    fields = getattr(type(model), "model_fields", {})
    for name, value in values.items():
        own = getattr(model, name, None)
        if isinstance(value, dict) and value:
            yield from _parameter_rows(f"{prefix}{name}.", value, own)
        elif isinstance(value, list) and value and all(isinstance(entry, dict) for entry in value):
            for place, entry in enumerate(value[:_LONGEST_LIST]):
                part = own[place] if isinstance(own, (list, tuple)) and place < len(own) else None
                yield from _parameter_rows(f"{prefix}{name}[{place}].", entry, part)
        else:
            unit, meaning, absent = "", "", "none"
            if name in fields:
                unit, meaning, absent = field_unit(fields[name]), fields[name].description or "", absent_meaning(fields[name])
            yield [prefix + name, absent if value is None else short_value(value), typeset_unit(unit), meaning]


def short_value(value: Any) -> str:
    """Return a value of a parameter or another setting as text; long lists are shortened."""
    if isinstance(value, list):
        if len(value) > 2 and all(entry == value[0] for entry in value):
            return f"{short_value(value[0])} ({len(value)} times)"
        more = f", ... ({len(value)} values)" if len(value) > _LONGEST_LIST else ""
        shown = [short_value(entry) for entry in value[:_LONGEST_LIST]]
        return ", ".join(f"({text})" if isinstance(value[0], list) else text for text in shown) + more
    return f"{value + 0.0:.6g}" if isinstance(value, float) else "none" if value is None else str(value)  # avoid -0


def experiment_section(log: Any) -> Markup:
    """Return the experiment as a TOML file that can be run again; "" if a script recorded the log."""
    content = header_table(log.metadata.get("experiment"))
    words = "The recorded experiment as a file for the command granular-env run, without the data files that it names."
    return parts.paragraph(words) + parts.preformatted(to_toml(content)) if "component" in content else Markup()


def environment_table(log: Any) -> Markup:
    """Return a table of the software and the machine that recorded the log, and the identity of its component."""
    metadata = log.metadata
    rows = [[f"{name} version", text] for name, text in metadata["versions"].items()]
    rows += [[name.replace("_", " "), short_value(value)] for name, value in metadata["machine"].items()]
    rows.append(["identity of component and parameters", metadata.get("identity", "")])
    return parts.table(["fact", "value"], rows)


def replay_commands(log: Any) -> Markup:
    """Return the commands that replay the log, branch from it and show it."""
    path = shlex.quote(str(log.path))
    middle = (log.start_tick + round(0.5 * log.duration / log.step_size)) * log.step_size
    commands = [
        f"granular-env replay {path} --verify   # run it again and compare every bit",
        f"granular-env branch {path} --at {middle:.6g}   # continue with other inputs",
        f"granular-env view {path}   # show it in rerun",
    ]
    words = parts.paragraph("This page did not verify the log; the first command does.")
    return words + parts.preformatted("\n".join(commands))
