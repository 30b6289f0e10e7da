"""Incidents of a run besides its steps, in sentences: failures, interruptions, steps not recorded, a recovery, a resumption."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_MOST = 20
_LONGEST = 1000


def incident_sentences(log: Any) -> list[str]:
    """Return a sentence for each incident that a reader should know of, and one for the segments if they are several."""
    sentences = [text for incident in log.incidents if (text := _sentence(incident))]
    if len(sentences) > _MOST:
        sentences = [*sentences[:_MOST], f"{len(sentences) - _MOST} more incidents are in the log"]
    if (count := len(log.segments)) > 1:
        why = "the component was reset, restored or put back in between"
        sentences.append(f"The log has {count} segments, laid end to end in time: {why}.")
    return sentences


def _sentence(incident: Mapping[str, Any]) -> str | None:
    kind = incident.get("incident")
    if kind == "recovered":
        return f"Recovered from another log; lost: {_cut(incident.get('lost'))}."
    if kind == "resumed":
        return "The run was resumed: its process had been killed or interrupted before."
    if kind == "unrecorded":
        return f"Steps are missing: {_cut(incident.get('message'))}."
    if kind not in ("failed", "interrupted"):
        return None
    message = ": ".join(_cut(incident[key]) for key in ("kind", "message") if incident.get(key))
    if kind == "failed":
        return f"A step failed: {message}" + _undone(incident)
    return "A step was interrupted" + (f" ({message})" if message else "") + _undone(incident)


def _undone(incident: Mapping[str, Any]) -> str:
    ticks = incident.get("undone_ticks")
    if not isinstance(ticks, int) or ticks <= 0:
        return ""
    written = "1 internal step of it, which had been written already, was" if ticks == 1 else (
        f"{ticks} internal steps of it, which had been written already, were"
    )  # fmt: skip
    return f"; {written} undone"


def _cut(value: object) -> str:
    text = str(value)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."
