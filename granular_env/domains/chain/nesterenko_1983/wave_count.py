"""The waves of the paper, counted by one rule for all its sections.

The paper counts waves in its figures and gives no rule. A small maximum is a wave or is none as one likes, so everything is
counted twice: with a height that such a figure shows well, and with one that it hardly shows.
"""

from __future__ import annotations

import dataclasses

from granular_env.atlas.verdicts import Value

from .. import measurement
from ..measurement import History, Wave
from ..measurement.chain_history import Direction

# Least heights, as parts of the tallest wave's at the same grain; the lower one for finding waves.
CLEAR, FAINT = 0.05, 0.02
RULE = (
    "A wave is a maximum of the grain’s velocity. Those above 5 % and those above 2 % of the tallest one there are counted; a "
    "number is reproduced where both counts are the paper’s, and holds in part where one is."
)


def waves(history: History, place: int, above: float = FAINT, direction: Direction = "right") -> list[Wave]:
    """Return the waves that pass a grain, in the order of arrival.

    Args:
        history: of a chain.
        place: our index of the grain.
        above: least height, as a part of the tallest wave's there.
        direction: which way they run.
    """
    sign = 1.0 if direction == "right" else -1.0
    largest = float((sign * history.velocity[:, place]).max())
    if not largest > 0.0:
        return []
    found = measurement.waves_at(history, place, 0.5 * above * largest, direction=direction)
    tallest = max((wave.amplitude for wave in found), default=0.0)
    return [wave for wave in found if wave.amplitude > above * tallest]


def counts(label: str, printed: str | None, history: History, place: int) -> list[Value]:
    """Return the number of waves at a grain by both thresholds, beside the paper's."""
    begin = f"{label}, " if label else ""
    return [
        Value(f"{begin}above {100.0 * above:.0f} %", printed, len(waves(history, place, above))) for above in (CLEAR, FAINT)
    ]


def heights(found: list[Wave], scale: float, digits: int = 4) -> str:
    """Return the waves' heights in units of `scale`, as words."""
    return ", ".join(f"{wave.amplitude / scale:.{digits}g}" for wave in found)


def before_return(history: History, place: int) -> History:
    """Return the part of a history in which nothing has come back to a grain from the right end: its way is so much longer."""
    arrived = float(measurement.arrivals(history, FAINT * float(history.velocity[:, place].max()))[place])
    last = history.frame(min(arrived * 0.95 * (2 * history.grains - place) / place, float(history.time[-1])))
    own = slice(0, last + 1)
    displacement = None if history.displacement is None else history.displacement[own]
    return dataclasses.replace(history, time=history.time[own], velocity=history.velocity[own], displacement=displacement)
