"""Thresholds for the paper's words "not noticeable", "slight" and "conserved", for which it prints no numbers."""

from __future__ import annotations

from granular_env.atlas.verdicts import Value

# "Not noticeable": what no eye sees in a figure [%].
NOT_SEEN = 2.0
NOT_SEEN_WORDS = (
    f"The paper judges by eye and gives no number; what is below {NOT_SEEN:g} % of the largest value is read as not noticeable."
)
# "Slight": seen when one looks for it [%].
SLIGHT = 10.0
SLIGHT_WORDS = f"The paper judges by eye and gives no number; up to {SLIGHT:g} % is read as slight."
# What a conserved quantity may miss: the rounding of some thousand sums.
_ROUNDING = 1e-10
EXACT_SUM = f"What is below {_ROUNDING:g} is rounding."


def absent(label: str, percent: float, printed: str = "not noticeable", digits: int = 2) -> Value:
    """Return what the paper does not see beside ours [%]."""
    return Value(label, printed, percent, "%", paper=0.0, loose=NOT_SEEN, digits=digits)


def slight(label: str, percent: float, printed: str = "slight", digits: int = 2) -> Value:
    """Return what the paper sees a little of beside ours [%]."""
    return Value(label, printed, percent, "%", at_most=True, loose=SLIGHT, digits=digits)


def complete(label: str, part: float, printed: str = "none") -> Value:
    """Return what is conserved in the paper's words: what is missing in ours, as a part of the whole."""
    return Value(label, printed, part, paper=0.0, tolerance=_ROUNDING, source="rounding", resolution=_ROUNDING, digits=2)
