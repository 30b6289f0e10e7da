"""The constant-volume burn that the paper names, taken at its word: its detonation is too fast on any mesh."""

from __future__ import annotations

from granular_env.atlas.context import Context
from granular_env.atlas.model import Entry, Findings, Item
from granular_env.atlas.verdicts import Value

from .rigid_tube import front_ratio, gas_tube

_CELLS = (380, 760)
# "Correct": as we read it, within so much of the speed of Chapman and Jouguet.
_CORRECT = 0.01
# The component itself states what the burn that conserves energy may be off.
_LAWS = (("constant_volume", "pressure is overwritten"), ("pressure_burn", "energy is conserved"))


def compute(context: Context) -> Findings:
    """Run both burns on two meshes."""
    values: list[Value] = []
    for law, words in _LAWS:
        for cells in _CELLS:
            ratio = front_ratio(context.run(gas_tube(1e5, cells=cells, length=1.52, reaction=law)))
            values.append(Value(
                f"{words}, cells of {1520 / cells:.0f} mm", "correct", ratio, paper=1.0,
                loose=_CORRECT, digits=3,
            ))  # fmt: skip
    return Findings([
        Item(
            "The constant-volume burn “guarantees a correct prediction of the speed of propagation and of the state of "
            "chemical "
            "equilibrium at all resolutions of the mesh”", "section Results", values,
            remark="Speed of the front, over that of Chapman and Jouguet, in a closed tube of 1.52 m, 100 kPa; within "
            f"{100 * _CORRECT:g} % is our reading of correct.",
            reason="The recipe writes the pressure over that of the flow, which does not conserve energy. The other entries of "
            "this page use a burn that starts where the pressure has risen, and conserves energy: the last two rows.",
        )
    ])  # fmt: skip


ENTRY = Entry(
    "recipe",
    "Results",
    "The constant-volume burn",
    "The paper does not follow the reaction: its gas burns by the recipe of C. L. Mader, as it is compressed.",
    compute,
    weight=6.0,
    runs=4,
)
