"""Section 3, figure 7: a load on the interface

A short vertical load acts on the surface of a half-space, exactly at the interface between a grid (left) and automata
(right). Waves of all types propagate to both sides.
"""

import numpy as np

from half_space import BY_EYE, DEEP, HALF_WIDTH, NOT_SEEN, SLIGHT, Motion, lattice, motion, run_experiment
from pages import Page, show
from pictures import Window, draw_speed, draw_vectors
from rayleigh import surface_crest

CASES = {"square": "symmetric", "hexagonal": "hexagonal-symmetric"}
CAPTION = (
    "70 µs after the start of a 20 µs load. Dashed: theoretical fronts of P, S, head (C) and Rayleigh (R) waves; the load is  "
    "smooth, so the motion starts slightly behind them."
)


def asymmetry(moving: Motion) -> tuple[float, float]:
    """Return the largest differences from the mirror image, below `DEEP` and everywhere, in percent of the largest velocity."""
    x, y = lattice(0.0, HALF_WIDTH, 1e-3)
    right, left = moving.velocity_at(x, y), moving.velocity_at(-x, y) * [-1.0, 1.0]
    gap = 100.0 * np.linalg.norm(right - left, axis=-1) / np.linalg.norm(left, axis=-1).max()
    return float(gap[y < -DEEP].max()), float(gap.max())


def main(page: Page) -> None:
    """Compare the two sides, the two packings, and the balances."""
    moving = {packing: motion(name) for packing, name in CASES.items()}
    unseen = {"near": 0.0, "within": NOT_SEEN, "reading": f"below {NOT_SEEN:g} %"}
    page.add_heading('"Both methods give identical results": the velocities left and right of the load')
    for packing, known in (("square", ("0.62", "9.5")), ("hexagonal", ("1.2", "1.9"))):
        for where, gap, found in zip((f"below {DEEP:g} m", "everywhere"), asymmetry(moving[packing]), known, strict=True):
            page.compare(f"{packing}, {where}", "identical", gap, "%", **unseen, found=found)
    lead = 1e3 * (surface_crest(moving["square"], 1.0) - surface_crest(moving["square"], -1.0))
    page.text(f"""Largest difference between the velocity and its mirror image, relative to the largest velocity. {BY_EYE}
        Waves only a few cells long are slightly slower, by an amount that depends on the lattice. The Rayleigh wave has the
        sharpest peak; in the square packing it is {lead:.2g} mm ahead of that in the grid, a distance proportional to the
        square of the cell size.""")
    page.add_heading('"The influence of the packing ... showed itself only in a slight change of the pulses\' shape"')
    x, y = lattice(0.0, HALF_WIDTH)
    square, hexagonal = (moving[packing].velocity_at(x, y) for packing in CASES)
    gap = 100.0 * np.linalg.norm(square - hexagonal, axis=-1) / np.linalg.norm(square, axis=-1).max()
    slight = {"most": SLIGHT, "reading": f"up to {SLIGHT:g} %"}
    page.compare(f"square - hexagonal, below {DEEP:g} m", "slight change", gap[y < -DEEP].max(), "%", **slight, found="0.81")
    page.compare("square - hexagonal, everywhere", "slight change", gap.max(), "%", **slight, found="10.0")
    ahead = 1e3 * (surface_crest(moving["square"], 1.0) - surface_crest(moving["hexagonal"], 1.0))
    page.text(f"""Near the surface, the Rayleigh wave of the square packing is {ahead:.2g} mm ahead of that of the close
        packing, so the difference is just above {SLIGHT:g} %.""")

    page.add_heading("Momentum and energy, with shear")
    for packing, name in CASES.items():
        log = run_experiment(name)
        missing = {what: float(np.abs(log.series(what)[1]).max()) for what in
                   ("momentum_residual", "impulse", "energy_residual", "input_work")}  # fmt: skip
        page.compare(
            f"{packing}: momentum missing", "none", missing["momentum_residual"] / missing["impulse"], near=0.0, within=1e-10
        )
        energy = 100.0 * missing["energy_residual"] / missing["input_work"]
        page.compare(f"{packing}: energy missing", "none", energy, "%", near=0.0, within=1e-2)
    page.text("""Relative to the impulse and the work of the load; the work is accurate to second order in the step. The paper
        claims complete transfer of momentum without shear.""")

    for packing, which in (
        ("square", "above and below"),
        ("hexagonal", "for the close packing, which is rotated by 90°"),
    ):
        words = f"Figure 7 {which}"
        draw_vectors(page, f"{words}: velocity vectors, scaled as the root of the speed. {CAPTION}", moving[packing], Window())
        draw_speed(page, f"{words}: speed. {CAPTION}", moving[packing], Window())


if __name__ == "__main__":
    show(main)
