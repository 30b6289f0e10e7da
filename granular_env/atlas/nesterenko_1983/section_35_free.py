"""Section 3.5 B: a disturbance in a chain of random grains with free ends; figure 8."""

from __future__ import annotations

from granular_env import measurement
from granular_env.atlas.bands import Band
from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Entry, Figure, Findings, Item, Mark
from granular_env.atlas.verdicts import Value
from granular_env.measurement import History

from .cases import SPEED, case, grain
from .drawn import TIME, velocity_of
from .draws import OUTSIDE, histories, last_velocities, strip

# R0 in mm and number of grains -> as printed.
_CASES = {(0.5, 100): ".692", (2.0, 100): ".507", (3.0, 50): "1.003"}
_WAVES = 0.02 * SPEED

Draws = dict[tuple[float, int], list[History]]


def compute(context: Context) -> Findings:
    """Bands of the last grain's velocity, how the first wave dies away, and figure 8."""
    draws = {(smallest, grains): list(histories(context, "3.5b-random-free", smallest, grains)) for smallest, grains in _CASES}
    bands = {which: Band.of([last_velocities(chain)[1] for chain in chains]) for which, chains in draws.items()}
    equal = float(case(context, "3.1-two-grains").velocity[-1, -1]) / SPEED
    items = [_last(bands, equal), _disorder(bands), _no_two_waves(context, draws[2.0, 100])]
    return Findings(items, [_figure_8(context, draws[2.0, 100][0]), _figure_last(bands, equal)])


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


def _disorder(bands: dict[tuple[float, int], Band]) -> Item:
    small, large = bands[0.5, 100], bands[2.0, 100]
    error = (small.error_of_mean**2 + large.error_of_mean**2) ** 0.5
    distance = (large.mean - small.mean) / error
    pairs = [a > b for a in small.draws for b in large.draws]
    return Item(
        "R0 = 0.5 decays less than R0 = 2", "section 3.5 B",
        [Value("larger mean v100/v0", "R0 = 0.5", "R0 = 0.5" if small.mean > large.mean else "R0 = 2")],
        remark=f"Means {small.mean:.2f} for R0 = 0.5 and {large.mean:.2f} for R0 = 2, {abs(distance):.1f} standard errors "
        "apart.",
        reason="It rests on one draw of each. Of a pair of single draws "
        f"{100.0 * sum(pairs) / len(pairs):.0f} % come out the paper’s way round; the means do not.",
    )  # fmt: skip


def _no_two_waves(context: Context, chains: list[History]) -> Item:
    counts = Band.of([len(measurement.waves_at(chain, grain(context, 61), _WAVES)) for chain in chains])
    return Item(
        "The disturbance does not break into two solitary waves, R0 = 2", "section 3.5 B, figure 8",
        [
            Value("maxima at grain 61", "more than 2", "more than 2" if counts.quantile(5) > 2.0 else "2"),
            Value("how many above 0.02 v0", None, counts.mean, band=counts),
        ],
        remark="More than 2 in 95 % of the draws.",
    )  # fmt: skip


def _figure_8(context: Context, chain: History) -> Figure:
    curves = [
        velocity_of(chain, grain(context, 61), "grain 61", 0),
        velocity_of(chain, grain(context, 96), "grain 96", 1),
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


ENTRY = Entry(
    "3.5b-free",
    "3.5 B",
    "A disturbance among random grains",
    "As in 3.1 the first two grains move at 5 m/s, now in a chain of random grains with free ends. The first wave dies away "
    "though nothing dissipates.",
    compute,
    weight=18.0,
)
