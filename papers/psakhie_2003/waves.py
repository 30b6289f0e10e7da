"""Section 3: the waves of a load on the surface

A load on the surface makes longitudinal (P) and transverse (S) waves, conical or head waves (C) that join them along the
surface, and the Rayleigh wave (R). The paper describes each wave in words; we use the run of figure 7 with the square packing.
"""

import math

import numpy as np

from granular_env.components.support.float_arrays import FloatArray
from half_space import EARLY, LATE, LOAD, P_SPEED, S_SPEED, Motion, crest_position, exact_velocity, motion
from pages import Page, show
from pictures import Window, draw_shade, draw_vectors

SIDES = {"grid": -1.0, "automata": 1.0}
SINE = S_SPEED / P_SPEED
ROOT = math.sqrt(0.5)


def distances_within_wave(speed: float, time: float, samples: int = 4001) -> FloatArray:
    """Return distances from the load within a wave: behind its front, over the duration of the load [m]."""
    return np.linspace(speed * (time - LOAD), speed * time, samples)


def ray_velocities(moving: Motion, r: FloatArray, side: float) -> FloatArray:
    """Return velocities along and across a ray at 45°, to the right (side 1) or left, shape (samples, 2)."""
    velocity = moving.velocity_at(side * ROOT * r, -ROOT * r) * [side, 1.0]
    return np.stack([velocity @ [ROOT, -ROOT], velocity @ [ROOT, ROOT]], axis=1)


def head_wave(last: Motion, side: float) -> tuple[float, float]:
    """Return the angle between the head wave's normal and the depth [degrees], and where its crest meets the surface [m]."""
    depths, found = np.linspace(0.01, 0.05, 17), []
    for depth in depths:
        front = (S_SPEED * LATE - depth * math.sqrt(1.0 - SINE * SINE)) / SINE
        x = np.linspace(front - 0.6 * P_SPEED * LOAD, front, 4001)
        # The first half of the wave rotates the medium towards the direction of travel.
        found.append(crest_position(x, np.minimum(side * last.spin(side * x, np.full_like(x, -depth)), 0.0)))
    slope, start = np.polyfit(depths, found, 1)
    return math.degrees(math.atan2(1.0, -slope)), float(start)


def vortices(last: Motion, side: float) -> list[str]:
    """Return points between head wave and S around which the velocity turns once in the sense of its rotation."""
    x, y = np.arange(0.12, 0.26, 1e-3), np.arange(-0.16, -0.03, 1e-3)
    velocity = last.velocity_at(*np.meshgrid(side * x, y))
    angle = np.arctan2(velocity[..., 1], side * velocity[..., 0])
    corners = [angle[:-1, :-1], angle[:-1, 1:], angle[1:, 1:], angle[1:, :-1]]
    turns = sum((b - a + math.pi) % (2.0 * math.pi) - math.pi for a, b in zip(corners, corners[1:] + corners[:1], strict=True))
    found = []
    for row, column in np.argwhere(turns > math.pi):
        px, py = x[column] + 5e-4, y[row] + 5e-4
        ahead_of_s = math.hypot(px, py) > S_SPEED * (LATE - 0.5 * LOAD)
        if ahead_of_s and SINE * px - math.sqrt(1.0 - SINE**2) * py < S_SPEED * LATE:
            found.append(f"({side * px:.3f} m, {py:.3f} m)")
    return found


def main(page: Page) -> None:
    """Measure speeds and directions of P and S, the head wave, and the vortex."""
    early, last = motion("symmetric", EARLY), motion("symmetric")
    page.add_heading(
        "P and S propagate with speeds that follow from the elastic constants: their crests, 40 to 70 µs, on a ray at 45°"
    )
    for number, (name, formula, speed, known) in enumerate((
        ("P", "√((K + 4μ/3)/ρ)", P_SPEED, ("5202", "5196", "5202")), ("S", "√(μ/ρ)", S_SPEED, ("3016", "3019", "3020")),
    )):  # fmt: skip
        for (part, side), found in zip(SIDES.items(), known[:2], strict=True):
            places = [crest_position(r, ray_velocities(moving, r, side)[:, number]) for moving, r in
                      ((early, distances_within_wave(speed, EARLY)), (last, distances_within_wave(speed, LATE)))]  # fmt: skip
            ours = (places[1] - places[0]) / (LATE - EARLY)
            page.compare(f"{name} in the {part}", f"{formula} = {speed:.0f} m/s", ours, "m/s", near=speed, within=0.02 * speed,
                         reading="within 2 %", found=found)  # fmt: skip
        places = []
        for time in (EARLY, LATE):
            r = distances_within_wave(speed, time, 121)
            places.append(crest_position(r, exact_velocity(ROOT * r, ROOT * r, time) @ ([ROOT, -ROOT], [ROOT, ROOT])[number]))
        page.add_value(f"{name} in the exact solution", (places[1] - places[0]) / (LATE - EARLY), "m/s", known[2])
    page.text("""The crest of a cylindrical wave changes its shape near the source and is slightly faster than its front, also
        in the exact solution.""")

    page.add_heading("The motion is along the ray in P and across it in S: fraction of the kinetic energy in this direction")
    for part, side in SIDES.items():
        for number, (name, speed, words, found) in enumerate(
            (("P", P_SPEED, "along", "96.5"), ("S", S_SPEED, "across", "99.4"))
        ):
            velocity = ray_velocities(last, distances_within_wave(speed, LATE), side)
            share = 100.0 * float((velocity[:, number] ** 2).sum() / (velocity**2).sum())
            page.compare(
                f"{name} in the {part}", words, share, "%", near=100.0, within=10.0, reading="90 % of the energy", found=found
            )

    page.add_heading("The conical wave's front extends from P at the surface along the tangent to the front of S")
    predicted = math.degrees(math.asin(SINE))
    for (part, side), found in zip(SIDES.items(), ("35.6", "35.5"), strict=True):
        angle, start = head_wave(last, side)
        page.compare(f"angle of its normal in the {part}", f"tangent to S: {predicted:.1f}°", angle, "°", near=predicted,
                     within=2.0, reading="within 2°", found=found)  # fmt: skip
        at_exit = "at P's exit" if 0.0 < P_SPEED * LATE - start < P_SPEED * LOAD else "elsewhere"
        page.compare(f"where it meets the surface, {part}", "at P's exit", at_exit)
    page.add_heading("A vortex motion of particles between the fronts of the conical and the transverse waves")
    for part, side in SIDES.items():
        page.compare(f"in the {part}", "vortex", "vortex" if vortices(last, side) else "none")
    places = "; ".join(place for side in SIDES.values() for place in vortices(last, side))
    page.text(
        f"Points at rest around which the velocity turns once, ahead of the middle of S and behind the front of C: {places}."
    )

    draw_shade(page, "Rate of rotation: P waves do not rotate the medium, so the head wave (C) is visible."
              , "rate of rotation, 1/s", last.spin(*Window().samples(160)), Window(), signed=True)  # fmt: skip
    draw_vectors(page, "Figure 7 enlarged, in the automata: between C and S the velocity turns about points at rest.",
                 last, Window(0.08, 0.38, 0.0, -0.16))  # fmt: skip


if __name__ == "__main__":
    show(main)
