"""The criterion of fracture, and what the outcome depends on

Bonds between particles break where the largest principal stress exceeds a multiple of the yield stress; the paper's multiple
is 3.
"""

import math
from collections.abc import Sequence

from pages import Page, show
from tubes import COARSER, FACTOR, HEAD, HOURGLASS, NODES, PRINTED, REACH, Outcome, burst_log, outcome, outcome_row, saturation

# Factor, stabilisation, nodes.
RUNS = (
    (PRINTED, HOURGLASS, NODES), (2.0, HOURGLASS, NODES), (FACTOR, HOURGLASS, NODES), (FACTOR, 0.02, NODES),
    (FACTOR, 0.1, NODES), (FACTOR, HOURGLASS, COARSER),
)  # fmt: skip


def compare_outcomes(some: Sequence[Outcome]) -> str:
    """Return the outcomes of several runs as text, with ranges of differing values."""
    words = " or ".join(sorted({one.word for one in some}))
    reach, pieces = [100.0 * one.reach for one in some], [one.pieces for one in some]
    around = f"around {min(reach):.0f} to {max(reach):.0f} % of the circumference"
    return f"{words}; {around}; {min(pieces)} to {max(pieces)} pieces"


def spread(values: Sequence[float]) -> float:
    """Return the ratio of the largest to the smallest value, or 1 if all are 0."""
    return max(values) / min(values) if min(values) > 0.0 else 1.0 if max(values) == 0.0 else math.inf


def main(page: Page) -> None:
    """Vary factor, stabilisation and mesh for the 1 in notch."""
    found = {run: outcome(burst_log(1, *run[:1], nodes=run[2], hourglass=run[1])) for run in RUNS}
    printed = found[RUNS[0]]
    page.add_heading('"If the maximum of the principal tensile stress exceeds σ0 three times, the bonds ... are broken"')
    page.compare("3 σ0", "is exceeded", "is exceeded" if printed.parted else "is never exceeded", found="is never exceeded")
    page.add_value("separated points", int(printed.parted), found="0")
    page.add_value("largest principal stress at a point, over 3 σ0", printed.ratio, found="0.65")
    page.add_value("its location", "in the notch" if printed.in_notch else "elsewhere", found="in the notch")
    page.add_value("the flow law at a plastic strain of 1, over σ0", saturation(), found="1.62")
    page.add_value("largest plastic strain", printed.strain, found="1.0")
    page.text(f"""Notch of 1 in, σ0 = 275 MPa (the paper prints GPa), over all points and ticks. With the printed material, a
        ligament with two free surfaces carries 2/√3 times the {saturation():.2f} σ0 of the flow law, and slightly more at the
        strain rates of a detonation. It flows instead of breaking, beyond the strain at which aluminium tears.""")

    page.add_heading("Does the outcome depend on numerical parameters?")
    alike = {"stabilisation": RUNS[2:5], "mesh": (RUNS[2], RUNS[5])}
    known = {
        "stabilisation": ("hoop crack; around 100 to 100 % of the circumference; 1 to 2 pieces", "1.0", "1.0"),
        "mesh": ("axial crack or hoop crack; around 88 to 100 % of the circumference; 2 to 2 pieces", "1.0", "1.1"),
    }
    for varied, runs in alike.items():
        some = [found[run] for run in runs]
        page.add_value(f"{varied}: the outcome", compare_outcomes(some), found=known[varied][0])
        page.add_value(
            f"{varied}: reach along, largest over smallest", spread([one.along for one in some]), found=known[varied][1]
        )
        page.add_value(
            f"{varied}: reach around, largest over smallest", spread([one.reach for one in some]), found=known[varied][2]
        )
    rows = [
        [f"{run[0]:g}", f"{run[1]:g}", f"{run[2]:.0f}", *outcome_row(one), f"{one.parted:.0f}"] for run, one in found.items()
    ]
    page.add_table(f"""Notch of 1 in. The stabilisation resists displacements that alternate between columns with a fraction
        of the material's stiffness; the paper mentions none. The criterion contains no length, so the width of a crack
        depends on the mesh. {REACH}""", ("factor", "stabilisation", "nodes", *HEAD, "separated points"), rows)  # fmt: skip
    with page.plot("Reach of the cracks around the tube. Labels: factor, stabilisation, nodes. Dotted: 3/4, as in the paper.",
                   "fraction of the circumference, %", "") as axes:  # fmt: skip
        axes.plot([100.0 * one.reach for one in found.values()], range(len(found), 0, -1), "o")
        axes.set_yticks(range(len(found), 0, -1), [f"{run[0]:g}, {run[1]:g}, {run[2]:.0f}" for run in found])
        axes.axvline(75.0, color="0.4", linestyle=":")


if __name__ == "__main__":
    show(main)
