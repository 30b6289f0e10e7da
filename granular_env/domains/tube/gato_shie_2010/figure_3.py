"""Figure 3: the notch of two inches."""

from __future__ import annotations

from granular_env.atlas.context import Context
from granular_env.atlas.model import Entry, Findings

from .cases import EARLY
from .crack_statements import as_printed, crack_outcome, cracks, picture, runs_beyond, turns

_INCHES = 2


def compute(context: Context) -> Findings:
    """Run it with the paper's factor and with the page's."""
    one = crack_outcome(context, _INCHES)
    statements = [
        ("first", "short cracks from the notch’s ends", runs_beyond(one, _INCHES)),
        ("then", "branches run around the tube", turns(one)),
        ("end, computed", "not parted on the other side", one.words != "severed"),
        ("end, experiment", "severed", one.words == "severed"),
    ]
    return Findings(
        [as_printed(context, _INCHES, "hoop crack"), cracks(context, _INCHES, "figure 3", statements)],
        [
            picture(context, _INCHES, "figure-3-early", "Figure 3: notch of 2 in", EARLY),
            picture(context, _INCHES, "figure-3", "Figure 3: notch of 2 in"),
        ],
    )


ENTRY = Entry(
    "figure-3",
    "Results",
    "Figure 3: the long notch, 2 in",
    "In the experiment one crack ran around the whole tube and severed it. The paper’s computation “branches and runs in two "
    "directions around the circumference”, and does not predict “complete failure on the other side of the shell”; the authors "
    "blame their simple criterion, and that the gas does not feel the wall.",
    compute,
    weight=60.0,
    runs=5,
)
