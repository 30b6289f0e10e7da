"""Section 2.3: the two schemes for nodes of the interface, and the factor that is missing in (15) and (18)."""

from __future__ import annotations

from typing import Any

import numpy as np

from granular_env.atlas.context import Context
from granular_env.atlas.model import Entry, Findings, Item
from granular_env.atlas.verdicts import Value

from .cases import MATERIAL, P_SPEED
from .noisy_block import ACROSS, ALONG, SIZE, noisy_block
from .thresholds import EXACT_SUM, complete

_STEP, _TICKS = 1e-7, 400
# Neighbours 1 to 4 of a node in unit cells: below, right, above, left. Cell I lies between 2 and 3, II between 3 and 4, ...
_NEIGHBOURS = ((0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0))
_STRAIN = 1e-10


def compute(context: Context) -> Findings:
    """Run both ways from one noisy start, and put a homogeneous stress into (18)."""
    return Findings([_same(context), _factor(context)])


def _same(context: Context) -> Item:
    logs = [context.run(noisy_block(context, 1, scheme, 1, _STEP, _TICKS)) for scheme in ("force", "momentum")]
    found = [np.concatenate([log.series(f"{part}_velocity")[1][-1] for part in ("grid", "automata")]) for log in logs]
    gap = np.abs(found[0] - found[1]).max() / np.abs(found[0]).max()
    return Item(
        "“Two approaches are possible”: momenta of node and automaton are added, or the forces of both are", "section 2.3",
        [complete("difference of the velocities", float(gap), "both ensure continuity")],
        remark=f"After {_TICKS} steps of a noisy motion, over the largest velocity. They are the same algebra: m V = m_a V_a + "
        f"m_c V_c after each part has been kicked by its own force is one kick by the sum. {EXACT_SUM} In an experiment: "
        "scheme = momentum, and scheme = force.",
    )  # fmt: skip


def contour(stress: dict[str, float]) -> float:
    """Return the vertical sum of (11) and (15), of sigma_yy in the cells I to IV about a node, in unit cells."""
    (x1, _), (x2, _), (x3, _), (x4, _) = _NEIGHBOURS
    sides = {"I": x2 - x3, "II": x3 - x4, "III": x4 - x1, "IV": x1 - x2}
    return sum(stress[cell] * sides[cell] for cell in stress)


def _factor(context: Context) -> Item:
    # The stress grows by 1 over the side of a cell: it accelerates unit masses by 1.
    mass = contour({"I": 0.5, "II": 0.5, "III": -0.5, "IV": -0.5})
    below = contour({"III": 1.0, "IV": 1.0})
    exact = {"paper": 0.0, "tolerance": 1e-12, "source": "an identity"}
    return Item(
        "(18): “components of the vector of the force that acts from the side of the automata”", "section 2.3, (15) to (18)",
        [
            Value("mass that these sums move, over φ", "2", mass, paper=2.0, tolerance=1e-12, source="(15)"),
            Value("force on an interface node under homogeneous stress: with F′", "none", abs(below + 1.0), "σΔ", **exact),
            Value("the same with 2 F′", None, abs(below + 2.0), "σΔ", digits=2),
            Value("the same in our interface", None, _left_over(context), "σΔ", resolution=1e-10, digits=2),
        ],
        remark="σ is the stress, Δ the side of a cell. Here the paper’s sums over the cells are evaluated; ours comes from a "
        "strained block.",
        reason="The sums of (15) to (18) lack the factor ½ of (11), so that the mass on their left is 2φ, twice that of the "
        "node. The force of the automata enters them by itself and would have to be doubled: with F′ as printed a body under "
        "homogeneous stress does not stay at rest. That is a matter of writing, for the paper’s figures show no such motion.",
    )  # fmt: skip


def _left_over(context: Context) -> float:
    """Return the largest force on nodes of the interface away from its ends, in a homogeneous strain."""
    found = noisy_block(context, 1, "force", 1, _STEP, 1)
    nodes = np.stack(np.meshgrid(np.arange(ALONG + 1) * SIZE, np.arange(ACROSS + 1) * SIZE), axis=-1).reshape(-1, 2)
    automata = nodes + [ALONG * SIZE, 0.0]
    found["start"] = {
        f"{part}_displacement": np.stack([_STRAIN * places[:, 0], 0.0 * places[:, 0]], axis=1).tolist()
        for part, places in (("grid", nodes), ("automata", automata))
    }
    found["record"] = {"every": _STEP, "variables": ["kinetic_energy"]}
    block: Any = context.state(found)
    forces = block.forces_on_nodes()[block.interface.nodes[2:-2]]
    stress = MATERIAL.density * P_SPEED**2 * _STRAIN
    return float(np.abs(forces).max() / (stress * SIZE))


ENTRY = Entry(
    "2.3-two-ways",
    "2.3",
    "Two ways to move the nodes of the interface",
    "A node of the interface is also an automaton. Either each part moves it by its own forces and the momenta are added, or "
    "the forces of both are added first.",
    compute,
    weight=1.5,
    runs=3,
)
