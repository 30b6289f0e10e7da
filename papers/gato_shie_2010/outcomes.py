"""Figures 2 to 5: the outcome by notch

In the paper three notches have three outcomes: a crack stops; a crack severs the tube in the experiment but not in the
computation; a crack severs it in both.
"""

from pages import Page, show
from tubes import ARRIVAL, DRAWN_OUT, EARLY, FACTOR, HEAD, LATE, PRINTED, REACH, burst_log, outcome, outcome_row, reach_history

# Notch [in] -> the paper's words on computation and experiment, our outcomes, change of the cross-section.
NOTCHES = {
    1: ("straight, at 45°, around; stops at about 3/4 of the circumference", "the same",
        "axial crack, then hoop crack", "8.6e2"),
    2: ("branches around both ways; not parted on the other side", "one crack around all of it: severed",
        "axial crack, then hoop crack", "9.6e2"),
    3: ("straight, then branches around all of it: severed", "the same", "axial crack at both", "1.0e2"),
}  # fmt: skip


def main(page: Page) -> None:
    """Compare the three notches at an early and at the final time."""
    words, rows = [], []
    page.add_heading(f'"t = 0.4 ms": does the outcome depend on the time, {1e3 * EARLY:g} or {1e3 * LATE:g} ms?')
    for inches, (computed, experiment, known, change) in NOTCHES.items():
        printed, early, late = (
            outcome(burst_log(inches, PRINTED)),
            outcome(burst_log(inches), EARLY),
            outcome(burst_log(inches)),
        )
        both = f"{late.word} at both" if early.word == late.word else f"{early.word}, then {late.word}"
        page.add_value(f"{inches} in: outcome", both, found=known)
        grown = 100.0 * float(burst_log(inches).metadata["report"]["largest change of the cross-section now"])
        page.add_value(f"{inches} in: largest change of the cross-section", grown, "%", change)
        words.append([f"{inches} in", computed, experiment, late.word])
        rows += [
            [f"{inches} in", f"{PRINTED:g}, as printed", f"{1e3 * printed.time:.2g} ms", *outcome_row(printed)],
            [f"{inches} in", f"{FACTOR:g}", f"{1e3 * EARLY:g} ms", *outcome_row(early)],
            [f"{inches} in", f"{FACTOR:g}", f"{1e3 * LATE:g} ms", *outcome_row(late)],
        ]
    page.text("""The paper does not state the origin of its time; ours is the passage of the front at the middle of the notch.
        Once flaps have opened a cross-section by more than a tenth, the pressure of the gas in a rigid tube is too large.
        Results at late times are then properties of the paper's coupling, not of a tube.""")
    page.add_table("Axial crack: cracks along the tube over less than 5 % of the circumference. Hoop crack: over more. "
               "Severed: the ends are disconnected.", ("notch", "the paper's computation", "the experiment", "here"),
               words)  # fmt: skip
    page.add_table(f"Runs with the paper's factor end at a plastic strain of {DRAWN_OUT:g}. {REACH}",
               ("notch", "factor", "time", *HEAD), rows)  # fmt: skip
    with page.plot("Reach of the cracks around the tube, over the time since the front passed the notch. Dotted: 3/4, where "
                   "the crack of 1 in stops in the paper.", "time, µs", "of the circumference, %") as axes:  # fmt: skip
        for inches in NOTCHES:
            times, part = reach_history(burst_log(inches))
            axes.plot(1e6 * (times - ARRIVAL), 100.0 * part, label=f"{inches} in")
        axes.axhline(75.0, color="0.4", linestyle=":")
        axes.set_xlim(-50.0)


if __name__ == "__main__":
    show(main)
