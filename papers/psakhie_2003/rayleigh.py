"""Section 3: the Rayleigh wave

The Rayleigh wave propagates along the free surface. The medium moves on ellipses; the amplitude vanishes within a small depth.
"""

import numpy as np

from granular_env.components.grid.theory import rayleigh_ellipse, rayleigh_speed
from granular_env.components.support.float_arrays import FloatArray
from half_space import EARLY, LATE, LOAD, MATERIAL, S_SPEED, Motion, crest_position, exact_velocity, motion
from pages import Page, show

SPEED = rayleigh_speed(MATERIAL)
LENGTH = SPEED * LOAD
SIDES = {"grid": -1.0, "automata": 1.0}
DEPTHS = np.linspace(0.0, 1.0, 41) * LENGTH
QUICKLY = "half of its energy is gone in half of its length"


def distances_within_wave(time: float = LATE, samples: int = 2001) -> FloatArray:
    """Return distances from the load within the wave: behind its front, over the duration of the load [m]."""
    return np.linspace(SPEED * (time - LOAD), SPEED * time, samples)


def surface_crest(moving: Motion, side: float, time: float = LATE) -> float:
    """Return the distance from the load to the crest of vertical surface velocity, to the right (side 1) or left [m]."""
    x = distances_within_wave(time)
    return crest_position(x, moving.velocity_at(side * x, np.zeros_like(x))[:, 1])


def is_rotating(last: Motion, side: float) -> bool:
    """Return whether the surface velocity rotates by more than half a turn in the retrograde sense."""
    x = distances_within_wave()
    velocity = last.velocity_at(side * x, np.zeros_like(x)) * [side, 1.0]
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    own = speed > 0.3 * speed.max()
    # Along x the velocity rotates in the sense opposite to its rotation in time at a point.
    angle = np.unwrap(np.arctan2(velocity[own, 1], velocity[own, 0]))
    return bool(angle[0] - angle[-1] > np.pi)


def axes_ratio(last: Motion, side: float) -> float:
    """Return the ratio of the vertical to the horizontal axis of the surface ellipse, from the spectra of both components."""
    x = np.linspace(SPEED * (LATE - 1.5 * LOAD), SPEED * (LATE + 0.5 * LOAD), 8004)
    spectrum = np.abs(np.fft.rfft(last.velocity_at(side * x, np.zeros_like(x)) * np.hanning(len(x))[:, None], axis=0))[1:16]
    return float(np.sqrt((spectrum[:, 1] ** 2).sum() / (spectrum[:, 0] ** 2).sum()))


def energies(last: Motion, side: float) -> FloatArray:
    """Return the mean squared velocity within the wave at given depths [m2/s2]."""
    x = distances_within_wave()
    return np.array([(last.velocity_at(side * x, np.full_like(x, -depth)) ** 2).sum(axis=1).mean() for depth in DEPTHS])


def main(page: Page) -> None:
    """Measure speed, ellipse and decay in the grid and in the automata."""
    last = motion("symmetric")
    for part, side, speed_known in (("grid", -1.0, "0.905"), ("automata", 1.0, "0.913")):
        page.add_heading(f"In the {part}")
        places = [surface_crest(motion("symmetric", time), side, time) for time in (EARLY, LATE)]
        speed = (places[1] - places[0]) / (LATE - EARLY) / S_SPEED
        behind = "slightly behind S" if 0.8 < speed < 1.0 else "not"
        page.compare("it runs", "slightly behind S", behind, reading="more than 0.8 of its speed")
        page.add_value("speed of its crest between 40 and 70 µs over that of S", speed, found=speed_known)
        page.compare("polarisation", "elliptical", "elliptical" if is_rotating(last, side) else "not")
        page.add_value("vertical over horizontal axis", axes_ratio(last, side), found="1.47")
        energy = energies(last, side) / energies(last, side)[0]
        below = int(np.argmax(energy < 0.5))
        depth = float(np.interp(0.5, energy[[below, below - 1]], DEPTHS[[below, below - 1]])) / LENGTH
        page.compare("with depth it", "decays quickly", "decays quickly" if depth < 0.5 else "does not", reading=QUICKLY)
        page.add_value("depth at which half its energy is left, over its length", depth, found="0.29")
    page.add_heading("In theory")
    page.add_value("speed over that of S", SPEED / S_SPEED, found="0.9194")
    page.add_value("vertical over horizontal axis, any frequency", rayleigh_ellipse(MATERIAL), found="1.4679")
    page.text(
        f"Kinetic energies of a layer within the length of the wave, {1e3 * LENGTH:.0f} mm, relative to the surface layer."
    )

    with page.plot("Hodograph of the surface velocity as the Rayleigh wave passes; for a single frequency it is an ellipse",
                   "horizontal velocity, mm/s", "vertical velocity, mm/s") as axes:  # fmt: skip
        for style, (part, side) in zip(("-", "--"), SIDES.items(), strict=True):
            velocity = 1e3 * last.velocity_at(side * distances_within_wave(samples=201), np.zeros(201))
            axes.plot(side * velocity[:, 0], velocity[:, 1], style, label=part)
    with page.plot("Kinetic energy within the wave over that at the surface; the remainder at depth is from the nearby S wave.",
                   "depth, in lengths of the wave", "kinetic energy") as axes:  # fmt: skip
        for style, (part, side) in zip(("-", "--"), SIDES.items(), strict=True):
            axes.plot(DEPTHS / LENGTH, energies(last, side) / energies(last, side)[0], style, label=part)
        x, depths = distances_within_wave(samples=61), np.array([0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0])
        squares = [(exact_velocity(x, np.full_like(x, depth * LENGTH)) ** 2).sum(axis=1).mean() for depth in depths]
        axes.plot(depths, squares / energies(last, -1.0)[0], "o", label="exact solution")


if __name__ == "__main__":
    show(main)
