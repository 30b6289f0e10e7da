"""Section 3.1: the same disturbance under precompression

Constant forces at both ends compress the chain before the impact.
"""

from chains import COUNTED, MASS, SPEED, A, cut_before_return, heights_text, run_experiment, wave_counts, waves_at_grain
from granular_env.domains.chain import measurement
from pages import Page, show


def main(page: Page) -> None:
    """Compare two moving grains with no precompression, a weak precompression, and a precompression as strong as the wave."""
    free = run_experiment("3.1-two-grains")
    crest = measurement.overlap_of(free, waves_at_grain(free, 60)[0]).height
    weak, strong = (
        cut_before_return(run_experiment("3.1-two-grains", precompression=A * MASS * (part * crest) ** 1.5), 60)
        for part in (0.01, 1.0)
    )
    page.add_heading("A weak precompression, ξ0 = 0.01 ξm, changes nothing qualitatively (at grain 60)")
    for threshold, number in wave_counts(weak, 60).items():
        page.compare(f"waves {threshold}", "2", number)
    page.add_value("their v_m/v0", heights_text(waves_at_grain(weak, 60)), found="0.8465, 0.4317")
    page.text(f"Without precompression they are {heights_text(waves_at_grain(free, 60))}. {COUNTED}")

    page.add_heading("A precompression ξ0 ~ ξm changes the solution (at grain 60, before reflections from the end)")
    counted, lowest = wave_counts(strong, 60), float(strong.velocity[:, 59].min()) / SPEED
    still = 2 in counted.values() or lowest >= 0.0
    page.compare("two waves with rest behind them", "no longer", "still" if still else "no longer")
    for (threshold, number), found in zip(counted.items(), ("12", "13"), strict=True):
        page.add_value(f"waves {threshold}", number, found=found)
    page.add_value("v_m/v0 of the first 6", heights_text(waves_at_grain(strong, 60)[:6], digits=3),
               found="0.58, 0.0144, 0.0394, 0.0513, 0.0576, 0.0608")  # fmt: skip
    page.add_value("lowest v/v0", lowest, found="-0.0729")
    page.text("An oscillating train follows the first wave, and grains move backwards.")

    with page.plot("Velocity of grain 60 for three precompressions. At a hundredth of the wave's strain both waves remain; "
                   "at an equal strain, an oscillating train replaces them.", "time, µs", "v / v0") as axes:  # fmt: skip
        for label, chain in (("ξ0 = 0", free), ("ξ0 = 0.01 ξm", weak), ("ξ0 = ξm", strong)):
            axes.plot(1e6 * chain.time, chain.velocity[:, 59] / SPEED, label=label)


if __name__ == "__main__":
    show(main)
