"""Declarations of a log's component beside the run, compared with the component of the re-run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from ...components.component import Component
from ...components.support.serialization import canonical_json
from ..format.header import closing_facts, component_facts
from ..format.metadata import METADATA_NAME, metadata_of_log
from ..format.records import words
from ..replay.log import Log

# Compared elsewhere: what decides whether the component can be built and stepped at all.
_ELSEWHERE = ("component", "parameters", "identity", "step_size")


def declaration_differences(log: Log, component: Component) -> Iterator[tuple[str, str]]:
    """Yield the name, and a sentence, for each declaration and array of the header that the component does not give."""
    facts, arrays = component_facts(component, list(log.variables))
    for name, value in facts.items():
        recorded = log.records.header.get(name)
        if name in ("variables", "inputs"):
            yield from _variable_differences(recorded, value)
        elif name not in _ELSEWHERE and not _is_same(recorded, value):
            yield name, f"{name} is {recorded!r} in the header, and {value!r} for this program's {component.name}"
    for name in sorted({**arrays, **log.records.header_arrays}):
        mine, recorded = arrays.get(name), log.records.header_arrays.get(name)
        if mine is None or recorded is None or mine.shape != recorded.shape or words(mine) != words(recorded):
            yield name, f"the array {name!r} of the header, which viewers draw, is not what the parameters give"


def metadata_differences(log: Log, component: Component) -> Iterator[tuple[str, str]]:
    """Yield a sentence where the record that stock tools show is not the copy of the header that it should be."""
    if not log.complete:
        return
    # A log of a component that is not ours may have been recovered where its units were not known.
    expected = [[(METADATA_NAME, metadata_of_log(log.records.header, model))] for model in (component.Parameters, None)]
    if log.records.container.metadata() not in expected:
        yield "metadata", "the Metadata record for other programs is not what the header says"


def closing_differences(log: Log, component: Component) -> Iterator[tuple[str, str]]:
    """Yield the name, and a sentence, for what the end of a log says of the run and the component, at its end, does not."""
    recorded = log.records.closing_header
    for name, value in closing_facts(component).items():
        if name in recorded and not _is_same(recorded[name], value):
            yield name, f"the {name} at the end of the log differs: {_where(recorded[name], value)}"


def _variable_differences(recorded: Any, mine: list[dict[str, Any]]) -> Iterator[tuple[str, str]]:
    by_name = {facts["name"]: facts for facts in recorded}
    for facts in mine:
        name = facts["name"]
        for key, value in facts.items():
            # Wording may change with the program; what was recorded is held by its digest.
            if key != "description" and by_name[name].get(key) != value:
                yield name, f"the {key} of {name!r} is {by_name[name].get(key)!r} in the header, and {value!r} for this program"


def _where(recorded: Any, mine: Any) -> str:
    if not isinstance(recorded, Mapping) or not isinstance(mine, Mapping):
        return f"it says {recorded!r}, the re-run {mine!r}"
    names = [name for name in {**mine, **recorded} if not _is_same(recorded.get(name), mine.get(name))]
    return ", ".join(f"{name} is {recorded.get(name)!r}, and {mine.get(name)!r} in the re-run" for name in names)


def _is_same(first: Any, second: Any) -> bool:
    return canonical_json(first) == canonical_json(second)
