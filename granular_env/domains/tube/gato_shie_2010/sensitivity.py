"""Sensitivity of the outcome to the fracture criterion's factor, the mesh and the stabilisation."""

from __future__ import annotations

from typing import NamedTuple

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item, Mark, Table
from granular_env.atlas.verdicts import Value

from .cases import COARSER, DRAWN_OUT, HOURGLASS, LATE, PAPER_FACTOR
from .flow_stress_saturation import saturation
from .outcome import HEAD, PARTS, Outcome, compare, in_notch, outcome, ratio, row_of

_INCHES = 1
_STABILISATIONS = (0.02, 0.1)
_FACTORS = (2.0,)


class Variant(NamedTuple):
    """A run of the table: what was varied, and what became of it."""

    factor: float
    hourglass: float
    nodes: float
    outcome: Outcome

    def label(self) -> str:
        """Return what was varied, for an axis."""
        return f"factor {self.factor:g}, {self.hourglass:g}, {self.nodes:.0f}"


def compute(context: Context) -> Findings:
    """Vary the factor, the mesh and the stabilisation about the run of figure 2."""
    found = _variants(context)
    printed, own = found[0], found[2:]
    return Findings([_reached(printed.outcome), _unchanged(own)], [_figure(found)], [_table(found)])


def _variants(context: Context) -> list[Variant]:
    """Return the runs, that with the paper's factor first; those with the page's factor are the last ones."""
    factor, nodes = context.constants["factor"], context.constants["nodes"]
    kinds = [(one, HOURGLASS, nodes) for one in (PAPER_FACTOR, *_FACTORS, factor)]
    kinds += [(factor, one, nodes) for one in _STABILISATIONS]
    kinds.append((factor, HOURGLASS, COARSER * nodes))
    return [
        Variant(factor, hourglass, nodes, outcome(context, _INCHES, factor, hourglass=hourglass, nodes=nodes))
        for factor, hourglass, nodes in kinds
    ]


def _reached(printed: Outcome) -> Item:
    reached = "is exceeded" if printed.parted else "is never exceeded"
    instead = " It flows instead, and is drawn out until aluminium would tear." if printed.is_drawn_out else ""
    return Item(
        "“If the maximum of the principal tensile stress exceeds σ0 three times, the bonds between neighbouring particles are "
        "broken”", "section Material model and criterion of failure",
        [
            Value(f"{PAPER_FACTOR:g} σ0", "is exceeded", reached),
            Value("points that have parted", None, printed.parted, digits=4),
            Value("largest principal stress at a point, over 3 σ0", None, printed.ratio, digits=2),
            Value("where", None, "in the notch" if in_notch(_INCHES, printed.nearest) else "elsewhere"),
            Value("the flow law at a plastic strain of 1, over σ0", None, saturation(), digits=3),
            Value("largest plastic strain", None, printed.strain, digits=2),
        ],
        remark="Notch of 1 in, σ0 = 275 MPa: the paper prints GPa. Over all points and all ticks; beside a crack the stress is "
        "larger than before it.",
        reason=f"With the material as printed the flow stress is {saturation():.2f} σ0 at a plastic strain of 1, and a "
        f"ligament with two free surfaces bears 2/√3 of that, a little more at the rates of a detonation.{instead}",
    )  # fmt: skip


def _table(found: list[Variant]) -> Table:
    rows = [
        [f"{one.factor:g}", f"{one.hourglass:g}", f"{one.nodes:.0f}", *row_of(one.outcome), f"{one.outcome.parted:.0f}"]
        for one in found
    ]
    return Table(
        "table-criterion", "What the outcome for the 1 in notch hangs on",
        f"{1e3 * LATE:g} ms after the front; the first row has the factor that the paper prints, and ends where a point has "
        f"flowed by {DRAWN_OUT:g}. The stabilisation holds "
        "displacements that alternate from column to column, by a part of the material’s stiffness; the paper names none. "
        "Nodes: of the whole tube. There is no length in the criterion, so that a crack is as wide as the mesh makes it.",
        ("factor", "stabilisation", "nodes", *HEAD, "points that parted"), rows,
    )  # fmt: skip


def _unchanged(own: list[Variant]) -> Item:
    """Say whether the outcome is the same for each stabilisation and mesh, and how much lengths differ."""
    alike = {
        "stabilisation": [one.outcome for one in own if one.nodes == own[0].nodes],
        "mesh": [one.outcome for one in own if one.hourglass == own[0].hourglass],
    }
    values: list[Value] = []
    for varied, some in alike.items():
        values += [
            Value(f"{varied}: the outcome", None, compare(some)),
            Value(f"{varied}: reach along the tube, largest over least", None, _spread([one.along for one in some]), digits=2),
            Value(f"{varied}: reach around the tube, largest over least", None, _spread([one.reach for one in some]), digits=2),
        ]  # fmt: skip
    stabilisations = sorted({one.hourglass for one in own})
    return Item(
        "Does the outcome hang on what is not of the material?", "not in the paper", values,
        remark=f"For the notch of 1 in and the factor {own[0].factor:g}: stabilisations of "
        f"{', '.join(f'{one:g}' for one in stabilisations)}, and meshes of "
        f"{' and '.join(f'{one:.0f}' for one in sorted({one.nodes for one in own}))} nodes.",
    )  # fmt: skip


def _spread(values: list[float]) -> float:
    """Return the largest over the least."""
    return ratio(max(values), min(values))


def _figure(found: list[Variant]) -> Figure:
    places = [float(len(found) - k) for k in range(len(found))]
    labels = list(zip(places, [one.label() for one in found], strict=True))
    return Figure(
        "figure-criterion", "How far cracks reach around the tube, by factor, stabilisation and mesh",
        "The part of the circumference over which cracks lie, wherever along the tube, notch of 1 in. Labels: the factor, the "
        "stabilisation and the nodes.",
        Axis("part of the circumference, %", *PARTS), Axis("", 0.0, len(found) + 1.0, labels),
        [Curve("computed", [100.0 * one.outcome.reach for one in found], places, "points", 0)],
        [Mark("the paper: stops at about 3/4", x=75.0)],
    )  # fmt: skip


ENTRY = Entry(
    "criterion",
    "Criterion",
    "The criterion of fracture, and what the outcome hangs on",
    "Bonds between particles break where the largest principal stress exceeds a multiple of the yield stress, in the paper "
    "three "
    "times.",
    compute,
    weight=120.0,
    runs=6,
)
