"""Section 3.3, figure 5: a triangular push

A force on the first grain of 100 falls from 2e6 m/s² times its mass to zero in 100 µs, or in 10 µs.
"""

from chains import COUNTED, heights_text, run_experiment, wave_counts, waves_at_grain
from pages import Page, show


def main(page: Page) -> None:
    """Count the waves of a long and of a short force pulse."""
    long, short = run_experiment("3.3-triangle-100us"), run_experiment("3.3-triangle-10us")
    page.add_heading("Number of waves from a pulse of 100 µs")
    for grain, (clear, faint), found in (
        (35, ("7", "7"), "16.4, 13, 10.1, 7.48, 5.06, 2.8, 0.824"),
        (60, ("7", "8"), "16.4, 13, 10.1, 7.56, 5.19, 3.03, 1.19, 0.485"),
    ):
        for (threshold, number), known in zip(wave_counts(long, grain).items(), (clear, faint), strict=True):
            page.compare(f"grain {grain}, {threshold}", "7", number, found=known)
        page.add_value("their v_m", heights_text(waves_at_grain(long, grain), 1.0, 3), "m/s", found)
    page.text(f"""{COUNTED} Between grains 35 and 60 an eighth, low wave separates from the seventh. In the paper's figure its
        height would be a few percent of the first wave's.""")
    page.add_heading("Number of waves from a pulse of 10 µs, at grain 35")
    for threshold, number in wave_counts(short, 35).items():
        page.compare(f"waves {threshold}", "1", number)
    page.add_value("its v_m", waves_at_grain(short, 35)[0].amplitude, "m/s", "6.4296")

    for chain, caption in (
        (
            long,
            "Figure 5: a triangular force pulse of 100 µs splits into solitary waves, which separate between the two grains.",
        ),
        (short, "The same pulse shape for 10 µs: one solitary wave."),
    ):
        with page.plot(caption, "time, µs", "velocity, m/s") as axes:
            for grain in (35, 60):
                axes.plot(1e6 * chain.time, chain.velocity[:, grain - 1], label=f"grain {grain}")


if __name__ == "__main__":
    show(main)
