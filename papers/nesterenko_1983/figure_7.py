"""Section 3.5 A, figure 7: a piston and grains of random radii

200 grains with radii (R0 + RAND) mm, where RAND is uniform between 0 and 1 and R0 = 0.5, are driven by a piston at 5 m/s. The
paper shows one sample. Only the radius of its grain 25 is known, so we compute many samples with this grain.
"""

import numpy as np

from chains import SPEED
from granular_env.domains.chain.measurement import History
from pages import Page, show
from random_chains import FRONT, OUTSIDE, UNEVEN, arrival_time, draw_strips, histories

LOOK = 3.8e-4
# name of the number -> (quantity, as printed, mean of ours)
EXTREMES = {
    "largest": ("largest v, any grain", "11.76", "14.79"),
    "largest of 25": ("largest v, grain 25", "11.76", "11.00"),
    "smallest of 25": ("smallest v, grain 25", "-2.142", "-1.14"),
    "smallest": ("smallest v, any grain", None, "-4.99"),
}


def sample_numbers(chain: History) -> dict[str, float]:
    """Return the numbers of a sample: extremes until the front is at grain 170, and first maxima behind it at 3.8e-4 s."""
    frame = chain.frame_number(LOOK)
    until = chain.velocity[: chain.frame_number(min(arrival_time(chain, 170), LOOK)) + 1]
    # First decrease of the velocity after it exceeds the front's threshold, ignoring the ends.
    falls = (np.diff(chain.velocity, axis=0) < 0.0) & (chain.velocity[:-1] > FRONT)
    first = np.where(falls.any(axis=0), chain.velocity[np.argmax(falls, axis=0), np.arange(chain.grains)], np.nan)
    first[[0, -1]] = np.nan
    own = np.isfinite(first)
    height, rise = first[own] / SPEED, np.diff(first[own])
    return {
        "largest": float(until[:, 1:-1].max()),
        "smallest": float(until[:, 1:-1].min()),
        "largest of 25": float(until[:, 24].max()),
        "smallest of 25": float(until[:, 24].min()),
        "unevenness": 100.0 * float(np.std(chain.velocity[frame, 1:11] / SPEED)),
        "front": float(np.flatnonzero(chain.velocity[frame] > FRONT)[-1] + 1),
        "front over behind": float(height[-1] * SPEED / chain.velocity[frame, 1 : len(height)].max()),
        "falling": 100.0 * float(np.mean(rise < 0.0)),
        "least": float(height.min()),
        "greatest": float(height.max()),
        "lighter and slower": 100.0 * float(np.mean(np.sign(np.diff(chain.mass[own])) == np.sign(rise))),
    }


def main(page: Page) -> None:
    """Compare extremes of the velocity and the paper's statements on the front with many samples."""
    found: list[dict[str, float]] = []
    profiles, curves = [], []
    for chain in histories(0.5, 200, "piston", LOOK, grain_25=7.82465e-4):
        found.append(sample_numbers(chain))
        profiles.append(chain.velocity[-1])
        curves.append(chain.velocity[::5, 24])
    time = np.arange(len(curves[0])) * 1e-6
    draws = {name: np.array([one[name] for one in found]) for name in found[0]}

    page.add_heading("Extreme velocities behind the front, R0 = 0.5, until the front is at grain 170")
    for name, (what, printed, known) in EXTREMES.items():
        page.compare_samples(what, printed, draws[name], "m/s", known)
    strips = page.rows[-4:]
    page.text(f"""Mean ± standard deviation [5 %, 95 %] over {len(found)} samples, each with the paper's radius of grain 25,
        0.782465 mm. This grain was the fastest of the paper's sample. The largest velocity of all grains is above 11.76 m/s
        in every sample, at least {draws["largest"].min():.1f} m/s. {OUTSIDE}""")

    page.add_heading("Statements on the front, at 3.8e-4 s")
    uneven = "uneven" if np.percentile(draws["unevenness"], 5) > 5.0 else "even"
    page.compare("velocities of grains 2 to 11", "uneven", uneven, reading=UNEVEN)
    page.compare_samples("their standard deviation over v0", None, draws["unevenness"], "%", "37.5")
    for what, name, bad, share, reading in (
        ("front lower than the following maxima", "front over behind", draws["front over behind"] >= 1.0, "100", ""),
        ("a first maximum below v0", "least", draws["least"] >= 1.0, "100", ""),
        ("a first maximum substantially above v0", "greatest", draws["greatest"] <= 2.0, "78", "above 2 v0"),
    ):
        part = 100.0 * float(1.0 - bad.mean())
        page.compare(what, "may be", "may be" if part > 0.0 else "is never", reading=reading)
        page.add_value(f"fraction of the samples ({name})", part, "%", share)
    page.compare_samples("smallest first maximum, v/v0", None, draws["least"], found="0.588")
    page.compare_samples("largest first maximum, v/v0", None, draws["greatest"], found="2.146")
    for what, name, known in (("first maximum falls from a grain to the next", "falling", "48.0"),
                              ("a lighter grain is slower", "lighter and slower", "58.2")):  # fmt: skip
        page.compare(what, "may be", "may be" if draws[name].mean() > 0.0 else "is never")
        page.compare_samples("fraction of the grains", None, draws[name], "%", known)
    page.compare_samples("place of the front", None, draws["front"], "grains", "191.1")
    page.text("In the paper the front was at grain 148 when grain 25 was slowest, and at 170 when it was fastest.")

    for caption, label, x, lines in (
        ("Figure 7 a: velocities at 3.8e-4 s, R0 = 0.5.", "grain", np.arange(1, 201), np.array(profiles)),
        ("Figure 7 b: velocity of grain 25, R0 = 0.5.", "time, µs", 1e6 * time, np.array(curves)),
    ):
        with page.plot(caption, label, "velocity, m/s") as axes:
            axes.fill_between(x, *np.percentile(lines, (5, 95), axis=0), alpha=0.3, label="5 to 95 % of the samples")
            axes.plot(x, lines[0], label="seed 1")
    with page.plot("Extremes over many samples; crosses: the paper's sample.", "velocity, m/s", "") as axes:
        draw_strips(axes, strips)


if __name__ == "__main__":
    show(main)
