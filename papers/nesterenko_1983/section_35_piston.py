"""Section 3.5 A: random grains before a piston, the last grain and the energies

100 random grains before a piston, with R0 = 0.5, 2 and 3; a smaller R0 means more unequal grains. The paper gives one number
for each, from one sample.
"""

import numpy as np

from chains import SPEED, run_piston
from pages import Page, show
from random_chains import OUTSIDE, UNEVEN, draw_strips, front_energy_ratio, histories, last_velocities

# Name -> R0 -> as printed, and the mean of our samples.
PRINTED = {
    "last": {0.5: ("2.969", "2.66"), 2.0: ("2.366", "2.62"), 3.0: (None, "2.57")},
    "first": {0.5: (None, "2.33"), 2.0: (None, "2.44"), 3.0: (None, "2.46")},
    "ratio": {0.5: ("1.178", "1.275"), 2.0: ("1.236", "1.263"), 3.0: ("1.232", "1.261")},
    "deviation": {0.5: ("9", "10.7"), 2.0: ("7", "7.9"), 3.0: ("6", "8.2")},
    "largest": {0.5: (None, "3.62"), 2.0: (None, "2.89"), 3.0: (None, "2.73")},
    "unevenness": {0.5: (None, "35.4"), 2.0: (None, "29.8"), 3.0: (None, "33.7")},
}


def sample_numbers(smallest: float) -> dict[str, np.ndarray]:
    """Return the numbers of all samples with a smallest radius R0 [mm]."""
    rows = []
    for chain in histories(smallest, 100, "piston"):
        energy = front_energy_ratio(chain, 70, 90)
        near = chain.velocity[chain.frame_number(0.9 * float(chain.time[-1])), 1:11] / SPEED
        rows.append((*last_velocities(chain), energy.mean, 100.0 * energy.deviation,
                     float(chain.velocity[:, 1:-1].max()) / SPEED, 100.0 * float(np.std(near))))  # fmt: skip
    return dict(zip(("first", "last", "ratio", "deviation", "largest", "unevenness"), np.array(rows).T, strict=True))


def main(page: Page) -> None:
    """Compare last grains, energies and largest velocities with many samples."""
    found = {smallest: sample_numbers(smallest) for smallest in (0.5, 2.0, 3.0)}
    equal, chain = float(run_piston(100).velocity[-1, -1]) / SPEED, run_piston()
    even = front_energy_ratio(chain, 70, 90)

    def add_rows(name: str, what: str, unit: str = "") -> None:
        for smallest, (printed, known) in PRINTED[name].items():
            page.compare_samples(f"{what}, R0 = {smallest:g}", printed, found[smallest][name], unit, known)

    page.add_heading("Final velocity of the last of 100 random grains")
    add_rows("last", "v100/v0")
    strips = [page.rows[-3:]]
    add_rows("first", "v100/v0 at first")
    page.text(f"""Mean ± standard deviation [5 %, 95 %] over 100 samples. {OUTSIDE} "At first" means when the grain leaves its
        neighbour; later waves may hit it again.""")
    for smallest, printed, known in ((0.5, "more", "less"), (2.0, "less", "less")):
        side = "more" if found[smallest]["last"].mean() > equal else "less"
        page.compare(f"compared with equal grains, R0 = {smallest:g}", printed, side, found=known)
    page.text(f"""Means over the samples, compared with v100/v0 = {equal:.3f} of equal grains. The paper's faster grain for R0
        = 0.5 is one sample; it occurs in {100.0 * float(np.mean(found[0.5]["last"] > equal)):.0f} % of ours.""")

    page.add_heading("Ek/Ep while the front travels from grain 70 to 90")
    add_rows("ratio", "mean")
    strips.append(page.rows[-3:])
    add_rows("deviation", "largest deviation from the mean", "%")
    for smallest, one in found.items():
        much = "much larger" if one["deviation"].mean() > 200.0 * even.deviation else "not much larger"
        page.compare(f"deviations against equal grains, R0 = {smallest:g}", "much larger", much, reading="more than twice")
        far = float(np.abs(one["ratio"] - 1.25).mean()) > abs(even.mean - 1.25)
        page.compare(f"mean from 1.25, R0 = {smallest:g}", "farther", "farther" if far else "nearer")
    page.text(f"With the piston's energy. Equal grains: {even.mean:.3f}, deviation {100.0 * even.deviation:.1f} %.")

    page.add_heading("Largest velocities, and the motion near the piston")
    add_rows("largest", "largest v/v0")
    for smallest, one in found.items():
        share = float(np.mean(one["largest"] > 2.0))
        page.compare(
            f"above 2 v0, R0 = {smallest:g}", "yes", "yes" if share > 0.5 else "no", reading="in more than half of the samples"
        )
    means = [one["largest"].mean() for one in found.values()]
    falling = "the smaller R0, the more" if means == sorted(means, reverse=True) else "otherwise"
    page.compare("excess over 2 v0", "the smaller R0, the more", falling)
    for smallest, one in found.items():
        uneven = "uneven" if np.percentile(one["unevenness"], 5) > 5.0 else "even"
        page.compare(f"velocities of grains 2 to 11, R0 = {smallest:g}", "uneven", uneven, reading=UNEVEN)
    add_rows("unevenness", "their standard deviation over v0", "%")

    for strip, caption, label in zip(strips, ("Last of 100 random grains before a piston", "Ek/Ep in random chains"),
                                     ("v100 / v0", "Ek / Ep"), strict=True):  # fmt: skip
        with page.plot(f"{caption}; crosses: the paper's samples.", label, "") as axes:
            draw_strips(axes, strip)


if __name__ == "__main__":
    show(main)
