"""Section 3.5 A, figure 7: a piston drives grains of random radii; the profile, and the largest and smallest velocities."""

from __future__ import annotations

import numpy as np

from granular_env import measurement
from granular_env.atlas.bands import Band
from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item, Mark
from granular_env.atlas.verdicts import Value
from granular_env.measurement import History

from .cases import SPEED, grain, length
from .drawn import MICRO, TIME
from .draws import FRONT, OUTSIDE, envelope, histories, strip

_LOOK = 3.8e-4
_GRAINS = 200


def compute(context: Context) -> Findings:
    """Figure 7 and its extremes over many draws with R0 = .5 mm."""
    chains = list(histories(context, "3.5a-random-piston", 0.5, _GRAINS, _LOOK))
    measured = [_extremes(context, chain) for chain in chains]
    bands = {name: Band.of([one[name] for one in measured]) for name in measured[0]}
    items = [_largest(bands), _smallest(bands), _uneven(bands), _front(bands)]
    return Findings(items, [_figure_profile(chains), _figure_history(context, chains), _figure_extremes(bands)])


def _extremes(context: Context, chain: History) -> dict[str, float]:
    """Of one draw, until the front has reached grain 170, where the paper's was at its largest velocity."""
    seen = measurement.arrivals(chain, FRONT)
    place, late = grain(context, 25), seen[min(grain(context, 170), length(context, _GRAINS) - 1)]
    own = chain.velocity[: chain.frame(min(late, chain.time[-1])) + 1 if np.isfinite(late) else len(chain.time)]
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


def _largest(bands: dict[str, Band]) -> Item:
    whole, own = bands["largest"], bands["largest of 25"]
    return Item(
        "Largest velocity behind the front, R0 = 0.5", "section 3.5 A, figure 7",
        [
            Value("any grain", "11.76", whole.mean, "m/s", band=whole),
            Value("grain 25", "11.76", own.mean, "m/s", band=own),
        ],
        remark="Until the front is at grain 170. The paper says that the largest was that of its grain 25. Mean ± sd [5 %, "
        f"95 %] over {whole.count} draws.",
        reason="Of all grains, at every microsecond, the largest velocity is more than that in every draw: the least one is "
        f"{whole.low:.1f} m/s. The paper does not say how many grains and times it looked at; for grain 25 alone its number "
        "is an ordinary draw.",
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
            Value("grains 2 to 11 at 3.8e-4 s", "uneven", "uneven" if spread.quantile(5) > 1.0 else "even"),
            Value("their standard deviation over v0", None, spread.mean, "%", band=spread),
        ],
        remark="Uneven: more than 1 % of v0 in 95 % of the draws; equal grains have come to rest within that (3.4).",
    )  # fmt: skip


def _front(bands: dict[str, Band]) -> Item:
    return Item(
        "How far the front is at 3.8e-4 s", "figure 7, a", [Value("grain", None, bands["front"].mean, band=bands["front"])],
        remark="The paper says that it was at grain 148 when grain 25 was at its slowest, and at 170 when it was at its "
        "fastest.",
    )  # fmt: skip


def _figure_profile(chains: list[History]) -> Figure:
    profiles = np.array([chain.velocity[chain.frame(_LOOK)] for chain in chains])
    numbers = np.arange(1, profiles.shape[1] + 1)
    return Figure(
        "figure-7a", "Figure 7 a: velocities at 3.8e-4 s, R0 = 0.5",
        f"One draw of ours (seed 1), and the range of 90 % of {len(chains)} draws at each grain. No two draws are alike; the "
        "paper’s is not known.",
        Axis("grain", low=0.0), Axis("velocity, m/s"),
        [
            envelope(numbers, profiles),
            Curve("seed 1", numbers, profiles[0], "line", 0),
        ],
        [Mark("2 v0", y=2.0 * SPEED), Mark("v0", y=SPEED)],
    )  # fmt: skip


def _figure_history(context: Context, chains: list[History]) -> Figure:
    place = grain(context, 25)
    velocities = np.array([chain.velocity[:, place] for chain in chains])
    time = chains[0].time * MICRO
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


ENTRY = Entry(
    "3.5a-profile",
    "3.5 A",
    "A piston and grains of random radii",
    "200 grains with radii (R0 + RAND) mm, RAND even between 0 and 1, here R0 = 0.5, driven by a piston at 5 m/s. The paper "
    "shows one draw of the random radii. Its draw is not known, so we make many, and say where the paper’s numbers stand "
    "among them.",
    compute,
    weight=12.0,
)
