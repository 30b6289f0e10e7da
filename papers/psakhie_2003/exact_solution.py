"""Beyond the paper: comparison with the exact solution

A line load on a half-space has an exact solution (Cagniard and de Hoop), which the paper does not use. Grid and automata
converge to it.
"""

import numpy as np

from half_space import exact_velocity, motion
from pages import Page, show

# Angle of a line from the vertical [degrees] -> differences in the grid, the square and the hexagonal packing [%].
LINES = {0.0: ("1.6", "1.6", "1.3"), 45.0: ("3.0", "2.4", "1.7"), 80.0: ("1.4", "1.8", "2.2")}
RADII = np.linspace(0.03, 0.39, 181)


def main(page: Page) -> None:
    """Compare velocities along lines from the load in the grid and in the automata of both packings."""
    square, hexagonal = motion("symmetric"), motion("hexagonal-symmetric")
    for angle, known in LINES.items():
        sine, cosine = np.sin(np.radians(angle)), np.cos(np.radians(angle))
        exact = exact_velocity(sine * RADII, cosine * RADII)
        found = {}
        for (name, moving, side), digits in zip(
            (("grid", square, -1.0), ("square packing", square, 1.0), ("hexagonal packing", hexagonal, 1.0)), known, strict=True
        ):
            # Points on the interface, x = 0, belong to the automata.
            found[name] = moving.velocity_at(side * np.maximum(sine * RADII, 1e-12), -cosine * RADII) * [side, 1.0]
            percent = 100.0 * float(np.sqrt(((found[name] - exact) ** 2).sum() / (exact**2).sum()))
            page.add_value(f"{name}, at {angle:g}° from the vertical", percent, "%", digits)
        if angle > 0.0:
            with page.plot(f"Velocity along a line at {angle:g}° from the vertical, 70 µs; below: across it, shifted.",
                           "distance from the load, m", "velocity, mm/s") as axes:  # fmt: skip
                for number, direction in enumerate(([sine, -cosine], [cosine, sine])):
                    shift = -number * 1.2e3 * np.abs(exact).max()
                    axes.plot(RADII, 1e3 * exact @ direction + shift, color="0.6", label=None if number else "exact")
                    axes.plot(
                        RADII[::3], 1e3 * (found["grid"] @ direction)[::3] + shift, "C0.", label=None if number else "grid"
                    )
                    axes.plot(
                        RADII, 1e3 * found["square packing"] @ direction + shift, "C1--", label=None if number else "automata"
                    )
    page.text("""L2 difference of the velocity along lines from the load, 30 to 390 mm, at 70 µs. Cells of twice the size
        increase it by a factor of three and a half to four.""")


if __name__ == "__main__":
    show(main)
