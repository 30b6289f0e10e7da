"""Section 3.5 A, figure 7: a piston drives grains of random radii; the profile, and the largest and smallest velocities."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item, Mark
from granular_env.atlas.seed_statistics import Band
from granular_env.atlas.verdicts import Value

from ..measurement import History
from .cases import SPEED, grain, length
from .random_chains import FRONT, OUTSIDE, UNEVEN, UNEVEN_REASON, arrival, envelope, histories, is_uneven, strip
from .velocity_curves import MICRO, TIME

_LOOK = 3.8e-4
_GRAINS = 200
# Radius of the paper's grain 25 [m]: the one thing that it tells of its draw.
_GIVEN = {25: 7.82465e-4}


def compute(context: Context) -> Findings:
    """Figure 7, its extremes, and what is said of the front, over many draws with R0 = 0.5 mm."""
    draws = [_draw(context, chain) for chain in histories(context, "3.5a-random-piston", 0.5, _GRAINS, _LOOK, _GIVEN)]
    bands = {name: Band.of([draw.numbers[name] for draw in draws]) for name in draws[0].numbers}
    items = [_largest(bands), _smallest(bands), _uneven(bands), *_sentences(bands), _front(bands)]
    return Findings(items, [_figure_profile(draws), _figure_history(draws), _figure_extremes(bands)])


@dataclasses.dataclass(frozen=True)
class _Draw:
    """The record of a draw: numbers, velocities of all grains at 3.8e-4 s, times, and velocities of grain 25."""

    numbers: dict[str, float]
    profile: np.ndarray
    time: np.ndarray
    velocity: np.ndarray


def _draw(context: Context, chain: History) -> _Draw:
    numbers = _extremes(context, chain) | _leading(chain)
    frame, thin = chain.frame(_LOOK), slice(None, None, 5)
    return _Draw(numbers, chain.velocity[frame], chain.time[thin], chain.velocity[thin, grain(context, 25)])


def _extremes(context: Context, chain: History) -> dict[str, float]:
    """Return extreme velocities of one draw, until the front has reached grain 170, where the paper's was at its largest."""
    place = grain(context, 25)
    late = arrival(chain, min(grain(context, 170), length(context, _GRAINS) - 1))
    own = chain.velocity[: chain.frame(min(late, float(chain.time[-1]))) + 1]
    near = chain.velocity[chain.frame(_LOOK), 1:11] / SPEED
    # The piston does not count, nor the last grain, which a free end lets go.
    inner = own[:, 1:-1]
    reached = np.flatnonzero(chain.velocity[chain.frame(_LOOK)] > FRONT)
    return {
        "largest": float(inner.max()),
        "smallest": float(inner.min()),
        "largest of 25": float(own[:, place].max()),
        "smallest of 25": float(own[:, place].min()),
        "unevenness": 100.0 * float(np.std(near)),
        "front": float(reached[-1] + 1),
    }


def _leading(chain: History) -> dict[str, float]:
    """Return what the paper says of the first maximum of the grains that the front has passed, for one draw."""
    first = _first_maxima(chain)
    heights, mass = first[np.isfinite(first)] / SPEED, chain.mass[np.isfinite(first)]
    # At each moment at which a grain has its first maximum, what the grains behind it reach at that time.
    profile = chain.velocity[chain.frame(_LOOK)] / SPEED
    lighter = np.sign(np.diff(mass))
    return {
        "front over behind": float(heights[-1] / profile[1 : len(heights)].max()),
        "share falling": 100.0 * float(np.mean(np.diff(heights) < 0.0)),
        "least first": float(heights.min()),
        "greatest first": float(heights.max()),
        "lighter and slower": 100.0 * float(np.mean(lighter == np.sign(np.diff(heights)))),
    }


def _first_maxima(chain: History) -> np.ndarray:
    """Return the height of each grain's first maximum [m/s], shape (grains,); NaN where there is none, and for the ends."""
    velocity = chain.velocity
    # The first fall of the velocity after it has passed the front's threshold.
    falls = (np.diff(velocity, axis=0) < 0.0) & (velocity[:-1] > FRONT)
    found = np.where(falls.any(axis=0), velocity[np.argmax(falls, axis=0), np.arange(chain.grains)], np.nan)
    found[[0, -1]] = np.nan
    return found


def _largest(bands: dict[str, Band]) -> Item:
    whole, own = bands["largest"], bands["largest of 25"]
    below = sum(draw < 11.76 for draw in whole.draws)
    return Item(
        "Largest velocity behind the front, R0 = 0.5", "section 3.5 A, figure 7",
        [
            Value("any grain", "11.76", whole.mean, "m/s", band=whole),
            Value("grain 25", "11.76", own.mean, "m/s", band=own),
        ],
        remark="Until the front is at grain 170. The paper says that the largest was that of its grain 25, whose radius, "
        f"0.782465 mm, every draw has. Mean ± sd [5 %, 95 %] over {whole.count} draws.",
        reason="Of all grains, five times a microsecond, the largest velocity is more than that in "
        f"{whole.count - below} of {whole.count} draws; the least one is {whole.low:.1f} m/s. The paper does not say how many "
        "grains and times it looked at; for grain 25 alone its number is an ordinary draw.",
    )  # fmt: skip


def _smallest(bands: dict[str, Band]) -> Item:
    whole, own = bands["smallest"], bands["smallest of 25"]
    return Item(
        "Negative velocities, R0 = 0.5", "section 3.5 A, figure 7",
        [Value("grain 25", "-2.142", own.mean, "m/s", band=own), Value("any grain", None, whole.mean, "m/s", band=whole)],
        remark="The smallest velocity until the front is at grain 170. Grain 25 was one of the paper’s choice, because it "
        "was its fastest.",
        reason=OUTSIDE,
    )  # fmt: skip


def _uneven(bands: dict[str, Band]) -> Item:
    spread = bands["unevenness"]
    return Item(
        "No even velocity is reached, not even beside the piston", "section 3.5 A, 1",
        [
            Value("grains 2 to 11 at 3.8e-4 s", "uneven", "uneven" if is_uneven(spread) else "even", reading=UNEVEN),
            Value("their standard deviation over v0", None, spread.mean, "%", band=spread),
        ],
        remark="Equal grains differ by less than 1 % (3.4).", reason=UNEVEN_REASON,
    )  # fmt: skip


def _sentences(bands: dict[str, Band]) -> list[Item]:
    """Return what the paper says, in four sentences, of the first maximum of the grains that the front passes."""
    lower = bands["front over behind"].percentile(1.0)
    falling = bands["share falling"]
    below, above = bands["least first"].percentile(1.0), 100.0 - bands["greatest first"].percentile(2.0)
    untied = bands["lighter and slower"]
    every = "; in every draw" if falling.low > 0.0 else ""
    return [
        Item(
            "The front may be lower than what follows", "section 3.5 A, 2",
            [
                Value("first maximum below the largest behind it", "may be", _may_be(lower)),
                Value("in so many draws", None, lower, "%", digits=3),
            ],
            remark="At 3.8e-4 s, of the last grain that has had its first maximum.",
        ),
        Item(
            "The first maximum does not tend monotonically to 2 v0", "section 3.5 A, 2",
            [
                Value("it falls from a grain to the next", "may be", _may_be(falling.mean)),
                Value("for so many grains", None, falling.mean, "%", band=falling),
            ],
            remark=f"Of the grains that the front has passed at 3.8e-4 s{every}. Among equal grains it grows from each "
            "to the next.",
        ),
        Item(
            "The first maximum may be below v0, and much above it", "section 3.5 A, 2",
            [
                Value("below v0 at some grain", "may be", _may_be(below)),
                Value("in so many draws", None, below, "%", digits=3),
                Value("least first maximum, v/v0", None, bands["least first"].mean, band=bands["least first"]),
                Value("substantially above v0", "may be", _may_be(above), reading="above 2 v0"),
                Value("in so many draws", None, above, "%", digits=3),
                Value("greatest first maximum, v/v0", None, bands["greatest first"].mean, band=bands["greatest first"]),
            ],
            reason="The paper does not say how much “substantially above v0” is; above 2 v0 is our reading.",
        ),
        Item(
            "A lighter grain need not be faster in its first maximum", "section 3.5 A, 2",
            [
                Value("lighter than its neighbour, and slower", "may be", _may_be(untied.mean)),
                Value("of so many neighbours", None, untied.mean, "%", band=untied),
            ],
            remark="Of each two neighbours that the front has passed.",
        ),
    ]  # fmt: skip


def _may_be(percent: float) -> str:
    return "may be" if percent > 0.0 else "is never"


def _front(bands: dict[str, Band]) -> Item:
    return Item(
        "How far the front is at 3.8e-4 s", "figure 7, a", [Value("grain", None, bands["front"].mean, band=bands["front"])],
        remark="The paper says that it was at grain 148 when grain 25 was at its slowest, and at 170 when it was at its "
        "fastest.",
    )  # fmt: skip


def _figure_profile(draws: list[_Draw]) -> Figure:
    profiles = np.array([draw.profile for draw in draws])
    numbers = np.arange(1, profiles.shape[1] + 1)
    return Figure(
        "figure-7a", "Figure 7 a: velocities at 3.8e-4 s, R0 = 0.5",
        f"One draw of ours (seed 1), and the range of 90 % of {len(draws)} draws at each grain. No two draws are alike; the "
        "paper’s is not known.",
        Axis("grain", low=0.0), Axis("velocity, m/s"),
        [
            envelope(numbers, profiles),
            Curve("seed 1", numbers, profiles[0], "line", 0),
        ],
        [Mark("2 v0", y=2.0 * SPEED), Mark("v0", y=SPEED)],
    )  # fmt: skip


def _figure_history(draws: list[_Draw]) -> Figure:
    velocities = np.array([draw.velocity for draw in draws])
    time = draws[0].time * MICRO
    return Figure(
        "figure-7b", "Figure 7 b: velocity of grain 25, R0 = 0.5",
        "The same draw, and the range of 90 % of all. Marked: the extremes of the paper’s draw.",
        Axis(TIME), Axis("velocity, m/s"),
        [
            envelope(time, velocities),
            Curve("seed 1", time, velocities[0], "line", 0),
        ],
        [Mark("11.76", y=11.76), Mark("-2.142", y=-2.142)],
    )  # fmt: skip


def _figure_extremes(bands: dict[str, Band]) -> Figure:
    rows = {"largest": 4.0, "largest of 25": 3.0, "smallest of 25": 2.0, "smallest": 1.0}
    names = {
        "largest": "largest, any",
        "largest of 25": "largest, 25",
        "smallest of 25": "smallest, 25",
        "smallest": "smallest, any",
    }
    curves = [curve for name, row in rows.items() for curve in strip(bands[name], row, row == 4.0)]
    marks = [Mark("11.76", 11.76, 4.0), Mark("11.76", 11.76, 3.0), Mark("-2.142", -2.142, 2.0)]
    return Figure(
        "figure-extremes", "Extremes over many draws, and the paper’s",
        f"Each dot is one of {bands['largest'].count} draws, until the front is at grain 170. The paper has one draw.",
        Axis("velocity, m/s"), Axis("", 0.4, 4.6, [(row, names[name]) for name, row in rows.items()]), curves, marks,
    )  # fmt: skip


def _runs(constants: Mapping[str, float]) -> int:
    return int(constants["seeds"])


ENTRY = Entry(
    "3.5a-profile",
    "3.5 A",
    "A piston and grains of random radii",
    "200 grains with radii (R0 + RAND) mm, RAND even between 0 and 1, here R0 = 0.5, driven by a piston at 5 m/s. The paper "
    "shows one draw of the random radii. Of its draw only the radius of grain 25 is known, so we make many with that grain, "
    "and say where the paper’s numbers stand among them.",
    compute,
    weight=8.0,
    runs=_runs,
)
