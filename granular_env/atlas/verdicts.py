"""Verdicts: how a paper's number and a computed one compare. Nobody writes a verdict down; they come from the numbers.

A tolerance is one that the paper states, or the rounding of what it prints. Where it states none, its reader has to choose one;
then what keeps to it, a number or words, holds in part, never more.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections import Counter
from collections.abc import Sequence
from typing import Literal

from .seed_statistics import Band

Kind = Literal["reproduced", "bound kept", "in part", "as bands", "not reproduced", "no figure"]

_NOT_WORTH_SAYING = 1e-3
# The verdicts of more values than so many are counted, not listed: the table beside has each of them.
_LISTED = 7
# "2.708", "5.6e12", "about 10"
_DECIMAL = re.compile(r"(?:about )?([-+]?\d*\.?\d+(?:e[-+]?\d+)?)")


@dataclasses.dataclass(frozen=True)
class Verdict:
    """A kind for counting and colouring, and the words that say how far it goes."""

    kind: Kind
    words: str
    beside: str = ""
    """The words beside others, in a list of several; default: the same."""

    @property
    def words_in_list(self) -> str:
        """Return the words as they stand beside those of other values."""
        return self.beside or self.words


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
        source: where the paper states that tolerance; every `tolerance` and `relative` has one.
        at_most: whether the paper states an upper bound. Less keeps it, which says nothing more: any good program does.
        loose: a larger difference, of our own choice, within which it holds in part; with `at_most`, our own reading of a bound
            that the paper gives in words.
        reading: what we take the paper's words for where they have no number, such as "more than twice" for "much larger";
            words of ours that rest on it hold in part.
        band: ours as a distribution over many draws, of which the paper has one; `computed` is its mean.
        digits: significant digits of `computed` that have converged; no more are printed or kept.
        resolution: what is smaller is rounding error, and is printed as less than this.
    """

    label: str
    printed: str | None
    computed: float | str
    unit: str = ""
    paper: float | None = None
    tolerance: float | None = None
    relative: float | None = None
    source: str = ""
    at_most: bool = False
    loose: float | None = None
    reading: str = ""
    band: Band | None = None
    digits: int = 5
    resolution: float = 0.0

    def __post_init__(self) -> None:
        stated = self.tolerance is not None or self.relative is not None
        if stated and not self.source:
            raise ValueError(f"value {self.label!r}: a tolerance needs a source in the paper; without one use loose")
        if self.reading and not isinstance(self.computed, str):
            raise ValueError(f"value {self.label!r}: a reading is for words; for a number use loose")

    @property
    def number(self) -> float | None:
        """The paper's number, or None where it gives words or nothing."""
        in_words = isinstance(self.computed, str) or (self.at_most and self.loose is not None)
        if self.paper is not None or self.printed is None or in_words:
            return self.paper
        decimal = _DECIMAL.fullmatch(self.printed)
        if decimal is None:
            raise ValueError(f"value {self.label!r}: {self.printed!r} is no number; say with paper= what it means")
        return float(decimal[1])

    @property
    def display_value(self) -> float | str:
        """Ours with the digits that have converged; counts and words as they are."""
        if isinstance(self.computed, str | int) or not math.isfinite(self.computed):
            return self.computed
        if self.below_resolution:
            return self.resolution
        return float(f"{self.computed:.{self.digits}g}")

    @property
    def below_resolution(self) -> bool:
        """Return whether ours is nothing but rounding error."""
        return not isinstance(self.computed, str) and bool(abs(self.computed) < self.resolution)

    @property
    def largest_difference(self) -> float:
        """The largest difference that counts as reproduced."""
        if self.tolerance is not None:
            return self.tolerance
        if self.relative is not None and self.number is not None:
            return abs(self.number) * self.relative
        return self.rounding

    @property
    def rounding(self) -> float:
        """Half a unit of the last digit that the paper prints; 0 where things are counted."""
        decimal = None if self.printed is None else _DECIMAL.fullmatch(self.printed)
        if isinstance(self.computed, int) or decimal is None or self.paper is not None:
            return 0.0
        digits, _, power = decimal[1].partition("e")
        return 0.5 * 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))

    @property
    def difference(self) -> float:
        """Ours minus the paper's."""
        assert self.number is not None and not isinstance(self.computed, str)
        return self.computed - self.number

    @property
    def verdict(self) -> Verdict:
        """Return the verdict of this number alone."""
        if self.printed is None:
            return Verdict("no figure", "the paper gives none")
        if isinstance(self.computed, str):
            if self.computed == self.printed:
                if self.reading:
                    return Verdict("in part", "as we read it")
                return Verdict("reproduced", "reproduced", "yes")
            return _not_reproduced(f"“{self.computed}”, not “{self.printed}”")
        if self.band is not None:
            return self._in_band(self.band)
        return self._below() if self.at_most else self._within()

    def _below(self) -> Verdict:
        assert not isinstance(self.computed, str)
        bound = self.number if self.loose is None else self.loose
        assert bound is not None
        if math.isfinite(self.computed) and self.computed <= bound:
            read = self.loose is not None
            return Verdict("in part", "kept as we read it") if read else Verdict("bound kept", "bound kept", "kept")
        # With the digits that have converged ours may be printed like the bound itself.
        if self.display_value == bound:
            return _not_reproduced(f"just above {bound:g} {self.unit}".strip())
        return _not_reproduced(f"{_round(self.computed - bound)} {self.unit}".strip() + " more")

    def _within(self) -> Verdict:
        gap = abs(self.difference)
        if not math.isfinite(gap):
            return _not_reproduced("not finite")
        # A number that rounds to what is printed is as near as one can ask; and nobody wants to read of 1e-14 %.
        near = self.rounding if self.rounding <= self.largest_difference else 0.0
        if gap <= max(near, _NOT_WORTH_SAYING * self.largest_difference, self.resolution) * (1.0 + 1e-9):
            return Verdict("reproduced", "reproduced", "yes")
        if gap <= self.largest_difference * (1.0 + 1e-9):
            return Verdict("reproduced", f"reproduced to {self.distance}", f"yes to {self.distance}")
        if self.loose is not None and gap <= self.loose:
            return Verdict("in part", f"only to {self.distance}")
        return _not_reproduced(f"{self.distance} off")

    def _in_band(self, band: Band) -> Verdict:
        assert self.number is not None
        if not band.low <= self.number <= band.high:
            side = "below" if self.number < band.low else "above"
            return _not_reproduced(f"the paper’s is {side} all {band.count} draws")
        percentile = f"{band.percentile(self.number):.0f}"
        return Verdict("as bands", percentile, f"at percentile {percentile}")

    @property
    def distance(self) -> str:
        """Return how far ours is from the paper's: in its unit where a tolerance is or things are counted; else percent."""
        assert self.number is not None
        absolute = self.tolerance is not None or self.loose is not None or isinstance(self.computed, int)
        if self.number == 0.0 or absolute:
            return f"{_round(abs(self.difference))} {self.unit}".strip()
        return f"{_round(100.0 * abs(self.difference / self.number))} %"


def _not_reproduced(words: str) -> Verdict:
    return Verdict("not reproduced", words, f"no, {words}")


def _round(value: float) -> str:
    """One digit below 1, two above: how far off, not how exactly."""
    return f"{float(f'{value:.1g}' if value < 1.0 else f'{value:.2g}'):g}"


def combine(values: Sequence[Value]) -> Verdict:
    """Return the verdict of an item, from all of its values that the paper gives too."""
    judged = [(value, value.verdict) for value in values if value.printed is not None]
    kinds = {verdict.kind for _, verdict in judged}
    if not judged:
        return Verdict("no figure", "the paper gives none")
    if kinds == {"bound kept"}:
        return Verdict("bound kept", "bound kept" if len(judged) == 1 else "bounds kept")
    if kinds <= {"reproduced", "bound kept"}:
        worst = max((pair for pair in judged if pair[1].kind == "reproduced"), key=lambda pair: _relative(pair[0]))[1]
        return Verdict("reproduced", worst.words)
    if kinds == {"as bands"}:
        return Verdict(
            "as bands", f"as bands: the paper’s draw at percentile {', '.join(verdict.words for _, verdict in judged)}"
        )
    if kinds == {"not reproduced"}:
        value, verdict = judged[0]
        # Of several values the reader has to know whose words these are.
        which = f"{value.label}: " if len(judged) > 1 and value.label else ""
        return Verdict("not reproduced", f"not reproduced: {which}{verdict.words}")
    if len(judged) == 1 or kinds == {"in part"}:
        return Verdict("in part", max(judged, key=lambda pair: _relative(pair[0]))[1].words)
    if len(judged) > _LISTED:
        counted = Counter(verdict.kind for _, verdict in judged)
        parts = f"of {len(judged)} values {', '.join(f'{count} {kind}' for kind, count in counted.most_common())}"
    else:
        parts = "; ".join(f"{value.label}: {verdict.words_in_list}" for value, verdict in judged)
    bands = "as bands" in kinds and "not reproduced" not in kinds
    return Verdict("as bands" if bands else "in part", f"in part: {parts}")


def _relative(value: Value) -> float:
    if isinstance(value.computed, str) or value.number is None:
        return 0.0
    shown = 0.0 if value.verdict.words == "reproduced" else 1.0
    return shown + abs(value.difference) / (abs(value.number) or 1.0)
