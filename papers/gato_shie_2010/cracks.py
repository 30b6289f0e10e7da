"""Rows and pictures of figures 2 to 5: outcomes for a notch with the paper's factor and with our factor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from granular_env.components.support.float_arrays import FloatArray
from pages import Page
from tubes import DRAWN_OUT, FACTOR, INCH, LATE, PRINTED, RADIUS, WALL, Outcome, burst_log, outcome, saturation


def compare_printed_factor(page: Page, inches: int, printed: str, strain: str, end: str) -> None:
    """Compare the outcome for the paper's factor; `strain` and `end` are our known numbers."""
    one = outcome(burst_log(inches, PRINTED))
    page.add_heading(f"The {inches} in notch with the paper's factor {PRINTED:g}")
    page.compare("outcome", printed, one.word, found="whole")
    page.add_value("points that have parted", int(one.parted), found="0")
    page.add_value(
        "location of the largest principal stress", "in the notch" if one.in_notch else "elsewhere", found="in the notch"
    )
    page.add_value("largest plastic strain", one.strain, found=strain)
    page.add_value("end of the run, after the front", 1e3 * one.time, "ms", end)
    page.text(f"""At a plastic strain of 1, the flow stress of the printed material is {saturation():.2f} times the yield
        stress; the largest principal stress was {PRINTED * one.ratio:.1f} times the yield stress. The ligament flows instead,
        beyond the strain at which aluminium tears; the run ends at a plastic strain of {DRAWN_OUT:g}. The paper must have
        used another material or factor. A tube is whole if no neighbouring columns of nodes are separated.""")


def compare_our_factor(
    page: Page, inches: int, statements: Sequence[tuple[str, str, bool, bool]], known: Sequence[str]
) -> Outcome:
    """Compare the paper's statements with our result for our factor.

    Args:
        page: page for the rows.
        inches: length of the notch.
        statements: (subject, the paper's words, whether our result agrees, whether it is known to agree).
        known: our outcome, reach along [in], around [%], at one place [%], pieces, valid until [ms].
    """
    one = outcome(burst_log(inches))
    page.add_heading(f"Cracks from the {inches} in notch with the factor {FACTOR:g}")
    for what, words, ours, expected in statements:
        page.compare(what, words, words if ours else "does not", reading="from the separated columns",
                     found=words if expected else "does not")  # fmt: skip
    page.add_value("outcome", one.word, found=known[0])
    page.add_value("reach of cracks along the tube", one.along / INCH, "in", known[1])
    page.add_value("fraction of the circumference reached by cracks", 100.0 * one.reach, "%", known[2])
    page.add_value("largest cracked fraction at one axial position", 100.0 * one.around, "%", known[3])
    page.add_value("pieces", one.pieces, found=known[4])
    page.add_value("valid until, after the front", one.valid, found=f"{known[5]} ms")
    page.text(f"""Results are for {1e3 * LATE:g} ms after the front passed the notch. Cracks separate columns of nodes on the
        outer surface. They are valid until a cross-section has grown by more than half: with one-way coupling the gas
        flows as in a rigid tube and loads flaps with its full pressure. The piece of tube is 6.3 in long. An angle of 45°
        appears as steps and is not judged. The outcome depends on our factor and on the mesh.""")
    return one


def is_beyond_notch(one: Outcome, inches: int) -> bool:
    """Return whether cracks along the tube reach beyond the notch."""
    return one.along > (inches + 0.05) * INCH


def has_turned(one: Outcome) -> bool:
    """Return whether cracks extend around the tube over more than a tenth of its circumference."""
    return one.reach > 0.1


def crack_lines(one: Outcome) -> tuple[FloatArray, FloatArray]:
    """Return the cracks as interrupted lines, x [m] and angle [rad]: one line across each cut pair."""
    x, arc = one.x[one.pairs], one.arc[one.pairs]
    dx, darc = np.abs(np.diff(x, axis=1)[:, 0]), np.abs(np.diff(arc, axis=1)[:, 0])
    around = dx > 1e-6 * darc
    half = 0.5 * np.where(around, float(np.median(darc[~around])), float(np.median(dx[around])))[one.cut]
    around, middle, angle = around[one.cut], x[one.cut].mean(axis=1), arc[one.cut].mean(axis=1)
    gap = np.full(len(middle), np.nan)
    ends_x = np.stack([middle - half * ~around, middle + half * ~around, gap], axis=1).ravel()
    ends_y = np.stack([angle - half * around, angle + half * around, gap], axis=1).ravel()
    return np.concatenate([ends_x, ends_x]), np.concatenate([ends_y, -ends_y])


def draw_unrolled_tube(page: Page, title: str, inches: int, after: float) -> None:
    """Draw the unrolled tube at a time `after` the front has passed the notch [s]: equivalent stress, cracks, notch."""
    one = outcome(burst_log(inches), after)
    invalid = "" if one.valid == "the end" else f" Not valid: a cross-section had grown by half after {one.valid}."
    caption = (
        f"{title}: notch of {inches} in, {1e3 * after:g} ms after the front, factor {FACTOR:g}. The unrolled outer surface; "
        f"one half is computed, the other is its mirror image. The detonation came from the left.{invalid}"
    )
    outer = RADIUS + WALL
    with page.plot(caption, "x from the middle of the notch, mm", "around the tube, mm", (7.5, 5.2), "upper right") as axes:
        places, angles = np.unique(np.round(one.x, 9)), np.unique(np.round(one.arc, 9))
        stress = 1e-6 * one.stress.reshape(len(places), len(angles)).T
        around = 1e3 * outer * np.concatenate([-angles[:0:-1], angles])
        shade = axes.pcolormesh(1e3 * places, around, np.vstack([stress[:0:-1], stress]), cmap="Blues", shading="gouraud")
        axes.figure.colorbar(shade, ax=axes, label="equivalent stress, MPa", shrink=0.8)
        if one.cut.any():
            x, arc = crack_lines(one)
            axes.plot(1e3 * x, 1e3 * outer * arc, "C1", linewidth=1.5, label="cracks")
        axes.plot([-500.0 * inches * INCH, 500.0 * inches * INCH], [0.0, 0.0], "k--", label="notch")
        axes.set(aspect="equal", xlim=1e3 * places[[0, -1]], ylim=around[[0, -1]])
