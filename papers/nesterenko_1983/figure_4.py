"""Section 3.2 B, figure 4: a tall solitary wave overtakes lower ones

Grains 1 and 2 of 150 move at 10 m/s, grains 18 and 19 at 5 m/s, all to the right. Taller waves are faster.
"""

import numpy as np
from scipy.optimize import linear_sum_assignment

from chains import COUNTED, UNCHANGED, heights_text, run_experiment, wave_counts, waves_at_grain
from pages import Page, show

# Grain -> time window [µs], the paper's order of arrival, our crests [µs].
WINDOWS = {
    50: (200.0, 300.0, "1, 2, 3", "209.8, 251.4, 286.9"),
    85: (400.0, 550.0, "1, 3, 2", "439.3, 482.9, 523.3"),
    145: (800.0, 950.0, "3, 1", "818.2, 845.7"),
}


def main(page: Page) -> None:
    """Compare the number of waves, their order, and their heights."""
    chain = run_experiment("3.2b-overtaking")
    first = waves_at_grain(chain, 50)
    page.add_heading("Number of solitary waves, at grain 50")
    for threshold, number in wave_counts(chain, 50).items():
        page.compare(f"waves {threshold}", "6", number)
    page.add_value("their v_m", heights_text(first, 1.0), "m/s", "4.268, 2.232, 8.43, 4.438, 0.9572, 0.6094")
    page.text(COUNTED)

    page.add_heading("Wave 3 overtakes first wave 2, then wave 1")
    height: dict[int, dict[int, float]] = {}
    for grain, (begin, end, order, known) in WINDOWS.items():
        found = waves_at_grain(chain, grain)
        # Waves keep their numbers from grain 50, identified by their heights.
        unlike = np.abs(np.log([[wave.amplitude / other.amplitude for other in first] for wave in found]))
        numbers = {int(place): int(name) + 1 for place, name in zip(*linear_sum_assignment(unlike), strict=True)}
        own = [(numbers[place], wave) for place, wave in enumerate(found) if place in numbers]
        height[grain] = {number: wave.amplitude for number, wave in own}
        own = own[: len(order.split(", "))]
        page.compare(f"order of arrival at grain {grain}", order, ", ".join(str(number) for number, _ in own))
        inside = all(begin <= 1e6 * wave.time <= end for _, wave in own)
        window = f"{begin:g} to {end:g}" if grain < 145 else f"after {begin:g}"
        page.compare("their crests", window, window if inside else "outside", "µs")
        page.add_value("their crests", ", ".join(f"{1e6 * wave.time:.1f}" for _, wave in own), "µs", known)
    page.text("At grain 145 the paper omits wave 2, which has fallen behind.")

    page.add_heading("Height and form do not change, grain 50 to 145")
    for number, known in ((1, "-1.31"), (3, "0.239")):
        change = 100.0 * (height[145][number] / height[50][number] - 1.0)
        page.compare(f"change of v_m, wave {number}", "unchanged", change, "%", near=0.0, within=UNCHANGED,
                     reading="within 5 %", found=known)  # fmt: skip
    page.text("Overtaking changes the waves slightly, by less than is visible in a figure.")

    for grain, words in ((50, "waves 1, 2 and 3 in the order of their arrival; the third is the tallest and fastest"),
                         (85, "the tallest wave has passed wave 2"), (145, "it has also passed wave 1")):  # fmt: skip
        begin, end, *_ = WINDOWS[grain]
        own = (chain.time >= 1e-6 * begin) & (chain.time <= 1e-6 * end)
        with page.plot(f"Figure 4, grain {grain}: {words}.", "time, µs", "velocity, m/s", (7.0, 2.4)) as axes:
            axes.plot(1e6 * chain.time[own], chain.velocity[own, grain - 1])
            axes.set_ylim(-0.3, 9.2)


if __name__ == "__main__":
    show(main)
