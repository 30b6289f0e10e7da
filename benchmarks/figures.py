"""A measured figure with its bound, and the table of all figures."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Figure:
    """One row of the table.

    Attributes:
        what: measured quantity and data.
        value: measured value.
        unit: "x" for a ratio, "us", "%".
        at_least: lower bound, if larger is better.
        at_most: upper bound, if smaller is better.
        note: further information for the reader.
    """

    what: str
    value: float
    unit: str = "x"
    at_least: float | None = None
    at_most: float | None = None
    note: str = ""

    @property
    def bound_text(self) -> str:
        """The bound as text."""
        if self.at_least is not None:
            return f">= {self.at_least:g} {self.unit}"
        return f"<= {self.at_most:g} {self.unit}" if self.at_most is not None else ""

    @property
    def is_met(self) -> bool | None:
        """Whether the bound is met; None without a bound."""
        if self.at_least is not None:
            return self.value >= self.at_least
        return self.value <= self.at_most if self.at_most is not None else None

    @property
    def verdict(self) -> str:
        """`is_met` as one word."""
        return {True: "met", False: "MISSED", None: ""}[self.is_met]


HEADINGS = ("what", "measured", "wanted", "verdict", "")


def figure_table(figures: Iterable[Figure]) -> str:
    """Return all figures in aligned columns."""
    rows: list[tuple[str, ...]] = [HEADINGS]
    rows += [(f.what, f"{f.value:.3g} {f.unit}", f.bound_text, f.verdict, f.note) for f in figures]
    widths = [max(len(row[column]) for row in rows) for column in range(len(HEADINGS) - 1)]
    rows.insert(1, tuple("-" * width for width in (*widths, 0)))
    return "\n".join(
        "  ".join([*(cell.ljust(width) for cell, width in zip(row, widths, strict=False)), row[-1]]).rstrip() for row in rows
    )
