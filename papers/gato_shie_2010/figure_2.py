"""Figure 2: the short notch, 1 in

"In the case of the short notch, as in the experiment, the crack first ran straight; nearer to the front of the detonation it
curved and ran at an angle of 45°, and then went on around the tube." It stopped after about 3/4 of the circumference.
"""

import math

import numpy as np

from cracks import compare_our_factor, compare_printed_factor, draw_unrolled_tube, has_turned, is_beyond_notch
from pages import Page, show
from tubes import EARLY, GAUGES, LATE, burst_log, outcome, reach_history

# Largest strain of a gauge, and time without advance after which a crack counts as arrested [s].
LIMIT, STOPPED = 0.05, 5e-5


def main(page: Page) -> None:
    """Run the notch with the paper's factor and with our factor."""
    compare_printed_factor(page, 1, "hoop crack", "1.0", "0.07")
    one = outcome(burst_log(1))
    times, reach = reach_history(burst_log(1))
    stopped = bool((reach[times > times[-1] - STOPPED] == reach[-1]).all())
    statements = [
        ("first", "straight on", is_beyond_notch(one, 1), True),
        ("then", "around the tube", has_turned(one), True),
        ("end", "stops at about 3/4 around", stopped and 0.6 < one.reach < 0.9, False),
    ]
    compare_our_factor(page, 1, statements, ("hoop crack", "6.3", "100", "45", "2", "0.14"))
    for after in (EARLY, LATE):
        draw_unrolled_tube(page, "Figure 2", 1, after)
    times, strains = burst_log(1).series("shell_gauge_strain")
    # Drop the readings of a gauge after a crack has passed it.
    strains = np.where(np.maximum.accumulate(np.abs(strains), axis=0) > LIMIT, np.nan, strains)
    with page.plot("Hoop strain at gauges on the outer surface. Curves end at a strain of 5 %, at which a gauge would fail. "
                   "The paper has no such figure.", "time, µs", "hoop strain, 10⁻³") as axes:  # fmt: skip
        for number, (place, angle) in enumerate(GAUGES):
            label = f"axially {1e3 * place:.0f} mm, around {math.degrees(angle):.0f}°"
            axes.plot(1e6 * times, 1e3 * strains[:, number, 1], label=label)
        axes.set_xlim(700.0)


if __name__ == "__main__":
    show(main)
