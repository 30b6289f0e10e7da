"""Figure 2: the notch of one inch."""

from __future__ import annotations

import math

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Axis, Curve, Entry, Figure, Findings

from .cases import EARLY, GAUGES, LATE, run_notched_tube
from .crack_statements import as_printed, crack_outcome, cracks, picture, runs_beyond, turns
from .outcome import reach_history

_INCHES = 1
# A crack has stopped that has reached no farther for so long [s].
_STANDS = 5e-5
# Strain up to which a foil gauge measures.
_GAUGE_LIMIT = 0.05


def compute(context: Context) -> Findings:
    """Run it with the paper's factor and with the page's."""
    one = crack_outcome(context, _INCHES)
    times, reach = reach_history(run_notched_tube(context, _INCHES, context.constants["factor"]))
    stands = bool((reach[times > times[-1] - _STANDS] == reach[-1]).all())
    statements = [
        ("first", "straight on", runs_beyond(one, _INCHES)),
        ("then", "around the tube", turns(one)),
        ("end", "stops at about 3/4 around", stands and 0.6 < one.reach < 0.9),
    ]
    return Findings(
        [as_printed(context, _INCHES, "hoop crack"), cracks(context, _INCHES, "figure 2", statements)],
        [*_pictures(context), _strains(context)],
    )


def _pictures(context: Context) -> list[Figure]:
    return [
        picture(context, _INCHES, name, "Figure 2: notch of 1 in", after)
        for name, after in (("figure-2-early", EARLY), ("figure-2", LATE))
    ]


def _strains(context: Context) -> Figure:
    """Return the hoop strain at the gauges over time."""
    times, strains = run_notched_tube(context, _INCHES, context.constants["factor"]).series("shell_gauge_strain")
    # A gauge that a crack has passed tells nothing of the wall any more: its strain is that of a gap.
    strains = np.where(np.maximum.accumulate(np.abs(strains), axis=0) > _GAUGE_LIMIT, np.nan, strains)
    curves = [
        Curve(f"{1e3 * place:.0f} mm, {math.degrees(angle):.0f}°", 1e6 * times, 1e3 * strains[:, number, 1], "line", number)
        for number, (place, angle) in enumerate(GAUGES)
    ]
    return Figure(
        "figure-2-strain", "Hoop strain at gauges, notch of 1 in",
        "On the outer surface; places from the middle of the notch along the tube, angles from it around the tube, on the "
        "far side for 180°. A curve ends at a strain of "
        f"{100.0 * _GAUGE_LIMIT:g} %, where a gauge would fail, or a crack has passed it. The paper has no such figure; the "
        "experiments had gauges.",
        Axis("time, µs", 700.0), Axis("hoop strain, 1e-3"), curves,
    )  # fmt: skip


ENTRY = Entry(
    "figure-2",
    "Results",
    "Figure 2: the short notch, 1 in",
    "“In the case of the short notch, as in the experiment, the crack first ran straight; nearer to the front of the "
    "detonation it "
    "curved and ran at an angle of 45°, and then went on around the tube.” It stopped after about 3/4 of the circumference.",
    compute,
    weight=60.0,
    runs=6,
)
