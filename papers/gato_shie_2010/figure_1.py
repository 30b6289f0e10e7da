"""Figure 1: a detonation in a rigid tube

The gas alone, C2H4 + 3 O2, is computed in a rigid tube first. Its pressure near the notch then loads the wall.
"""

import numpy as np

from granular_env.components.detonation.theory import TaylorWave
from pages import Page, record, show
from tubes import MIDDLE, front_speed, gas_component, gas_tube

# Filling [Pa] -> printed speed and peak, ours, gap to Taylor's wave and its decay time.
CASES = {
    80e3: (("2300", "2.6"), ("2360", "2.680"), ("5.0", "253")),
    100e3: (None, None, ("4.5", "252")),
    180e3: (("2400", "6.1"), ("2400", "6.215"), ("2.7", "249")),
}


def main(page: Page) -> None:
    """Run the smallest and the largest filling of the experiments."""
    curves = []
    for pressure, (printed, ours, taylor) in CASES.items():
        document = gas_tube(pressure)
        log, tube = record(document), gas_component(document)
        page.add_heading(f"Filled to {pressure / 1e3:.0f} kPa")
        if printed and ours:
            page.compare("speed of the front", printed[0], front_speed(log), "m/s", near=float(printed[0]),
                         within=0.03 * float(printed[0]), reading="within 3 %", found=ours[0])  # fmt: skip
            peak = tube.front.burnt.pressure / 1e6
            page.compare("Chapman-Jouguet pressure", printed[1], peak, "MPa", near=float(printed[1]),
                         within=0.05 * float(printed[1]), reading="within 5 %", found=ours[1])  # fmt: skip
        wave = TaylorWave(tube.front, tube.ahead, tube.gas.gamma)
        times, gauges = log.series("gauge_pressure")
        arrival = MIDDLE / wave.front.speed
        passed = (times < MIDDLE / wave.resting_sound_speed) & (times > arrival + 1.5e-5)
        exact = wave.state(np.full(int(passed.sum()), MIDDLE), times[passed])[2]
        gap = float(np.abs(gauges[passed, -1] - exact).max()) / wave.front.burnt.pressure
        page.add_value("largest difference from Taylor's wave, over the peak", 100.0 * gap, "%", taylor[0])
        page.add_value("decay time", 1e6 * wave.decay_time(MIDDLE), "µs", taylor[1])
        shown = (times > arrival - 5e-5) & (times < arrival + 3e-4)
        exact = wave.state(np.full(int(shown.sum()), MIDDLE), times[shown])[2]
        curves.append((f"{pressure / 1e3:.0f} kPa", 1e6 * times[shown], gauges[shown, -1] / 1e6, exact / 1e6))
    page.text("""We use chemical equilibrium (GRI-Mech 3.0) at 295 K and cells of 3 mm. The paper rounds the numbers of the
        experiments and states no error. Its printed profile has no numbers legible in the scan. Taylor's wave is the exact
        solution for a front that starts at a closed end; we compare with it from about 15 µs behind the front.""")
    with page.plot("Figure 1: pressure at the middle of the notch over time. Dashed: the exact solution for a front that "
                   "starts at full speed at the closed end.", "time, µs", "pressure, MPa") as axes:  # fmt: skip
        for label, times, pressure, exact in curves:
            [line] = axes.plot(times, pressure, label=label)
            axes.plot(times, exact, "--", color=line.get_color(), alpha=0.6)


if __name__ == "__main__":
    show(main)
