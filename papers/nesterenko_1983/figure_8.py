"""Section 3.5 B, figure 8: a disturbance among random grains

The first two grains move at 5 m/s as in section 3.1, now in a chain of random grains with free ends. The first wave decays
although nothing dissipates.
"""

import numpy as np

from chains import CLEAR, FAINT, SPEED, run_experiment, waves_at_grain
from pages import Page, show
from random_chains import OUTSIDE, draw_strips, duration, histories, last_velocities, random_chain

# (R0 in mm, grains) -> as printed, and the mean of our samples.
CASES = {(0.5, 100): ("0.692", "0.40"), (2.0, 100): ("0.507", "0.46"), (3.0, 50): ("1.003", "0.93")}
MANY = range(1, 401)


def final_velocities(smallest: float) -> np.ndarray:
    """Return the last grain's final velocity over v0 in many samples of 100 grains."""
    found = []
    for seed in MANY:
        chain = random_chain(smallest, 100, seed, "free")
        chain.step(duration(smallest, 100, "free"))
        found.append(chain.get("velocity")[-1] / SPEED)
    return np.array(found)


def main(page: Page) -> None:
    """Compare the last grain's velocity and the number of waves with many samples."""
    page.add_heading("Final velocity of the last random grain, v_N/v0")
    moving = {}
    for (smallest, grains), (printed, known) in CASES.items():
        moving[smallest] = list(histories(smallest, grains, "free"))
        last = [last_velocities(chain)[1] for chain in moving[smallest]]
        page.compare_samples(f"R0 = {smallest:g}, N = {grains}", printed, last, found=known)
    strips = page.rows
    equal = float(run_experiment("3.1-two-grains").velocity[-1, -1]) / SPEED
    page.text(f"Mean ± standard deviation [5 %, 95 %] over 100 samples. {OUTSIDE} For equal grains it is {equal:.4f} v0.")

    page.add_heading("R0 = 0.5 decays less than R0 = 2, over 400 samples each")
    small, large = final_velocities(0.5), final_velocities(2.0)
    errors = [float(one.std(ddof=1)) / len(one) ** 0.5 for one in (small, large)]
    page.compare("larger mean v100/v0", "R0 = 0.5", "R0 = 0.5" if small.mean() > large.mean() else "R0 = 2", found="R0 = 2")
    for name, one, error, known in (("0.5", small, errors[0], "0.401 ± 0.008"), ("2", large, errors[1], "0.455 ± 0.005")):
        page.add_value(f"mean and its standard error, R0 = {name}", f"{one.mean():.3f} ± {error:.3f}", found=known)
    page.text(f"""The means are {abs(small.mean() - large.mean()) / float(np.hypot(*errors)):.1f} standard errors apart. The
        paper's statement rests on one sample of each: {100.0 * np.greater.outer(small, large).mean():.0f} % of the pairs of
        single samples agree with it.""")

    page.add_heading("The disturbance does not break into two solitary waves, R0 = 2: maxima at grain 61")
    for above, known in ((CLEAR, "22.9"), (FAINT, "23.5")):
        counted = [len(waves_at_grain(chain, 61, above)) for chain in moving[2.0]]
        words = "more than 2" if np.percentile(counted, 5) > 2.0 else "2"
        page.compare(f"above {100 * above:.0f} % of the tallest", "more than 2", words, reading="in 95 % of the samples")
        page.compare_samples("how many", None, counted, found=known)

    with page.plot("Figure 8: velocities of grains 61 and 96, R0 = 2, seed 1. The first maximum resembles a solitary wave "
                   "but loses height, because its energy is scattered.", "time, µs", "velocity, m/s") as axes:  # fmt: skip
        for grain in (61, 96):
            axes.plot(1e6 * moving[2.0][0].time, moving[2.0][0].velocity[:, grain - 1], label=f"grain {grain}")
    with page.plot("The last random grain of a free chain; crosses: the paper's samples.", "v_N / v0", "") as axes:
        draw_strips(axes, strips)


if __name__ == "__main__":
    show(main)
