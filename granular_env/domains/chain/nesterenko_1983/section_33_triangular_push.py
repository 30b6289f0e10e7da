"""Section 3.3: a triangular push; figure 5."""

from __future__ import annotations

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value

from ..measurement import History
from .cases import case, grain
from .velocity_curves import TIME, velocity_of
from .wave_count import RULE, counts, heights, waves


def compute(context: Context) -> Findings:
    """Waves of a long and of a short push."""
    long, short = case(context, "3.3-triangle-100us"), case(context, "3.3-triangle-10us")
    return Findings([_long(context, long), _short(context, short)], [_figure(context, long), _figure_short(context, short)])


def _long(context: Context, chain: History) -> Item:
    values = []
    for number in (35, 60):
        values += counts(f"grain {number}", "7", chain, grain(context, number))
        values.append(Value("their v_m", None, heights(waves(chain, grain(context, number)), 1.0, 3), "m/s"))
    return Item(
        "Number of waves of a push of 100 µs", "section 3.3, figure 5", values,
        remark=f"The push is 2e6 m/s² times a grain’s mass at first. {RULE}",
        reason="On its way from grain 35 to 60 an eighth, low wave parts from the seventh. In the paper’s figure it would be a "
        "hump of a few percent of the first.",
    )  # fmt: skip


def _short(context: Context, chain: History) -> Item:
    place = grain(context, 35)
    (only,) = waves(chain, place)[:1]
    return Item(
        "Number of waves of a push of 10 µs", "section 3.3",
        [*counts("", "1", chain, place), Value("its v_m", None, only.amplitude, "m/s")],
        remark="At grain 35, counted by the same rule.",
    )  # fmt: skip


def _figure(context: Context, chain: History) -> Figure:
    curves = [velocity_of(chain, grain(context, number), f"grain {number}", colour) for number, colour in ((35, 0), (60, 1))]
    return Figure(
        "figure-5", "Figure 5: a triangular push of 100 µs",
        "The push breaks into a row of solitary waves, which drift apart on their way from grain 35 to grain 60.",
        Axis(TIME), Axis("velocity, m/s"), curves,
    )  # fmt: skip


def _figure_short(context: Context, chain: History) -> Figure:
    return Figure(
        "figure-5-short", "The same push for 10 µs", "A single solitary wave.", Axis(TIME), Axis("velocity, m/s"),
        [velocity_of(chain, grain(context, number), f"grain {number}", colour) for number, colour in ((35, 0), (60, 1))],
    )  # fmt: skip


ENTRY = Entry(
    "3.3-triangle",
    "3.3",
    "A triangular push",
    "A force on the first grain of 100 that falls from 2e6 m/s² times its mass to zero in 100 µs, or in 10 µs.",
    compute,
    weight=0.3,
    runs=2,
)
