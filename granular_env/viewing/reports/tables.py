"""The tables of a report: balances, events, validity, parameters, the experiment, the machine, and how to replay the log."""

from __future__ import annotations

import math
import os
import shlex
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from markupsafe import Markup
from pydantic.fields import FieldInfo

from granular_env.components.errors import GranularError
from granular_env.components.events import Event
from granular_env.components.support.parameter_fields import left_out, unit_of
from granular_env.documents import to_toml
from granular_env.recording.event_places import event_table, listed_events
from granular_env.recording.header import BalanceNames

from .. import html_page
from ..scene_data import SceneData
from ..unit_labels import typeset

_LONGEST_LIST = 8
_MOST_EVENTS = 200
_MOST_INCIDENTS, _LONGEST_MESSAGE = 20, 1000
_LONGEST_TEXT = 20_000
# Parameters that the component works out -> what its geometry calls them.
_WORKED_OUT = {"mass": "mass", "contact_stiffness": "stiffness"}


def balances(scene_data: SceneData) -> Markup:
    """Return the entries of the balances at the start and at the end, and how well they add up."""
    rows = []
    for balance in scene_data.balances:
        residuals = [name for name in scene_data.curves if name.startswith(balance.residual)]
        for name in (*balance.entries, *residuals):
            curve = scene_data.curves.get(name)
            if curve is not None and len(curve.values):
                first, last, largest = float(curve.values[0]), float(curve.values[-1]), float(np.abs(curve.values).max())
                rows.append([name.replace("_", " "), typeset(curve.unit), first, last, largest])
    if not rows:
        return html_page.paragraph("No balance was recorded.")
    closures = " ".join(_closure(scene_data, balance) for balance in scene_data.balances)
    return html_page.table(["entry", "unit", "start", "end", "largest magnitude"], rows) + html_page.paragraph(closures)


def _closure(scene_data: SceneData, balance: BalanceNames) -> str:
    """Return how large the residual of a balance is beside its largest entry, in one sentence."""
    entries = [scene_data.curves[name] for name in balance.entries if name in scene_data.curves]
    residuals = [curve for name, curve in scene_data.curves.items() if name.startswith(balance.residual)]
    quantity = balance.quantity.replace("_", " ")
    words = f"The residual of the balance of {quantity} is the error of the numerics"
    scale, worst = (max((float(np.abs(one.values).max()) for one in curves), default=0.0) for curves in (entries, residuals))
    if not residuals or scale == 0.0:
        return f"{words}."
    return f"{words}: at most {worst / scale:.2g} of the largest entry, {scale:.2g} {typeset(balance.unit)}."


def incident_sentences(log: Any) -> list[str]:
    """Return a sentence for each incident besides the steps, and one for the segments if they are several."""
    sentences = [text for incident in log.incidents if (text := _incident_sentence(incident))][:_MOST_INCIDENTS]
    if (count := len(log.segments)) > 1:
        why = "the component was reset, restored or put back in between"
        sentences.append(f"The log has {count} segments, laid end to end in time: {why}.")
    return sentences


def _incident_sentence(incident: Mapping[str, Any]) -> str | None:
    undone = incident.get("undone_ticks")
    after = f"; internal steps of it that had been written and were undone: {undone}" if undone else ""
    message = ": ".join(str(incident[key])[:_LONGEST_MESSAGE] for key in ("kind", "message") if incident.get(key))
    return {
        "recovered": f"Recovered from another log; lost: {str(incident.get('lost'))[:_LONGEST_MESSAGE]}.",
        "resumed": "The run was resumed: its process had been killed or interrupted before.",
        "unrecorded": f"Steps are missing: {message}.",
        "failed": f"A step failed: {message}{after}.",
        "interrupted": f"A step was interrupted: {message or 'by the user'}{after}.",
    }.get(str(incident.get("incident")))


def events(log: Any) -> Markup:
    """Return what happened to the component in the run and, of a branch, before it; empty where nothing could."""
    kinds = log.event_kinds
    if not kinds:
        return Markup()
    found, earlier = log.events(), log.earlier_events()
    told = _earlier_events(log, earlier)
    if not found and not earlier:
        nothing = "Nothing happened in this log of what could: " + ", ".join(kinds) + "."
        return html_page.paragraph(f"{nothing} {told}".strip())
    shown = listed_events(found, earlier or [], _MOST_EVENTS)
    heads, rows = event_table(shown, log)
    for row in rows:
        row[1] = row[1].replace("_", " ")
    more = ""
    if len(shown) < len(found) + len(earlier or []):
        which = f"first {len(shown)} of {len(found)} events" if len(found) > _MOST_EVENTS else f"table has {len(shown)}"
        more = f"The {which}; `events()` and `earlier_events()` of `ge.open_log(path)` have all of them."
    words = "; ".join(f"{kind.replace('_', ' ')}: {text}" for kind, text in kinds.items())
    return html_page.table(heads, rows) + html_page.paragraph(" ".join(filter(None, [f"{words}.", told, more])))


def _earlier_events(log: Any, earlier: Sequence[Event] | None) -> str:
    """Return in words what happened before a log begins; empty where nothing did."""
    start = f"{log.start_tick * log.step_size:.9g} s"
    if earlier is None:
        return f"This log begins at {start}, and does not say what happened before."
    if not earlier:
        return ""
    counts = Counter(event.kind.replace("_", " ") for event in earlier).most_common()
    kinds = ", ".join(f"{count} x {kind}" for kind, count in counts)
    return f"Of these events {len(log.events())} are in this log, {len(earlier)} before it begins at {start}: {kinds}."


def validity(log: Any) -> Markup:
    """Return how far the model's assumptions held."""
    metadata = log.metadata
    figures_of_run, cautions = metadata["report"], metadata["cautions"]
    parts = []
    if figures_of_run:
        rows = [[typeset(name), _number(value)] for name, value in figures_of_run.items()]
        parts.append(html_page.table(["figure", "value"], rows))
    else:
        parts.append(
            html_page.paragraph("The component reports no figures of validity, or the run was interrupted before it could.")
        )
    parts.append(html_page.bullets(cautions, "cautions") if cautions else html_page.paragraph("No cautions."))
    return Markup().join(parts)


def _number(value: Any) -> Any:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value) if math.isfinite(value) else "unknown"
    return "unknown" if value is None else value


def parameters(log: Any) -> Markup:
    """Return every parameter with its value, also where that is a default or was worked out.

    A table among them has rows under its name.
    """
    component = None
    with suppress(GranularError):
        component = log.component()
    model = None if component is None else component.parameters
    worked_out = {"step_size": log.step_size, **_worked_out(getattr(component, "geometry", None))}
    rows = _parameter_rows("", log.metadata["parameters"], model, worked_out)
    return html_page.table(["parameter", "value", "unit", "meaning"], rows)


def _parameter_rows(path: str, values: Mapping[str, Any], model: Any, worked_out: Mapping[str, Any]) -> Iterator[list[Any]]:
    """Yield a row for each value, and those of the tables among them, each under a row with its name alone.

    Args:
        path: name of the table; empty for the outermost.
        values: what is in it.
        model: the values as the component has them, with units and meanings; None where that is not known.
        worked_out: what the component makes of values that were left to it.
    """
    fields: Mapping[str, FieldInfo] = getattr(type(model), "model_fields", {})
    tables = list[tuple[str, Mapping[str, Any], Any]]()
    for name, value in values.items():
        if inner := list(_tables(f"{path}.{name}" if path else name, value, getattr(model, name, None))):
            tables += inner
            continue
        unit, meaning, without = "", "", "none"
        if name in fields:
            unit, meaning, without = unit_of(fields[name]), fields[name].description or "", left_out(fields[name])
        shown = without if value is None else _short(value)
        if value is None and name in worked_out:
            shown = f"{without}: {_short(worked_out[name])}"
        yield [name, shown, typeset(unit), meaning]
    for place, table, inner in tables:
        yield [place]
        yield from _parameter_rows(place, table, inner, {})


def _tables(name: str, value: Any, model: Any) -> Iterator[tuple[str, Mapping[str, Any], Any]]:
    """Yield the tables that a value is, or is a list of: name, content, and how the component has it."""
    if isinstance(value, dict) and value:
        yield name, value, model
    elif isinstance(value, list) and value and all(isinstance(entry, dict) and entry for entry in value):
        models = model if isinstance(model, (list, tuple)) and len(model) == len(value) else [None] * len(value)
        for place, entry in enumerate(value[:_LONGEST_LIST]):
            more = f" (of {len(value)})" if len(value) > _LONGEST_LIST else ""
            yield f"{name}[{place}]{more}", entry, models[place]


def _worked_out(geometry: Any) -> dict[str, list[float]]:
    """Return what a component's geometry has for the parameters that were left to it."""
    found = {name: getattr(geometry, attribute, ()) for name, attribute in _WORKED_OUT.items()}
    return {name: kept for name, values in found.items() if (kept := [one for one in np.ravel(values).tolist() if one != 0.0])}


def _short(value: Any) -> str:
    if isinstance(value, list) and value and all(entry == value[0] for entry in value):
        return f"{_short(value[0])} ({len(value)} times)" if len(value) > 1 else _short(value[0])
    if isinstance(value, list) and len(value) > _LONGEST_LIST:
        return f"{', '.join(str(_short(entry)) for entry in value[:_LONGEST_LIST])}, ... ({len(value)} values)"
    if isinstance(value, list):
        return ", ".join(_short(entry) for entry in value)
    if isinstance(value, dict):
        return ", ".join(f"{key} = {_short(entry)}" for key, entry in value.items())
    return f"{value + 0.0:.6g}" if isinstance(value, float) else "" if value is None else str(value)  # no -0


def experiment(log: Any) -> Markup:
    """Return the experiment as a TOML file that can be run again; "" where the log was recorded by a script."""
    content = log.metadata.get("experiment")
    if not isinstance(content, dict) or "component" not in content:
        return Markup()
    text = to_toml(content)
    words = "The experiment as it was run, as a file for the command granular-env run; data files that it names are not here."
    if len(text) > _LONGEST_TEXT:
        text = f"{text[:_LONGEST_TEXT]}\n# ... cut off: the log holds all of it"
    return html_page.paragraph(words) + html_page.preformatted(text)


def environment(log: Any) -> Markup:
    """Return what the log was recorded with, and its size."""
    metadata = log.metadata
    rows = [[f"{name} version", text] for name, text in metadata["versions"].items()]
    rows += [[name.replace("_", " "), _short(value)] for name, value in metadata["machine"].items()]
    rows.append(["bits depend on the platform", "yes" if metadata.get("platform_bound") else "no"])
    rows.append(["identity of component and parameters", metadata.get("identity", "")])
    rows.append(["size of the log", file_size(os.path.getsize(log.path))])
    return html_page.table(["fact", "value"], rows)


def file_size(count: int) -> str:
    """Return a number of bytes in words: ``1.17 MB``."""
    for unit, size in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if count >= size:
            return f"{count / size:.3g} {unit}"
    return f"{count} bytes"


def replay(log: Any) -> Markup:
    """Return the commands that re-run the log, branch it off and show it."""
    path = shlex.quote(html_page.printable(log.path))
    middle = log.start_tick * log.step_size + (round(0.5 * log.duration / log.step_size)) * log.step_size
    commands = [
        f"granular-env replay {path} --verify      # re-run it and compare every recorded bit",
        f"granular-env branch {path} --at {middle:.12g}      # go on from there, with other inputs",
        f"granular-env view {path}      # look at it in rerun",
    ]
    words = (
        "The log is a program; these commands re-run it, branch it off and show it. Making this page did not verify it: the "
        "first command does."
    )
    return html_page.paragraph(words) + html_page.preformatted("\n".join(commands))
