"""Section 3.2 A: the waves of a heavy striker, and a wall

A striker of five grain masses hits a chain of 80 grains at 5 m/s that ends at a rigid wall.
"""

import granular_env as ge
from chains import COUNTED, EVERY, MASS, SPEED, STEEL, UNCHANGED, heights_text, run_experiment, wave_counts, waves_at_grain
from granular_env.domains.chain import measurement
from granular_env.domains.chain.measurement import History
from pages import Page, show

EXPECTED = {4: (None, "5", "7"), 5: ("6", "6", "8"), 6: (None, "7", "10")}


def run_long_chain(masses: int) -> History:
    """Return the motion in a chain so long that no reflection reaches grain 60 before all waves have passed."""
    chain = ge.Chain(grains=160, mass={0: masses * MASS}, **STEEL)
    chain.reset(velocity={0: SPEED})
    return measurement.observe(chain, 1e-3, EVERY)


def main(page: Page) -> None:
    """Count the waves of strikers in a chain without a wall, and compare the first wave before and after the wall."""
    long = {masses: run_long_chain(masses) for masses in EXPECTED}
    page.add_heading("Number of waves of a heavy striker, at grain 60 of a long chain")
    for masses, (printed, *known) in EXPECTED.items():
        for (threshold, number), found in zip(wave_counts(long[masses], 60).items(), known, strict=True):
            page.compare(f"{masses} masses, {threshold}", printed, number, found=found)
    page.add_value("v_m/v0 of 5 masses", heights_text(waves_at_grain(long[5], 60)),
               found="1.292, 0.6764, 0.3752, 0.2137, 0.124, 0.07326, 0.0432, 0.03449")  # fmt: skip
    page.text(f"""{COUNTED} "A piston of 5 t" is read as a striker of five grain masses. Ever lower waves follow the sixth, so
        the count depends on the smallest height that counts. Above 5 %, neither 4 nor 6 masses give the paper's six waves;
        above 2 %, none of the three does.""")

    page.add_heading("The wall reflects the waves without change of form, at grain 60")
    wall = run_experiment("3.2-wall-striker")
    before, after = waves_at_grain(wall, 60)[0], waves_at_grain(wall, 60, direction="left")[0]
    change = 100.0 * (after.amplitude / before.amplitude - 1.0)
    page.compare("change of the first wave's v_m", "unchanged", change, "%", near=0.0, within=UNCHANGED, reading="within 5 %",
                 found="-2.85")  # fmt: skip
    page.text(
        "On its way back it meets the following waves; each collision reduces its height slightly, as in a head-on collision."
    )

    with page.plot("Grain 60, struck by five grain masses. With a rigid wall after grain 80 the first waves return before the "
                   "last have passed.", "time, µs", "v / v0") as axes:  # fmt: skip
        axes.plot(1e6 * long[5].time, long[5].velocity[:, 59] / SPEED, "--", label="long chain")
        axes.plot(1e6 * wall.time, wall.velocity[:, 59] / SPEED, label="wall after grain 80")


if __name__ == "__main__":
    show(main)
