"""Section 3.5 A: the last grain and the energies of random chains before a piston, for three R0."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item, Mark
from granular_env.atlas.seed_statistics import Band
from granular_env.atlas.verdicts import Value

from .. import measurement
from .cases import SPEED, grain
from .random_chains import OUTSIDE, UNEVEN, UNEVEN_REASON, energy_while, histories, is_uneven, last_velocities, strip
from .section_34_piston import piston

_LAST = {0.5: "2.969", 2.0: "2.366", 3.0: None}
_RATIO = {0.5: "1.178", 2.0: "1.236", 3.0: "1.232"}
_DEVIATION = {0.5: "9", 2.0: "7", 3.0: "6"}
# Of how many draws a sentence has to hold.
_MOST = "in more than half of the draws"

Bands = dict[float, dict[str, Band]]


def compute(context: Context) -> Findings:
    """Bands for R0 = 0.5, 2 and 3 mm, N = 100."""
    bands = {smallest: _bands(context, smallest) for smallest in _LAST}
    equal = float(piston(context, 100).velocity[-1, -1]) / SPEED
    chain = piston(context)
    ratio = energy_while(chain, grain(context, 70), grain(context, 90))
    items = [
        _last(bands), _against_equal(bands, equal), _ratios(bands), _deviations(bands), _energy_against_equal(bands, ratio),
        _above_twice(bands), _uneven(bands),
    ]  # fmt: skip
    return Findings(items, [_figure_last(bands, equal), _figure_ratio(bands)])


def _bands(context: Context, smallest: float) -> dict[str, Band]:
    rows = []
    for chain in histories(context, "3.5a-random-piston", smallest, 100):
        energy = energy_while(chain, grain(context, 70), grain(context, 90))
        # Behind the front: the last grain, which a free end lets go, does not count.
        largest = float(chain.velocity[:, 1:-1].max()) / SPEED
        near = chain.velocity[chain.frame(0.9 * float(chain.time[-1])), 1:11] / SPEED
        rows.append((*last_velocities(chain), energy.mean, 100.0 * energy.deviation, largest, 100.0 * float(np.std(near))))
    names = ("first", "last", "ratio", "deviation", "largest", "unevenness")
    return dict(zip(names, map(Band.of, np.array(rows).T), strict=True))


def _values(bands: Bands, name: str, printed: dict[float, str | None], unit: str = "") -> list[Value]:
    return [
        Value(f"R0 = {smallest:g}", printed[smallest], found[name].mean, unit, band=found[name])
        for smallest, found in bands.items()
    ]


def _draws(bands: Bands) -> str:
    return f"Mean ± sd [5 %, 95 %] over {bands[0.5]['last'].count} draws; the verdict says where the paper’s draw stands."


def _last(bands: Bands) -> Item:
    first = [
        Value(f"R0 = {smallest:g}, at first", None, found["first"].mean, band=found["first"])
        for smallest, found in bands.items()
    ]
    return Item(
        "Final velocity of the last of 100 random grains, v100/v0", "section 3.5 A, 2",
        [*_values(bands, "last", _LAST), *first],
        remark=f"{_draws(bands)} “At first”: when it leaves its neighbour; later waves may hit it once more.",
        reason=OUTSIDE,
    )  # fmt: skip


def _against_equal(bands: Bands, equal: float) -> Item:
    """Compare the mean over the draws, and not one draw, with equal grains."""
    sides = {smallest: "more" if found["last"].mean > equal else "less" for smallest, found in bands.items()}
    shares = {smallest: 100.0 - found["last"].percentile(equal) for smallest, found in bands.items()}
    return Item(
        "The last random grain against the last of equal ones", "section 3.5 A, 2",
        [Value("R0 = 0.5", "more", sides[0.5]), Value("R0 = 2", "less", sides[2.0])],
        remark=f"Of the means, against v100/v0 = {equal:.3f} of equal grains; they differ by {_errors(bands[0.5], equal):.0f} "
        f"and {_errors(bands[2.0], equal):.0f} standard errors.",
        reason=f"That random grains of R0 = 0.5 leave faster is one draw: they do in {shares[0.5]:.0f} % of ours, and the "
        f"mean is {bands[0.5]['last'].mean:.2f}.",
    )  # fmt: skip


def _errors(found: dict[str, Band], value: float) -> float:
    """Return by how many standard errors the mean of the last velocities differs from a number."""
    return abs(found["last"].mean - value) / found["last"].error_of_mean


def _ratios(bands: Bands) -> Item:
    return Item(
        "Ek/Ep while the front goes from grain 70 to 90, mean", "section 3.5 A, 3", _values(bands, "ratio", dict(_RATIO)),
        remark=f"{_draws(bands)} With the piston’s energy.", reason=OUTSIDE,
    )  # fmt: skip


def _deviations(bands: Bands) -> Item:
    return Item(
        "Ek/Ep in that time, largest deviation from its mean", "section 3.5 A, 3",
        _values(bands, "deviation", dict(_DEVIATION), "%"),
        remark=_draws(bands), reason=OUTSIDE,
    )  # fmt: skip


def _energy_against_equal(bands: Bands, equal: measurement.EnergyRatio) -> Item:
    """Compare the energies of random grains with those of equal ones in the same window."""
    values = []
    for smallest, found in bands.items():
        more = found["deviation"].mean > 200.0 * equal.deviation
        away = [abs(draw - 1.25) for draw in found["ratio"].draws]
        farther = float(np.mean(away)) > abs(equal.mean - 1.25)
        words = "much larger" if more else "not much larger"
        values.append(Value(f"R0 = {smallest:g}, deviations", "much larger", words, reading="more than twice"))
        values.append(Value(f"R0 = {smallest:g}, mean from 1.25", "farther", "farther" if farther else "nearer"))
    return Item(
        "Ek/Ep swings more, and its mean is farther from 1.25, than for equal grains", "section 3.5 A, 3",
        values,
        remark=f"Of the means over the draws. Equal grains, from 70 to 90: {equal.mean:.3f}, deviation "
        f"{100.0 * equal.deviation:.1f} %.",
        reason="The paper does not say how much “much larger” is; more than twice is our reading.",
    )  # fmt: skip


def _uneven(bands: Bands) -> Item:
    values = []
    for smallest, found in bands.items():
        spread = found["unevenness"]
        words = "uneven" if is_uneven(spread) else "even"
        values.append(Value(f"R0 = {smallest:g}", "uneven", words, reading=UNEVEN))
        values.append(Value("standard deviation over v0", None, spread.mean, "%", band=spread))
    return Item(
        "No even velocity beside the piston, for any R0", "section 3.5 A, 1", values,
        remark="Grains 2 to 11.", reason=UNEVEN_REASON,
    )  # fmt: skip


def _above_twice(bands: Bands) -> Item:
    values = []
    for smallest, found in bands.items():
        share = 100.0 - found["largest"].percentile(2.0)
        values.append(Value(f"R0 = {smallest:g}, above 2 v0", "yes", "yes" if share > 50.0 else "no", reading=_MOST))
        values.append(Value("largest v/v0", None, found["largest"].mean, band=found["largest"]))
    means = [found["largest"].mean for found in bands.values()]
    own = [found["largest"] for found in bands.values()]
    apart = [
        (a.mean - b.mean) / np.hypot(a.error_of_mean, b.error_of_mean) for a, b in zip(own, own[1:], strict=False)
    ]  # fmt: skip
    falling = "the smaller R0, the more" if means == sorted(means, reverse=True) else "not the smaller R0, the more"
    return Item(
        "Grains faster than 2 v0 behind the front", "section 3.5 A, 2",
        [*values, Value("excess over 2 v0", "the smaller R0, the more", falling)],
        remark=f"The excess is that of the means, which differ by {apart[0]:.1f} and {apart[1]:.1f} standard errors.",
        reason=f"The paper says it of its draws, one for each R0, and not of how many others; {_MOST} is our reading.",
    )  # fmt: skip


def _strips(bands: Bands, name: str, rows: dict[float, float]) -> list[Curve]:
    """Return a strip for each R0; the first one names what is what."""
    top = max(rows.values())
    return [curve for smallest, row in rows.items() for curve in strip(bands[smallest][name], row, row == top)]


def _figure_last(bands: Bands, equal: float) -> Figure:
    rows = {0.5: 3.0, 2.0: 2.0, 3.0: 1.0}
    curves = _strips(bands, "last", rows)
    marks = [Mark(printed, float(printed), rows[smallest]) for smallest, printed in _LAST.items() if printed]
    return Figure(
        "figure-35a-last", "Last of 100 random grains before a piston",
        f"Each dot is a draw. Equal grains leave with {equal:.3f} v0. The paper has one draw for R0 = 0.5 and one for 2.",
        Axis("v100 / v0"), Axis("", 0.4, 3.6, [(row, f"R0 = {smallest:g}") for smallest, row in rows.items()]), curves, marks,
    )  # fmt: skip


def _figure_ratio(bands: Bands) -> Figure:
    rows = {0.5: 3.0, 2.0: 2.0, 3.0: 1.0}
    curves = _strips(bands, "ratio", rows)
    marks = [Mark(printed, float(printed), rows[smallest]) for smallest, printed in _RATIO.items()]
    return Figure(
        "figure-35a-energy", "Ek/Ep in random chains before a piston",
        "Mean while the front goes from grain 70 to 90. Around the virial theorem’s 5/4, and the wider, the more unlike the "
        "grains.",
        Axis("Ek / Ep"), Axis("", 0.4, 3.6, [(row, f"R0 = {smallest:g}") for smallest, row in rows.items()]), curves, marks,
    )  # fmt: skip


def _runs(constants: Mapping[str, float]) -> int:
    return 3 * int(constants["seeds"]) + 2


ENTRY = Entry(
    "3.5a-ensembles",
    "3.5 A",
    "Random grains before a piston: many draws",
    "100 random grains before a piston, with R0 = 0.5, 2 and 3: the smaller R0, the more unlike the grains are. The paper "
    "gives one number for each, of one draw.",
    compute,
    weight=18.0,
    runs=_runs,
)
