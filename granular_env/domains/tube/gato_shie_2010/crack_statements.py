"""The statements of figures 2 to 5: the outcome for a notch beside the paper's words, with a picture."""

from __future__ import annotations

from granular_env.atlas.context import Context
from granular_env.atlas.model import Figure, Item
from granular_env.atlas.verdicts import Value

from .cases import ARRIVAL, DRAWN_OUT, DURATION, INCH, LATE, PAPER_FACTOR, PAPER_NODES, PIECE, run_notched_tube
from .flow_stress_saturation import saturation
from .outcome import Outcome, in_notch, outcome, read_outcome
from .pictures import rolled_out

_COARSE = " Nodes that are so far apart cannot follow every branch."


def crack_outcome(context: Context, inches: int) -> Outcome:
    """Return what becomes of a tube with the page's factor."""
    return outcome(context, inches, context.constants["factor"])


def as_printed(context: Context, inches: int, printed: str) -> Item:
    """Return the paper's outcome beside that with its own factor."""
    one = outcome(context, inches, PAPER_FACTOR)
    gives_way = "The ligament gives way all the same: it flows, and is drawn out until aluminium would tear. "
    return Item(
        f"The {inches} in notch with the paper’s factor {PAPER_FACTOR:g}", "section Results",
        [
            Value("outcome", printed, one.words),
            Value("points that have parted", None, one.parted, digits=4),
            Value("the most overloaded one", None, "in the notch" if in_notch(inches, one.nearest) else "elsewhere"),
            Value("largest plastic strain", None, one.strain, digits=2),
            Value("the run ends, after the front", None, 1e3 * one.end, "ms", digits=2),
        ],
        remark="A tube is whole where no two neighbouring columns of nodes are parted, at whatever depth of the wall. The run "
        f"ends where a point has flowed by {DRAWN_OUT:g}.",
        reason=f"With the material that the paper prints the flow stress is {saturation():.2f} times the yield stress at a "
        f"plastic strain of 1; the largest principal stress was {PAPER_FACTOR * one.ratio:.1f} times it, "
        f"{'in the notch' if in_notch(inches, one.nearest) else 'outside the notch'}. "
        f"{gives_way if one.is_drawn_out else ''}Either the material or the factor of the paper’s computation was another one.",
    )  # fmt: skip


def cracks(context: Context, inches: int, where: str, statements: list[tuple[str, str, bool]]) -> Item:
    """Return the paper's statements on cracks beside what happens with the page's factor.

    Args:
        context: of the atlas.
        inches: length of the notch.
        where: the section or figure.
        statements: (what it is about, the paper's words, whether ours does so).
    """
    one, factor = crack_outcome(context, inches), context.constants["factor"]
    values = [
        Value(label, words, words if ours else "does not", reading="from where columns are parted")
        for label, words, ours in statements
    ]
    return Item(
        f"Cracks from the {inches} in notch, with the factor {factor:g}", where,
        [
            *values,
            Value("outcome", None, one.words),
            Value("length of cracks along the tube", None, one.along / INCH, "in", digits=2),
            Value("part of the circumference over which cracks reach", None, 100.0 * one.reach, "%", digits=2),
            Value("largest part of it at one place", None, 100.0 * one.around, "%", digits=2),
            Value("pieces", None, one.pieces, digits=2),
            Value("valid until, after the front", None, *valid_until(one), digits=2),
        ],
        remark="From neighbouring columns of nodes that are parted on the outer surface at the end of the run, "
        f"{1e3 * LATE:g} ms after the front has passed the notch. They are valid until a cross-section has grown by more than "
        "half: the gas of the paper’s one-way coupling flows as in a rigid tube, and loads flaps with its full pressure. The "
        f"piece of the tube is {PIECE / INCH:.1f} in long. Cracks "
        "part columns from their neighbours, so that an angle such as 45° shows as steps, and is not judged.",
        reason=f"The factor is ours, {factor:g} instead of {PAPER_FACTOR:g}, and the outcome hangs on it and on the mesh: see "
        f"the table of the criterion.{_COARSE if context.constants['nodes'] < PAPER_NODES else ''}",
    )  # fmt: skip


def picture(context: Context, inches: int, name: str, title: str, after: float = LATE) -> Figure:
    """Return the rolled-out tube, with stress and cracks, so long after the front has passed the middle of the notch [s]."""
    factor = context.constants["factor"]
    one = read_outcome(run_notched_tube(context, inches, factor), min(ARRIVAL + after, DURATION))
    invalid = (
        ""
        if one.is_valid
        else f" Not valid: {1e3 * one.valid_until:.2g} ms after the front a cross-section had grown by more than half, which "
        "the gas of one-way coupling does not feel."
    )
    return rolled_out(
        name, f"{title}, {1e3 * after:g} ms{'' if one.is_valid else ', not valid'}",
        "The outer surface, rolled out; one half is computed, the other is its mirror image. The detonation came from the "
        "left. The shade is the equivalent stress, "
        f"{1e3 * after:g} ms after the front has passed the middle of the notch; cracks as they are with the factor "
        f"{factor:g}.{invalid}",
        one, inches,
    )  # fmt: skip


def valid_until(one: Outcome) -> tuple[float | str, str]:
    """Return until when the gas flowed in a tube like that of the wall, and the unit."""
    return ("the end", "") if one.is_valid else (1e3 * one.valid_until, "ms")


def runs_beyond(one: Outcome, inches: int) -> bool:
    """Tell whether cracks along the tube reach beyond the notch."""
    return one.along > (inches + 0.05) * INCH


def turns(one: Outcome) -> bool:
    """Tell whether cracks reach around the tube by more than a tenth of its circumference."""
    return one.reach > 0.1
