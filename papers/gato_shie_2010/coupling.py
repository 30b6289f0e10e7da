"""Two-way coupling

The paper uses one-way coupling: the gas is computed first, in a rigid tube, and its pressure then loads the wall. Here the
wall also acts on the gas: the gas has the cross-section inside the wall, loses the energy of its work on the wall, and leaks
through open cracks. The gas remains one-dimensional, so flaps do not act as a nozzle.
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
        page.add_value(f"{words.replace('_', '-')}: fraction of the gas that has leaked", leaked, "%", known[words][0])
        page.add_value(f"{words.replace('_', '-')}: largest increase of the mean radius", growth, "mm", known[words][1])
        rows.append([words.replace("_", "-"), *outcome_row(result), f"{leaked:.2g} %", f"{growth:.2g} mm"])
    page.add_table(
        f"Notch of 1 in, {1e3 * LATE:g} ms after the front.",
        ("coupling", *HEAD, "leaked", "largest increase of the radius"),
        rows,
    )
    with page.plot("Reach of the cracks along the tube over time.", "time, µs", "reach along the tube, in") as axes:
        for words, log in logs.items():
            times, reach = log.series("shell_crack_along")
            axes.plot(1e6 * times, reach / INCH, label=words.replace("_", "-"))
        axes.set_xlim(700.0)


if __name__ == "__main__":
    show(main)
