"""Figures 4 and 5: the notch of three inches."""

from __future__ import annotations

from granular_env.atlas.context import Context
from granular_env.atlas.model import Entry, Findings

from .cases import EARLY
from .crack_statements import as_printed, crack_outcome, cracks, picture, runs_beyond, turns

_INCHES = 3
# An early time of figure 4, after the front has passed the middle of the notch [s].
_VERY_EARLY = 3e-5


def compute(context: Context) -> Findings:
    """Run it with the paper's factor and with the page's."""
    one = crack_outcome(context, _INCHES)
    statements = [
        ("first", "straight on", runs_beyond(one, _INCHES)),
        ("then", "branches around the tube", turns(one)),
        ("end", "severed", one.words == "severed"),
    ]
    return Findings(
        [as_printed(context, _INCHES, "severed"), cracks(context, _INCHES, "figures 4 and 5", statements)],
        [
            picture(context, _INCHES, "figure-4", "Figure 4: notch of 3 in", _VERY_EARLY),
            picture(context, _INCHES, "figure-4-later", "Figure 4: notch of 3 in", EARLY),
            picture(context, _INCHES, "figure-5", "Figure 5: notch of 3 in"),
        ],
    )


ENTRY = Entry(
    "figures-4-and-5",
    "Results",
    "Figures 4 and 5: the very long notch, 3 in",
    "“First the cracks ran straight on from the notch, then they branched in the direction of the circumference into some "
    "small "
    "branches that went around the whole of it and led to the complete failure of the tube (on both sides of the notch).”",
    compute,
    weight=60.0,
    runs=6,
)
