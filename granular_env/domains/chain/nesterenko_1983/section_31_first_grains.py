"""Section 3.1: the first grains of a chain are set moving."""

from __future__ import annotations

from typing import Any

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item, Mark
from granular_env.atlas.verdicts import Value
from granular_env.components.chain import theory

from .. import measurement
from ..measurement import History
from .cases import DIAMETER, ERROR, ERROR_SOURCE, SPEED, case, change, grain, longer
from .velocity_curves import MICRO, TIME, velocity_of
from .wave_count import RULE, counts, heights, waves

_LAST = {20: "1.2338", 50: "1.2342", 100: "1.2342"}
# The paper prints six velocities for seven grains: the third is missing.
_REBOUND = ["-.11", "-.048", None, "-.013", "-.0068", "-.0029", "-.0004"]
_LOOK = 2e-4


def _moving(context: Context, grains: int) -> History:
    return case(context, "3.1-two-grains", least=_LOOK, start__velocity={str(i): SPEED for i in range(grains)})


def compute(context: Context) -> Findings:
    """Last grains, rebound, the number of solitary waves, and how they scale."""
    chain = case(context, "3.1-two-grains", least=_LOOK)
    items = [
        _last_grains(context),
        _rebound(chain),
        _negative_and_detached(chain),
        _momentum(chain),
        _second_wave(chain),
        _distance(context, chain),
        _count(context),
        _formation(context, chain),
        _powers(context, chain),
        _length(context, chain),
    ]
    return Findings(items, [_figure_2(context, chain), _figure_rebound(chain)])


def _last_grains(context: Context) -> Item:
    values = []
    for grains, printed in _LAST.items():
        velocity = case(context, "3.1-two-grains", component__grains=grains).velocity[-1, -1]
        values.append(Value(f"N = {grains}", printed, velocity / SPEED, digits=7))
    return Item(
        "Final velocity of the last grain, v_N/v0", "section 3.1", values,
        remark="Equal for 50 and 100 grains: the taller wave is stationary by then.",
    )  # fmt: skip


def _rebound(chain: History) -> Item:
    velocity = chain.velocity[chain.frame(_LOOK)] / SPEED
    values = [Value(str(i + 1), printed, float(velocity[i]), digits=4) for i, printed in enumerate(_REBOUND)]
    return Item(
        "Velocities of grains 1 to 7 at 2e-4 s, v/v0", "section 3.1", values,
        remark="The paper calls them m/s; they are v/v0. It prints six of the seven, the third is missing.",
    )  # fmt: skip


def _negative_and_detached(chain: History) -> Item:
    frame = chain.frame(_LOOK)
    backwards = int(np.argmax(chain.velocity[frame] >= 0.0))
    # Contact j is left of grain j; the first grains have left each other as far as the contacts to their right are open.
    apart = int(np.argmax(chain.overlap[frame, 1:] >= 0.0))
    return Item(
        "The chain’s head comes apart at 2e-4 s", "section 3.1",
        [Value("moving backwards", "1 to 7", f"1 to {backwards}"), Value("apart", "1 to 8", f"1 to {apart}")],
    )  # fmt: skip


def _momentum(chain: History) -> Item:
    share = 100.0 * measurement.momentum_carried_off(chain, _LOOK)
    return Item(
        "Momentum that the rebounding grains carry off", "section 3.1",
        [Value("", "about 10", share, "%")], remark="Of the initial momentum.",
    )  # fmt: skip


def _second_wave(chain: History) -> Item:
    place = _crests(chain, _LOOK)[0] + 1.0
    return Item(
        "Where the second, lower wave is at 2e-4 s", "section 3.1",
        [Value("its crest, from the first", "near 27", place, "grains", paper=27.0, loose=1.0, digits=4)],
        reason="“Near” has no number; a grain is our reading.",
    )  # fmt: skip


def _crests(chain: History, time: float) -> list[float]:
    """Places of the waves along the chain at an instant, in diameters from the first grain, the lower wave first."""
    largest = float(chain.velocity[chain.frame(time)].max())
    return [wave.position / DIAMETER for wave in measurement.waves_along(chain, time, 0.05 * largest)]


def _distance(context: Context, chain: History) -> Item:
    """Between the two waves, at three times."""
    times = [longer(context, time) for time in (2e-4, 3e-4, 4e-4)]
    apart = [float(np.ptp(_crests(chain, time))) for time in times]
    growing = all(later > before for before, later in zip(apart, apart[1:], strict=False))
    return Item(
        "The distance between the two waves grows", "section 3.1",
        [
            Value("over these times", "grows continually", "grows continually" if growing else "does not"),
            *(
                Value(f"at {time * MICRO:.0f} µs", None, distance, "a", digits=4)
                for time, distance in zip(times, apart, strict=True)
            ),
        ],
        remark="Their crests, in diameters. Their speeds differ as the fifth root of their heights.",
    )  # fmt: skip


def _count(context: Context) -> Item:
    values = []
    for moving, printed in ((1, "1"), (2, "2"), (4, "4")):
        chain = _moving(context, moving)
        values += counts(f"{moving} moving", printed, chain, grain(context, 60))
        values.append(Value("their v_m/v0", None, heights(waves(chain, grain(context, 60)), SPEED, 5)))
    return Item(
        "Number of solitary waves for 1, 2 and 4 moving grains", "section 3.1", values,
        remark=f"At grain 60. {RULE}",
    )  # fmt: skip


def _formation(context: Context, chain: History) -> Item:
    """Return how much the taller wave's height still changes after the twentieth grain."""
    early, late = (waves(chain, grain(context, number))[0].amplitude for number in (20, 80))
    return Item(
        "The waves are formed at the twentieth grain", "section 3.1",
        [change("change of v_m, 20 to 80", "none", 100.0 * (late / early - 1.0), digits=2)],
        reason="The taller wave still grows a little after the twentieth grain, by more than the paper’s error; its own v_20 "
        "and v_50 of the last grain differ by 0.03 %.",
    )  # fmt: skip


def _powers(context: Context, chain: History) -> Item:
    """Exponents from the two waves of one run: speed and duration against height."""
    high, low = waves(chain, grain(context, 60))[:2]
    ratio = np.log(high.amplitude / low.amplitude)
    exactly: dict[str, Any] = {"relative": ERROR, "source": ERROR_SOURCE, "digits": 5}
    return Item(
        "Speed and half-width in time go as powers of v_m", "section 3.1, from (3.1)",
        [
            Value("V", "1/5", float(np.log(high.speed / low.speed) / ratio), **exactly, paper=0.2),
            Value("duration", "-1/5", float(np.log(high.duration / low.duration) / ratio), **exactly, paper=-0.2),
        ],
        remark="From the two waves of one run.",
    )  # fmt: skip


def _length(context: Context, chain: History) -> Item:
    values = []
    for name, wave in zip(("taller wave", "lower wave"), waves(chain, grain(context, 60))[:2], strict=True):
        half = measurement.overlap_of(chain, wave).duration * wave.speed / DIAMETER
        values += [
            Value(f"{name}, half-width", None, half, "a"),
            Value(f"{name}, length", "5", half * theory.PERIOD / theory.HALF_WIDTH, "a", digits=4),
        ]
    return Item(
        "Length of the solitary wave: five diameters a, whatever its height", "section 3.1", values,
        remark="The wave has no sharp end. Its length is that of the cos^4 wave (2.7) of the same width at half its height.",
    )  # fmt: skip


def _figure_2(context: Context, chain: History) -> Figure:
    grains = [(5, 0), (20, 1), (50, 2), (75, 3), (100, 5)]
    curves = [velocity_of(chain, grain(context, number), f"grain {number}", colour, SPEED) for number, colour in grains]
    return Figure(
        "figure-2a", "Figure 2, curves a: two moving grains",
        "Velocities of five grains. Solitary waves form, drift apart, and leave at the free end: the last grain keeps "
        f"{chain.velocity[-1, -1] / SPEED:.4f} v0.",
        Axis(TIME), Axis("v / v0"), curves, [Mark("1.2342", y=1.2342)],
    )  # fmt: skip


def _figure_rebound(chain: History) -> Figure:
    velocity = chain.velocity[chain.frame(_LOOK)] / SPEED
    count = min(10, len(velocity))
    marks = [Mark("", i + 1.0, float(printed)) for i, printed in enumerate(_REBOUND) if printed]
    return Figure(
        "figure-rebound", "The first grains at 2e-4 s",
        f"{int(np.argmax(velocity >= 0.0))} grains have bounced back, and each is slower than the one before it: the chain’s "
        "head comes apart. The paper leaves out the third.",
        Axis("grain", 0.5, count + 0.5, [(i + 1.0, str(i + 1)) for i in range(count)]), Axis("v / v0"),
        [Curve("computed", np.arange(1, count + 1), velocity[:count], "points")], marks,
    )  # fmt: skip


ENTRY = Entry(
    "3.1-two-grains",
    "3.1",
    "An initial disturbance breaks into solitary waves",
    "The first two of 100 touching steel grains are given 5 m/s; both ends are free. The disturbance breaks into two solitary "
    "waves, one for each moving grain, and the grains behind them bounce back.",
    compute,
    weight=0.5,
    runs=7,
)
