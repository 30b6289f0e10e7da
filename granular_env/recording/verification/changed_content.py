"""Changes in a log after its run: its digests, compared with the parameters, header and inputs that it holds now."""

from __future__ import annotations

from ...components.component import Component
from ...components.errors import LogError
from ..format.digests import header_digests, held_word, parameter_digests, step_digests
from ..format.record_index import DETAIL, SEGMENT
from ..format.records import HASHES, STEPS
from ..format.step_history import raw_sets
from ..replay.log import Log


def changed_parameters(log: Log, component: Component) -> list[str]:
    """Parameters of the component, built from the header, that are not those that the log was recorded with."""
    mine = parameter_digests(component)
    for row in log.records.index.select(HASHES, 0):
        recorded = log.records.read(row).header.get("parameters")
        if isinstance(recorded, dict):
            names = [name for name in {**mine, **recorded} if mine.get(name) != recorded.get(name)]
            if names:
                return names
    return []


def changed_header(log: Log) -> list[str]:
    """Return the entries of the header that are not those that the log was recorded with."""
    mine = header_digests(log.records.header, log.records.header_arrays)
    changed: dict[str, None] = {}
    for segment in log.records.index.all_segments:
        # The first hashes of a segment are taken where it starts; the digests stand beside them.
        for row in log.records.index.select(HASHES, 0, segment.number)[:1]:
            recorded = log.records.read(row).header.get("header")
            recorded = recorded if isinstance(recorded, dict) else {}
            changed |= dict.fromkeys(name for name in {**mine, **recorded} if mine.get(name) != recorded.get(name))
    return list(changed)


def changed_input(log: Log) -> tuple[str, tuple[int, int], str] | None:
    """Return the first input whose steps are not what their digests say, the ticks that its batch spans, and a sentence."""
    accounts = log.records.rows(HASHES)
    accounts = accounts[accounts[:, DETAIL] == 1]
    rows, inputs = log.records.rows(STEPS), list(log.input_variables)
    # Where the writer was killed, the digests of the last batch may be what it did not come to, in a recovered log too.
    without = len(rows) - len(accounts)
    if log.complete and without != 0 and not (without == 1 and "report" not in log.records.closing_header):
        raise LogError(
            f"{len(rows)} batches of steps have {len(accounts)} digests",
            hint="it was put together",
            source=f"log {str(log.path)!r}",
        )
    profile_words = {number: held_word(profile) for number, profile in enumerate(log.profiles)}
    for row, account in zip(rows, accounts, strict=False):
        record, recorded = log.records.read(row), log.records.read(account).header.get("steps")
        mine = step_digests(record.arrays["durations"], raw_sets(record, inputs, profile_words))
        if mine != recorded:
            recorded = recorded if isinstance(recorded, dict) else {}
            names = sorted(name for name in {**mine, **recorded} if mine.get(name) != recorded.get(name))
            span = log.records.log_tick(row[SEGMENT], record.first), log.records.log_tick(row[SEGMENT], record.last)
            name = next((name for name in names if name), "")
            if name:
                return name, span, f"input {name!r} is not what was recorded"
            return "duration", span, "the durations of the calls of step are not what was recorded"
    return None
