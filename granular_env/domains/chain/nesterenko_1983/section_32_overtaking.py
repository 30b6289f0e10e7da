"""Section 3.2 B: a tall solitary wave overtakes lower ones; figure 4."""

from __future__ import annotations

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Entry, Figure, Findings, Item
from granular_env.atlas.verdicts import Value

from ..measurement import History, Wave
from .cases import case, change, grain
from .velocity_curves import TIME, during
from .wave_count import RULE, counts, heights, waves

# Grains and windows of time of figure 4 [s]; the last one has no end in the paper.
_WINDOWS = {50: (2e-4, 3e-4), 85: (4e-4, 5.5e-4), 145: (8e-4, 9.5e-4)}


def compute(context: Context) -> Findings:
    """Find how many waves there are, who passes whom, and what it costs."""
    chain = case(context, "3.2b-overtaking", least=_WINDOWS[145][1])
    found = {number: waves(chain, grain(context, number)) for number in _WINDOWS}
    leading = {number: _leading(seen, found[50]) for number, seen in found.items()}
    items = [_count(context, chain), _order(leading), _windows(leading), _form(leading)]
    return Findings(items, [_figure(context, chain, number, window) for number, window in _WINDOWS.items()])


def _leading(found: list[Wave], first: list[Wave]) -> dict[int, Wave]:
    """Waves at a grain, in the order of arrival, by the number that they had at the first grain; told by their heights."""
    from scipy.optimize import linear_sum_assignment

    unlike = np.abs(np.log([[wave.amplitude / other.amplitude for other in first] for wave in found]))
    names = dict(zip(*(places.tolist() for places in linear_sum_assignment(unlike)), strict=True))
    return {names[place] + 1: wave for place, wave in enumerate(found) if place in names}


def _count(context: Context, chain: History) -> Item:
    place = grain(context, 50)
    return Item(
        "Number of solitary waves", "section 3.2 B",
        [*counts("", "6", chain, place), Value("their v_m", None, heights(waves(chain, place), 1.0), "m/s")],
        remark=f"At grain 50. {RULE}",
    )  # fmt: skip


def _order(leading: dict[int, dict[int, Wave]]) -> Item:
    printed = {50: "1, 2, 3", 85: "1, 3, 2", 145: "3, 1"}
    values = [
        Value(f"grain {number}", printed[number], ", ".join(map(str, list(seen)[: 3 if number < 145 else 2])))
        for number, seen in leading.items()
    ]
    return Item(
        "Wave 3 overtakes first wave 2, then wave 1", "section 3.2 B, figure 4", values,
        remark="Order of arrival; waves are numbered as they arrive at grain 50 and known by their heights. At grain 145 the "
        "paper leaves out wave 2, which has fallen behind.",
    )  # fmt: skip


def _windows(leading: dict[int, dict[int, Wave]]) -> Item:
    values = []
    for number, (begin, end) in _WINDOWS.items():
        times = [wave.time for wave in leading[number].values()][: 3 if number < 145 else 2]
        inside = all(begin <= time for time in times) and (number == 145 or all(time <= end for time in times))
        printed = f"{begin * 1e6:g} to {end * 1e6:g} µs" if number < 145 else f"after {begin * 1e6:g} µs"
        values.append(Value(f"grain {number}", printed, printed if inside else "outside"))
        values.append(Value("crests", None, ", ".join(f"{time * 1e6:.1f}" for time in times), "µs"))
    return Item("When the waves pass", "section 3.2 B, figure 4", values)


def _form(leading: dict[int, dict[int, Wave]]) -> Item:
    values = [
        change(
            f"change of v_m, wave {name}, grain 50 to 145", "unchanged",
            100.0 * (leading[145][name].amplitude / leading[50][name].amplitude - 1.0),
        )
        for name in (1, 3)
    ]  # fmt: skip
    return Item(
        "Height and form do not change", "section 3.2 B", values,
        reason="The waves come out of an overtaking a little changed, less than a figure shows.",
    )  # fmt: skip


def _figure(context: Context, chain: History, number: int, window: tuple[float, float]) -> Figure:
    curve = during(chain, *window, grain(context, number), f"grain {number}", {50: 0, 85: 1, 145: 2}[number])
    captions = {
        50: "Waves 1, 2 and 3 in the order of their arrival; the third is the tallest and fastest.",
        85: "The tallest has passed wave 2.",
        145: "It has passed wave 1 as well.",
    }
    return Figure(
        f"figure-4-grain-{number}", f"Figure 4: velocity of grain {number}", captions[number], Axis(TIME),
        Axis("velocity, m/s", low=-0.3, high=9.2), [curve],
    )  # fmt: skip


ENTRY = Entry(
    "3.2b-overtaking",
    "3.2 B",
    "A tall solitary wave overtakes lower ones",
    "Grains 1 and 2 of 150 move at 10 m/s, grains 18 and 19 at 5 m/s, all to the right. Taller waves are faster.",
    compute,
    weight=0.3,
    runs=1,
)
