"""Section 3.5 B: a disturbance in a chain of random grains with free ends; figure 8."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Entry, Figure, Findings, Item, Mark
from granular_env.atlas.seed_statistics import Band
from granular_env.atlas.verdicts import Value

from ..measurement import History
from .cases import SPEED, case, grain
from .random_chains import MANY, OUTSIDE, document, histories, last_velocities, strip
from .velocity_curves import TIME, velocity_of
from .wave_count import CLEAR, FAINT, waves

# R0 in mm and number of grains -> as printed.
_CASES = {(0.5, 100): ".692", (2.0, 100): ".507", (3.0, 50): "1.003"}
# Of how many draws the disturbance has to be so.
_MOST = "in 95 % of the draws"
_EXPERIMENT, _FIGURE = "3.5b-random-free", (2.0, 100)


def compute(context: Context) -> Findings:
    """Bands of the last grain's velocity, how the first wave dies away, and figure 8."""
    last: dict[tuple[float, int], list[float]] = {}
    places, shown = (grain(context, 61), grain(context, 96)), None
    counted: dict[float, list[int]] = {CLEAR: [], FAINT: []}
    for which in _CASES:
        last[which] = []
        for chain in histories(context, _EXPERIMENT, *which):
            last[which].append(last_velocities(chain)[1])
            if which == _FIGURE:
                shown = shown or chain
                for above, found in counted.items():
                    found.append(len(waves(chain, places[0], above)))
    assert shown is not None
    bands = {which: Band.of(draws) for which, draws in last.items()}
    equal = float(case(context, "3.1-two-grains").velocity[-1, -1]) / SPEED
    items = [_last(bands, equal), _disorder(_many(context, 0.5), _many(context, 2.0)), _no_two_waves(counted)]
    return Findings(items, [_figure_8(shown, places), _figure_last(bands, equal)])


def _many(context: Context, smallest: float) -> Band:
    """Return the last grain's velocity over v0 in more draws than the others, without logs.

    It is the largest ever: what hits the last grain pushes it.
    """
    seeds = range(1, MANY * int(context.constants["seeds"]) + 1)
    return Band.of([
        context.state(document(context, _EXPERIMENT, smallest, 100, seed)).get("velocity")[-1] / SPEED for seed in seeds
    ])  # fmt: skip


def _name(smallest: float, grains: int) -> str:
    return f"R0 = {smallest:g}, N = {grains}"


def _last(bands: dict[tuple[float, int], Band], equal: float) -> Item:
    values = [Value(_name(*which), printed, bands[which].mean, band=bands[which]) for which, printed in _CASES.items()]
    above = max(100.0 - band.percentile(equal) for band in bands.values())
    return Item(
        "Final velocity of the last random grain, v_N/v0", "section 3.5 B", values,
        remark=f"Mean ± sd [5 %, 95 %] over {bands[0.5, 100].count} draws; the verdict says where the paper’s draw stands. "
        f"Equal grains: {equal:.4f}, which {above:.0f} % of the draws exceed.",
        reason=OUTSIDE,
    )  # fmt: skip


def _disorder(small: Band, large: Band) -> Item:
    distance = (large.mean - small.mean) / float(np.hypot(small.error_of_mean, large.error_of_mean))
    pairs = np.greater.outer(small.draws, large.draws)
    return Item(
        "R0 = 0.5 decays less than R0 = 2", "section 3.5 B",
        [
            Value("larger mean v100/v0", "R0 = 0.5", "R0 = 0.5" if small.mean > large.mean else "R0 = 2"),
            Value("mean v100/v0, R0 = 0.5", None, f"{small.mean:.3f} ± {small.error_of_mean:.3f}"),
            Value("mean v100/v0, R0 = 2", None, f"{large.mean:.3f} ± {large.error_of_mean:.3f}"),
        ],
        remark=f"Mean ± standard error over {small.count} draws, seeds 1 to {small.count}; the means are {abs(distance):.1f} "
        "standard errors apart.",
        reason=f"It rests on one draw of each. Of a pair of single draws {100.0 * float(pairs.mean()):.0f} % come out the "
        "paper’s way round; the means do not.",
    )  # fmt: skip


def _no_two_waves(counted: dict[float, list[int]]) -> Item:
    values = []
    for above, found in counted.items():
        counts = Band.of(found)
        words = "more than 2" if counts.quantile(5) > 2.0 else "2"
        values.append(Value(f"maxima at grain 61, above {100.0 * above:.0f} %", "more than 2", words, reading=_MOST))
        values.append(Value("how many", None, counts.mean, band=counts))
    return Item(
        "The disturbance does not break into two solitary waves, R0 = 2", "section 3.5 B, figure 8", values,
        remark="Of the tallest one.",
        reason=f"The paper says it of its one draw, and not of how many others; {_MOST} is our reading.",
    )  # fmt: skip


def _figure_8(chain: History, places: tuple[int, int]) -> Figure:
    curves = [
        velocity_of(chain, place, f"grain {number}", int(number == 96)) for place, number in zip(places, (61, 96), strict=True)
    ]
    return Figure(
        "figure-8", "Figure 8: velocities of grains 61 and 96, R0 = 2",
        "One draw of ours (seed 1). The first maximum looks like a solitary wave and loses height on its way, without any "
        "dissipation: its energy is scattered over many grains.",
        Axis(TIME), Axis("velocity, m/s"), curves,
    )  # fmt: skip


def _figure_last(bands: dict[tuple[float, int], Band], equal: float) -> Figure:
    rows = dict(zip(_CASES, (3.0, 2.0, 1.0), strict=True))
    curves = [curve for which, row in rows.items() for curve in strip(bands[which], row, row == 3.0)]
    marks = [Mark(printed, float(printed), rows[which]) for which, printed in _CASES.items()]
    names = [(row, f"{smallest:g}, {grains}") for (smallest, grains), row in rows.items()]
    return Figure(
        "figure-35b-last", "Last random grain of a free chain",
        f"Each dot is a draw; rows are R0 and N. Equal grains leave with {equal:.4f} v0.",
        Axis("v_N / v0"), Axis("R0, N", 0.4, 3.6, names), curves, marks,
    )  # fmt: skip


def _runs(constants: Mapping[str, float]) -> int:
    return (3 + 2 * MANY) * int(constants["seeds"]) + 1


ENTRY = Entry(
    "3.5b-free",
    "3.5 B",
    "A disturbance among random grains",
    "As in 3.1 the first two grains move at 5 m/s, now in a chain of random grains with free ends. The first wave dies away "
    "though nothing dissipates.",
    compute,
    weight=26.0,
    runs=_runs,
)
