"""Two-way coupling: a gas that feels the wall and leaks through cracks, beside the paper's one-way coupling."""

from __future__ import annotations

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item, Table
from granular_env.atlas.verdicts import Value
from granular_env.recording.log import Log

from .cases import INCH, LATE, run_notched_tube
from .outcome import HEAD, Outcome, compare, ratio, read_outcome, row_of

_INCHES = 1


def compute(context: Context) -> Findings:
    """Run the notch of figure 2 with a gas that feels the wall."""
    factor = context.constants["factor"]
    logs = {
        words: run_notched_tube(context, _INCHES, factor, two_way=two_way)
        for words, two_way in (("one-way", False), ("two-way", True))
    }
    found = {words: read_outcome(log) for words, log in logs.items()}
    return Findings([_same(found)], [_figure(logs)], [_table(logs, found)])


def _table(logs: dict[str, Log], found: dict[str, Outcome]) -> Table:
    rows = [[words, *row_of(one), *_gas(logs[words])] for words, one in found.items()]
    return Table(
        "table-coupling", "A gas in a rigid tube, and one that feels the wall",
        f"Notch of {_INCHES} in, {1e3 * LATE:g} ms after the front. Leaked: the part of the gas that has left through cracks.",
        ("coupling", *HEAD, "leaked", "largest mean growth of the radius"), rows,
    )  # fmt: skip


def _gas(log: Log) -> list[str]:
    end = float(log.times("shell_pieces")[-1])
    leaked = float(log.get("leaked_mass", end)) / float(log.get("gas_mass", 0.0))
    return [f"{100.0 * leaked:.2g} %", f"{1e3 * _growth(log):.2g} mm"]


def _same(found: dict[str, Outcome]) -> Item:
    one, two = found["one-way"], found["two-way"]
    return Item(
        "“The gas does not feel the wall”: what changes when it does", "section Results, on figure 3",
        [
            Value("the outcome of both", None, compare([one, two])),
            Value("reach along the tube, over that of one-way coupling", None, ratio(two.along, one.along), digits=2),
            Value("reach around the tube, over that of one-way coupling", None, ratio(two.reach, one.reach), digits=2),
        ],
        remark="The paper blames, among other things, that its gas flows as in a rigid tube. Here the gas gets the "
        "cross-section that the wall leaves it, pays for the work on the wall, and leaves through open cracks. It stays "
        "one-dimensional: flaps are no nozzle.",
    )  # fmt: skip


def _growth(log: Log) -> float:
    return float(np.max(log.series("radial_displacement")[1]))


def _figure(logs: dict[str, Log]) -> Figure:
    curves = []
    for number, (words, log) in enumerate(logs.items()):
        times, reach = log.series("shell_crack_along")
        curves.append(Curve(words, 1e6 * times, reach / INCH, "line" if number == 0 else "dashed", number))
    return Figure(
        "figure-coupling", "How far cracks reach along the tube, over time",
        "From the first place to the last, with the gas of a rigid tube and with one that feels the wall; notch of 1 in.",
        Axis("time, µs", 700.0), Axis("reach of cracks along the tube, in", 0.0), curves,
    )  # fmt: skip


ENTRY = Entry(
    "coupling",
    "Results",
    "Two-way coupling",
    "The paper couples one way: the gas is computed first, in a rigid tube, and then its pressure loads the wall.",
    compute,
    weight=60.0,
    runs=2,
)
