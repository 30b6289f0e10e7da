"""Section 3.4: partition of energy

Ek/Ep is the kinetic energy of all grains over the energy stored in all contacts. For Hertz's law, the virial theorem gives
5/4 for the mean over a long time.
"""

import numpy as np

from chains import CLEAR, FAINT, SPEED, UNCHANGED, run_experiment, run_piston
from granular_env.components.chain import theory
from granular_env.domains.chain import measurement
from granular_env.domains.chain.measurement import History
from pages import Page, show

# The paper's ratio, and its relative deviation.
RATIO, DEVIATION = 1.249, 0.008
SETTLED, END = 3e-5, 1e-3
WINDOWS = (SETTLED, 1e-4, 2e-4, 4e-4)
# Name -> experiment, begin and end of free propagation [s], our ratio, our ratio for the waves alone.
OTHERS = {
    "3.1": ("3.1-two-grains", 1e-4, 5e-4, "1.269", "1.249"),
    "3.2 A": ("3.2a-head-on", 1e-4, 2.6e-4, "1.268", None),
    "3.2 B": ("3.2b-overtaking", 2e-4, 7e-4, "1.270", "1.250"),
}


def energy_ratio(chain: History) -> np.ndarray:
    """Return Ek/Ep in each frame; NaN without stored energy."""
    stored = measurement.potential_energy(chain)
    return np.divide(measurement.kinetic_energy(chain), stored, out=np.full_like(stored, np.nan), where=stored > 0.0)


def deviation(chain: History, begin: float, centre: float) -> float:
    """Return the largest deviation of Ek/Ep from a number, in percent of it, with interpolated maxima."""
    own = chain.window(begin, END)
    ratio = energy_ratio(chain)[own]
    highest = max(crest.height for crest in measurement.crests(chain.time[own], ratio, 1.0))
    return 100.0 * max(highest - centre, centre - float(ratio.min())) / centre


def wave_ratio(chain: History, begin: float, end: float) -> float:
    """Return Ek/Ep of the solitary waves that run to the right, from about twenty times."""
    found = [wave for time in np.linspace(begin, end, 21) for wave in measurement.waves_along(chain, float(time), 0.1 * SPEED)]
    return sum(wave.kinetic_energy for wave in found) / sum(wave.potential_energy for wave in found)


def main(page: Page) -> None:
    """Compare Ek/Ep before a piston, of a solitary wave, and in the other problems."""
    chain = run_piston()
    means = {begin: measurement.energy_ratio(chain, begin, END).mean for begin in WINDOWS}
    page.add_heading("Ek/Ep before the piston, from 30 µs until the front reaches the end")
    read = {"within": DEVIATION * RATIO, "reading": "within the paper's deviation of 0.8 %"}
    page.compare("mean", "1.249", means[SETTLED], **read, found="1.2531")
    page.compare(
        "at 3e-5 s, where it settles", "1.249", measurement.energy_ratio(chain, SETTLED, SETTLED).mean, **read, found="1.368"
    )
    page.add_value(
        "mean without the piston's own energy", measurement.energy_ratio(chain, SETTLED, END, piston=False).mean, found="1.2294"
    )
    page.compare("largest deviation from 1.249", "at most 0.8", deviation(chain, SETTLED, RATIO), "%", most=0.8, found="9.7")
    page.add_value("largest deviation from our own mean", deviation(chain, SETTLED, means[SETTLED]), "%", "9.3")
    later = ", ".join(
        f"{means[begin]:.4f} ± {deviation(chain, begin, means[begin]):.2g} % from {1e6 * begin:g} µs" for begin in WINDOWS[1:]
    )
    page.text(f"""The ratio still oscillates at 30 µs, as the front reaches each grain, and then falls slowly. Its mean
        therefore depends on the window, whose end the paper does not state. Mean and largest deviation in other windows:
        {later}; all exceed 0.8 %. The paper does not state which energies it counts.""")
    velocity = chain.velocity[chain.frame_number(SETTLED)]
    for least in (CLEAR, FAINT):
        moving = int(np.count_nonzero(velocity > least * SPEED))
        page.compare(f"grains faster than {100 * least:.0f} % of v0 at 3e-5 s", "6", moving)

    page.add_heading("Ek/Ep of a solitary wave, and in sections 3.1 and 3.2 while waves run freely")
    wave = theory.lattice_wave(0.0)
    page.compare("mean energies, by the virial theorem", "1.25", wave.kinetic_energy / wave.potential_energy, found="1.2500")
    page.add_value("mean of the ratio", wave.energy_ratio, found="1.2508")
    for name, (experiment, begin, end, known, alone) in OTHERS.items():
        other = run_experiment(experiment)
        page.compare(f"{name}", "similar", measurement.energy_ratio(other, begin, end).mean, near=RATIO,
                     within=0.01 * UNCHANGED * RATIO, reading="within 5 %", found=known)  # fmt: skip
        if alone:
            page.add_value(f"{name}, of the waves alone", wave_ratio(other, begin, end), found=alone)
    page.text("The excess is the kinetic energy of grains that have bounced back and are not in contact.")

    with page.plot(
        "Kinetic over potential energy before the piston. Dotted: the printed mean and its 0.8 %.", "time, µs", "Ek / Ep"
    ) as axes:
        own = (chain.time > 1e-5) & (chain.time <= END)
        axes.plot(1e6 * chain.time[own], energy_ratio(chain)[own])
        axes.set_ylim(1.2, 1.32)
        for part in (1.0 - DEVIATION, 1.0, 1.0 + DEVIATION):
            axes.axhline(RATIO * part, color="0.4", linestyle=":")


if __name__ == "__main__":
    show(main)
