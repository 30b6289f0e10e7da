"""The three lengths of notch: what became of each tube beside the paper's words, and the growth of their cracks over time."""

from __future__ import annotations

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings, Item, Mark, Table
from granular_env.atlas.verdicts import Value
from granular_env.recording.log import Log

from .cases import ARRIVAL, DRAWN_OUT, EARLY, LATE, PAPER_FACTOR, run_notched_tube
from .outcome import HEAD, PARTS, REACH, Outcome, reach_history, read_outcome, row_of

# Notch [in] -> the paper's words on its computation, and on the experiment.
_PAPER = {
    1: ("straight, at 45°, around; stops at about 3/4 of the circumference", "the same"),
    2: ("branches around both ways; not parted on the other side", "one crack around all of it: severed"),
    3: ("straight, then branches around all of it: severed", "the same"),
}
_MILLI, _MICRO = 1e3, 1e6


def compute(context: Context) -> Findings:
    """Read the runs of figures 2 to 5 at an early and at the last time."""
    factor = context.constants["factor"]
    logs = {inches: run_notched_tube(context, inches, factor) for inches in _PAPER}
    printed = {inches: read_outcome(run_notched_tube(context, inches, PAPER_FACTOR)) for inches in _PAPER}
    early = {inches: read_outcome(log, ARRIVAL + EARLY) for inches, log in logs.items()}
    late = {inches: read_outcome(log) for inches, log in logs.items()}
    rows: list[list[str]] = []
    for inches in _PAPER:
        rows += [
            [
                f"{inches} in",
                f"{PAPER_FACTOR:g}, as printed",
                f"{_MILLI * printed[inches].end:.2g} ms",
                *row_of(printed[inches]),
            ],
            [f"{inches} in", f"{factor:g}", f"{_MILLI * EARLY:g} ms", *row_of(early[inches])],
            [f"{inches} in", f"{factor:g}", f"{_MILLI * LATE:g} ms", *row_of(late[inches])],
        ]
    return Findings([_growth(early, late, logs)], [_figure(logs)], [_words(late), _table(rows)])


def _words(late: dict[int, Outcome]) -> Table:
    return Table(
        "table-words", "What becomes of the tube: the paper’s words and our word",
        "Ours with the factor of this page. Axial crack: cracks along the tube that take less than 5 % of the circumference; "
        "hoop crack: more; severed: nothing joins the ends of the piece any more.",
        ("notch", "the paper’s computation", "the paper on the experiment", "ours"),
        [[f"{inches} in", *words, late[inches].words] for inches, words in _PAPER.items()],
    )  # fmt: skip


def _table(rows: list[list[str]]) -> Table:
    return Table(
        "table-outcomes", "What becomes of the tube, by notch, factor and time",
        "Times after the front has passed the middle of the notch; runs with the paper’s factor end where a point has flowed "
        f"by {DRAWN_OUT:g}. {REACH} The piece of the tube is 160 mm long.",
        ("notch", "factor", "time", *HEAD), rows,
    )  # fmt: skip


def _growth(early: dict[int, Outcome], late: dict[int, Outcome], logs: dict[int, Log]) -> Item:
    values: list[Value] = []
    for inches, one in late.items():
        before = early[inches].words
        same = before == one.words
        values.append(Value(
            f"{inches} in: the outcome at {_MILLI * EARLY:g} and at {_MILLI * LATE:g} ms", None,
            f"{one.words} at both" if same else f"{before}, then {one.words}",
        ))  # fmt: skip
        values.append(Value(
            f"{inches} in: largest change of the cross-section", None,
            100.0 * float(logs[inches].metadata["report"]["largest change of the cross-section now"]), "%", digits=2,
        ))  # fmt: skip
    return Item(
        "“t = 0.4 ms”: does the outcome hang on how long one looks?", "figure 5", values,
        remark="The paper does not say from when it counts; we count from the front’s passing the middle of the notch. Where "
        "flaps have opened the cross-section by more than a tenth, the pressure of a gas in a rigid tube, which goes on "
        "loading them, is too large: late times are those of the paper’s coupling, not of a tube.",
    )  # fmt: skip


def _figure(logs: dict[int, Log]) -> Figure:
    curves: list[Curve] = []
    for number, (inches, log) in enumerate(logs.items()):
        times, part = reach_history(log)
        curves.append(Curve(f"{inches} in", _MICRO * (times - ARRIVAL), 100.0 * part, "line", number))
    return Figure(
        "figure-growth", "How far cracks reach around the tube, over time",
        "The part of the circumference over which cracks lie, wherever along the tube; time from the front’s passing the "
        "middle of the notch.",
        Axis("time, µs", -50.0), Axis("part of the circumference, %", *PARTS), curves,
        [Mark("the paper, 1 in: stops at about 3/4", y=75.0)],
    )  # fmt: skip


ENTRY = Entry(
    "outcomes",
    "Results",
    "The outcome by notch",
    "In the paper three notches have three outcomes: a crack that stops, one that severs the tube in the experiment and not in "
    "the computation, and one that severs it in both.",
    compute,
    weight=5.0,
    runs=6,
)
