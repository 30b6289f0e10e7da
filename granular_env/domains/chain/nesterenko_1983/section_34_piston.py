"""Section 3.4: a piston at constant velocity; the profile, the last grain, and the first peak."""

from __future__ import annotations

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item, Mark
from granular_env.atlas.verdicts import Value

from .. import measurement
from ..measurement import History
from .cases import SPEED, UNCHANGED, case, grain
from .wave_count import CLEAR, FAINT

_LOOK = 5.45e-4
# Frames to either side of a maximum.
_AROUND = 8
_LAST = {20: "2.708", 50: "2.836", 100: "2.876", 200: "2.895"}
# Long enough for the front to run through 200 grains, and for the last one to leave.
_DURATION = 1.2e-3


def piston(context: Context, grains: int = 200) -> History:
    """Return the motion of the piston's chain until the last grain has left."""
    duration = _DURATION if grains == 200 else max(6e-6 * grains + 1e-4, 2e-4)
    return case(context, "3.4-piston", least=_LOOK if grains == 200 else 0.0, component__grains=grains, duration=duration)


def compute(context: Context) -> Findings:
    """Compute the items of the section except energies and speeds."""
    chain = piston(context)
    return Findings(
        [_last_grains(context), _first_peak(context, chain), _bound(context), _near_piston(chain), _growing(chain)],
        [_figure_6(chain), _figure_peak(context, chain)],
    )


def _last_grains(context: Context) -> Item:
    values = [
        Value(f"N = {grains}", printed, float(piston(context, grains).velocity[-1, -1]) / SPEED, digits=7)
        for grains, printed in _LAST.items()
    ]
    return Item(
        "Final velocity of the last grain, v_N/v0", "section 3.4", values,
        remark="The paper puts its own error at 0.01 %.",
        reason="The paper’s figures for 20 and 50 grains are 0.03 % above ours, three times its own error; at half the step "
        "ours keep all digits that are printed here. The paper’s step is not known.",
    )  # fmt: skip


def _peak(chain: History, index: int) -> float:
    """Height of the first maximum at a grain, over v0; only what lies around it is looked at."""
    velocity = chain.velocity[:, index]
    begin = int(np.argmax(velocity > 1.2 * SPEED))
    top = begin + int(np.argmax(np.diff(velocity[begin:]) < 0.0))
    own = slice(max(top - _AROUND, 0), top + _AROUND + 1)
    return measurement.crests(chain.time[own], velocity[own], 1.2 * SPEED)[0].height / SPEED


def _first_peak(context: Context, chain: History) -> Item:
    values = [
        Value("grain 50", None, _peak(chain, grain(context, 50)), "v0", digits=6),
        Value("grain 180", "2", _peak(chain, grain(context, 180)), "v0", paper=2.0, loose=0.02 * UNCHANGED, digits=6),
    ]
    return Item(
        "First maximum tends to 2 v0: v_m", "section 3.4, figure 6", values,
        reason=f"The paper gives 2 as a limit and no value at any grain; within {UNCHANGED:g} % is our reading. It is passed, "
        "see the next item.",
    )  # fmt: skip


def _bound(context: Context) -> Item:
    long = case(
        context, "3.4-piston", component__grains=500, duration=2.75e-3, record__variables=["velocity"],
        name="nesterenko-1983/3.4-piston-500",
    )  # fmt: skip
    passed = next((number for number in range(20, 400, 5) if _peak(long, grain(context, number)) > 2.0), None)
    height = _peak(long, grain(context, 450))
    return Item(
        "2 v0 is the limit of the first maximum", "section 3.4",
        [Value("v_m, grain 450 of 500", "at most 2", height, "v0", paper=2.0, at_most=True, digits=6)],
        reason=f"In a longer chain the first maximum passes 2 v0 near grain {passed}, is {height:.4f} v0 at grain 450, and "
        "still grows. 2 is the limit for the Korteweg-de Vries equation, to which the paper compares, not for this chain.",
    )  # fmt: skip


def _near_piston(chain: History) -> Item:
    velocity = chain.velocity[chain.frame(_LOOK), 1:11] / SPEED
    worst = 100.0 * float(np.abs(velocity - 1.0).max())
    return Item(
        "Grains near the piston have come to rest beside it", "section 3.4, figure 6",
        [Value("largest |v − v0|, grains 2 to 11", "none", worst, "%", paper=0.0, loose=UNCHANGED, digits=3)],
        remark="At 5.45e-4 s, as a part of v0.",
        reason=f"They still oscillate a little; the paper calls it a stationary state. Within {UNCHANGED:g} % is our reading.",
    )  # fmt: skip


def _growing(chain: History) -> Item:
    values = []
    for least in (CLEAR, FAINT):
        early, late = (
            int(np.count_nonzero(np.abs(np.diff(chain.velocity[chain.frame(time)])) > least * SPEED))
            for time in (2.7e-4, _LOOK)
        )
        name = f"differing by {100.0 * least:.0f} % of v0"
        values.append(Value(name, "more and more", "more and more" if late > early else "no more"))
        values.append(Value("at 2.7e-4 s, at 5.45e-4 s", None, f"{early}, {late}"))
    return Item(
        "More and more grains oscillate: the motion is not steady", "section 3.4", values,
        remark="Neighbours whose velocities differ by so much.",
    )  # fmt: skip


def _figure_6(chain: History) -> Figure:
    velocity = chain.velocity[chain.frame(_LOOK)]
    return Figure(
        "figure-6", "Figure 6: velocities of all grains at 5.45e-4 s",
        "The piston is at the left. Behind the front the grains oscillate about the piston’s velocity; beside the piston they "
        "have come to rest relative to it.",
        Axis("grain", low=0.0), Axis("velocity, m/s"), [Curve("computed", np.arange(1, chain.grains + 1), velocity)],
        [Mark("2 v0", y=2.0 * SPEED), Mark("piston, v0", y=SPEED)],
    )  # fmt: skip


def _figure_peak(context: Context, chain: History) -> Figure:
    numbers = np.arange(5, 196, 5)
    heights = [_peak(chain, grain(context, int(number))) for number in numbers]
    ends = np.array(list(_LAST))
    final = [float(piston(context, int(grains)).velocity[-1, -1]) / SPEED for grains in ends]
    marks = [Mark("2 v0", y=2.0), *(Mark(printed, float(grains), float(printed)) for grains, printed in _LAST.items())]
    return Figure(
        "figure-first-peak", "The first maximum, and the velocity with which the last grain leaves",
        "The first maximum grows along the chain and passes twice the piston’s velocity; a free last grain leaves with more.",
        Axis("grain, or number of grains", low=0.0), Axis("v / v0"),
        [Curve("first maximum", numbers, heights, "line", 0), Curve("last grain of N", ends, final, "points", 1)], marks,
    )  # fmt: skip


ENTRY = Entry(
    "3.4-piston",
    "3.4",
    "A piston drives an oscillating front",
    "The first grain of 200 moves at 5 m/s throughout. A front runs into the resting chain, and behind it the grains "
    "oscillate; without dissipation the motion never becomes steady.",
    compute,
    weight=1.0,
    runs=10,
)
