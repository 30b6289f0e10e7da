"""The result of running a log again and comparing: identical, different, incomplete, or nothing to compare."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from ...output_files import count_of
from ..format.header import machine, table_of, versions

# Sentences on pieces that are not in a log, at most.
_MOST_GAPS = 20

Outcome = Literal["identical", "different", "incomplete", "nothing was compared"]
# Parts of the header that no re-run gives again; the log keeps digests of them apart, which are compared.
_DIGESTED = "the experiment, the options, the parent, descriptions, versions, machine, command and date"


@dataclass(slots=True, repr=False)
class Verification:
    """The findings of a re-run.

    Attributes:
        path: the log.
        complete: whether the log was closed.
        calls, ticks: calls of `step`, and ticks, that were run again.
        frames: instants at which the recorded variables were compared.
        hashes, snapshots: how many of each were compared.
        variable: name of the first variable, or entry of the log, that differs; None where nothing does.
        index: its first element that differs, or None where that is not known.
        interval: times between which the difference arose: last agreeing, first differing [s]; None for what has no time.
        notes: one sentence for each difference, then what may explain them.
        missing: parts that every closed log has and this one does not, so that they could not be compared.
        incidents: what happened to the recording, such as "failed" or "recovered"; nothing tells whether that is true.
        gaps: a sentence for each piece of the run that the log says it does not hold.
    """

    path: str
    complete: bool
    calls: int = 0
    ticks: int = 0
    frames: int = 0
    hashes: int = 0
    snapshots: int = 0
    variable: str | None = None
    index: int | None = None
    interval: tuple[float, float] | None = None
    notes: list[str] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    incidents: list[str] = field(default_factory=list)
    gaps: list[str] = field(default_factory=list)

    @property
    def outcome(self) -> Outcome:
        """The verdict in a word or two."""
        if self.variable is not None:
            return "different"
        if not self.ticks:
            return "nothing was compared"
        return "identical" if self.complete else "incomplete"

    @property
    def identical(self) -> bool:
        """Return whether the log was closed, holds at least one tick, and every bit that a re-run gives is the same."""
        return self.outcome == "identical"

    @property
    def message(self) -> str:
        """The verdict for people: a line for what was compared, and one for each difference and each part left out."""
        hashes = count_of(self.hashes, "hash", "hashes")
        kinds = f"{count_of(self.frames, 'frame')}, {hashes}, {count_of(self.snapshots, 'snapshot')}"
        size = f"{count_of(self.calls, 'call')} of step, {count_of(self.ticks, 'tick')} ({kinds})"
        lines = [f"{self.outcome}: {self._summary(size, kinds)}", *self.notes, *_first_of(self.gaps)]
        if self.variable is None and self.ticks:
            if self.missing:
                lines.append(f"not compared, since the log does not have them: {', '.join(self.missing)}")
            lines.append(f"compared with digests, since no re-run gives them: {_DIGESTED}")
            if self.incidents:
                counts = Counter(self.incidents).items()
                kinds = ", ".join(kind if count == 1 else f"{kind} {count} times" for kind, count in counts)
                lines.append(f"not compared, since nothing tells of them: incidents of the recording ({kinds})")
        return "\n".join(lines)

    def _summary(self, size: str, kinds: str) -> str:
        unclosed = "" if self.complete else "; the log was not closed"
        if self.outcome == "different":
            return f"{size if self.ticks else kinds} agree{unclosed}"
        if self.outcome == "nothing was compared":
            return f"the log holds no call of step{unclosed}"
        if self.outcome == "incomplete":
            return f"the log was not closed; what it holds agrees bit for bit: {size}"
        return f"{size} compared bit for bit"

    def __bool__(self) -> bool:
        return self.identical

    def __repr__(self) -> str:
        return f"<Verification of {self.path!r}: {self.message.splitlines()[0]}>"


def _first_of(sentences: list[str]) -> list[str]:
    """Return the first few of many sentences, and how many there are."""
    rest = len(sentences) - _MOST_GAPS
    return sentences if rest <= 0 else [*sentences[:_MOST_GAPS], f"{rest} more such pieces are not in the log"]


class Difference(Exception):  # noqa: N818 - a finding, carried out of nested loops
    """Something of the log that the re-run does not give.

    Attributes:
        variable: its name.
        tick: where that was seen, a tick of the segment.
        index: its element, where that is known.
        reason: what is known beyond that.
    """

    def __init__(self, variable: str, tick: int, index: int | None = None, reason: str = "") -> None:
        """Take what was found."""
        super().__init__(variable)
        self.variable, self.tick, self.index, self.reason = variable, tick, index, reason


def foreign_facts(header: Mapping[str, Any]) -> list[str]:
    """Return versions and facts of the machine that are not those of the recording, in case they are the reason."""
    recorded = {**table_of(header.get("versions")), **table_of(header.get("machine"))}
    return [
        f"{name} was {recorded[name]!r} and is {value!r} now"
        for name, value in {**versions(), **machine()}.items()
        if name in recorded and recorded[name] != value
    ]
