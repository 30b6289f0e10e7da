"""The outcome by initial pressure

In the experiments the detonation tube was filled with 80 to 180 kPa; the speed of the front is the same, and its pressure is
proportional to the filling. The paper does not state the filling for each figure.
"""

from pages import Page, show
from tubes import COARSER, FACTOR, HEAD, LATE, REACH, burst_log, outcome, outcome_row

# Notch [in], filling [kPa] -> our outcome, and circumferential reach [%].
RUNS = {
    (1, 80): ("axial crack", "0"), (1, 130): ("axial crack", "2"), (1, 180): ("axial crack", "88"),
    (2, 80): ("axial crack", "0"), (2, 130): ("hoop crack", "17"), (2, 180): ("hoop crack", "39"),
    (3, 80): ("axial crack", "4"), (3, 130): ("axial crack", "2"), (3, 180): ("hoop crack", "17"),
}  # fmt: skip


def main(page: Page) -> None:
    """Run each notch with each filling, on a coarser mesh."""
    rows, reach = [], {}
    for (inches, pressure), (word, around) in RUNS.items():
        one = outcome(burst_log(inches, nodes=COARSER, pressure=1e3 * pressure))
        page.add_value(f"{inches} in, {pressure} kPa: outcome", one.word, found=word)
        page.add_value(f"{inches} in, {pressure} kPa: reach around", 100.0 * one.reach, "%", around)
        rows.append([f"{inches} in", f"{pressure} kPa", *outcome_row(one)])
        reach[inches, pressure] = 100.0 * one.reach
    page.add_table(
        f"Factor {FACTOR:g}, {COARSER:.0f} nodes, coarser than in the figures. {REACH}", ("notch", "filling", *HEAD), rows
    )
    with page.plot(f"Reach of the cracks around the tube, {1e3 * LATE:g} ms after the front; of three adjacent points "
                   "the middle one is at its true pressure.", "initial pressure, kPa", "circumference, %") as axes:  # fmt: skip
        for number in (1, 2, 3):
            own = {pressure: part for (inches, pressure), part in reach.items() if inches == number}
            axes.plot([pressure + 2.0 * (number - 2) for pressure in own], list(own.values()), "o", label=f"{number} in")


if __name__ == "__main__":
    show(main)
