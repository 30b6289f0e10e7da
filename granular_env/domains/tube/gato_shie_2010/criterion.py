"""The criterion of fracture: how near the notch comes to it, and what the outcome hangs on."""

from __future__ import annotations

import math

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item, Mark
from granular_env.atlas.verdicts import Value
from granular_env.components.materials.thermoviscoplastic import Thermoviscoplastic

from .cases import COARSER, HOURGLASS, PAPER_FACTOR
from .outcome import Outcome, in_notch, outcome, outcome_values

_INCHES = 1
_STABILISATIONS = (0.02, 0.1)
_FACTORS = (2.0,)


def compute(context: Context) -> Findings:
    """Vary the factor, the mesh and the stabilisation about the run of figure 2."""
    printed = outcome(context, _INCHES, PAPER_FACTOR)
    found = {words: one for words, one in _variants(context)}
    return Findings([_reached(printed), _table(found), _unchanged(context, found)], [_figure(context, printed, found)])


def _variants(context: Context) -> list[tuple[str, Outcome]]:
    """Return the outcome of each variant, by what is varied."""
    factor, nodes = context.constants["factor"], context.constants["nodes"]
    coarse = COARSER * nodes
    found = [(f"factor {factor:g}", outcome(context, _INCHES, factor))]
    found += [(f"factor {one:g}", outcome(context, _INCHES, one)) for one in _FACTORS]
    found += [
        (f"factor {factor:g}, stabilisation {one:g}", outcome(context, _INCHES, factor, hourglass=one))
        for one in _STABILISATIONS
    ]
    return [*found, (f"factor {factor:g}, {coarse:.0f} nodes", outcome(context, _INCHES, factor, nodes=coarse))]


def _reached(printed: Outcome) -> Item:
    reached = "is exceeded" if printed.parted else "is never exceeded"
    return Item(
        "“If the maximum of the principal tensile stress exceeds σ0 three times, the bonds between neighbouring particles are "
        "broken”", "section Material model and criterion of failure",
        [
            Value(f"{PAPER_FACTOR:g} σ0", "is exceeded", reached),
            Value("points that have parted", None, printed.parted, digits=4),
            Value("largest principal stress at a point, over 3 σ0", None, printed.ratio, digits=2),
            Value("where", None, "in the notch" if in_notch(_INCHES, printed.nearest) else "elsewhere"),
            Value("the flow law at a plastic strain of 1, over σ0", None, _saturated(), digits=3),
        ],
        remark="Notch of 1 in, σ0 = 275 MPa: the paper prints GPa. Over all points and all ticks; beside a crack the stress is "
        "larger than before it.",
        reason="With the material as printed the flow stress does not go far beyond 1.6 σ0, and the constraint below the notch "
        "is "
        "not enough.",
    )  # fmt: skip


def _saturated() -> float:
    """Return the flow stress at the reference rate and temperature over the yield stress, at a plastic strain of 1."""
    law = Thermoviscoplastic()
    return (1.0 + 1.0 / law.reference_strain) ** law.hardening_exponent


def _table(found: dict[str, Outcome]) -> Item:
    values: list[Value] = []
    for words, one in found.items():
        values += outcome_values(words, one)
    return Item(
        "What the outcome for the 1 in notch hangs on", "not in the paper", values,
        remark=f"The stabilisation holds displacements that alternate from column to column; {HOURGLASS:g} of the "
        "material’s stiffness elsewhere on this page. The paper names no stabilisation.",
    )  # fmt: skip


def _unchanged(context: Context, found: dict[str, Outcome]) -> Item:
    """Say whether the outcome is the same for each stabilisation and mesh, and how much lengths differ."""
    own = f"factor {context.constants['factor']:g}"
    alike = {
        "stabilisation": [one for words, one in found.items() if words.startswith(own) and "nodes" not in words],
        "mesh": [one for words, one in found.items() if words == own or (words.startswith(own) and "nodes" in words)],
    }
    values: list[Value] = []
    for varied, some in alike.items():
        words = sorted({one.words for one in some})
        values += [
            Value(f"{varied}: the outcome", None, "unchanged" if len(words) == 1 else f"changes: {', '.join(words)}"),
            Value(f"{varied}: reach along the tube, largest over least", None, _spread([one.along for one in some]), digits=2),
            Value(f"{varied}: part of the circumference, largest over least", None, _spread([one.around for one in some]),
                  digits=2),
        ]  # fmt: skip
    return Item(
        "Does the outcome hang on what is not of the material?", "not in the paper", values,
        remark="For the notch of 1 in and the page’s factor: three stabilisations from 0.02 to 0.1, and two meshes. There is "
        "no length in the criterion, so that a crack is as wide as the mesh makes it.",
    )  # fmt: skip


def _spread(values: list[float]) -> float:
    """Return the largest over the least; infinity where the least is 0 and the largest is not."""
    least, largest = min(values), max(values)
    return largest / least if least > 0.0 else (1.0 if largest == 0.0 else math.inf)


def _figure(context: Context, printed: Outcome, found: dict[str, Outcome]) -> Figure:
    names, values = [f"factor {PAPER_FACTOR:g}", *found], [printed.around, *(one.around for one in found.values())]
    places = [float(len(names) - k) for k in range(len(names))]
    labels = list(zip(places, names, strict=True))
    return Figure(
        "figure-criterion", "How far a crack runs around the tube, by factor, stabilisation and mesh",
        "The largest part of the circumference that a crack takes at one place along the tube, notch of 1 in.",
        Axis("part of the circumference, %", 0.0, 100.0), Axis("", 0.0, len(names) + 1.0, labels),
        [Curve("computed", [100.0 * value for value in values], places, "points", 0)],
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
