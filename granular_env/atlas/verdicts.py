"""Verdicts: how a paper's number and a computed one compare. Nobody writes a verdict down; they come from the numbers."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Sequence
from typing import Literal

from .bands import Band

Kind = Literal["reproduced", "in part", "as bands", "not reproduced", "no figure"]

_NOT_WORTH_SAYING = 1e-3
_DECIMAL = re.compile(r"[-+]?\d*\.?\d+")


@dataclasses.dataclass(frozen=True)
class Verdict:
    """A kind for counting and colouring, and the words that say how far it goes."""

    kind: Kind
    words: str


@dataclasses.dataclass(frozen=True)
class Value:
    """A number of the paper beside ours.

    Attributes:
        label: which one, where an item has several.
        printed: as the paper has it, such as "2.708" or "about 10"; None: the paper gives none.
        computed: ours: a number, or words that are compared with `printed`.
        unit: SI, or as the paper prints it.
        paper: the number that `printed` means, where it is not the decimal itself ("unchanged" is 0).
        tolerance: largest difference that counts as reproduced; default: half a unit of the last printed digit.
        relative: the same as a part of the paper's value.
        at_most: whether the paper states an upper bound, which less satisfies.
        loose: a larger difference, within which it holds in part.
        band: ours as a distribution over many draws, of which the paper has one; `computed` is its mean.
    """

    label: str
    printed: str | None
    computed: float | str
    unit: str = ""
    paper: float | None = None
    tolerance: float | None = None
    relative: float | None = None
    at_most: bool = False
    loose: float | None = None
    band: Band | None = None

    @property
    def number(self) -> float | None:
        """The paper's number, or None where it gives words or nothing."""
        if self.paper is not None or self.printed is None or isinstance(self.computed, str):
            return self.paper
        return float(self.printed)

    @property
    def allowed(self) -> float:
        """The largest difference that counts as reproduced."""
        if self.tolerance is not None:
            return self.tolerance
        if self.relative is not None and self.number is not None:
            return abs(self.number) * self.relative
        return self.rounding

    @property
    def rounding(self) -> float:
        """Half a unit of the last digit that the paper prints; 0 where things are counted."""
        if isinstance(self.computed, int) or self.printed is None or not _DECIMAL.fullmatch(self.printed):
            return 0.0
        return 0.5 * 10.0 ** -len(self.printed.partition(".")[2])

    @property
    def difference(self) -> float:
        """Ours minus the paper's."""
        assert self.number is not None and not isinstance(self.computed, str)
        return self.computed - self.number

    @property
    def verdict(self) -> Verdict:
        """Of this number alone."""
        if self.printed is None:
            return Verdict("no figure", "the paper gives none")
        if isinstance(self.computed, str):
            if self.computed == self.printed:
                return Verdict("reproduced", "reproduced")
            return Verdict("not reproduced", f"“{self.computed}”, not “{self.printed}”")
        if self.band is not None:
            return self._in_band(self.band)
        return self._within()

    def _within(self) -> Verdict:
        gap = self.difference if self.at_most else abs(self.difference)
        if not math.isfinite(gap):
            return Verdict("not reproduced", "not finite")
        # A number that rounds to what is printed is as near as one can ask; and nobody wants to read of 1e-14 %.
        near = self.rounding if self.rounding <= self.allowed else 0.0
        if gap <= max(near, _NOT_WORTH_SAYING * self.allowed) * (1.0 + 1e-9):
            return Verdict("reproduced", "reproduced")
        if gap <= self.allowed * (1.0 + 1e-9):
            return Verdict("reproduced", f"reproduced to {self.distance}")
        if self.loose is not None and gap <= self.loose:
            return Verdict("in part", f"only to {self.distance}")
        return Verdict("not reproduced", f"{self.distance} {'more' if self.at_most else 'off'}")

    def _in_band(self, band: Band) -> Verdict:
        assert self.number is not None
        if not band.low <= self.number <= band.high:
            side = "below" if self.number < band.low else "above"
            return Verdict("not reproduced", f"the paper’s is {side} all {band.count} draws")
        return Verdict("as bands", f"{band.percentile(self.number):.0f}")

    @property
    def distance(self) -> str:
        """How far ours is from the paper's: in its unit where the tolerance is, or where things are counted; else percent."""
        assert self.number is not None
        if self.number == 0.0 or self.tolerance is not None or isinstance(self.computed, int):
            return f"{_rounded(abs(self.difference))} {self.unit}".strip()
        return f"{_rounded(100.0 * abs(self.difference / self.number))} %"


def _rounded(value: float) -> str:
    """One digit below 1, two above: how far off, not how exactly."""
    return f"{float(f'{value:.1g}' if value < 1.0 else f'{value:.2g}'):g}"


def combined(values: Sequence[Value]) -> Verdict:
    """The verdict of an item: of all its values that the paper has too."""
    judged = [(value, value.verdict) for value in values if value.printed is not None]
    kinds = {verdict.kind for _, verdict in judged}
    if not judged:
        return Verdict("no figure", "the paper gives none")
    if kinds == {"reproduced"}:
        worst = max(judged, key=lambda pair: _relative(pair[0]))[1]
        return Verdict("reproduced", worst.words)
    if kinds == {"as bands"}:
        return Verdict(
            "as bands", f"as bands: the paper’s draw at percentile {', '.join(verdict.words for _, verdict in judged)}"
        )
    if kinds == {"not reproduced"}:
        return Verdict("not reproduced", f"not reproduced: {judged[0][1].words}")
    if len(judged) == 1 or kinds == {"in part"}:
        return Verdict("in part", max(judged, key=lambda pair: _relative(pair[0]))[1].words)
    parts = "; ".join(f"{value.label}: {_short(verdict)}" for value, verdict in judged)
    bands = "as bands" in kinds and "not reproduced" not in kinds
    return Verdict("as bands" if bands else "in part", f"in part: {parts}")


def _short(verdict: Verdict) -> str:
    words = verdict.words.removeprefix("reproduced")
    return {"reproduced": f"yes{words}", "not reproduced": f"no, {words}", "as bands": f"at percentile {words}"}.get(
        verdict.kind, words
    )


def _relative(value: Value) -> float:
    if isinstance(value.computed, str) or value.number is None:
        return 0.0
    shown = 0.0 if value.verdict.words == "reproduced" else 1.0
    return shown + abs(value.difference) / (abs(value.number) or 1.0)
