"""Two-way coupling

The paper couples one way: the gas is computed first, in a rigid tube, and then its pressure loads the wall. Here the gas also
feels the wall: it gets the cross-section that the wall leaves it, pays for the work on the wall, and leaves through open
cracks. It stays one-dimensional: flaps are no nozzle.
"""

from criterion import compare_outcomes
from pages import Page, show
from tubes import HEAD, INCH, LATE, burst_log, outcome, outcome_row


def main(page: Page) -> None:
    """Run the notch of 1 in with both couplings."""
    logs = {words: burst_log(1, coupling=words) for words in ("one_way", "two_way")}
    one, two = (outcome(log) for log in logs.values())
    page.add_heading('"The gas does not feel the wall": what changes when it does')
    page.add_value("the outcomes", compare_outcomes([one, two]),
               found="axial crack or hoop crack; around 49 to 100 % of the circumference; 1 to 2 pieces")  # fmt: skip
    page.add_value("reach along the tube, over that of one-way coupling", two.along / one.along, found="0.92")
    page.add_value("reach around the tube, over that of one-way coupling", two.reach / one.reach, found="0.49")
    rows, known = [], {"one_way": ("0", "28"), "two_way": ("17", "18")}
    for (words, log), result in zip(logs.items(), (one, two), strict=True):
        leaked = 100.0 * float(log.get("leaked_mass", float(log.times("shell_pieces")[-1]))) / float(log.get("gas_mass", 0.0))
        growth = 1e3 * float(log.series("radial_displacement")[1].max())
        page.add_value(f"{words.replace('_', '-')}: part of the gas that has leaked", leaked, "%", known[words][0])
        page.add_value(f"{words.replace('_', '-')}: largest mean growth of the radius", growth, "mm", known[words][1])
        rows.append([words.replace("_", "-"), *outcome_row(result), f"{leaked:.2g} %", f"{growth:.2g} mm"])
    page.add_table(
        f"Notch of 1 in, {1e3 * LATE:g} ms after the front.",
        ("coupling", *HEAD, "leaked", "largest growth of the radius"),
        rows,
    )
    with page.plot("How far cracks reach along the tube, over time.", "time, µs", "reach along the tube, in") as axes:
        for words, log in logs.items():
            times, reach = log.series("shell_crack_along")
            axes.plot(1e6 * times, reach / INCH, label=words.replace("_", "-"))
        axes.set_xlim(700.0)


if __name__ == "__main__":
    show(main)
