"""The three notches at several initial pressures: from which one on a tube breaks, and how far."""

from __future__ import annotations

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Table

from .cases import COARSER, LATE
from .outcome import HEAD, PARTS, Outcome, outcome, row_of

_INCHES = (1, 2, 3)
_PRESSURES = (80e3, 130e3, 180e3)
# Points of the same pressure are drawn so far from each other, so that none hides another [kPa].
_APART = 2.0


def compute(context: Context) -> Findings:
    """Run each notch with each filling, on a coarser mesh."""
    factor, nodes = context.constants["factor"], max(COARSER * context.constants["nodes"], 3000.0)
    found = {
        (inches, pressure): outcome(context, inches, factor, nodes=nodes, pressure=pressure)
        for inches in _INCHES
        for pressure in _PRESSURES
    }
    return Findings([], [_figure(found)], [_table(found, factor, nodes)])


def _table(found: dict[tuple[int, float], Outcome], factor: float, nodes: float) -> Table:
    rows = [[f"{inches} in", f"{pressure / 1e3:.0f} kPa", *row_of(one)] for (inches, pressure), one in found.items()]
    return Table(
        "table-pressures", "The outcome by notch and initial pressure",
        "The paper names the range of the experiments, 80 to 180 kPa, and not at which pressure each figure was made. "
        f"Factor {factor:g}, {nodes:.0f} nodes, coarser than elsewhere on this page.",
        ("notch", "initial pressure", *HEAD), rows,
    )  # fmt: skip


def _figure(found: dict[tuple[int, float], Outcome]) -> Figure:
    curves = [
        Curve(
            f"{inches} in", [pressure / 1e3 + _APART * (number - 1) for pressure in _PRESSURES],
            [100.0 * found[inches, pressure].reach for pressure in _PRESSURES], "points", number,
        )
        for number, inches in enumerate(_INCHES)
    ]  # fmt: skip
    return Figure(
        "figure-pressures", "How far cracks reach around the tube, by notch and initial pressure",
        "The part of the circumference over which cracks lie, wherever along the tube, "
        f"{1e3 * LATE:g} ms after the front. Of three points side by side the middle one is at the pressure of all three.",
        Axis("initial pressure, kPa", 70.0, 190.0), Axis("part of the circumference, %", *PARTS), curves,
    )  # fmt: skip


ENTRY = Entry(
    "pressures",
    "Results",
    "The outcome by initial pressure",
    "In the experiments the detonation tube was filled with 80 to 180 kPa; the front is then as fast, and its pressure is in "
    "proportion.",
    compute,
    weight=150.0,
    runs=9,
)
