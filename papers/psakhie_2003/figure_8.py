"""Section 3, figure 8: a load to the left of the interface

The load acts on the grid, 0.1 m to the left of the interface, so all waves reach the interface at many angles.
"""

import numpy as np

from half_space import BESIDE, BY_EYE, DEEP, NOT_SEEN, SLIGHT, lattice, motion
from pages import Page, show
from pictures import Window, draw_shade, draw_speed, draw_vectors

CASES = {"square": "asymmetric", "hexagonal": "hexagonal-asymmetric"}
WINDOW = Window(left=-0.5, right=0.3, source=-BESIDE)
# Packing -> differences in the grid and in the automata, each below 0.1 m depth and near the surface.
FOUND = {"square": ("0.03", "0.20", "0.25", "5.2"), "hexagonal": ("0.059", "0.28", "0.42", "1.2")}
CAPTION = "70 µs after the start of a 20 µs load, 0.1 m left of the interface. Dashed: theoretical fronts. Square packing."


def main(page: Page) -> None:
    """Compare both packings with a grid throughout, without an interface."""
    alone = motion("grid")
    x, y = lattice(WINDOW.left, WINDOW.right)
    unseen = {"near": 0.0, "within": NOT_SEEN, "reading": f"below {NOT_SEEN:g} %"}
    slight = {"most": SLIGHT, "reading": f"up to {SLIGHT:g} %"}
    for packing, (back, back_surface, on, on_surface) in FOUND.items():
        gap = (
            100.0
            * np.linalg.norm(motion(CASES[packing]).velocity_at(x, y) - alone.velocity_at(x, y), axis=-1)
            / alone.left.largest
        )
        deep, left = y < -DEEP, x < 0.0
        page.add_heading(f"{packing.capitalize()} packing: largest difference from a grid alone, over its largest velocity")
        for where, own, found in ((f"below {DEEP:g} m", deep, back), ("near the surface", ~deep, back_surface)):
            page.compare(
                f"secondary waves: in the grid, {where}",
                "no noticeable ones",
                gap[left & own].max(),
                "%",
                **unseen,
                found=found,
            )
        for where, own, found in ((f"below {DEEP:g} m", deep, on), ("near the surface", ~deep, on_surface)):
            most = gap[~left & own].max()
            page.compare(f"pulses in the automata, {where}", "insignificant difference", most, "%", **slight, found=found)
    page.text(f""""No noticeable secondary (reflected, refracted and conical) waves arose", "only an insignificant difference in
        the shape of the pulses". {BY_EYE} The difference in the automata is not a wave from the interface. It is due to their
        dispersion, which differs from that of the grid, and is largest at the sharp peak of the Rayleigh wave.""")

    draw_vectors(
        page, f"Figure 8, top: velocity vectors, scaled as the root of the speed. {CAPTION}", motion("asymmetric"), WINDOW
    )
    draw_speed(page, f"Figure 8, bottom: speed. {CAPTION}", motion("asymmetric"), WINDOW)
    for packing, name in CASES.items():
        places = WINDOW.samples(160)
        gap = (
            100.0 * np.linalg.norm(motion(name).velocity_at(*places) - alone.velocity_at(*places), axis=-1) / alone.left.largest
        )
        draw_shade(page, f"Effect of the interface, {packing} packing: the motion minus that of a grid throughout. A reflected "
                   "wave would be to the left of the interface.", "difference, %", gap, WINDOW)  # fmt: skip


if __name__ == "__main__":
    show(main)
