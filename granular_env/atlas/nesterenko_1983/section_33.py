"""Section 3.3: a triangular push; figure 5."""

from __future__ import annotations

from granular_env import measurement
from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value
from granular_env.measurement import History, Wave

from .cases import case, grain
from .drawn import TIME, velocity_of

# Waves above this are counted [m/s].
_WAVES = 0.4


def compute(context: Context) -> Findings:
    """Waves of a long and of a short push."""
    long, short = case(context, "3.3-triangle-100us"), case(context, "3.3-triangle-10us")
    return Findings([_long(context, long), _short(context, short)], [_figure(context, long), _figure_short(context, short)])


def _waves(context: Context, chain: History, number: int) -> list[Wave]:
    """Those that pass on the way from the push; what comes back from the free end is rarefied and moves no grain so fast."""
    return measurement.waves_at(chain, grain(context, number), _WAVES)


def _long(context: Context, chain: History) -> Item:
    found = {number: _waves(context, chain, number) for number in (35, 60)}
    values = []
    for number, waves in found.items():
        values.append(Value(f"grain {number}", "7", len(waves)))
        values.append(Value("their v_m", None, ", ".join(f"{wave.amplitude:.3g}" for wave in waves), "m/s"))
    return Item(
        "Number of waves of a push of 100 µs", "section 3.3, figure 5", values,
        remark=f"Above {_WAVES:g} m/s. The push is 2e6 m/s² times a grain’s mass at first.",
        reason=f"On its way from grain 35 to 60 an eighth, low wave, {found[60][-1].amplitude:.3f} m/s high, parts from the "
        "seventh. In the paper’s figure it would be a hump of a few percent of the first.",
    )  # fmt: skip


def _short(context: Context, chain: History) -> Item:
    waves = _waves(context, chain, 35)
    return Item(
        "Number of waves of a push of 10 µs", "section 3.3",
        [Value("", "1", len(waves)), Value("its v_m", None, waves[0].amplitude if waves else float("nan"), "m/s")],
        remark="At grain 35.",
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
)
